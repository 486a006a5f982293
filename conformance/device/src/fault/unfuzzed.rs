//! Reasons why the fuzzer does not claim to find a fault.

use canvass_macros::Catalogue;

/// Why the fuzzer does not claim to find a fault. The text of a variant continues the sentence "The fault ...".
#[derive(Catalogue, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unfuzzed {
    /// changes a string: the oracle of the fuzzer remembers only values of up to eight bytes
    StringChanged,
    /// is a refusal: a server may refuse a transfer or a value for its own reasons, with abort codes for them
    Refusal,
    /// concerns a request that overlaps another one: no standard defines the handling of a second request before the
    /// answer to the first
    OverlappingRequest,
    /// shows only after more consecutive requests or resets than a sequence has
    AfterManyRequests,
    /// concerns behaviour that the standard leaves open: a server may refuse a request that begins a transfer during a
    /// block transfer
    RequestInBlock,
    /// is an answer that the standard leaves open, so that every choice is correct
    OpenAnswer,
    /// is a value that is wrong since power-on: identity, serial number and capabilities differ between devices, so
    /// that the fuzzer accepts the values that it reads after power-on
    WrongFromPowerOn,
    /// concerns an event timer that is linked to an object of the profile: after a write to one of the two the oracle
    /// treats the other as unknown
    LinkedTimer,
    /// shows only in values that are loaded after a store or restore: each sequence begins with a device as delivered,
    /// and after a store the oracle no longer knows the values after a reset
    AfterStore,
    /// sets or keeps bits of alarms and warnings wrongly: only the application of a device knows its errors
    AlarmBits,
    /// concerns the error history: the content of 1003h depends on errors that only the device knows
    ErrorHistory,
    /// is a measured value that is wrong or does not follow the configuration: the only property of measured values
    /// that the oracle knows is the range of the position
    MeasuredValue,
    /// accepts a value that CiA 406 or the manual forbids: the oracle knows the limits of the description and the rules
    /// of CiA 301 for values, not those of a profile
    ProfileLimits,
    /// occurs at the moment of a reset, when frames may still be queued
    MomentOfReset,
    /// shows before the write that causes it is confirmed: until then the oracle does not know the heartbeat time
    BeforeConfirmation,
    /// concerns the detection of a lost node or master: the oracle follows the EMCY messages of a device, but does
    /// not demand them
    LossNoticed,
    /// concerns the reaction of a device to an error (1029h): only the application knows the error, and the oracle
    /// follows a change of state, but does not demand it
    ErrorBehaviour,
    /// concerns PDOs that are longer or shorter than their mapping: CiA 301 allows a device to process or ignore longer
    /// PDOs, and asks only for an EMCY message for shorter ones
    PdoLength,
    /// concerns RPDOs that wait for SYNC or for their deadline: the oracle follows only RPDOs that take effect
    /// immediately
    WaitingRpdo,
    /// concerns the values of an RPDO that waits when the device leaves operational, which CiA 301 does not define
    HeldRpdo,
    /// is a value outside its limits in a PDO: a PDO has no answer, so that the oracle does not know whether the value
    /// was accepted
    ValueByPdo,
    /// concerns the content of TPDOs, which the oracle does not judge
    TpdoContents,
    /// is a deviation in time within the tolerance for millisecond timers and bus load
    WithinTolerance,
    /// delays a PDO after an event: only the device knows when a value has changed
    PdoDelayed,
    /// concerns the events of a TPDO, which the manufacturer defines
    TpdoEvent,
    /// concerns SYNC start value, window and counter of TPDOs: while one of them is used, the oracle treats the SYNC
    /// count as unknown
    SyncCount,
    /// concerns the answer to a remote frame for a PDO that does not allow remote frames, or the time at which the PDO
    /// takes its values: the oracle follows an answer without forbidding it, and does not judge the content of PDOs
    RemoteFrame,
    /// is found as well, but in some runs only by nine or ten frames: the fuzzer claims faults that it shows with eight
    /// frames at most
    FoundByMoreFrames,
    /// switches on a PDO without mapped objects: a device may refuse this, or never send the PDO
    EmptyPdo,
    /// concerns SYNC or TIME that the device itself produces: the oracle follows its CAN-ID, but not its period and
    /// content
    OwnSyncOrTime,
    /// concerns the clock of the device, which only manufacturer-specific objects show
    HiddenClock,
    /// is an EMCY message that is missing or too soon after another one: only the device knows its errors
    EmcyMissing,
    /// is found only in some runs: few of the values that the fuzzer draws reveal it
    FoundSometimes,
    /// concerns the bit rate: after its activation no node can communicate on a bus with the old bit rate
    BitRate,
    /// concerns EMCY messages: the oracle accepts the errors that the device reports
    EmcyReported,
    /// shows only while the shaft turns
    ShaftTurning,
    /// concerns requests of fewer than eight bytes, which CiA 305 does not define
    ShortLssRequest,
    /// contradicts the description: the oracle compares the behaviour of the device with the standards
    Description,
    /// concerns the second SDO channel: the oracle follows the default channel
    SecondSdoChannel,
    /// shows only after a configuration was stored, and the fuzzer stores none
    StoredConfiguration,
    /// concerns the times at which a producer sends TIME, which CiA 301 leaves open
    TimeProduced,
    /// concerns the use of the received time, which CiA 301 leaves open
    TimeConsumed,
    /// concerns the speed of a clock of the device, which the oracle does not know
    ClockSpeed,
    /// concerns the SYNC that the device itself produces, of which the oracle knows only the time
    OwnSyncTime,
    /// concerns bit 31 of 1005h, which has a meaning only in DS-301 V3.0
    SyncConsumerBit,
    /// concerns the content of a TPDO, which the oracle does not judge
    TpdoContent,
    /// concerns a remote frame for a synchronous TPDO, to which CiA 301 demands no answer
    RemoteSynchronous,
    /// is in the device description, not in the device: the cases of CiA 306 read it
    InDescription,
    /// concerns events of TPDOs, which the application defines
    ApplicationEvent,
    /// concerns the CAN-ID of SYNC: the fuzzer uses a single one
    SyncCanId,
    /// shows at the start of a device without node-ID, whose time the oracle leaves open
    UnconfiguredStart,
    /// concerns 1020h, which a write to another object changes
    ConfigurationDate,
    /// shows only if another device answers: a simulated device is alone on its bus
    AnotherDevice,
    /// shows only with the correct signature of a store, which the fuzzer never generates
    StoreSignature,
}
