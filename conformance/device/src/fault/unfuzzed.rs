//! Reasons why the fuzzer does not claim to find a fault.

use canvass_macros::Catalogue;

/// Why the fuzzer does not claim to find a fault. The text of a variant continues the sentence "The fault ...".
#[derive(Catalogue, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unfuzzed {
    /// changes a string: the models remember values of up to eight bytes
    StringChanged,
    /// is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so
    Refusal,
    /// is about a request that overlaps another: what a server does with a second request before its answer to the
    /// first is nowhere written
    OverlappingRequest,
    /// shows after more requests or resets in one go than a sequence has
    AfterManyRequests,
    /// is what the standard leaves open: a request that begins a transfer in the middle of a block transfer may be
    /// refused
    RequestInBlock,
    /// is an answer that the standard leaves open, so that every choice is right
    OpenAnswer,
    /// is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from
    /// device to device, so that the fuzzer takes what it reads after power-on for right
    WrongFromPowerOn,
    /// is about the event timer that an object of the profile is linked to: after a write to the one the models take
    /// the other for unknown
    LinkedTimer,
    /// shows only in what is loaded after something was stored or restored: each sequence begins with a device as
    /// delivered, and after a store the models can't know any more what a reset brings
    AfterStore,
    /// sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows
    AlarmBits,
    /// is about the history of errors: what stands in 1003h depends on errors that only the device knows
    ErrorHistory,
    /// is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models
    /// know the range of the position alone
    MeasuredValue,
    /// accepts a value that CiA 406 or the manual forbids: the models know the limits of the description and the rules
    /// of CiA 301 for values, not those of a profile
    ProfileLimits,
    /// comes in the moment of a reset, when a frame may still have been on its way
    MomentOfReset,
    /// shows before the write that causes it is confirmed, when the new heartbeat time may be in force or not
    BeforeConfirmation,
    /// is about when a lost node or master is noticed: whether and when a device reports an error, the models take from
    /// its EMCY messages and don't demand
    LossNoticed,
    /// is about what a device does on an error (1029h), or whether: what the error is, only its application knows, and
    /// a change of state by itself is followed, not demanded
    ErrorBehaviour,
    /// is about PDOs longer or shorter than their mapping: CiA 301 lets a device process or ignore the first, and only
    /// asks for an EMCY message on the second
    PdoLength,
    /// is about RPDOs that wait for SYNC or for their deadline: the models follow only those that act at once
    WaitingRpdo,
    /// is about what an RPDO held when operational was left, of which CiA 301 says nothing
    HeldRpdo,
    /// is a value beyond its limits that comes by PDO: nobody is answered, so that the models don't know whether it was
    /// taken
    ValueByPdo,
    /// is in the contents of TPDOs, which the models do not judge
    TpdoContents,
    /// is later or earlier than it should be by no more than the tolerance that a timer in milliseconds and a bus in
    /// use need
    WithinTolerance,
    /// makes a PDO wait longer than it should after an event: when a value has changed, only the device knows
    PdoDelayed,
    /// is about what counts as an event of a TPDO, which the manufacturer decides
    TpdoEvent,
    /// is about SYNC start value, window and counter of TPDOs, whose count the models take as unknown while one of them
    /// is in use
    SyncCount,
    /// is about a remote frame to a PDO that does not allow one, or about the moment whose values it shows: an answer
    /// is followed, not forbidden, and contents of PDOs are not judged
    RemoteFrame,
    /// is found too, but in some runs only by nine or ten frames: what the fuzzer claims, it shows by eight at most
    FoundByMoreFrames,
    /// switches a PDO on that carries nothing: a device may refuse that, or never send it
    EmptyPdo,
    /// is about SYNC or TIME that the device itself produces: the models follow its identifier, not its period and
    /// content
    OwnSyncOrTime,
    /// is about the clock of the device, which no service shows but objects of the manufacturer
    HiddenClock,
    /// is an EMCY message that is missing or comes too soon after another: which errors there are, only the device
    /// knows
    EmcyMissing,
    /// is found only in some runs: few of the values that the fuzzer draws show it
    FoundSometimes,
    /// is about the bit rate: after its activation nobody can follow on a bus of the old one
    BitRate,
    /// is about EMCY messages, of which the models take what the device reports and don't demand
    EmcyReported,
    /// shows only while the shaft turns
    ShaftTurning,
    /// is about requests of fewer than eight bytes, of which CiA 305 says nothing
    ShortLssRequest,
    /// contradicts the description: the models hold what the device does against the standards
    Description,
    /// is about the second SDO channel: the models follow the default one
    SecondSdoChannel,
    /// shows only after a configuration was stored, which the fuzzer does not do
    StoredConfiguration,
    /// is about what CiA 301 leaves open: when a producer sends TIME
    TimeProduced,
    /// is about what CiA 301 leaves open: what a device does with the time
    TimeConsumed,
    /// is about a clock of the device: how it goes, the models do not know
    ClockSpeed,
    /// is about the SYNC that a device produces itself, of which the models know the time alone
    OwnSyncTime,
    /// is about bit 31 of 1005h, which only DS-301 V3.0 gives a meaning
    SyncConsumerBit,
    /// is about the content of a TPDO, which the models don't judge
    TpdoContent,
    /// is a remote frame to a synchronous TPDO, of which CiA 301 does not say that it is answered
    RemoteSynchronous,
    /// is in the device description, not in the device: the cases of CiA 306 read it
    InDescription,
    /// is about events of TPDOs, which are the application's matter
    ApplicationEvent,
    /// is about SYNC, which the fuzzer sends with one CAN-ID
    SyncCanId,
    /// shows in the start of a device without node-ID, whose time the models leave open
    UnconfiguredStart,
    /// is about 1020h, which other writes change
    ConfigurationDate,
    /// shows only where another device answers: a simulated device is alone on its bus
    AnotherDevice,
    /// shows only with the right signature of a store, which the fuzzer never makes up
    StoreSignature,
}
