//! Firmware faults that a simulated device can have, drawn from defects of real devices and stacks.

mod unfuzzed;

pub use unfuzzed::Unfuzzed;

use Fuzz::{Allowed, Found, Never};
use Unfuzzed::*;
use canvass_analyzer::meant;
use canvass_macros::Catalogue;
use std::fmt;
use std::str::FromStr;

/// A defect of a firmware. Each fault is a separate switch; faults can be combined.
#[derive(Catalogue, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Fault {
    /// No boot-up message after a reset.
    BootUpMissing,
    /// Two boot-up messages after a reset.
    BootUpTwice,
    /// The boot-up message carries the state pre-operational instead of 00h.
    BootUpWrongData,
    /// NMT commands to node-ID 0 are ignored.
    #[row(fuzz = Allowed("other-nodes"))]
    NmtBroadcastIgnored,
    /// NMT commands to other nodes are executed.
    #[row(fuzz = Allowed("other-nodes"))]
    NmtNodeIdIgnored,
    /// A reserved NMT command puts the node into stopped.
    NmtUnknownCommandStops,
    /// Reset commands are ignored in stopped.
    NmtResetWhenStoppedIgnored,
    /// Start remote node is ignored in stopped.
    NmtStartWhenStoppedIgnored,
    /// Reset communication does not restore unsaved communication parameters.
    NmtResetCommunicationKeepsParameters,
    /// A persistent hardware error, which EMCY 5000h reports after each start, prevents the device from entering
    /// operational.
    NmtStartRefusedInError,
    /// Stop remote node is ignored in operational.
    NmtStopWhenOperationalIgnored,
    /// Enter pre-operational is ignored.
    NmtEnterPreOperationalIgnored,
    /// An NMT command to the current state restarts the node.
    NmtRepeatedCommandResets,
    /// An NMT frame without node-ID is taken as a command to the node.
    #[row(fuzz = Allowed("other-nodes"))]
    NmtShortFrameObeyed,
    /// Reset node does not restore unsaved parameters.
    NmtResetNodeKeepsParameters,
    /// The SDO server does not answer in operational.
    SdoSilentWhenOperational,
    /// After a misplaced download segment was refused, the next upload of a four-byte value returns the bytes of this
    /// segment.
    SdoRefusedSegmentServed,
    /// A download segment during an upload is refused, but overwrites the value of the upload.
    #[row(fuzz = Never(StringChanged))]
    SdoSegmentWrittenInUpload,
    /// A segment without a transfer is not answered.
    SdoStraySegmentSilent,
    /// A new request during a segmented transfer is refused with abort 0504 0001h.
    SdoBusyAfterAbandonedTransfer,
    /// A download that does not state its length is not answered.
    SdoUnsizedDownloadSilent,
    /// The SDO server answers in stopped.
    SdoAnsweredWhenStopped,
    /// A request that arrives in stopped is answered after the device has left stopped.
    SdoRequestKeptOverStop,
    /// Heartbeats show pre-operational in every state.
    HeartbeatWrongState,
    /// Heartbeats have twice the period of 1017h.
    HeartbeatPeriodDoubled,
    /// Writing 0 to 1017h does not end the heartbeat.
    HeartbeatNotStopped,
    /// Aborts name the object of the previous transfer.
    SdoStaleMultiplexer,
    /// An object that does not exist is refused with abort 0609 0011h.
    SdoWrongCodeForNoObject,
    /// A sub-index that does not exist is refused with abort 0602 0000h.
    SdoWrongCodeForNoSubIndex,
    /// Downloads to read-only objects are confirmed.
    SdoReadOnlyWritable,
    /// A download to a read-only object is refused with abort 0800 0022h.
    SdoReadOnlyWrongCode,
    /// Downloads that are too long are confirmed.
    SdoLengthUnchecked,
    /// Downloads that are too short are confirmed.
    SdoShortLengthUnchecked,
    /// An unknown SDO command specifier is not answered.
    SdoUnknownCommandSilent,
    /// An unknown SDO command specifier as the first request after boot-up is not answered.
    SdoFirstUnknownCommandSilent,
    /// The server answers an abort of the client with an abort.
    SdoAbortAnswered,
    /// Segments whose toggle bit does not alternate are accepted.
    SdoToggleUnchecked,
    /// A wrong toggle bit is refused with abort 0504 0001h.
    SdoToggleWrongCode,
    /// The toggle bit of upload segments is always 0.
    SdoUploadToggleStuck,
    /// The toggle bit of confirmed download segments is always 0.
    SdoConfirmationToggleStuck,
    /// The last segment of an upload is not marked as the last.
    SdoUploadEndMissing,
    /// A segmented upload announces one byte more than the value has.
    SdoAnnouncedSizeWrong,
    /// A request for a further segment after the last segment of an upload is answered.
    SdoSegmentAfterEndAnswered,
    /// Each segment of a download is written to the object immediately, before the transfer is complete.
    SdoSegmentsWrittenAtOnce,
    /// Objects of up to four bytes can't be written in segments.
    #[row(fuzz = Never(Refusal))]
    SdoSegmentedShortRefused,
    /// A segmented download that does not announce its size is refused.
    SdoSegmentedSizeRequired,
    /// A download segment without data is not answered.
    SdoEmptySegmentSilent,
    /// Read-only objects are protected against expedited downloads only.
    SdoReadOnlySegmentedAccepted,
    /// An abort of the client does not end the transfer.
    SdoAbortIgnored,
    /// A command that is not allowed in the current transfer is not answered.
    SdoWrongCommandIgnored,
    /// Commands of a block transfer are not answered when no block transfer is in progress.
    SdoStrayBlockSilent,
    /// A new request during a segmented download is refused with abort 0504 0001h.
    SdoBusyAfterAbandonedDownload,
    /// A second request that comes before the answer to the first one changes the object that this answer names.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(OverlappingRequest))]
    SdoBackToBackMixed,
    /// Every hundredth request is not answered.
    #[row(fuzz = Never(AfterManyRequests))]
    SdoResponseLost,
    /// The SDO server stops working after a request of fewer than eight bytes.
    SdoShortRequestWedges,
    /// A remote frame with the CAN-ID of SDO requests is answered.
    SdoRemoteAnswered,
    /// A 29-bit frame whose lower 11 bits are the CAN-ID of SDO requests is answered.
    SdoExtendedAnswered,
    /// SDO requests to the next higher node-ID are also answered.
    #[row(fuzz = Allowed("other-nodes"))]
    SdoOtherNodeAnswered,
    /// The SDO server stops working after a transfer that the client did not continue.
    SdoTimeoutWedges,
    /// Requests to objects that do not exist are not answered.
    SdoNoObjectSilent,
    /// Aborts name object 0000h:00.
    SdoAbortMultiplexerZero,
    /// A wrong length is refused with abort 0609 0030h.
    SdoLengthWrongCode,
    /// A value outside its limits is refused with abort 0601 0002h.
    #[row(model = "kuebler-sendix-58x8")]
    SdoRangeWrongCode,
    /// Wrong command specifiers are refused with abort 0800 0000h.
    SdoCommandWrongCode,
    /// A sub-index that does not exist is refused with abort 0A00 0001h, which no standard defines.
    SdoUnknownAbortCode,
    /// Reading a write-only object is refused with abort 0602 0000h.
    SdoWriteOnlyWrongCode,
    /// The upload of an empty string is not answered.
    SdoEmptyValueSilent,
    /// A new request during a block transfer is refused with abort 0504 0001h.
    #[row(fuzz = Never(RequestInBlock))]
    SdoBusyAfterAbandonedBlock,
    /// Block sizes of 0 and above 127 are accepted.
    SdoBlockSizeUnchecked,
    /// Wrong block sizes are refused with abort 0609 0030h.
    SdoBlockSizeWrongCode,
    /// A block upload continues with the next block, whatever the client confirms.
    SdoBlockConfirmationIgnored,
    /// The confirmation of segments that were not sent is accepted.
    SdoBlockConfirmationUnchecked,
    /// After a lost segment the whole block is sent again instead of the unconfirmed segments.
    SdoBlockRepeatsAll,
    /// All blocks of an upload have the size of the first.
    SdoBlockNewSizeIgnored,
    /// A block upload announces one byte more than the value has.
    SdoBlockAnnouncedSizeWrong,
    /// The end of a block upload gives one unused byte too many.
    SdoBlockLastLengthWrong,
    /// The end of a block upload of a multiple of 7 bytes tells that the last segment holds no data.
    SdoBlockSevenEndsEmpty,
    /// The CRC of block uploads starts with FFFFh.
    SdoBlockCrcStartWrong,
    /// The CRC of block uploads has its bytes in the wrong order.
    SdoBlockCrcSwapped,
    /// The end of a block upload without CRC contains a CRC.
    SdoBlockCrcUnasked,
    /// The last segment of a block upload is not marked as the last.
    SdoBlockEndUnmarked,
    /// The sequence numbers of a block upload do not begin with 1 in every block.
    SdoBlockNumbersContinue,
    /// The server requests blocks of 0 segments.
    SdoBlockSizeZeroOffered,
    /// A block download to a read-only object is confirmed, without effect.
    SdoBlockReadOnlyAccepted,
    /// Every block download is refused with abort 0607 0013h.
    #[row(fuzz = Never(Refusal))]
    SdoBlockDownloadRefused,
    /// A segment with sequence number 0 is ignored.
    #[row(fuzz = Never(OpenAnswer))]
    SdoBlockSequenceZeroIgnored,
    /// The data of a repeated segment is written twice.
    SdoBlockRepeatedAppended,
    /// A block download continues although a segment was lost.
    SdoBlockGapAccepted,
    /// The unused bytes of the last segment of a block download are stored as data.
    SdoBlockPaddingKept,
    /// The CRC of block downloads is not checked.
    SdoBlockCrcIgnored,
    /// The CRC of a block download without CRC is checked after a block download with CRC.
    SdoBlockCrcKept,
    /// A wrong CRC is refused with abort 0800 0000h.
    SdoBlockCrcWrongCode,
    /// The value of a block download is written before its CRC is checked.
    SdoBlockWrittenBeforeCheck,
    /// A block download whose size differs from the announced size is accepted.
    SdoBlockSizeMismatchAccepted,
    /// The confirmation of a downloaded block counts one segment too few.
    SdoBlockCountOffByOne,
    /// The end of a block download is not confirmed.
    SdoBlockEndSilent,
    /// The last segment of an upload announces one byte too few.
    SdoSegmentLengthWrong,
    /// Reserved bytes of SDO responses hold old data.
    #[row(model = "kuebler-sendix-58x8")]
    SdoUnusedBytesNotZero,
    /// SDO responses have fewer than eight bytes if they carry less data.
    #[row(model = "kuebler-sendix-58x8")]
    SdoShortResponse,
    /// 1018h:01 is 0.
    #[row(fuzz = Never(WrongFromPowerOn))]
    VendorIdZero,
    /// 1000h names device profile 401 instead of the encoder profile.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(WrongFromPowerOn))]
    DeviceTypeProfileWrong,
    /// 1018h:03 does not exist, although LSS needs it.
    IdentityRevisionMissing,
    /// 1001h does not exist.
    ErrorRegisterMissing,
    /// 1008h ends with bytes that are not printable.
    #[row(fuzz = Never(WrongFromPowerOn))]
    DeviceNameWithGarbage,
    /// TPDOs are sent in pre-operational.
    TpdoInPreOperational,
    /// TPDOs have twice the period of their event timer.
    EventTimerDoubled,
    /// Heartbeats have bit 7 set.
    HeartbeatToggles,
    /// The heartbeat ends when the NMT state changes.
    HeartbeatLostOnStateChange,
    /// 1016h accepts two entries for one node.
    HeartbeatConsumerDoubleAccepted,
    /// The toggle bit of node guarding answers does not alternate.
    GuardingToggleStuck,
    /// Values outside the limits of the device description are confirmed.
    #[row(model = "kuebler-sendix-58x8")]
    SdoRangeUnchecked,
    /// TPDOs are sent in stopped.
    TpdoWhenStopped,
    /// TPDOs of transmission type n are sent at every SYNC.
    SyncCycleIgnored,
    /// The inhibit time of TPDOs is not observed.
    InhibitTimeIgnored,
    /// The CAN-ID of a PDO can be changed while the PDO is valid.
    CobIdChangeWhileValid,
    /// Restricted CAN-IDs are accepted for PDOs, SYNC and EMCY.
    RestrictedCanIdAccepted,
    /// Reserved transmission types are accepted.
    ReservedTransmissionTypeAccepted,
    /// The mapping can be changed while the PDO is valid.
    MappingChangeWhileValid,
    /// Mappings of more than 64 bits are accepted.
    #[row(model = "kuebler-sendix-58x8")]
    MappingTooLongAccepted,
    /// Objects that are not PDO-mappable can be mapped.
    UnmappableObjectMapped,
    /// 6200h does not change the event timer of TPDO 1.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LinkedTimer))]
    CyclicTimerNotLinked,
    /// 1010h and 1011h accept any value as their signature.
    #[row(fuzz = Allowed("nvm"))]
    StoreSignatureUnchecked,
    /// 1010h confirms "save", but stores nothing.
    #[row(fuzz = Never(AfterStore))]
    StoreWithoutEffect,
    /// 1011h restores the defaults immediately instead of at the next reset.
    #[row(fuzz = Never(AfterStore))]
    RestoreAtOnce,
    /// EMCY messages are sent in stopped.
    EmcyWhenStopped,
    /// The device sends no EMCY 0000h when an error is gone.
    EmcyResetMissing,
    /// An EMCY message is sent twice.
    EmcyRepeated,
    /// The generic bit of 1001h is not set together with other bits.
    #[row(fuzz = Never(AlarmBits))]
    ErrorRegisterGenericMissing,
    /// Writing 0 to 1003h:00 does not clear the history.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryNotCleared,
    /// LSS confirms node-IDs that don't exist.
    #[row(fuzz = Allowed("node-id"))]
    LssNodeIdUnchecked,
    /// LSS inquiries are answered in the waiting state.
    LssAnsweredWhileWaiting,
    /// 6003h is confirmed, but the position does not change.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    PresetIgnored,
    /// 6003h accepts values outside the measuring range.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ProfileLimits))]
    PresetOutOfRangeAccepted,
    /// Bit 0 of 6000h does not reverse the direction of counting.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    CodeSequenceIgnored,
    /// 6001h and 6002h do not scale the position.
    #[row(model = "kuebler-sendix-58x8")]
    ScalingIgnored,
    /// 6500h does not follow 6000h.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    OperatingStatusStuck,
    /// Reset communication also resets application parameters.
    NmtResetCommunicationRestoresAll,
    /// Only the first of several NMT commands within one millisecond is executed.
    NmtCommandLost,
    /// Frames with 29-bit identifiers are handled like frames with the same lower 11 bits.
    ExtendedFrameObeyed,
    /// Every eighth reset ends without a boot-up message.
    #[row(fuzz = Never(AfterManyRequests))]
    BootUpSometimesMissing,
    /// An EMCY message is sent before the boot-up message.
    #[row(fuzz = Never(MomentOfReset))]
    EmcyBeforeBootUp,
    /// The SDO server answers before the boot-up message.
    SdoAnsweredBeforeBootUp,
    /// The device stays in pre-operational, whatever 1F80h contains.
    #[row(fuzz = Never(AfterStore))]
    StartUpIgnored,
    /// Heartbeat times are rounded up to multiples of 64 ms.
    HeartbeatTimerRounded,
    /// A new heartbeat time that is written while heartbeats are sent causes a burst of heartbeats.
    #[row(fuzz = Never(BeforeConfirmation))]
    HeartbeatBurst,
    /// The first heartbeat after a reset comes three periods after the boot-up message.
    #[row(fuzz = Never(AfterStore))]
    HeartbeatLateAfterBootUp,
    /// A heartbeat shows the state at the time of the previous heartbeat.
    HeartbeatStateLate,
    /// Reset communication does not reset the toggle bit of node guarding.
    GuardingToggleNotReset,
    /// Node guarding is answered while heartbeats are sent.
    GuardingBesideHeartbeat,
    /// Life guarding begins without a first remote frame of the master.
    #[row(fuzz = Never(LossNoticed))]
    LifeGuardingStartsAtOnce,
    /// The loss of the master is reported after the guard time, whatever the life time factor is.
    #[row(fuzz = Never(LossNoticed))]
    LifeTimeFactorIgnored,
    /// The loss of a node is reported although no heartbeat of the node was ever received.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerStartsAtOnce,
    /// Node 1 is not monitored, whatever 1016h contains.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerDeafToNodeOne,
    /// Heartbeats of monitored nodes do not count while the device is stopped.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerDeafWhenStopped,
    /// Each write to any object restarts monitoring, as if no heartbeat had come yet.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerRestartedByWrites,
    /// The device still monitors a node after a reset has cleared 1016h.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerOutlivesReset,
    /// The return of a lost node is not detected.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerNotRearmed,
    /// Only the first entry of 1016h monitors its node.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerFirstOnly,
    /// 1029h has no effect: an error never changes the NMT state.
    #[row(fuzz = Never(ErrorBehaviour))]
    ErrorBehaviourIgnored,
    /// 1029h accepts reserved values.
    ErrorBehaviourUnchecked,
    /// With 1029h:01 = 0 an error in stopped leads to pre-operational.
    #[row(fuzz = Never(ErrorBehaviour))]
    ErrorBehaviourLeavesStopped,
    /// RPDOs take effect in pre-operational.
    RpdoInPreOperational,
    /// RPDOs that are too short take effect, with zeros in place of the missing bytes.
    #[row(fuzz = Never(PdoLength))]
    RpdoLengthUnchecked,
    /// An RPDO that is too short is ignored without EMCY.
    #[row(fuzz = Never(PdoLength))]
    ShortRpdoUnreported,
    /// RPDOs that are longer than their mapping have no effect.
    #[row(fuzz = Never(PdoLength))]
    LongRpdoIgnored,
    /// An RPDO that is longer than its mapping is reported as a late RPDO, by EMCY 8250h.
    #[row(fuzz = Never(PdoLength))]
    LongRpdoCalledLate,
    /// Synchronous RPDOs don't wait for SYNC.
    #[row(fuzz = Never(WaitingRpdo))]
    SynchronousRpdoActsAtOnce,
    /// RPDOs of the transmission types 0 and 240 take effect without waiting for SYNC.
    #[row(fuzz = Never(WaitingRpdo))]
    OuterSynchronousRpdosActAtOnce,
    /// A missing RPDO is not detected after its deadline.
    #[row(fuzz = Never(WaitingRpdo))]
    RpdoDeadlineIgnored,
    /// The deadline of an RPDO continues to run after the device has left operational.
    #[row(fuzz = Never(WaitingRpdo))]
    RpdoDeadlineOutlivesStop,
    /// The deadline of an RPDO starts with the first reception, and later receptions do not restart it.
    #[row(fuzz = Never(WaitingRpdo))]
    RpdoDeadlineNotRestarted,
    /// Values of a synchronous RPDO that wait for SYNC are kept when the device leaves operational.
    #[row(fuzz = Never(HeldRpdo))]
    RpdoHeldOverStop,
    /// RPDOs take effect although bit 31 of their COB-ID is set.
    RpdoReceivedWhenInvalid,
    /// An RPDO can set values that an SDO download can't.
    #[row(fuzz = Never(ValueByPdo))]
    RpdoRangeUnchecked,
    /// A remote frame with the CAN-ID of an RPDO sets its objects to zero.
    RemoteFrameTakenAsRpdo,
    /// A TPDO carries one object more than sub-index 0 of its mapping counts, if the following entry is set.
    #[row(fuzz = Never(TpdoContents))]
    TpdoBeyondCount,
    /// The period of TPDOs is one millisecond longer than their event timer.
    #[row(fuzz = Never(WithinTolerance))]
    EventTimerOffByOne,
    /// The inhibit time counts in milliseconds instead of 100 microseconds.
    #[row(fuzz = Never(PdoDelayed))]
    InhibitTimeInMilliseconds,
    /// TPDOs of transmission type 0 are sent at every SYNC.
    #[row(fuzz = Never(TpdoEvent))]
    AcyclicTpdoWithoutEvent,
    /// A TPDO without SYNC start value waits for a SYNC whose counter is 0, which never comes.
    #[row(fuzz = Never(SyncCount))]
    SyncWithoutStartValueIgnored,
    /// Synchronous TPDOs are sent once when the device starts.
    #[row(fuzz = Never(TpdoEvent))]
    SynchronousTpdoAtStart,
    /// The SYNC start value of TPDOs has no effect.
    #[row(fuzz = Never(SyncCount))]
    SyncStartValueIgnored,
    /// The SYNC count of TPDOs of transmission type n does not restart when the device becomes operational.
    #[row(fuzz = Never(SyncCount))]
    SyncCountNotReset,
    /// Event-driven TPDOs are not sent when the device becomes operational.
    #[row(fuzz = Never(TpdoEvent))]
    TpdoNotSentAtStart,
    /// A change of the value within the inhibit time of a TPDO is never sent.
    #[row(fuzz = Never(TpdoEvent))]
    TpdoLostWhenInhibited,
    /// Remote frames are answered although bit 30 of the COB-ID is set.
    #[row(fuzz = Never(RemoteFrame))]
    RemoteFrameAnsweredWhenNotAllowed,
    /// A TPDO of transmission type 252 holds the values at the remote frame instead of the values at the last SYNC.
    #[row(fuzz = Never(RemoteFrame))]
    RtrTypeSampledAtOnce,
    /// Transmission types 252 and 253 are accepted although remote frames are not supported.
    #[row(model = "reference-406", fuzz = Never(OpenAnswer))]
    RtrTypeWithoutRtrAccepted,
    /// Bit 30 of a COB-ID can be cleared although remote frames are not supported.
    #[row(model = "reference-406", fuzz = Never(OpenAnswer))]
    RtrBitClearable,
    /// The inhibit time can be changed while the PDO is valid.
    #[row(fuzz = Never(FoundByMoreFrames))]
    InhibitTimeChangeWhileValid,
    /// The SYNC start value can be changed while the PDO is valid.
    SyncStartValueChangeWhileValid,
    /// A PDO without mapping can be made valid.
    #[row(fuzz = Never(EmptyPdo))]
    EmptyPdoValidated,
    /// Sub-index 0 of a mapping accepts any number of entries.
    MappingCountUnchecked,
    /// Objects that do not exist can be mapped.
    MissingObjectMapped,
    /// Dummy entries can be mapped into TPDOs.
    DummyMappedIntoTpdo,
    /// SYNC is produced with twice the period of 1006h.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncPeriodDoubled,
    /// SYNC is produced in stopped.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncWhenStopped,
    /// The SYNC counter does not restart after stopped.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncCounterNotReset,
    /// The SYNC counter begins with 0.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncCounterFromZero,
    /// 1019h accepts 1 and values above 240.
    SyncOverflowUnchecked,
    /// 1019h can be changed while 1006h is not 0.
    SyncOverflowChangeWhileProducing,
    /// The CAN-ID of SYNC can be changed while SYNC is produced.
    SyncIdChangeWhileProducing,
    /// SYNC messages with a wrong length are accepted.
    #[row(fuzz = Never(OpenAnswer))]
    SyncLengthUnchecked,
    /// TIME does not set the clock.
    #[row(fuzz = Never(HiddenClock))]
    TimeIgnored,
    /// The CAN-ID of TIME can be changed while TIME is in use.
    TimeIdChangeWhileValid,
    /// TIME is produced with reserved bits set.
    #[row(fuzz = Never(OwnSyncOrTime))]
    TimeReservedBitsSet,
    /// The COB-IDs of 1201h can be changed while the channel is valid.
    SdoChannelIdChangeWhileValid,
    /// 1015h has no effect.
    #[row(fuzz = Never(EmcyMissing))]
    EmcyInhibitTimeIgnored,
    /// No error is signalled while the inhibit time of EMCY is not 0.
    #[row(fuzz = Never(EmcyMissing))]
    EmcyMutedByInhibitTime,
    /// Errors within the inhibit time of EMCY are never reported.
    #[row(fuzz = Never(EmcyMissing))]
    EmcyLostWhenInhibited,
    /// Errors that occur in stopped are never reported.
    #[row(fuzz = Never(EmcyMissing))]
    EmcyLostWhenStopped,
    /// The CAN-ID of EMCY can be changed while EMCY is valid.
    EmcyIdChangeWhileValid,
    /// EMCY messages are sent although bit 31 of 1014h is set.
    EmcySentWhenInvalid,
    /// Each reading of 1001h sends EMCY 0000h.
    #[row(fuzz = Never(AlarmBits))]
    EmcyResetUnasked,
    /// EMCY messages that wait for the inhibit time are sent after reset communication.
    #[row(fuzz = Never(AlarmBits))]
    EmcySurvivesReset,
    /// EMCY is sent on 080h + node-ID, whatever CAN-ID is written to 1014h.
    #[row(fuzz = Never(FoundSometimes))]
    EmcyKeepsCanId,
    /// EMCY is sent as a remote frame if 1014h has another CAN-ID than 080h + node-ID.
    #[row(fuzz = Never(FoundSometimes))]
    EmcyMovedIsRemote,
    /// EMCY messages hold 0 instead of the error register.
    EmcyRegisterZero,
    /// 1003h shows the oldest error first.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryReversed,
    /// Clearing 1003h ends all errors, and EMCY 0000h reports that.
    #[row(fuzz = Never(ErrorHistory))]
    HistoryClearsRegister,
    /// A new error moves only the first two entries of 1003h: all entries after them show the second error.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryMovesTwo,
    /// 1003h:00 counts more errors than 1003h has entries.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryOverflows,
    /// 1003h:00 accepts values other than 0.
    ErrorHistoryNonZeroAccepted,
    /// Entries of 1003h that hold no error read as 0.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryEmptyReadsZero,
    /// 1011h accepts any value as its signature.
    #[row(fuzz = Allowed("factory-defaults"))]
    RestoreSignatureUnchecked,
    /// After "save", later writes are stored as well.
    #[row(fuzz = Never(AfterStore))]
    LaterValuesStored,
    /// 1010h and 1011h check the signature at sub-index 1 only.
    #[row(fuzz = Allowed("nvm"))]
    StoreSignatureFirstOnly,
    /// 1011h confirms "load", but the stored values stay.
    #[row(fuzz = Never(AfterStore))]
    RestoreWithoutEffect,
    /// Every sub-index of 1011h restores all parameters.
    #[row(fuzz = Never(AfterStore))]
    RestoreGroupIgnored,
    /// 1010h does not store application parameters.
    #[row(fuzz = Never(AfterStore))]
    StoreLosesGroup,
    /// Every sub-index of 1010h stores all parameters.
    #[row(fuzz = Never(AfterStore))]
    StoreGroupIgnored,
    /// A reset while parameters are being stored leaves some of them new and some old.
    #[row(fuzz = Never(AfterStore))]
    StoreTornByReset,
    /// Switch selective does not compare the serial number.
    LssSelectiveThreeParts,
    /// Switch selective accepts the parts of the address in any order.
    LssSelectiveAnyOrder,
    /// Identify remote slave excludes the upper bounds.
    LssIdentifyRangeExclusive,
    /// A device with a node-ID answers identify non-configured remote slave.
    LssNonConfiguredAnswered,
    /// Reserved modes of switch global switch the slave to waiting.
    #[row(fuzz = Never(OpenAnswer))]
    LssReservedModeWaits,
    /// LSS confirms bit rates that don't exist.
    #[row(fuzz = Allowed("bit-rate"))]
    LssBitTimingUnchecked,
    /// LSS refuses bit rates with the manufacturer-specific error code.
    #[row(fuzz = Never(OpenAnswer))]
    LssBitTimingWrongCode,
    /// The LSS confirmation of store configuration contains a specific error code although there is no error.
    #[row(fuzz = Allowed("nvm"))]
    LssStoreSpecificError,
    /// LSS confirms store configuration, but stores nothing.
    #[row(fuzz = Never(AfterStore))]
    LssStoreNotPersistent,
    /// A node-ID configured by LSS takes effect before the reset.
    #[row(fuzz = Allowed("node-id"))]
    LssNodeIdAtOnce,
    /// Activate bit timing does not wait for its delay.
    #[row(fuzz = Never(BitRate))]
    LssActivatesAtOnce,
    /// Fastscan ends at any part of the address after which the master returns to the first part.
    FastscanEarlyMatch,
    /// An entry of 1016h for a node-ID above 127 stops the firmware.
    HeartbeatConsumerHangs,
    /// A reset in stopped stops the firmware: it does not start again.
    ResetWhenStoppedHangs,
    /// A Fastscan for a part above 3 stops the firmware.
    FastscanHangs,
    /// A device with a node-ID takes part in Fastscan.
    FastscanAnsweredWhenConfigured,
    /// A device without node-ID starts with node-ID 127.
    UnconfiguredNodeBoots,
    /// Many frames in a short time make the watchdog reset the device.
    #[row(fuzz = Never(AfterManyRequests))]
    WatchdogResetUnderLoad,
    /// The SDO server runs out of memory after 500 requests, and no longer answers.
    #[row(fuzz = Never(AfterManyRequests))]
    SdoMemoryLeak,
    /// 11-bit CAN-IDs above 7FFh are accepted for PDOs.
    CanIdTooHighAccepted,
    /// The CAN-IDs 550h to 57Fh are refused as if CiA 301 restricted them.
    #[row(fuzz = Never(Refusal))]
    CanIdsTakenForRestricted,
    /// While a PDO is valid, only bits 7 to 10 of its CAN-ID are protected against changes.
    #[row(fuzz = Never(FoundSometimes))]
    CanIdLowBitsMovable,
    /// Bits 11 to 28 of 1005h and 1014h are not checked.
    #[row(fuzz = Never(FoundSometimes))]
    CobIdBitsUnchecked,
    /// Bit 29 of 1014h, 1028h and 1201h is accepted, but has no effect.
    #[row(fuzz = Never(FoundSometimes))]
    CobIdFrameBitTaken,
    /// 1012h, which is described as writable, refuses each value with abort 0609 0030h.
    #[row(fuzz = Never(Refusal))]
    TimeIdRefused,
    /// While an entry of 1016h monitors a node, the other entries refuse any other node with abort 0604 0043h.
    #[row(fuzz = Never(Refusal))]
    ConsumerEntriesExclude,
    /// A SYNC start value has no effect if 1019h is written after it.
    #[row(fuzz = Never(SyncCount))]
    LateSyncCounterOverlooked,
    /// With a SYNC start value, every TPDO waits for the SYNC with that counter value, not only the first TPDO.
    #[row(fuzz = Never(SyncCount))]
    SyncStartAgain,
    /// A TPDO with a SYNC start value begins with the first SYNC whose counter has reached or passed that value.
    #[row(fuzz = Never(SyncCount))]
    SyncStartPassedBegins,
    /// EMCY 0000h carries the error register from before the end of the error.
    #[row(fuzz = Never(EmcyReported))]
    EmcyResetRegisterWrong,
    /// In units per second the speed counts physical steps, whatever 6001h says.
    #[row(model = "reference-406", fuzz = Never(ShaftTurning))]
    SpeedInPhysicalSteps,
    /// With scaling on, the position without offset is always 0.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    ScaledPositionStands,
    /// 6001h and 6002h, which are described as writable, refuse each value with abort 0609 0030h.
    #[row(model = "reference-406", fuzz = Never(Refusal))]
    ScalingRefused,
    /// 6001h refuses values below its current value.
    #[row(model = "reference-406", fuzz = Never(Refusal))]
    UnitsFewerRefused,
    /// 6002h refuses values below its current value.
    #[row(model = "reference-406", fuzz = Never(Refusal))]
    RangeSmallerRefused,
    /// Only the first mapped object of an RPDO receives its value.
    #[row(fuzz = Never(FoundSometimes))]
    RpdoFirstObjectOnly,
    /// Inhibit time and SYNC start value of a TPDO, which are described as writable, refuse every new value, even while
    /// the PDO is switched off.
    #[row(fuzz = Never(Refusal))]
    PdoTimesRefused,
    /// The mapping of TPDO 1 as delivered has a wrong length.
    DefaultMappingWrong,
    /// Dummy entries can't be mapped into RPDOs.
    #[row(fuzz = Never(Refusal))]
    DummyRefused,
    /// 1014h contains another CAN-ID than EMCY messages have.
    EmcyIdWrong,
    /// With 1029h:01 = 1, an error still leads to pre-operational.
    #[row(fuzz = Never(ErrorBehaviour))]
    ErrorBehaviourAlwaysLeaves,
    /// 1003h:00 always stays 0.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryNotKept,
    /// Bit 29 of a COB-ID is accepted and has no effect.
    ExtendedBitAccepted,
    /// Every Fastscan matches, whatever it compares.
    FastscanIgnoresBits,
    /// A stored entry of 1016h reads back after the start, but monitors no node.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerForgetsStored,
    /// The loss of a monitored node is reported after twice its consumer heartbeat time.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerLate,
    /// Only the first heartbeat of a monitored node counts.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerNotRestarted,
    /// An entry of 1016h still monitors its node after its time is set to 0.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerNotStopped,
    /// The loss of a monitored node is not reported by EMCY.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerSilent,
    /// Identify remote slave and identify non-configured remote slave are not answered.
    LssIdentifyUnanswered,
    /// Identify remote slave is answered whatever its bounds are.
    LssIdentifyUnchecked,
    /// LSS inquiries return the parts of the address with the bytes in the wrong order.
    LssInquirySwapped,
    /// The LSS inquiry of the node-ID returns the node-ID plus one.
    LssNodeIdInquiredWrong,
    /// LSS refuses every node-ID.
    #[row(fuzz = Allowed("node-id"))]
    LssNodeIdRefused,
    /// LSS confirms a node-ID, but does not change it.
    #[row(fuzz = Allowed("node-id"))]
    LssNodeIdWithoutEffect,
    /// LSS confirms a node-ID, but configures the next higher one.
    #[row(fuzz = Allowed("node-id"))]
    LssNodeIdMistaken,
    /// Switch selective is answered in configuration.
    #[row(fuzz = Never(OpenAnswer))]
    LssSelectiveInConfiguration,
    /// Switch selective compares the serial number only.
    LssSelectiveSerialOnly,
    /// Switch selective is executed but not answered.
    LssSelectiveUnanswered,
    /// LSS responses have five bytes.
    LssShortResponse,
    /// LSS requests of fewer than eight bytes are answered.
    #[row(fuzz = Never(ShortLssRequest))]
    LssShortRequestAnswered,
    /// LSS requests are answered, although the description says that the device has no LSS.
    #[row(model = "tr-c65", fuzz = Never(Description))]
    LssUndescribed,
    /// Store configuration is not answered.
    #[row(fuzz = Allowed("nvm"))]
    LssStoreUnanswered,
    /// Switch global is ignored.
    #[row(fuzz = Never(FoundByMoreFrames))]
    LssSwitchGlobalIgnored,
    /// Reserved LSS commands are answered.
    LssUnknownAnswered,
    /// Objects can be mapped into PDOs of either direction.
    MappingDirectionUnchecked,
    /// A mapping that was disabled can't be enabled again.
    #[row(fuzz = Never(Refusal))]
    MappingProcedureRefused,
    /// 1800h:01 contains another CAN-ID than the predefined one.
    PdoIdNotPredefined,
    /// The bytes of RPDOs are evaluated in the wrong order.
    RpdoBytesReversed,
    /// RPDO 1 has no effect.
    RpdoIgnored,
    /// An RPDO whose CAN-ID is changed is not received with the new CAN-ID.
    RpdoKeepsCanId,
    /// RPDOs take effect in stopped.
    RpdoWhenStopped,
    /// Writing the current COB-ID of a PDO is refused.
    #[row(fuzz = Never(Refusal))]
    SameCobIdRefused,
    /// A request on the second SDO channel ends the transfer on the first.
    #[row(fuzz = Never(SecondSdoChannel))]
    SdoChannelsShareTransfer,
    /// 1200h contains another CAN-ID than the server uses.
    #[row(fuzz = Never(WrongFromPowerOn))]
    SdoServerIdWrong,
    /// 1010h:01 reads as the signature instead of the capability.
    #[row(fuzz = Never(WrongFromPowerOn))]
    StoreCapabilityWrong,
    /// 1011h:01 reads as the signature instead of the capability.
    #[row(fuzz = Never(WrongFromPowerOn))]
    RestoreCapabilityWrong,
    /// SYNC carries a counter although 1019h is 0.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncAlwaysCounts,
    /// SYNC with another CAN-ID than the predefined one carries a counter although 1019h is 0.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncMovedCounts,
    /// Reading the error register clears it, although the error persists.
    #[row(fuzz = Never(LossNoticed))]
    ErrorRegisterReadClears,
    /// After a reset, stored heartbeat times read back, but have no effect until they are written again.
    #[row(fuzz = Never(StoredConfiguration))]
    StoredConfigurationIdle,
    /// 600Ch does not change while the shaft turns.
    #[row(model = "reference-406", fuzz = Never(ShaftTurning))]
    RawPositionStands,
    /// 6000h, which is described as writable, refuses each value with abort 0609 0030h.
    #[row(model = "reference-406", fuzz = Never(Refusal))]
    OperatingParametersRefused,
    /// An RPDO that is as long as its mapping is reported by EMCY 8220h.
    #[row(fuzz = Never(EmcyReported))]
    RightRpdoReported,
    /// SYNC of the right length is reported by EMCY 8240h.
    #[row(fuzz = Never(EmcyReported))]
    RightSyncReported,
    /// Only the first PDO of each direction protects its COB-ID and mapping while it is valid.
    PdoRulesFirstOnly,
    /// TIME is not sent, although bit 30 of 1012h is accepted.
    #[row(fuzz = Never(TimeProduced))]
    TimeNotProduced,
    /// 1005h does not exist, although TPDO 2 is synchronous.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(InDescription))]
    SyncObjectMissing,
    /// Writing 0 to bit 30 of 1012h does not end TIME.
    #[row(fuzz = Never(TimeProduced))]
    TimeNotStopped,
    /// The clock that TIME sets and the high resolution time stamp, 1013h, stand still.
    #[row(fuzz = Never(TimeConsumed))]
    ClockStands,
    /// Each write of an object sets the high resolution time stamp, 1013h.
    #[row(fuzz = Never(ClockSpeed))]
    StampSetByOthers,
    /// The return of a lost node makes the device leave operational, like its loss.
    #[row(fuzz = Never(LossNoticed))]
    ConsumerReturnLeaves,
    /// 1005h, which is described as writable, refuses each value with abort 0609 0030h, even its current value.
    #[row(fuzz = Never(Refusal))]
    SyncIdRefused,
    /// A PDO can't be switched off: bit 31 of its COB-ID is refused with abort 0609 0030h.
    #[row(fuzz = Never(Refusal))]
    PdoOffRefused,
    /// 1016h, which is described as writable, refuses each value with abort 0609 0030h.
    #[row(fuzz = Never(Refusal))]
    ConsumerTimeRefused,
    /// 1005h contains another CAN-ID than the predefined one.
    SyncIdWrong,
    /// Writing 0 to 1006h does not end SYNC.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncNotStopped,
    /// SYNC is produced as soon as 1006h holds a period, although bit 30 of 1005h is 0.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncProducedUnasked,
    /// Every seventh SYNC is ignored.
    SyncOverlooked,
    /// The SYNC that the device produces does not trigger its own TPDOs.
    #[row(fuzz = Never(OwnSyncTime))]
    SyncOwnUnheeded,
    /// The first SYNC that the device produces while 1019h is 0 stops the firmware.
    #[row(fuzz = Never(OwnSyncTime))]
    SyncHangsWithoutCounter,
    /// SYNC is also consumed while bit 31 of 1005h is cleared.
    #[row(model = "tr-c65", fuzz = Never(SyncConsumerBit))]
    SyncConsumerBitIgnored,
    /// A device that can't produce SYNC accepts bit 30 of 1005h.
    #[row(model = "kuebler-sendix-58x8")]
    SyncProducerBitAccepted,
    /// 1012h contains another CAN-ID than the predefined one.
    #[row(fuzz = Never(WrongFromPowerOn))]
    TimeIdWrong,
    /// The bytes of TPDOs are sent in the wrong order.
    #[row(fuzz = Never(TpdoContent))]
    TpdoBytesReversed,
    /// A TPDO whose CAN-ID is changed is still sent with the old one.
    TpdoKeepsCanId,
    /// After a reset a TPDO is sent with the CAN-ID that was written before the reset, whatever 1800h:01 shows.
    #[row(fuzz = Never(FoundSometimes))]
    TpdoIdOutlivesReset,
    /// A TPDO that is due while the SDO server writes an object is lost.
    TpdoLostAfterSdo,
    /// Remote frames for TPDO 1 are not answered.
    TpdoRemoteIgnored,
    /// TPDO 1 always has eight bytes.
    TpdoTooLong,
    /// A device that has received its first node-ID by LSS starts only after a reset.
    #[row(fuzz = Allowed("node-id"))]
    UnconfiguredNodeIdWaits,
    /// LSS refuses every bit rate.
    #[row(fuzz = Allowed("bit-rate"))]
    LssBitTimingRefused,
    /// Parts of another address do not end switch selective.
    #[row(fuzz = Never(OpenAnswer))]
    LssSelectiveMismatchIgnored,
    /// A block upload that switches to a normal upload loses the first byte.
    SdoBlockSwitchTruncates,
    /// Node guarding answers show pre-operational in every state.
    #[row(model = "kuebler-sendix-58x8")]
    GuardingWrongState,
    /// Node guarding is not answered while the life time is 0.
    #[row(model = "kuebler-sendix-58x8")]
    GuardingSilentWhenOff,
    /// The loss of the master is reported one guard time too late.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LossNoticed))]
    LifeTimeFactorOffByOne,
    /// Setting the life time to 0 does not end life guarding.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LossNoticed))]
    LifeGuardingNotStopped,
    /// The loss of the master is not reported by an EMCY message.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LossNoticed))]
    LifeGuardingUnreported,
    /// Neither 100Dh nor 1017h exists.
    #[row(model = "tr-c65")]
    ErrorControlMissing,
    /// 100Eh holds another COB-ID than node guarding uses.
    #[row(model = "tr-c65", fuzz = Never(WrongFromPowerOn))]
    GuardingCobIdWrong,
    /// 100Bh holds another node-ID than the device uses.
    #[row(model = "tr-c65", fuzz = Never(WrongFromPowerOn))]
    NodeIdObjectWrong,
    /// 1004h counts more PDOs than the device has.
    #[row(model = "tr-c65", fuzz = Never(WrongFromPowerOn))]
    PdoCountWrong,
    /// Remote frames for a TPDO that allows them are not answered.
    #[row(model = "tr-c65", fuzz = Never(RemoteSynchronous))]
    TpdoRemoteUnanswered,
    /// 1001h keeps the bits of an error that is gone.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    ErrorRegisterStuck,
    /// Bit 0 of 1001h is always set, even without an error.
    #[row(fuzz = Never(AlarmBits))]
    ErrorRegisterNeverClear,
    /// When one of several errors is gone, 1001h and EMCY 0000h report that all errors are gone.
    #[row(fuzz = Never(AlarmBits))]
    ErrorsClearedTogether,
    /// Switch mode selective of LMT is answered with 44h, as in LSS.
    #[row(model = "tr-lmp30")]
    LmtSwitchSelectiveAnswered,
    /// Switch mode selective of LMT accepts any serial number.
    #[row(model = "tr-lmp30")]
    LmtSerialNotCompared,
    /// Switch mode selective of LMT accepts any manufacturer name and product name.
    #[row(model = "tr-lmp30")]
    LmtNamesNotCompared,
    /// Reserved modes of switch mode global of LMT switch the slave to configuration.
    #[row(model = "tr-lmp30", fuzz = Never(OpenAnswer))]
    LmtReservedModeObeyed,
    /// LMT inquiries and configurations are answered in operation.
    #[row(model = "tr-lmp30")]
    LmtAnsweredInOperation,
    /// LMT bit timing uses the table of LSS, whose fifth row is reserved.
    #[row(model = "tr-lmp30", fuzz = Allowed("bit-rate"))]
    LmtBitTimingUnshifted,
    /// LMT confirms bit timings that don't exist.
    #[row(model = "tr-lmp30", fuzz = Allowed("bit-rate"))]
    LmtBitTimingUnchecked,
    /// LMT confirms node-IDs that don't exist.
    #[row(model = "tr-lmp30", fuzz = Allowed("node-id"))]
    LmtNodeIdUnchecked,
    /// A node-ID that LMT configures takes effect immediately.
    #[row(model = "tr-lmp30", fuzz = Allowed("node-id"))]
    LmtNodeIdAtOnce,
    /// Store configuration of LMT is not answered.
    #[row(model = "tr-lmp30", fuzz = Allowed("nvm"))]
    LmtStoreSilent,
    /// The device still sends while LMT activates a bit timing.
    #[row(model = "tr-lmp30", fuzz = Never(BitRate))]
    LmtActivationNotSilent,
    /// LMT pads names with FFh instead of 00h.
    #[row(model = "tr-lmp30")]
    LmtNameUnpadded,
    /// Identify remote slave of LMT is not answered.
    #[row(model = "tr-lmp30")]
    LmtIdentifySilent,
    /// Identify remote slave of LMT is answered even outside the range of serial numbers.
    #[row(model = "tr-lmp30")]
    LmtIdentifyRangeIgnored,
    /// LMT responses have seven bytes.
    #[row(model = "tr-lmp30")]
    LmtShortResponse,
    /// LMT inquiries return the serial number in binary.
    #[row(model = "tr-lmp30")]
    LmtSerialNotBcd,
    /// Bits 12 and 13 of 6500h are swapped.
    #[row(model = "lika-ax58", fuzz = Never(MeasuredValue))]
    LimitSwitchesSwapped,
    /// A limit switch is already active at its limit, not only beyond it.
    #[row(model = "lika-ax58", fuzz = Never(MeasuredValue))]
    LimitSwitchInclusive,
    /// 6001h and 6002h scale the position although bit 2 of 6000h is 0.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    ScalingAlwaysOn,
    /// 1000h of a multi-turn encoder contains the type single-turn.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(WrongFromPowerOn))]
    DeviceTypeTurnsWrong,
    /// 6500h does not exist.
    #[row(model = "kuebler-sendix-58x8")]
    OperatingStatusMissing,
    /// 6503h does not exist.
    #[row(model = "kuebler-sendix-58x8")]
    AlarmsMissing,
    /// 6004h has 16 bits instead of 32.
    #[row(model = "kuebler-sendix-58x8")]
    PositionSixteenBit,
    /// 6000h has 32 bits instead of 16.
    #[row(model = "kuebler-sendix-58x8")]
    OperatingParametersThirtyTwoBit,
    /// 6004h can be written.
    #[row(model = "kuebler-sendix-58x8")]
    PositionWritable,
    /// 6000h accepts its reserved bits, and shows them.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ProfileLimits))]
    ReservedOperatingBitsAccepted,
    /// 6001h and 6002h accept a range of less than one revolution.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ProfileLimits))]
    UnitsAboveRangeAccepted,
    /// 6001h = 0 makes the firmware divide by zero: the device answers no request until a reset.
    #[row(model = "kuebler-sendix-58x8")]
    UnitsZeroWedges,
    /// 6004h stays 0 if 6002h is 0, which means 2^32.
    #[row(model = "kuebler-sendix-f58", fuzz = Never(MeasuredValue))]
    RangeZeroStops,
    /// The product of position and 6001h is calculated with 32 bits.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    ScalingOverflow,
    /// The position wraps at the next power of two instead of at 6002h.
    #[row(model = "kuebler-sendix-58x8")]
    WrapAtPowerOfTwo,
    /// 6509h has the wrong sign.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    OffsetSignWrong,
    /// 6509h stays 0 after a preset.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    OffsetNotReported,
    /// After a preset 6004h shows the old position for some milliseconds.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    PresetGlitch,
    /// A preset that was not stored survives a reset.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AfterStore))]
    PresetPersists,
    /// 1010h does not store the preset.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AfterStore))]
    PresetLostAfterSave,
    /// TPDOs carry the position without the preset.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    TpdoPositionWithoutPreset,
    /// The first TPDO with an event timer is sent when the timer expires instead of when the device becomes
    /// operational.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(TpdoEvent))]
    FirstPositionMissing,
    /// TPDOs carry the values measured for the previous TPDO.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    TpdoPositionLate,
    /// 6200h = 0 does not end the cyclic transmission.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LinkedTimer))]
    CyclicTimerNotStopped,
    /// 6200h keeps the written value, but TPDO 1 keeps its previous period.
    #[row(model = "tr-c65", fuzz = Never(LinkedTimer))]
    CyclicTimerIdle,
    /// 6200h does not follow the event timer of TPDO 1.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LinkedTimer))]
    EventTimerNotInCyclicTimer,
    /// 6030h is not 0 while the shaft is at rest.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    SpeedNotZeroAtRest,
    /// The sign of 6030h does not follow the code sequence.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    SpeedSignIgnoresCodeSequence,
    /// With the other code sequence 6030h is twice the speed.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    SpeedDoubledBackwards,
    /// 6000h does not change the unit of the speed.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    SpeedFormatIgnored,
    /// 6030h is ten times too high.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    SpeedTenfold,
    /// 6031h:04 does not divide the speed.
    #[row(model = "kuebler-sendix-f58", fuzz = Never(MeasuredValue))]
    SpeedDivisorIgnored,
    /// 6040h shows the speed instead of its change.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    AccelerationShowsSpeed,
    /// The bits for overflow and underflow of 6400h are swapped.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    WorkAreaBitsSwapped,
    /// Bit 0 of 6400h is set above the work area, and not below it.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    WorkAreaOutsideOneSided,
    /// 6400h stays 0.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    WorkAreaStuck,
    /// 6400h shows out of range while the position is in the work area.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    WorkAreaInverted,
    /// 6401h accepts a low limit above the high limit.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ProfileLimits))]
    WorkAreaLimitsSwappedAccepted,
    /// 6503h has a bit set that is not supported by 6504h.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    UnsupportedAlarmSet,
    /// 6503h and 6504h have a reserved bit set.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    ReservedAlarmBitSet,
    /// 6505h has a bit set that is not supported by 6506h.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    UnsupportedWarningSet,
    /// A position error is shown by 6503h, but neither by an EMCY nor by 1001h.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    AlarmWithoutEmcy,
    /// A position error is reported by an EMCY, but not by 6503h.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    EmcyWithoutAlarm,
    /// A temperature beyond its limits is shown by 6505h, but not reported by an EMCY.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    WarningWithoutEmcy,
    /// A temperature beyond its limits is reported by an EMCY, but not shown by 6505h.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    WarningNotSet,
    /// 6505h keeps a warning whose cause is gone.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    WarningNotCleared,
    /// 6508h counts down.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    OperatingTimeBackwards,
    /// 6508h counts seconds instead of tenths of an hour.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    OperatingTimeInSeconds,
    /// 650Bh differs from 1018h:04.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(WrongFromPowerOn))]
    SerialNumberDiffers,
    /// 6501h shows 6001h instead of the physical resolution.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    SingleTurnResolutionFollowsScaling,
    /// 6502h is 0.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(WrongFromPowerOn))]
    RevolutionsZero,
    /// 6507h is FFFF FFFFh.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(WrongFromPowerOn))]
    ProfileVersionUnset,
    /// 2161h is the raw position itself instead of its inverse.
    #[row(model = "kuebler-sendix-f58", fuzz = Never(MeasuredValue))]
    RawInverseWrong,
    /// The checksum 2162h begins with FFFFh instead of 1021h.
    #[row(model = "kuebler-sendix-f58", fuzz = Never(MeasuredValue))]
    RawCrcStartWrong,
    /// A preset changes the raw position 600Ch.
    #[row(model = "kuebler-sendix-f58m", fuzz = Never(MeasuredValue))]
    RawPositionFollowsPreset,
    /// The second channel of the position drifts.
    #[row(model = "kuebler-c100", fuzz = Never(MeasuredValue))]
    RedundantChannelDrift,
    /// The second channel counts up like the first one.
    #[row(model = "kuebler-d125", fuzz = Never(MeasuredValue))]
    RedundantChannelNotNegated,
    /// 3003h does not reverse the direction of the angle.
    #[row(model = "kuebler-c100", fuzz = Never(MeasuredValue))]
    AngleDirectionIgnored,
    /// 3004h does not change the range of the angle.
    #[row(model = "kuebler-c100", fuzz = Never(MeasuredValue))]
    AngleRangeIgnored,
    /// The second angle does not run opposite to the first one.
    #[row(model = "kuebler-c100", fuzz = Never(MeasuredValue))]
    RedundantAngleSame,
    /// 3010h does not set the angle to zero.
    #[row(model = "kuebler-c100", fuzz = Never(MeasuredValue))]
    ZeroPointIgnored,
    /// The EDS has a line that is neither section, field nor comment.
    #[row(fuzz = Never(InDescription))]
    EdsLineWithoutSense,
    /// The EDS contains a section twice.
    #[row(fuzz = Never(InDescription))]
    EdsSectionTwice,
    /// The EDS does not describe sub-index 0 of 1018h.
    #[row(fuzz = Never(InDescription))]
    EdsSubIndexMissing,
    /// The EDS contains a field twice in a section.
    #[row(fuzz = Never(InDescription))]
    EdsFieldTwice,
    /// The EDS gives no data type for 1017h.
    #[row(fuzz = Never(InDescription))]
    EdsDataTypeMissing,
    /// The EDS has a hexadecimal number with a trailing h.
    #[row(fuzz = Never(InDescription))]
    EdsNumberUnreadable,
    /// The EDS gives a default with a decimal point for an integer.
    #[row(fuzz = Never(InDescription))]
    EdsFloatDefault,
    /// The EDS counts more sub-indexes of 1018h than it describes.
    #[row(fuzz = Never(InDescription))]
    EdsSubNumberWrong,
    /// The EDS counts more TPDOs than it describes.
    #[row(fuzz = Never(InDescription))]
    EdsPdoCountWrong,
    /// The creation date of the EDS begins with the year.
    #[row(fuzz = Never(InDescription))]
    EdsDateWrong,
    /// The EDS has a 2 in a field that allows 0 and 1 only.
    #[row(fuzz = Never(InDescription))]
    EdsBooleanWrong,
    /// The EDS lists one object twice and omits another object.
    #[row(fuzz = Never(InDescription))]
    EdsObjectListedTwice,
    /// The EDS gives 1001h an access type that does not exist.
    #[row(fuzz = Never(InDescription))]
    EdsAccessTypeUnknown,
    /// The EDS has another vendor number in DeviceInfo than in 1018h:01.
    #[row(fuzz = Never(InDescription))]
    EdsVendorNumberDiffers,
    /// The EDS has a default below its low limit.
    #[row(fuzz = Never(InDescription))]
    EdsDefaultBeyondLimit,
    /// The EDS maps an object with a wrong length.
    #[row(fuzz = Never(InDescription))]
    EdsMappingWrong,
    /// The EDS gives two TPDOs the same COB-ID.
    #[row(fuzz = Never(InDescription))]
    EdsCobIdTwice,
    /// The EDS gives 1017h another data type than CiA 301.
    #[row(fuzz = Never(InDescription))]
    EdsDataTypeWrong,
    /// The device has an object, 200Ah, that is missing in its description.
    UndescribedObject,
    /// Sub-index FFh of 1018h exists, but does not contain the structure of the object.
    #[row(fuzz = Never(OpenAnswer))]
    StructureEntryWrong,
    /// 1015h increases by one at every reset.
    ParameterDriftsAtReset,
    /// Downloads to a sub-index that does not exist are refused alternately with abort 0609 0011h and 0601 0002h.
    SdoRefusalAlternates,
    /// A maximum below its minimum is refused with abort 0601 0002h.
    #[row(model = "reference-406")]
    LimitsSwappedWrongCode,
    /// Mapping entries accept any number of bits for an object.
    #[row(model = "reference-406")]
    MappingLengthUnchecked,
    /// Sub-index 0 of a mapping can count entries that are 0, except the first entry.
    LaterEmptyEntryMapped,
    /// Sub-index 0 of a mapping can count entries that are 0.
    EmptyEntryMapped,
    /// After a refused mapping no mapping can be enabled until a reset.
    MappingFailureWedges,
    /// A TPDO that waited for its inhibit time is sent again after each further inhibit time.
    #[row(fuzz = Never(ApplicationEvent))]
    TpdoRepeatsAfterInhibit,
    /// A new CAN-ID in 1005h has no effect: SYNC is still received and sent with the old CAN-ID.
    #[row(fuzz = Never(SyncCanId))]
    SyncKeepsCanId,
    /// In configuration, a repeated switch state global to configuration acts like leaving configuration: a device
    /// without node-ID starts with the node-ID that it has received.
    #[row(fuzz = Never(UnconfiguredStart))]
    LssLeavesWhenToldAgain,
    /// 1007h has no effect: synchronous TPDOs are sent with any delay.
    #[row(fuzz = Never(SyncCount))]
    SyncWindowIgnored,
    /// A SYNC in pre-operational triggers a TPDO at the start.
    #[row(fuzz = Never(SyncCount))]
    SyncRememberedOverStart,
    /// An SDO transfer continues after the device was stopped.
    SdoTransferSurvivesStop,
    /// An SDO transfer continues after a reset.
    SdoTransferSurvivesReset,
    /// 1020h is not cleared when a parameter changes.
    #[row(fuzz = Never(ConfigurationDate))]
    ConfigurationDateKept,
    /// 1020h is 0 after a reset, although it was stored.
    #[row(fuzz = Never(AfterStore))]
    ConfigurationDateLost,
    /// 650Ah:03 is half of the highest position.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(WrongFromPowerOn))]
    HighestPositionWrong,
    /// 6008h does not follow the preset.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    HighPrecisionWithoutPreset,
    /// TPDO 2 is never sent.
    #[row(model = "kuebler-sendix-58x8")]
    SecondTpdoMissing,
    /// After a preset the position stands still for a while.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    PresetStopsCounting,
    /// 6050h shows the speed instead of the change of the acceleration.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    JerkShowsSpeed,
    /// 1029h:02 has no effect.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ErrorBehaviour))]
    ProfileErrorIgnored,
    /// With 1029h:02 = 1, an error of the sensor still leads to pre-operational.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ErrorBehaviour))]
    ProfileErrorAlwaysLeaves,
    /// Synchronous TPDOs come 30 ms after SYNC.
    #[row(fuzz = Never(WithinTolerance))]
    SyncTpdoLate,
    /// Every hundred and fiftieth SDO response takes 1.2 s.
    #[row(fuzz = Never(AfterManyRequests))]
    SdoResponseSlow,
    /// 6300h stays 0.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    CamStuck,
    /// A cam has no high limit.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    CamHighLimitIgnored,
    /// 6301h has no effect: every cam is active.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    CamEnableIgnored,
    /// 6302h has no effect.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    CamPolarityIgnored,
    /// 6330h has no effect.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    CamHysteresisIgnored,
    /// A slave takes no further part in Fastscan after another slave has answered.
    #[row(fuzz = Never(AnotherDevice))]
    FastscanYieldsToOthers,
    /// A node-ID configured by LSS survives reset node although it was not stored.
    #[row(fuzz = Never(AfterStore))]
    LssNodeIdStoredAtOnce,
    /// The third and fourth byte of a longer NMT frame are executed as a command.
    #[row(fuzz = Never(OpenAnswer))]
    NmtLongFrameMisread,
    /// An entry of 1016h whose node-ID does not exist monitors every node.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerWatchesEveryone,
    /// The loss of a node whose entry in 1016h has the time 0 is reported immediately after its first heartbeat.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerTimeZero,
    /// A heartbeat with no byte or with two bytes stops the firmware.
    HeartbeatConsumerCrashes,
    /// Guarding requests are answered although 100Ch does not exist.
    #[row(model = "kuebler-c100")]
    GuardingAnsweredUnsupported,
    /// 1010h:01 tells that the device does not store parameters on command, although it does.
    #[row(fuzz = Never(WrongFromPowerOn))]
    StoreCapabilityDenied,
    /// "save" is not answered in operational.
    #[row(fuzz = Never(StoreSignature))]
    StoreSilentWhenOperational,
    /// RPDOs refuse synchronous transmission types.
    #[row(fuzz = Never(Refusal))]
    SynchronousRpdoRefused,
    /// An abort of the client does not end a block download.
    SdoBlockAbortIgnored,
    /// An abort of the client before the first segment does not end a block download.
    SdoFirstBlockAbortIgnored,
    /// During a segmented download every new request is refused with abort 0800 0021h, even after a reset, until the
    /// client aborts the download.
    SdoOpenDownloadSurvivesReset,
    /// Only the last segment of a download is confirmed.
    SdoDownloadSegmentUnconfirmed,
    /// A download directly after a segmented upload is refused with abort 0800 0000h.
    #[row(fuzz = Never(Refusal))]
    SdoDownloadRefusedAfterUpload,
    /// The first block download after a block upload writes the value of that upload.
    SdoBlockDownloadWritesUpload,
    /// After a block upload, block downloads write the value of that upload, even after a reset.
    SdoBlockDownloadKeepsUpload,
    /// During a block upload every new request is refused with abort 0504 0001h until the client aborts the upload.
    #[row(fuzz = Never(RequestInBlock))]
    SdoBlockUploadSurvivesRefusal,
    /// Each segment of a block download is sent back.
    SdoBlockSegmentsEchoed,
    /// The CRC of a block download is calculated over the unused bytes of the last segment, too.
    SdoBlockCrcOfFilling,
    /// For 3 ms after a block upload SDO requests are ignored.
    SdoDeafAfterBlockUpload,
    /// A segmented download without stated size loses its last byte if its length is a multiple of 7, from 14.
    #[row(fuzz = Never(StringChanged))]
    SdoUnsizedSevenTruncated,
    /// A block download without CRC loses its last byte if its length is a multiple of 7, from 14.
    #[row(fuzz = Never(StringChanged))]
    SdoBlockSevenWithoutCrcTruncated,
    /// A segmented download that does not announce its size must have the size that the last segmented download
    /// announced.
    SdoStaleSizeExpected,
    /// The first start after "save" reports EMCY 5000h, and the device does not enter operational until the next start.
    #[row(fuzz = Never(AfterStore))]
    StoreBreaksStart,
    /// The first start after "load" reports EMCY 5000h, and the device does not enter operational until the next start.
    #[row(fuzz = Never(AfterStore))]
    RestoreBreaksStart,
    /// LSS confirms a bit rate, and keeps the old one when it is activated.
    #[row(fuzz = Never(BitRate))]
    LssBitTimingWithoutEffect,
    /// LMT confirms a bit rate, and keeps the old one when it is activated.
    #[row(model = "tr-lmp30", fuzz = Never(BitRate))]
    LmtBitTimingWithoutEffect,
}

