//! The liberties.

use super::USUAL_MODEL;

/// Devices of other makers that take liberties, as rows name them.
mod devices {
    pub const CANOPEN_NODE: &str = "CANopenNode";
    pub const LELY: &str = "lely-core";
    pub const C_OPEN: &str = "c-open";
    pub const CAN_FESTIVAL: &str = "CanFestival";
    pub const CANOPEN_STACK: &str = "embedded-office canopen-stack";
    pub const KUEBLER: &str = "Kübler Sendix";
    pub const LIKA: &str = "Lika AX58";
    pub const TR: &str = "TR-Electronic C_65 and LMP-30";
    pub const PUBLISHED: &str = "device descriptions of several makers";
}
use devices::*;

/// Defines the liberties: one row each, so that name, variant and text can't drift apart. `by [DEVICE, ...]` names devices
/// that take it, as far as they are known; `on "MODEL"` a model on which it shows, where it is not the usual one.
macro_rules! liberties {
    ($($variant:ident = $id:literal, $clause:literal $(by [$($device:ident),*])? $(on $model:literal)?: $summary:literal,)*) => {
        /// Something that a firmware may do in this way or in another. Each is a switch of its own; they can be combined.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub enum Liberty {
            $(#[doc = $summary] $variant,)*
        }

        impl Liberty {
            /// All liberties, in the order of their definition.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The name on the command line.
            pub const fn id(self) -> &'static str {
                match self { $(Self::$variant => $id,)* }
            }

            /// What the firmware does, or the description says.
            pub const fn summary(self) -> &'static str {
                match self { $(Self::$variant => $summary,)* }
            }

            /// The clause that allows it, or that leaves it open.
            pub const fn clause(self) -> &'static str {
                match self { $(Self::$variant => $clause,)* }
            }

            /// Devices that take it, as far as they are known.
            pub const fn devices(self) -> &'static [&'static str] {
                match self { $(Self::$variant => &[$($($device),*)?],)* }
            }

            /// The id of a model on which it shows.
            pub fn model(self) -> &'static str {
                let named: Option<&'static str> = match self { $(Self::$variant => liberties!(@model $($model)?),)* };
                named.unwrap_or(USUAL_MODEL)
            }
        }
    };
    (@model) => { None };
    (@model $model:literal) => { Some($model) };
}

