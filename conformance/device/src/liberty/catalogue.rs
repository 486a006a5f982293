//! The liberties.

use canvass_macros::Catalogue;

/// Devices of other makers that take liberties, as rows name them.
mod devices {
    pub(crate) const CANOPEN_NODE: &str = "CANopenNode";
    pub(crate) const LELY: &str = "lely-core";
    pub(crate) const C_OPEN: &str = "c-open";
    pub(crate) const CAN_FESTIVAL: &str = "CanFestival";
    pub(crate) const CANOPEN_STACK: &str = "embedded-office canopen-stack";
    pub const KUEBLER: &str = "Kübler Sendix";
    pub(crate) const LIKA: &str = "Lika AX58";
    pub const TR: &str = "TR-Electronic C_65 and LMP-30";
    pub(crate) const PUBLISHED: &str = "device descriptions of several makers";
}
use devices::*;

/// A behaviour that the standard leaves free. Each liberty is a separate switch; liberties can be combined.
#[derive(Catalogue, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Liberty {
    // SDO
    /// A segment whose toggle bit does not alternate is ignored without an abort.
    #[row(clause = "CiA 301 7.2.4.3.2, 7.2.4.3.5", devices = &[LELY])]
    ToggleIgnored,
    /// A new initiate during a block transfer is answered with abort 0504 0001h; the next request is served.
    #[row(clause = "CiA 301 7.2.4.3.8, 7.2.4.3.12", devices = &[CANOPEN_NODE])]
    BlockInitiateRefused,
    /// A transfer waits for its client without a timeout.
    #[row(clause = "CiA 301 7.2.4.3.17", devices = &[CANOPEN_STACK])]
    TransferWithoutTimeout,
    /// A transfer whose client stops sending ends without an abort.
    #[row(clause = "CiA 301 7.2.4.3.17")]
    TimeoutWithoutAbort,
    /// A request whose command has reserved bits set is refused as unknown, with abort 0504 0001h, which names no
    /// object.
    #[row(clause = "CiA 301 7.2.4.3", devices = &[CANOPEN_NODE])]
    ReservedBitsRefused,
    /// A block upload of a value up to the threshold becomes a normal upload, whatever block size it requests.
    #[row(clause = "CiA 301 7.2.4.3.13", devices = &[CANOPEN_NODE])]
    ProtocolBeforeBlockSize,
    /// The server requests block downloads in blocks of four segments.
    #[row(clause = "CiA 301 7.2.4.3.9")]
    SmallBlocks,
    /// Uploads in segments and in blocks don't announce their size.
    #[row(clause = "CiA 301 7.2.4.3.6, 7.2.4.3.13")]
    SizesUnannounced,
    /// Strings are uploaded in segments, even if they are short.
    #[row(clause = "CiA 301 7.2.4.3.6", devices = &[LIKA, TR])]
    StringsInSegments,
    /// A string or domain that is not empty accepts values of its own length, and refuses others with abort 0607 0012h
    /// or 0607 0013h.
    #[row(clause = "CiA 301 7.2.4.3.17", devices = &[CANOPEN_NODE])]
    StringsOfOneLength,
    /// Block transfers have no CRC.
    #[row(clause = "CiA 301 7.2.4.3.9, 7.2.4.3.13")]
    BlocksWithoutCrc,
    /// The SDO server does not support block transfers.
    #[row(clause = "CiA 301 7.2.4.1", devices = &[KUEBLER, LIKA, TR])]
    NoBlockTransfer,
    /// The SDO server does not support segmented transfers, and no object has more than four bytes.
    #[row(clause = "CiA 301 7.2.4.2.1")]
    NoSegmentedTransfer,
    /// A segmented or block download to an object that can't be written is refused only at its end.
    #[row(clause = "CiA 301 7.2.4.3.2, 7.2.4.3.8")]
    RefusedAtEnd,
    /// A block upload never becomes a normal upload, whatever its threshold is.
    #[row(clause = "CiA 301 7.2.4.3.13")]
    ProtocolNotSwitched,
    /// A block download that is too short and has a wrong CRC is refused for its length.
    #[row(clause = "CiA 301 7.2.4.3.11")]
    LengthBeforeCrc,
    /// A wrong length is refused with abort 0607 0010h, whether it is too long or too short.
    #[row(clause = "CiA 301 7.2.4.3.17")]
    LengthCodeGeneral,
    /// A value outside its limits is refused with abort 0609 0030h.
    #[row(clause = "CiA 301 7.2.4.3.17")]
    RangeCodeGeneral,
    /// A value above the range that a service supports is refused with abort 0609 0031h instead of 0609 0030h.
    #[row(clause = "CiA 301 7.2.4.3.17", devices = &[PUBLISHED])]
    LimitCodePrecise,
    /// A wrong signature of 1010h or 1011h is refused with abort 0609 0030h.
    #[row(clause = "CiA 301 7.5.2.13, 7.5.2.14, corrigendum 1")]
    SignatureCodeValue,
    /// A wrong signature of 1010h or 1011h is refused with abort 0800 0000h.
    #[row(clause = "CiA 301 7.5.2.13, 7.5.2.14, corrigendum 1", devices = &[TR])]
    SignatureCodeGeneral,
    /// Reading an empty entry of 1003h is refused with abort 0800 0000h.
    #[row(clause = "CiA 301 7.5.2.4")]
    HistoryCodeGeneral,
    /// Writing 1019h while 1006h is not 0 is refused with abort 0800 0000h.
    #[row(clause = "CiA 301 7.5.2.22")]
    OverflowCodeGeneral,
    /// Mapping an object that can't be mapped is refused with abort 0602 0000h, whether the object exists or not.
    #[row(clause = "CiA 301 7.5.2.36, 7.5.2.38")]
    EntryCodeMissing,
    /// Mapping an object that can't be mapped is refused with abort 0604 0041h, whether the object exists or not.
    #[row(clause = "CiA 301 7.5.2.36, 7.5.2.38")]
    EntryCodeUnmappable,
    /// An impossible number of mapped objects is refused with abort 0602 0000h.
    #[row(clause = "CiA 301 7.5.2.36, 7.5.2.38")]
    CountCodeMissing,
    /// A new CAN-ID for a valid COB-ID is refused with abort 0800 0000h.
    #[row(clause = "CiA 301 7.5.2.17, 7.5.2.35, 7.5.2.37")]
    CobIdCodeGeneral,
    /// A new CAN-ID for a valid COB-ID is refused with abort 0800 0022h.
    #[row(clause = "CiA 301 7.5.2.17, 7.5.2.35, 7.5.2.37")]
    CobIdCodeState,
    /// A valid COB-ID of a PDO or of EMCY can only be made invalid; even its current value is refused.
    #[row(clause = "CiA 301 7.5.2.35, 7.5.2.37", devices = &[C_OPEN, CANOPEN_STACK])]
    CobIdRewriteRefused,
    /// Writing the transmission type or the times of a valid PDO is refused with abort 0609 0030h.
    #[row(clause = "CiA 301 7.5.2.37", devices = &[CANOPEN_STACK])]
    PdoParametersLocked,
    // Times
    /// An SDO answer takes 900 ms.
    #[row(clause = "CiA 301 7.2.4")]
    AnswersIn900Ms,
    /// Each SDO answer takes a different time from 1 to 900 ms.
    #[row(clause = "CiA 301 7.2.4")]
    AnswersVary,
    /// The boot-up message follows a reset after 5 s.
    #[row(clause = "CiA 301 7.3.2.2.1")]
    RestartIn5S,
    /// "save" is answered after 3 s.
    #[row(clause = "CiA 301 7.5.2.13")]
    StoreIn3S,
    /// Written values are stored immediately: 1010h has bit 1 set, but not bit 0, and is read-only.
    #[row(clause = "CiA 301 7.5.2.13")]
    StoresByItself,
    /// Written values are stored immediately, and on command as well: 1010h has bits 0 and 1 set.
    #[row(clause = "CiA 301 7.5.2.13")]
    StoresBothWays,
    // Resets and NMT
    /// Manufacturer-specific variables (2000h to 5FFFh) are no parameters: resets do not change them.
    #[row(clause = "CiA 301 7.3.2.2.1", devices = &[CANOPEN_NODE, CAN_FESTIVAL])]
    VariablesKept,
    /// The device enters operational by itself, and 1F80h does not exist.
    #[row(clause = "CiA 301 7.3.2.2.3", devices = &[CANOPEN_NODE, LELY])]
    SelfStart,
    /// 1F80h is delivered with bit 2 cleared: the device enters operational by itself.
    #[row(clause = "CiA 302-2, NMT startup", devices = &[PUBLISHED])]
    SelfStartByObject,
    /// Restoring the defaults also removes the node-ID: after the next reset the device waits for LSS.
    #[row(clause = "CiA 301 7.5.2.14", devices = &[CANOPEN_NODE])]
    NodeIdRestored,
    // Identity
    /// 1008h, 1009h and 100Ah end with a byte 00h.
    #[row(clause = "CiA 301 7.1.6.3", devices = &[C_OPEN])]
    NamesEndInNul,
    /// 1008h, 1009h and 100Ah do not exist.
    #[row(clause = "CiA 301 7.5.2.8 to 7.5.2.10")]
    NoNames,
    /// 1018h contains the vendor-ID only.
    #[row(clause = "CiA 301 7.5.2.21")]
    VendorIdAlone,
    // EMCY and errors
    /// The device does not signal errors: EMCY, 1014h and 1015h do not exist.
    #[row(clause = "CiA 301 7.2.7.1")]
    NoEmcy,
    /// 1015h does not exist.
    #[row(clause = "CiA 301 7.5.2.18")]
    NoEmcyInhibitTime,
    /// The inhibit time of EMCY starts with the write of 1015h.
    #[row(clause = "CiA 301 7.5.2.18", devices = &[CANOPEN_NODE])]
    InhibitFromWrite,
    /// 1003h does not exist.
    #[row(clause = "CiA 301 7.5.2.4")]
    NoErrorHistory,
    /// 1003h holds one error.
    #[row(clause = "CiA 301 7.5.2.4")]
    ShortErrorHistory,
    /// Every error has the code 1000h.
    #[row(clause = "CiA 301 7.2.7.1")]
    GenericErrorCodes,
    /// Every error sets only bit 0 of 1001h.
    #[row(clause = "CiA 301 7.5.2.2", devices = &[CANOPEN_STACK])]
    GenericErrorBit,
    /// 1029h does not exist.
    #[row(clause = "CiA 301 7.5.2.32")]
    NoErrorBehaviour,
    /// SYNC of a wrong length is ignored without EMCY.
    #[row(clause = "CiA 301 7.5.2.22")]
    SyncLengthUnreported,
    /// An RPDO with more bytes than its mapping is accepted without EMCY.
    #[row(clause = "CiA 301 7.5.2.36")]
    LongRpdoUnreported,
    /// The newest of the errors that occurred in stopped is signalled afterwards.
    #[row(clause = "CiA 301 7.3.2.2.4")]
    StoppedEmcyNewest,
    /// Errors that occurred in stopped are not signalled afterwards.
    #[row(clause = "CiA 301 7.3.2.2.4")]
    StoppedEmcyDropped,
    /// The loss of a heartbeat is not signalled by EMCY; the NMT state changes according to 1029h.
    #[row(clause = "CiA 301 7.2.8.2.2", devices = &[C_OPEN])]
    LostHeartbeatUnreported,
    // Monitoring
    /// 1016h does not exist.
    #[row(clause = "CiA 301 7.5.2.19", devices = &[LIKA, TR])]
    NoHeartbeatConsumer,
    /// 1016h has one entry.
    #[row(clause = "CiA 301 7.5.2.19")]
    OneHeartbeatConsumer,
    /// The device does not support node guarding: 100Ch and 100Dh do not exist, and remote frames are not answered.
    #[row(clause = "CiA 301 7.2.8.2.2", devices = &[CANOPEN_NODE])]
    NoGuarding,
    // SYNC, TIME and other services
    /// 1019h does not exist.
    #[row(clause = "CiA 301 7.5.2.22")]
    NoSyncCounter,
    /// 1007h does not exist.
    #[row(clause = "CiA 301 7.5.2.7", devices = &[CANOPEN_STACK])]
    NoSyncWindow,
    /// The device only consumes SYNC: it refuses bit 30 of 1005h, and 1006h and 1019h do not exist.
    #[row(clause = "CiA 301 7.5.2.5, 7.5.2.6", devices = &[KUEBLER, LIKA, TR])]
    NoSyncProducer,
    /// The device neither consumes nor produces TIME: 1012h and 1013h do not exist.
    #[row(clause = "CiA 301 7.5.2.15, 7.5.2.16")]
    NoTime,
    /// The device can't store or restore parameters: 1010h and 1011h do not exist.
    #[row(clause = "CiA 301 7.5.2.13, 7.5.2.14")]
    NoStore,
    /// 1020h does not exist.
    #[row(clause = "CiA 301 7.5.2.23")]
    NoConfigurationDate,
    /// The device has no second SDO channel.
    #[row(clause = "CiA 301 7.5.2.33")]
    NoFurtherSdo,
    /// 1028h does not exist.
    #[row(clause = "CiA 301 7.5.2.31")]
    NoEmcyConsumer,
    // PDO
    /// All PDOs are switched off as delivered, also in the EDS.
    #[row(clause = "CiA 301 7.5.2.35, 7.5.2.37", devices = &[CANOPEN_NODE])]
    PdosInvalid,
    /// The device has one RPDO and one TPDO.
    #[row(clause = "CiA 301 7.2.2.1")]
    OnePdo,
    /// The device has the communication profile only: no object at or above 2000h exists, and PDOs map nothing and are
    /// switched off.
    #[row(clause = "CiA 301 7.4.1", devices = &[CANOPEN_NODE])]
    NoApplicationObjects,
    /// Objects with more than four bytes can't be written.
    #[row(clause = "CiA 301 7.4.1")]
    NoLongObjects,
    /// A write over the bus is no event: only events of the application trigger TPDOs.
    #[row(clause = "CiA 301 7.2.2.3", devices = &[LELY])]
    OwnEvents,
    /// The first TPDO of transmission type n follows a SYNC in the middle of the first n SYNCs after the start, the
    /// others follow every n SYNCs.
    #[row(clause = "CiA 301 7.2.2.2, 7.3.2.2.3", devices = &[CANOPEN_NODE])]
    SyncCountFromMiddle,
    /// Synchronous TPDOs are sent 40 ms after SYNC, because 1007h sets no window as delivered.
    #[row(clause = "CiA 301 7.2.2.2, 7.5.2.7")]
    SyncTpdoIn40Ms,
    /// PDOs are only event-driven: other transmission types are refused with abort 0609 0030h.
    #[row(clause = "CiA 301 7.5.2.35, 7.5.2.37")]
    NoSynchronousPdos,
    /// TPDOs do not support remote frames: bit 30 of their COB-IDs is set and can't be cleared.
    #[row(clause = "CiA 301 7.5.2.37", devices = &[KUEBLER, LIKA])]
    NoRtr,
    /// The device does not support dummy mapping.
    #[row(clause = "CiA 301 7.5.2.36")]
    NoDummies,
    /// Only whole bytes can be mapped: Granularity=8.
    #[row(clause = "CiA 306-1, DeviceInfo")]
    MappingInBytes,
    /// A mapping that is longer than a PDO is refused with abort 0604 0042h when the first excess entry is written.
    #[row(clause = "CiA 301 7.5.2.38")]
    MappingLengthAtEntry,
    /// The mapping of PDOs can't be changed: Granularity=0, and all mapping objects are read-only.
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
    /// The default inhibit time of TPDO 1 is longer than its event timer.
    #[row(clause = "CiA 301 7.5.2.37", devices = &[PUBLISHED])]
    LongInhibitTime,
    /// TPDO 1 is valid as delivered, but maps no object.
    #[row(clause = "CiA 301 7.5.2.38", devices = &[PUBLISHED])]
    ValidAndEmpty,
    // LSS
    /// The device does not support Fastscan.
    #[row(clause = "CiA 305, Fastscan", devices = &[C_OPEN])]
    NoFastscan,
    /// LSS does not support inquiry services.
    #[row(clause = "CiA 305, inquiry services")]
    NoLssInquiry,
    /// The device does not support LSS.
    #[row(clause = "CiA 305, scope", devices = &[LIKA, TR])]
    NoLss,
    /// LSS store configuration is answered after 2 s.
    #[row(clause = "CiA 305, store configuration", devices = &[LELY])]
    LssStoreIn2S,
    /// After "activate bit timing" the device is silent for 200 ms longer than the two delays.
    #[row(clause = "CiA 305 6.4.4")]
    BitRateTakenLate,
    // The bus
    /// The device is also an SDO client: it reads the device type of node 127, or node 126, twice a second.
    #[row(clause = "CiA 301 7.2.4.1")]
    OwnSdoClient,
    /// The device sends bursts of additional frames with CAN-ID 6D0h, which no other device uses.
    #[row(clause = "CiA 301 7.3.5")]
    OwnTraffic,
    /// On SocketCAN the unused bytes of a classical frame are not zero.
    #[row(clause = "CiA 301 6.2", devices = &[C_OPEN, CAN_FESTIVAL])]
    DirtyPadding,
    // Descriptions
    /// The EDS has no LowLimit and no HighLimit.
    #[row(clause = "CiA 306-1, object sections", devices = &[PUBLISHED])]
    EdsWithoutLimits,
    /// The EDS has ObjFlags: 1010h and 1011h are excluded when all objects are written.
    #[row(clause = "CiA 306-1, object sections", devices = &[PUBLISHED])]
    EdsObjFlags,
    /// The EDS describes 1003h and 1016h by CompactSubObj.
    #[row(clause = "CiA 306-1, CompactSubObj", devices = &[PUBLISHED])]
    EdsCompactSubObj,
    /// The times in the EDS have hours of one digit.
    #[row(clause = "CiA 306-1, FileInfo", devices = &[PUBLISHED])]
    EdsOneDigitHour,
    /// The entries of the object lists in the EDS are not sorted by their numbers.
    #[row(clause = "CiA 306-1, object sections", devices = &[PUBLISHED])]
    EdsListsOutOfOrder,
    /// Lines of the EDS end with comments.
    #[row(clause = "CiA 306-1, general format", devices = &[PUBLISHED])]
    EdsInlineComments,
    /// The EDS contains characters of ISO 8859-1.
    #[row(clause = "CiA 306-1, general format", devices = &[PUBLISHED])]
    EdsLatin1,
    /// 1018h has no defaults in the EDS; the section DeviceInfo contains the numbers.
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