/// The properties of a fault besides its name and its summary.
struct Row {
    /// The id of a model on which the fault shows.
    model: &'static str,
    /// Whether the fuzzer claims to find the fault.
    fuzz: Fuzz,
}

impl Row {
    /// The values of most faults.
    const USUAL: Self = Self { model: "reference-301", fuzz: Found };
}

/// Whether the fuzzer finds a fault.
#[derive(Clone, Copy)]
enum Fuzz {
    /// The fuzzer claims to find the fault.
    Found,
    /// The fuzzer claims to find the fault if the user allows this touch.
    Allowed(&'static str),
    /// The fuzzer does not claim to find the fault, for this reason.
    Never(Unfuzzed),
}

impl Fault {
    /// The id of a model on which the fault shows.
    pub const fn model(self) -> &'static str {
        self.row().model
    }

    /// Whether the fuzzer claims to find the fault even if the user allows no touch.
    pub const fn is_fuzzed(self) -> bool {
        matches!(self.row().fuzz, Found)
    }

    /// The touch that the user must allow so that the fuzzer finds the fault; `None`: no touch, or the fuzzer does not
    /// claim to find it.
    pub const fn fuzz_needs(self) -> Option<&'static str> {
        if let Allowed(touch) = self.row().fuzz { Some(touch) } else { None }
    }

    /// The reason why the fuzzer does not claim to find the fault; `None`: the fuzzer claims to find it.
    pub const fn unfuzzed(self) -> Option<&'static str> {
        if let Never(reason) = self.row().fuzz { Some(reason.summary()) } else { None }
    }
}