liberties! {
    // SDO
    ToggleIgnored = "toggle-ignored", "CiA 301 7.2.4.3.2, 7.2.4.3.5" by [LELY]: "A segment whose toggle bit does not alternate is ignored in silence.",
    BlockInitiateRefused = "block-initiate-refused", "CiA 301 7.2.4.3.8, 7.2.4.3.12" by [CANOPEN_NODE]: "A new initiate during a block transfer is answered with abort 0504 0001h; the next request is served.",
    TransferWithoutTimeout = "transfer-without-timeout", "CiA 301 7.2.4.3.17" by [CANOPEN_STACK]: "A transfer waits for its client without a timeout.",
    TimeoutWithoutAbort = "timeout-without-abort", "CiA 301 7.2.4.3.17": "A transfer whose client says nothing any more ends in silence.",
    ReservedBitsRefused = "reserved-bits-refused", "CiA 301 7.2.4.3" by [CANOPEN_NODE]: "A request whose command has reserved bits set is an unknown one: abort 0504 0001h, which names no object.",
    ProtocolBeforeBlockSize = "protocol-before-block-size", "CiA 301 7.2.4.3.13" by [CANOPEN_NODE]: "A block upload of a value up to the threshold becomes a normal one, whatever the size of blocks it asks for.",
    SmallBlocks = "small-blocks", "CiA 301 7.2.4.3.9": "Downloads come in blocks of four segments.",
    SizesUnannounced = "sizes-unannounced", "CiA 301 7.2.4.3.6, 7.2.4.3.13": "Uploads in segments and in blocks don't announce their size.",
    StringsInSegments = "strings-in-segments", "CiA 301 7.2.4.3.6" by [LIKA, TR]: "Strings come in segments, however short they are.",
    StringsOfOneLength = "strings-of-one-length", "CiA 301 7.2.4.3.17" by [CANOPEN_NODE]: "A string or domain that is not empty takes values of its own length, and refuses others with abort 0607 0012h or 0607 0013h.",
    BlocksWithoutCrc = "blocks-without-crc", "CiA 301 7.2.4.3.9, 7.2.4.3.13": "Block transfers have no CRC.",
    NoBlockTransfer = "no-block-transfer", "CiA 301 7.2.4.1" by [KUEBLER, LIKA, TR]: "The SDO server knows no block transfers.",
    NoSegmentedTransfer = "no-segmented-transfer", "CiA 301 7.2.4.2.1": "The SDO server knows no transfers in segments, and no object has more than four bytes.",
    RefusedAtEnd = "refused-at-end", "CiA 301 7.2.4.3.2, 7.2.4.3.8": "A download in segments or in blocks to what can't be written is refused only with its end.",
    ProtocolNotSwitched = "protocol-not-switched", "CiA 301 7.2.4.3.13": "A block upload stays one, whatever its threshold for another protocol.",
    LengthBeforeCrc = "length-before-crc", "CiA 301 7.2.4.3.11": "A block download that is too short and has a wrong CRC is refused for its length.",
    LengthCodeGeneral = "length-code-general", "CiA 301 7.2.4.3.17": "A wrong length is refused with abort 0607 0010h, whether it is too long or too short.",
    RangeCodeGeneral = "range-code-general", "CiA 301 7.2.4.3.17": "A value beyond its limits is refused with abort 0609 0030h.",
    LimitCodePrecise = "limit-code-precise", "CiA 301 7.2.4.3.17" by [PUBLISHED]: "A value above what a service knows is refused with abort 0609 0031h instead of 0609 0030h.",
    SignatureCodeValue = "signature-code-value", "CiA 301 7.5.2.13, 7.5.2.14, corrigendum 1": "A wrong signature of 1010h or 1011h is refused with abort 0609 0030h.",
    SignatureCodeGeneral = "signature-code-general", "CiA 301 7.5.2.13, 7.5.2.14, corrigendum 1" by [TR]: "A wrong signature of 1010h or 1011h is refused with abort 0800 0000h.",
    HistoryCodeGeneral = "history-code-general", "CiA 301 7.5.2.4": "An empty entry of 1003h is refused with abort 0800 0000h.",
    OverflowCodeGeneral = "overflow-code-general", "CiA 301 7.5.2.22": "1019h is refused with abort 0800 0000h while 1006h is not 0.",
    EntryCodeMissing = "entry-code-missing", "CiA 301 7.5.2.36, 7.5.2.38": "What can't be mapped is refused with abort 0602 0000h, whether the object exists or not.",
    EntryCodeUnmappable = "entry-code-unmappable", "CiA 301 7.5.2.36, 7.5.2.38": "What can't be mapped is refused with abort 0604 0041h, whether the object exists or not.",
    CountCodeMissing = "count-code-missing", "CiA 301 7.5.2.36, 7.5.2.38": "A number of mapped objects that is not possible is refused with abort 0602 0000h.",
    CobIdCodeGeneral = "cob-id-code-general", "CiA 301 7.5.2.17, 7.5.2.35, 7.5.2.37": "The CAN-ID of a valid COB-ID is refused with abort 0800 0000h.",
    CobIdCodeState = "cob-id-code-state", "CiA 301 7.5.2.17, 7.5.2.35, 7.5.2.37": "The CAN-ID of a valid COB-ID is refused with abort 0800 0022h.",
    CobIdRewriteRefused = "cob-id-rewrite-refused", "CiA 301 7.5.2.35, 7.5.2.37" by [C_OPEN, CANOPEN_STACK]: "A valid COB-ID of a PDO or of EMCY can only be made invalid; even the value that it has is refused.",
    PdoParametersLocked = "pdo-parameters-locked", "CiA 301 7.5.2.37" by [CANOPEN_STACK]: "Transmission type and times of a PDO are refused with abort 0609 0030h while it is valid.",
    // Times
    AnswersIn900Ms = "answers-in-900-ms", "CiA 301 7.2.4": "An SDO answer takes 900 ms.",
    AnswersVary = "answers-vary", "CiA 301 7.2.4": "An SDO answer takes 1 to 900 ms, each another time.",
    RestartIn5S = "restart-in-5-s", "CiA 301 7.3.2.2.1": "From a reset to the boot-up message it takes 5 s.",
    StoreIn3S = "store-in-3-s", "CiA 301 7.5.2.13": "\"save\" is answered after 3 s.",
    StoresByItself = "stores-by-itself", "CiA 301 7.5.2.13": "What is written is stored at once: 1010h has bit 1, not bit 0, and can only be read.",
    StoresBothWays = "stores-both-ways", "CiA 301 7.5.2.13": "What is written is stored at once, and on command as well: 1010h has bits 0 and 1.",
    // Resets and NMT
    VariablesKept = "variables-kept", "CiA 301 7.3.2.2.1" by [CANOPEN_NODE, CAN_FESTIVAL]: "Variables of the manufacturer (2000h to 5FFFh) are no parameters: resets leave them as they are.",
    SelfStart = "self-start", "CiA 301 7.3.2.2.3" by [CANOPEN_NODE, LELY]: "The device enters operational by itself; there is no 1F80h.",
    SelfStartByObject = "self-start-by-object", "CiA 302-2, NMT startup" by [PUBLISHED]: "1F80h is delivered with bit 2 cleared: the device enters operational by itself.",
    NodeIdRestored = "node-id-restored", "CiA 301 7.5.2.14" by [CANOPEN_NODE]: "Restoring the defaults restores that there is no node-ID: from the next reset on the device waits for LSS.",
    // Identity
    NamesEndInNul = "names-end-in-nul", "CiA 301 7.1.6.3" by [C_OPEN]: "1008h, 1009h and 100Ah end in a byte 00h.",
    NoNames = "no-names", "CiA 301 7.5.2.8 to 7.5.2.10": "There are no 1008h, 1009h and 100Ah.",
    VendorIdAlone = "vendor-id-alone", "CiA 301 7.5.2.21": "1018h has the vendor-ID and nothing else.",
    // EMCY and errors
    NoEmcy = "no-emcy", "CiA 301 7.2.7.1": "Errors are not signalled: there are no EMCY, no 1014h and no 1015h.",
    NoEmcyInhibitTime = "no-emcy-inhibit-time", "CiA 301 7.5.2.18": "There is no 1015h.",
    InhibitFromWrite = "inhibit-from-write", "CiA 301 7.5.2.18" by [CANOPEN_NODE]: "The inhibit time of EMCY begins with the write of 1015h.",
    NoErrorHistory = "no-error-history", "CiA 301 7.5.2.4": "There is no 1003h.",
    ShortErrorHistory = "short-error-history", "CiA 301 7.5.2.4": "1003h holds one error.",
    GenericErrorCodes = "generic-error-codes", "CiA 301 7.2.7.1": "Every error has the code 1000h.",
    GenericErrorBit = "generic-error-bit", "CiA 301 7.5.2.2" by [CANOPEN_STACK]: "Every error sets bit 0 of 1001h and no other.",
    NoErrorBehaviour = "no-error-behaviour", "CiA 301 7.5.2.32": "There is no 1029h.",
    SyncLengthUnreported = "sync-length-unreported", "CiA 301 7.5.2.22": "SYNC of a wrong length is ignored without EMCY.",
    LongRpdoUnreported = "long-rpdo-unreported", "CiA 301 7.5.2.36": "An RPDO with more bytes than are mapped is taken without EMCY.",
    StoppedEmcyNewest = "stopped-emcy-newest", "CiA 301 7.3.2.2.4": "Of the errors that came in stopped the newest is signalled afterwards.",
    StoppedEmcyDropped = "stopped-emcy-dropped", "CiA 301 7.3.2.2.4": "Errors that came in stopped are not signalled afterwards.",
    LostHeartbeatUnreported = "lost-heartbeat-unreported", "CiA 301 7.2.8.2.2" by [C_OPEN]: "The loss of a heartbeat is not signalled by EMCY; the state changes as 1029h says.",
    // Monitoring
    NoHeartbeatConsumer = "no-heartbeat-consumer", "CiA 301 7.5.2.19" by [LIKA, TR]: "There is no 1016h.",
    OneHeartbeatConsumer = "one-heartbeat-consumer", "CiA 301 7.5.2.19": "1016h has one entry.",
    NoGuarding = "no-guarding", "CiA 301 7.2.8.2.2" by [CANOPEN_NODE]: "There is no node guarding: no 100Ch, no 100Dh, no answer to remote frames.",
    // SYNC, TIME and other services
    NoSyncCounter = "no-sync-counter", "CiA 301 7.5.2.22": "There is no 1019h.",
    NoSyncWindow = "no-sync-window", "CiA 301 7.5.2.7" by [CANOPEN_STACK]: "There is no 1007h.",
    NoSyncProducer = "no-sync-producer", "CiA 301 7.5.2.5, 7.5.2.6" by [KUEBLER, LIKA, TR]: "SYNC is consumed only: bit 30 of 1005h is refused, and there is no 1006h and no 1019h.",
    NoTime = "no-time", "CiA 301 7.5.2.15, 7.5.2.16": "TIME is neither consumed nor produced: no 1012h, no 1013h.",
    NoStore = "no-store", "CiA 301 7.5.2.13, 7.5.2.14": "Nothing can be stored or restored: no 1010h, no 1011h.",
    NoConfigurationDate = "no-configuration-date", "CiA 301 7.5.2.23": "There is no 1020h.",
    NoFurtherSdo = "no-further-sdo", "CiA 301 7.5.2.33": "There is no second SDO channel.",
    NoEmcyConsumer = "no-emcy-consumer", "CiA 301 7.5.2.31": "There is no 1028h.",
    // PDO
    PdosInvalid = "pdos-invalid", "CiA 301 7.5.2.35, 7.5.2.37" by [CANOPEN_NODE]: "All PDOs are delivered off, in the EDS as well.",
    OnePdo = "one-pdo", "CiA 301 7.2.2.1": "There are one RPDO and one TPDO.",
    NoApplicationObjects = "no-application-objects", "CiA 301 7.4.1" by [CANOPEN_NODE]: "Nothing but the communication profile: no object from 2000h on; PDOs map nothing and are off.",
    NoLongObjects = "no-long-objects", "CiA 301 7.4.1": "No object can be written that has more than four bytes.",
    OwnEvents = "own-events", "CiA 301 7.2.2.3" by [LELY]: "What is written over the bus is no event: TPDOs are sent by events of the application alone.",
    SyncCountFromMiddle = "sync-count-from-middle", "CiA 301 7.2.2.2, 7.3.2.2.3" by [CANOPEN_NODE]: "The first TPDO of transmission type n comes in the middle of n SYNCs after the start, the others every n.",
    SyncTpdoIn40Ms = "sync-tpdo-in-40-ms", "CiA 301 7.2.2.2, 7.5.2.7": "Synchronous TPDOs come 40 ms after SYNC: 1007h sets no window as delivered.",
    NoSynchronousPdos = "no-synchronous-pdos", "CiA 301 7.5.2.35, 7.5.2.37": "PDOs are event-driven only: other transmission types are refused with abort 0609 0030h.",
    NoRtr = "no-rtr", "CiA 301 7.5.2.37" by [KUEBLER, LIKA]: "TPDOs can't be asked for by remote frames: bit 30 of their COB-IDs is set and can't be cleared.",
    NoDummies = "no-dummies", "CiA 301 7.5.2.36": "There is no dummy mapping.",
    MappingInBytes = "mapping-in-bytes", "CiA 306-1, DeviceInfo": "Nothing is mapped that is no whole byte: Granularity=8.",
    MappingLengthAtEntry = "mapping-length-at-entry", "CiA 301 7.5.2.38": "A mapping that is longer than a PDO is refused with abort 0604 0042h as soon as the entry is written with which it is.",
    MappingFixed = "mapping-fixed", "CiA 301 7.5.2.36, 7.5.2.38" by [LIKA, TR]: "The mapping of PDOs can't be changed: Granularity=0, all of it read-only.",
    NoInhibitTime = "no-inhibit-time", "CiA 301 7.5.2.37": "TPDOs have no inhibit time.",
    NoEventTimer = "no-event-timer", "CiA 301 7.5.2.37": "TPDOs have no event timer.",
    NoRpdoDeadline = "no-rpdo-deadline", "CiA 301 7.5.2.35": "RPDOs have no deadline.",
    LongInhibitTime = "long-inhibit-time", "CiA 301 7.5.2.37" by [PUBLISHED]: "The inhibit time of TPDO 1 is delivered longer than its event timer.",
    ValidAndEmpty = "valid-and-empty", "CiA 301 7.5.2.38" by [PUBLISHED]: "TPDO 1 is delivered valid and maps nothing.",
    // LSS
    NoFastscan = "no-fastscan", "CiA 305, Fastscan" by [C_OPEN]: "There is no Fastscan.",
    NoLssInquiry = "no-lss-inquiry", "CiA 305, inquiry services": "LSS knows no inquiry services.",
    NoLss = "no-lss", "CiA 305, scope" by [LIKA, TR]: "There is no LSS.",
    LssStoreIn2S = "lss-store-in-2-s", "CiA 305, store configuration" by [LELY]: "LSS \"store configuration\" is answered after 2 s.",
    // The bus
    OwnSdoClient = "own-sdo-client", "CiA 301 7.2.4.1": "The device is an SDO client too: it asks node 127, or node 126, for its device type twice a second.",
    OwnTraffic = "own-traffic", "CiA 301 7.3.5": "The device sends bursts of frames of its own, with CAN-ID 6D0h that nobody else has.",
    DirtyPadding = "dirty-padding", "CiA 301 6.2" by [C_OPEN, CAN_FESTIVAL]: "On SocketCAN the bytes of a classical frame that carry nothing are not zero.",
    // Descriptions
    EdsWithoutLimits = "eds-without-limits", "CiA 306-1, object sections" by [PUBLISHED]: "The EDS has no LowLimit and no HighLimit.",
    EdsObjFlags = "eds-obj-flags", "CiA 306-1, object sections" by [PUBLISHED]: "The EDS has ObjFlags: 1010h and 1011h are not to be written with all the rest.",
    EdsCompactSubObj = "eds-compact-sub-obj", "CiA 306-1, CompactSubObj" by [PUBLISHED]: "The EDS describes 1003h and 1016h by CompactSubObj.",
    EdsOneDigitHour = "eds-one-digit-hour", "CiA 306-1, FileInfo" by [PUBLISHED]: "The times of the EDS have hours of one digit.",
    EdsListsOutOfOrder = "eds-lists-out-of-order", "CiA 306-1, object sections" by [PUBLISHED]: "The keys of the lists of objects are not in their order.",
    EdsInlineComments = "eds-inline-comments", "CiA 306-1, general format" by [PUBLISHED]: "Lines of the EDS end in comments.",
    EdsLatin1 = "eds-latin-1", "CiA 306-1, general format" by [PUBLISHED]: "The EDS has characters of ISO 8859-1.",
    EdsIdentityWithoutDefaults = "eds-identity-without-defaults", "CiA 306-1, object sections" by [PUBLISHED]: "1018h has no defaults in the EDS; its DeviceInfo has the numbers.",
}
