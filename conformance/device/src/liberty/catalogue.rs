//! The liberties.

use canvass_macros::Catalogue;

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

/// Something that a firmware may do in this way or in another. Each is a switch of its own; they can be combined.
#[derive(Catalogue, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Liberty {
    // SDO
    /// A segment whose toggle bit does not alternate is ignored in silence.
    #[row(clause = "CiA 301 7.2.4.3.2, 7.2.4.3.5", devices = &[LELY])]
    ToggleIgnored,
    /// A new initiate during a block transfer is answered with abort 0504 0001h; the next request is served.
    #[row(clause = "CiA 301 7.2.4.3.8, 7.2.4.3.12", devices = &[CANOPEN_NODE])]
    BlockInitiateRefused,
    /// A transfer waits for its client without a timeout.
    #[row(clause = "CiA 301 7.2.4.3.17", devices = &[CANOPEN_STACK])]
    TransferWithoutTimeout,
    /// A transfer whose client says nothing any more ends in silence.
    #[row(clause = "CiA 301 7.2.4.3.17")]
    TimeoutWithoutAbort,
    /// A request whose command has reserved bits set is an unknown one: abort 0504 0001h, which names no object.
    #[row(clause = "CiA 301 7.2.4.3", devices = &[CANOPEN_NODE])]
    ReservedBitsRefused,
    /// A block upload of a value up to the threshold becomes a normal one, whatever the size of blocks it asks for.
    #[row(clause = "CiA 301 7.2.4.3.13", devices = &[CANOPEN_NODE])]
    ProtocolBeforeBlockSize,
    /// Downloads come in blocks of four segments.
    #[row(clause = "CiA 301 7.2.4.3.9")]
    SmallBlocks,
    /// Uploads in segments and in blocks don't announce their size.
    #[row(clause = "CiA 301 7.2.4.3.6, 7.2.4.3.13")]
    SizesUnannounced,
    /// Strings come in segments, however short they are.
    #[row(clause = "CiA 301 7.2.4.3.6", devices = &[LIKA, TR])]
    StringsInSegments,
    /// A string or domain that is not empty takes values of its own length, and refuses others with abort 0607 0012h or
    /// 0607 0013h.
    #[row(clause = "CiA 301 7.2.4.3.17", devices = &[CANOPEN_NODE])]
    StringsOfOneLength,
    /// Block transfers have no CRC.
    #[row(clause = "CiA 301 7.2.4.3.9, 7.2.4.3.13")]
    BlocksWithoutCrc,
    /// The SDO server knows no block transfers.
    #[row(clause = "CiA 301 7.2.4.1", devices = &[KUEBLER, LIKA, TR])]
    NoBlockTransfer,
    /// The SDO server knows no transfers in segments, and no object has more than four bytes.
    #[row(clause = "CiA 301 7.2.4.2.1")]
    NoSegmentedTransfer,
    /// A download in segments or in blocks to what can't be written is refused only with its end.
    #[row(clause = "CiA 301 7.2.4.3.2, 7.2.4.3.8")]
    RefusedAtEnd,
    /// A block upload stays one, whatever its threshold for another protocol.
    #[row(clause = "CiA 301 7.2.4.3.13")]
    ProtocolNotSwitched,
    /// A block download that is too short and has a wrong CRC is refused for its length.
    #[row(clause = "CiA 301 7.2.4.3.11")]
    LengthBeforeCrc,
    /// A wrong length is refused with abort 0607 0010h, whether it is too long or too short.
    #[row(clause = "CiA 301 7.2.4.3.17")]
    LengthCodeGeneral,
    /// A value beyond its limits is refused with abort 0609 0030h.
    #[row(clause = "CiA 301 7.2.4.3.17")]
    RangeCodeGeneral,
    /// A value above what a service knows is refused with abort 0609 0031h instead of 0609 0030h.
    #[row(clause = "CiA 301 7.2.4.3.17", devices = &[PUBLISHED])]
    LimitCodePrecise,
    /// A wrong signature of 1010h or 1011h is refused with abort 0609 0030h.
    #[row(clause = "CiA 301 7.5.2.13, 7.5.2.14, corrigendum 1")]
    SignatureCodeValue,
    /// A wrong signature of 1010h or 1011h is refused with abort 0800 0000h.
    #[row(clause = "CiA 301 7.5.2.13, 7.5.2.14, corrigendum 1", devices = &[TR])]
    SignatureCodeGeneral,
    /// An empty entry of 1003h is refused with abort 0800 0000h.
    #[row(clause = "CiA 301 7.5.2.4")]
    HistoryCodeGeneral,
    /// 1019h is refused with abort 0800 0000h while 1006h is not 0.
    #[row(clause = "CiA 301 7.5.2.22")]
    OverflowCodeGeneral,
    /// What can't be mapped is refused with abort 0602 0000h, whether the object exists or not.
    #[row(clause = "CiA 301 7.5.2.36, 7.5.2.38")]
    EntryCodeMissing,
    /// What can't be mapped is refused with abort 0604 0041h, whether the object exists or not.
    #[row(clause = "CiA 301 7.5.2.36, 7.5.2.38")]
    EntryCodeUnmappable,
    /// A number of mapped objects that is not possible is refused with abort 0602 0000h.
    #[row(clause = "CiA 301 7.5.2.36, 7.5.2.38")]
    CountCodeMissing,
    /// The CAN-ID of a valid COB-ID is refused with abort 0800 0000h.
    #[row(clause = "CiA 301 7.5.2.17, 7.5.2.35, 7.5.2.37")]
    CobIdCodeGeneral,
    /// The CAN-ID of a valid COB-ID is refused with abort 0800 0022h.
    #[row(clause = "CiA 301 7.5.2.17, 7.5.2.35, 7.5.2.37")]
    CobIdCodeState,
    /// A valid COB-ID of a PDO or of EMCY can only be made invalid; even the value that it has is refused.
    #[row(clause = "CiA 301 7.5.2.35, 7.5.2.37", devices = &[C_OPEN, CANOPEN_STACK])]
    CobIdRewriteRefused,
    /// Transmission type and times of a PDO are refused with abort 0609 0030h while it is valid.
    #[row(clause = "CiA 301 7.5.2.37", devices = &[CANOPEN_STACK])]
    PdoParametersLocked,
    // Times
    /// An SDO answer takes 900 ms.
    #[row(clause = "CiA 301 7.2.4")]
    AnswersIn900Ms,
    /// An SDO answer takes 1 to 900 ms, each another time.
    #[row(clause = "CiA 301 7.2.4")]
    AnswersVary,
    /// From a reset to the boot-up message it takes 5 s.
    #[row(clause = "CiA 301 7.3.2.2.1")]
    RestartIn5S,
    /// "save" is answered after 3 s.
    #[row(clause = "CiA 301 7.5.2.13")]
    StoreIn3S,
    /// What is written is stored at once: 1010h has bit 1, not bit 0, and can only be read.
    #[row(clause = "CiA 301 7.5.2.13")]
    StoresByItself,
    /// What is written is stored at once, and on command as well: 1010h has bits 0 and 1.
    #[row(clause = "CiA 301 7.5.2.13")]
    StoresBothWays,
    // Resets and NMT
    /// Variables of the manufacturer (2000h to 5FFFh) are no parameters: resets leave them as they are.
    #[row(clause = "CiA 301 7.3.2.2.1", devices = &[CANOPEN_NODE, CAN_FESTIVAL])]
    VariablesKept,
    /// The device enters operational by itself; there is no 1F80h.
    #[row(clause = "CiA 301 7.3.2.2.3", devices = &[CANOPEN_NODE, LELY])]
    SelfStart,
    /// 1F80h is delivered with bit 2 cleared: the device enters operational by itself.
    #[row(clause = "CiA 302-2, NMT startup", devices = &[PUBLISHED])]
    SelfStartByObject,
    /// Restoring the defaults restores that there is no node-ID: from the next reset on the device waits for LSS.
    #[row(clause = "CiA 301 7.5.2.14", devices = &[CANOPEN_NODE])]
    NodeIdRestored,
    // Identity
    /// 1008h, 1009h and 100Ah end in a byte 00h.
    #[row(clause = "CiA 301 7.1.6.3", devices = &[C_OPEN])]
    NamesEndInNul,
    /// There are no 1008h, 1009h and 100Ah.
    #[row(clause = "CiA 301 7.5.2.8 to 7.5.2.10")]
    NoNames,
    /// 1018h has the vendor-ID and nothing else.
    #[row(clause = "CiA 301 7.5.2.21")]
    VendorIdAlone,
    // EMCY and errors
    /// Errors are not signalled: there are no EMCY, no 1014h and no 1015h.
    #[row(clause = "CiA 301 7.2.7.1")]
    NoEmcy,
    /// There is no 1015h.
    #[row(clause = "CiA 301 7.5.2.18")]
    NoEmcyInhibitTime,
    /// The inhibit time of EMCY begins with the write of 1015h.
    #[row(clause = "CiA 301 7.5.2.18", devices = &[CANOPEN_NODE])]
    InhibitFromWrite,
    /// There is no 1003h.
    #[row(clause = "CiA 301 7.5.2.4")]
    NoErrorHistory,
    /// 1003h holds one error.
    #[row(clause = "CiA 301 7.5.2.4")]
    ShortErrorHistory,
    /// Every error has the code 1000h.
    #[row(clause = "CiA 301 7.2.7.1")]
    GenericErrorCodes,
    /// Every error sets bit 0 of 1001h and no other.
    #[row(clause = "CiA 301 7.5.2.2", devices = &[CANOPEN_STACK])]
    GenericErrorBit,
    /// There is no 1029h.
    #[row(clause = "CiA 301 7.5.2.32")]
    NoErrorBehaviour,
    /// SYNC of a wrong length is ignored without EMCY.
    #[row(clause = "CiA 301 7.5.2.22")]
    SyncLengthUnreported,
    /// An RPDO with more bytes than are mapped is taken without EMCY.
    #[row(clause = "CiA 301 7.5.2.36")]
    LongRpdoUnreported,
    /// Of the errors that came in stopped the newest is signalled afterwards.
    #[row(clause = "CiA 301 7.3.2.2.4")]
    StoppedEmcyNewest,
    /// Errors that came in stopped are not signalled afterwards.
    #[row(clause = "CiA 301 7.3.2.2.4")]
    StoppedEmcyDropped,
    /// The loss of a heartbeat is not signalled by EMCY; the state changes as 1029h says.
    #[row(clause = "CiA 301 7.2.8.2.2", devices = &[C_OPEN])]
    LostHeartbeatUnreported,
    // Monitoring
    /// There is no 1016h.
    #[row(clause = "CiA 301 7.5.2.19", devices = &[LIKA, TR])]
    NoHeartbeatConsumer,
    /// 1016h has one entry.
    #[row(clause = "CiA 301 7.5.2.19")]
    OneHeartbeatConsumer,
    /// There is no node guarding: no 100Ch, no 100Dh, no answer to remote frames.
    #[row(clause = "CiA 301 7.2.8.2.2", devices = &[CANOPEN_NODE])]
    NoGuarding,
    // SYNC, TIME and other services
    /// There is no 1019h.
    #[row(clause = "CiA 301 7.5.2.22")]
    NoSyncCounter,
    /// There is no 1007h.
    #[row(clause = "CiA 301 7.5.2.7", devices = &[CANOPEN_STACK])]
    NoSyncWindow,
    /// SYNC is consumed only: bit 30 of 1005h is refused, and there is no 1006h and no 1019h.
    #[row(clause = "CiA 301 7.5.2.5, 7.5.2.6", devices = &[KUEBLER, LIKA, TR])]
    NoSyncProducer,
    /// TIME is neither consumed nor produced: no 1012h, no 1013h.
    #[row(clause = "CiA 301 7.5.2.15, 7.5.2.16")]
    NoTime,
    /// Nothing can be stored or restored: no 1010h, no 1011h.
    #[row(clause = "CiA 301 7.5.2.13, 7.5.2.14")]
    NoStore,
    /// There is no 1020h.
    #[row(clause = "CiA 301 7.5.2.23")]
    NoConfigurationDate,
    /// There is no second SDO channel.
    #[row(clause = "CiA 301 7.5.2.33")]
    NoFurtherSdo,
    /// There is no 1028h.
    #[row(clause = "CiA 301 7.5.2.31")]
    NoEmcyConsumer,
    // PDO
    /// All PDOs are delivered off, in the EDS as well.
    #[row(clause = "CiA 301 7.5.2.35, 7.5.2.37", devices = &[CANOPEN_NODE])]
    PdosInvalid,
    /// There are one RPDO and one TPDO.
    #[row(clause = "CiA 301 7.2.2.1")]
    OnePdo,
    /// Nothing but the communication profile: no object from 2000h on; PDOs map nothing and are off.
    #[row(clause = "CiA 301 7.4.1", devices = &[CANOPEN_NODE])]
    NoApplicationObjects,
    /// No object can be written that has more than four bytes.
    #[row(clause = "CiA 301 7.4.1")]
    NoLongObjects,
    /// What is written over the bus is no event: TPDOs are sent by events of the application alone.
    #[row(clause = "CiA 301 7.2.2.3", devices = &[LELY])]
    OwnEvents,
    /// The first TPDO of transmission type n comes in the middle of n SYNCs after the start, the others every n.
    #[row(clause = "CiA 301 7.2.2.2, 7.3.2.2.3", devices = &[CANOPEN_NODE])]
    SyncCountFromMiddle,
    /// Synchronous TPDOs come 40 ms after SYNC: 1007h sets no window as delivered.
    #[row(clause = "CiA 301 7.2.2.2, 7.5.2.7")]
    SyncTpdoIn40Ms,
    /// PDOs are event-driven only: other transmission types are refused with abort 0609 0030h.
    #[row(clause = "CiA 301 7.5.2.35, 7.5.2.37")]
    NoSynchronousPdos,
    /// TPDOs can't be asked for by remote frames: bit 30 of their COB-IDs is set and can't be cleared.
    #[row(clause = "CiA 301 7.5.2.37", devices = &[KUEBLER, LIKA])]
    NoRtr,
    /// There is no dummy mapping.
    #[row(clause = "CiA 301 7.5.2.36")]
    NoDummies,
    /// Nothing is mapped that is no whole byte: Granularity=8.
    #[row(clause = "CiA 306-1, DeviceInfo")]
    MappingInBytes,
    /// A mapping that is longer than a PDO is refused with abort 0604 0042h as soon as the entry is written with which
    /// it is.
    #[row(clause = "CiA 301 7.5.2.38")]
    MappingLengthAtEntry,
    /// The mapping of PDOs can't be changed: Granularity=0, all of it read-only.
    #[row(clause = "CiA 301 7.5.2.36, 7.5.2.38", devices = &[LIKA, TR])]
    MappingFixed,
    /// TPDOs have no inhibit time.
    #[row(clause = "CiA 301 7.5.2.37")]
    NoInhibitTime,
    /// TPDOs have no event timer.
    #[row(clause = "CiA 301 7.5.2.37")]
    NoEventTimer,
    /// RPDOs have no deadline.
    #[row(clause = "CiA 301 7.5.2.35")]
    NoRpdoDeadline,
    /// The inhibit time of TPDO 1 is delivered longer than its event timer.
    #[row(clause = "CiA 301 7.5.2.37", devices = &[PUBLISHED])]
    LongInhibitTime,
    /// TPDO 1 is delivered valid and maps nothing.
    #[row(clause = "CiA 301 7.5.2.38", devices = &[PUBLISHED])]
    ValidAndEmpty,
    // LSS
    /// There is no Fastscan.
    #[row(clause = "CiA 305, Fastscan", devices = &[C_OPEN])]
    NoFastscan,
    /// LSS knows no inquiry services.
    #[row(clause = "CiA 305, inquiry services")]
    NoLssInquiry,
    /// There is no LSS.
    #[row(clause = "CiA 305, scope", devices = &[LIKA, TR])]
    NoLss,
    /// LSS "store configuration" is answered after 2 s.
    #[row(clause = "CiA 305, store configuration", devices = &[LELY])]
    LssStoreIn2S,
    // The bus
    /// The device is an SDO client too: it asks node 127, or node 126, for its device type twice a second.
    #[row(clause = "CiA 301 7.2.4.1")]
    OwnSdoClient,
    /// The device sends bursts of frames of its own, with CAN-ID 6D0h that nobody else has.
    #[row(clause = "CiA 301 7.3.5")]
    OwnTraffic,
    /// On SocketCAN the bytes of a classical frame that carry nothing are not zero.
    #[row(clause = "CiA 301 6.2", devices = &[C_OPEN, CAN_FESTIVAL])]
    DirtyPadding,
    // Descriptions
    /// The EDS has no LowLimit and no HighLimit.
    #[row(clause = "CiA 306-1, object sections", devices = &[PUBLISHED])]
    EdsWithoutLimits,
    /// The EDS has ObjFlags: 1010h and 1011h are not to be written with all the rest.
    #[row(clause = "CiA 306-1, object sections", devices = &[PUBLISHED])]
    EdsObjFlags,
    /// The EDS describes 1003h and 1016h by CompactSubObj.
    #[row(clause = "CiA 306-1, CompactSubObj", devices = &[PUBLISHED])]
    EdsCompactSubObj,
    /// The times of the EDS have hours of one digit.
    #[row(clause = "CiA 306-1, FileInfo", devices = &[PUBLISHED])]
    EdsOneDigitHour,
    /// The keys of the lists of objects are not in their order.
    #[row(clause = "CiA 306-1, object sections", devices = &[PUBLISHED])]
    EdsListsOutOfOrder,
    /// Lines of the EDS end in comments.
    #[row(clause = "CiA 306-1, general format", devices = &[PUBLISHED])]
    EdsInlineComments,
    /// The EDS has characters of ISO 8859-1.
    #[row(clause = "CiA 306-1, general format", devices = &[PUBLISHED])]
    EdsLatin1,
    /// 1018h has no defaults in the EDS; its DeviceInfo has the numbers.
    #[row(clause = "CiA 306-1, object sections", devices = &[PUBLISHED])]
    EdsIdentityWithoutDefaults,
}

/// The properties of a liberty besides its name and its summary.
struct Row {
    /// The clause that allows the liberty, or that leaves the behaviour open.
    clause: &'static str,
    /// Devices that are known to take the liberty.
    devices: &'static [&'static str],
}

impl Row {
    /// The values of most liberties; each liberty names its own clause.
    const USUAL: Self = Self { clause: "", devices: &[] };
}

impl Liberty {
    /// The clause that allows the liberty, or that leaves the behaviour open.
    pub const fn clause(self) -> &'static str {
        self.row().clause
    }

    /// Devices that are known to take the liberty.
    pub const fn devices(self) -> &'static [&'static str] {
        self.row().devices
    }

    /// The id of a model on which the liberty shows.
    pub const fn model(self) -> &'static str {
        "reference-301"
    }
}