/// A set of faults, one bit for each.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Faults([u64; WORDS]);

const WORDS: usize = Fault::ALL.len().div_ceil(u64::BITS as usize);

impl Faults {
    /// The empty set: a firmware without faults.
    pub const NONE: Self = Self([0; WORDS]);

    /// The set with one more fault.
    pub const fn with(mut self, fault: Fault) -> Self {
        self.0[fault as usize / u64::BITS as usize] |= Self::bit(fault);
        self
    }

    /// Whether the set contains the fault.
    pub const fn has(self, fault: Fault) -> bool {
        self.0[fault as usize / u64::BITS as usize] & Self::bit(fault) != 0
    }

    /// Whether the set is empty.
    pub fn is_empty(self) -> bool {
        self == Self::NONE
    }

    const fn bit(fault: Fault) -> u64 {
        1 << (fault as usize % u64::BITS as usize)
    }

    /// The faults of the set, in the order of their definition.
    pub fn iter(self) -> impl Iterator<Item = Fault> {
        Fault::ALL.iter().copied().filter(move |&fault| self.has(fault))
    }
}

impl FromIterator<Fault> for Faults {
    fn from_iter<T: IntoIterator<Item = Fault>>(faults: T) -> Self {
        faults.into_iter().fold(Self::NONE, Self::with)
    }
}

impl From<Fault> for Faults {
    fn from(fault: Fault) -> Self {
        Self::NONE.with(fault)
    }
}

impl fmt::Debug for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

/// There is no fault of that name.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("no fault is called \"{0}\"{hint}: `canvass list faults` shows them", hint = meant(.0, Fault::ALL.iter().map(|fault| fault.id())))]
pub struct UnknownFault(pub String);

impl FromStr for Fault {
    type Err = UnknownFault;

    fn from_str(id: &str) -> Result<Self, UnknownFault> {
        Self::ALL.iter().copied().find(|fault| fault.id() == id).ok_or_else(|| UnknownFault(id.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_found() {
        for &fault in Fault::ALL {
            assert_eq!(fault.id().parse(), Ok(fault));
        }
        assert!("nonsense".parse::<Fault>().is_err());
    }

    #[test]
    fn sets_hold_what_was_put_in() {
        assert_eq!(Fault::ALL.iter().copied().collect::<Faults>().iter().collect::<Vec<_>>(), Fault::ALL);
        let two = Faults::from(Fault::BootUpTwice).with(Fault::EventTimerDoubled);
        assert!(two.has(Fault::BootUpTwice) && two.has(Fault::EventTimerDoubled) && !two.has(Fault::BootUpMissing));
    }
}
