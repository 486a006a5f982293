//! Firmware faults that a simulated device can have, drawn from defects of real devices and stacks.

mod unfuzzed;

pub use unfuzzed::Unfuzzed;

use Fuzz::{Allowed, Found, Never};
use Unfuzzed::*;
use canvass_macros::Catalogue;
use std::fmt;
use std::str::FromStr;

/// One defect of a firmware. Each is a switch of its own; they can be combined.
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
    /// NMT commands to other nodes are obeyed.
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
    /// A lasting error of the hardware, which EMCY 5000h tells after each start, keeps the device out of operational.
    NmtStartRefusedInError,
    /// Stop remote node is ignored in operational.
    NmtStopWhenOperationalIgnored,
    /// Enter pre-operational is ignored.
    NmtEnterPreOperationalIgnored,
    /// A command for the state that the node is in already restarts it.
    NmtRepeatedCommandResets,
    /// An NMT frame without node-ID is taken as a command to the node.
    #[row(fuzz = Allowed("other-nodes"))]
    NmtShortFrameObeyed,
    /// Reset node does not restore unsaved parameters.
    NmtResetNodeKeepsParameters,
    /// The SDO server does not answer in operational.
    SdoSilentWhenOperational,
    /// The bytes of a segment that was refused are given as the next value of four bytes that is read.
    SdoRefusedSegmentServed,
    /// A download segment during an upload is refused, and overwrites the value that is being uploaded.
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
    /// A request that comes in stopped is answered once stopped is left.
    SdoRequestKeptOverStop,
    /// Heartbeats say pre-operational in every state.
    HeartbeatWrongState,
    /// Heartbeats come at twice the time of 1017h.
    HeartbeatPeriodDoubled,
    /// Writing 0 to 1017h does not end the heartbeat.
    HeartbeatNotStopped,
    /// Aborts name the object of the transfer before.
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
    /// A segmented upload announces one byte more than it has.
    SdoAnnouncedSizeWrong,
    /// After the last segment of an upload more can be asked for.
    SdoSegmentAfterEndAnswered,
    /// Each segment of a download goes into the object at once, before the transfer is complete.
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
    /// A command that has no place in the transfer under way is not answered.
    SdoWrongCommandIgnored,
    /// Commands of a block transfer without one are not answered.
    SdoStrayBlockSilent,
    /// A new request during a segmented download is refused with abort 0504 0001h.
    SdoBusyAfterAbandonedDownload,
    /// A request that comes before the answer to the last one changes the object that this answer names.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(OverlappingRequest))]
    SdoBackToBackMixed,
    /// Every hundredth request is not answered.
    #[row(fuzz = Never(AfterManyRequests))]
    SdoResponseLost,
    /// After a request of less than eight bytes the SDO server is dead.
    SdoShortRequestWedges,
    /// A remote frame with the CAN-ID of SDO requests is answered.
    SdoRemoteAnswered,
    /// A 29-bit frame whose identifier ends like that of SDO requests is answered.
    SdoExtendedAnswered,
    /// SDO requests to the next node-ID are answered too.
    #[row(fuzz = Allowed("other-nodes"))]
    SdoOtherNodeAnswered,
    /// After a transfer that the client did not go on with the SDO server is dead.
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
    /// A sub-index that does not exist is refused with abort 0A00 0001h, which nobody defines.
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
    /// A block upload goes on with the next block, whatever the client confirms.
    SdoBlockConfirmationIgnored,
    /// The confirmation of segments that were not sent is accepted.
    SdoBlockConfirmationUnchecked,
    /// After a lost segment the whole block is sent again, not what was not confirmed.
    SdoBlockRepeatsAll,
    /// All blocks of an upload have the size of the first.
    SdoBlockNewSizeIgnored,
    /// A block upload announces one byte more than it has.
    SdoBlockAnnouncedSizeWrong,
    /// The end of a block upload counts one unused byte too many.
    SdoBlockLastLengthWrong,
    /// The end of a block upload of 7 bytes, or a multiple, says that the last segment holds none.
    SdoBlockSevenEndsEmpty,
    /// The CRC of block uploads starts with FFFFh.
    SdoBlockCrcStartWrong,
    /// The CRC of block uploads has its bytes in the wrong order.
    SdoBlockCrcSwapped,
    /// The end of a block upload without CRC holds one all the same.
    SdoBlockCrcUnasked,
    /// The last segment of a block upload is not marked as the last.
    SdoBlockEndUnmarked,
    /// The sequence numbers of a block upload do not begin with 1 in every block.
    SdoBlockNumbersContinue,
    /// The server asks for blocks of no segments.
    SdoBlockSizeZeroOffered,
    /// A block download to a read-only object is confirmed, without effect.
    SdoBlockReadOnlyAccepted,
    /// Every block download is refused with abort 0607 0013h.
    #[row(fuzz = Never(Refusal))]
    SdoBlockDownloadRefused,
    /// A segment with sequence number 0 is taken for none.
    #[row(fuzz = Never(OpenAnswer))]
    SdoBlockSequenceZeroIgnored,
    /// A segment that comes twice is taken twice.
    SdoBlockRepeatedAppended,
    /// A block download goes on over a lost segment.
    SdoBlockGapAccepted,
    /// The unused bytes of the last segment of a block download are taken as data.
    SdoBlockPaddingKept,
    /// The CRC of block downloads is not checked.
    SdoBlockCrcIgnored,
    /// A block download without CRC is checked for one, once another one had it.
    SdoBlockCrcKept,
    /// A wrong CRC is refused with abort 0800 0000h.
    SdoBlockCrcWrongCode,
    /// The value of a block download is written before its CRC is checked.
    SdoBlockWrittenBeforeCheck,
    /// A block download of another size than announced is accepted.
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
    /// SDO responses have only as many bytes as they need.
    #[row(model = "kuebler-sendix-58x8")]
    SdoShortResponse,
    /// 1018h:01 is 0.
    #[row(fuzz = Never(WrongFromPowerOn))]
    VendorIdZero,
    /// 1000h names device profile 401 instead of that of an encoder.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(WrongFromPowerOn))]
    DeviceTypeProfileWrong,
    /// 1018h:03 does not exist, although LSS needs it.
    IdentityRevisionMissing,
    /// 1001h does not exist.
    ErrorRegisterMissing,
    /// 1008h ends in bytes that are not printable.
    #[row(fuzz = Never(WrongFromPowerOn))]
    DeviceNameWithGarbage,
    /// TPDOs are sent in pre-operational.
    TpdoInPreOperational,
    /// TPDOs come at twice the time of their event timer.
    EventTimerDoubled,
    /// Heartbeats have bit 7 set.
    HeartbeatToggles,
    /// The heartbeat ends when the NMT state changes.
    HeartbeatLostOnStateChange,
    /// 1016h takes two entries for one node.
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
    /// The mapping can be changed while it is in use.
    MappingChangeWhileValid,
    /// Mappings of more than 64 bits are accepted.
    #[row(model = "kuebler-sendix-58x8")]
    MappingTooLongAccepted,
    /// Objects that are not for PDOs can be mapped.
    UnmappableObjectMapped,
    /// 6200h does not change the event timer of TPDO 1.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LinkedTimer))]
    CyclicTimerNotLinked,
    /// 1010h and 1011h take any value as their signature.
    #[row(fuzz = Allowed("nvm"))]
    StoreSignatureUnchecked,
    /// 1010h confirms, but nothing is stored.
    #[row(fuzz = Never(AfterStore))]
    StoreWithoutEffect,
    /// 1011h restores the values at once instead of at the next reset.
    #[row(fuzz = Never(AfterStore))]
    RestoreAtOnce,
    /// EMCY messages are sent in stopped.
    EmcyWhenStopped,
    /// No EMCY 0000h when an error is gone.
    EmcyResetMissing,
    /// An EMCY message is sent twice.
    EmcyRepeated,
    /// 1001h does not have its generic bit set together with others.
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
    /// 6003h takes values outside the measuring range.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ProfileLimits))]
    PresetOutOfRangeAccepted,
    /// 6000h bit 0 does not turn the direction of counting.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    CodeSequenceIgnored,
    /// 6001h and 6002h do not scale the position.
    #[row(model = "kuebler-sendix-58x8")]
    ScalingIgnored,
    /// 6500h does not follow 6000h.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    OperatingStatusStuck,
    /// Reset communication loads application parameters anew too.
    NmtResetCommunicationRestoresAll,
    /// Of NMT commands within one millisecond only the first one is obeyed.
    NmtCommandLost,
    /// Frames with 29-bit identifiers are taken for those with the same lower 11 bits.
    ExtendedFrameObeyed,
    /// Every eighth reset ends without a boot-up message.
    #[row(fuzz = Never(AfterManyRequests))]
    BootUpSometimesMissing,
    /// An EMCY message is sent before the boot-up message.
    #[row(fuzz = Never(MomentOfReset))]
    EmcyBeforeBootUp,
    /// The SDO server answers before the boot-up message.
    SdoAnsweredBeforeBootUp,
    /// The device waits in pre-operational, whatever 1F80h says.
    #[row(fuzz = Never(AfterStore))]
    StartUpIgnored,
    /// Heartbeat times are rounded up to multiples of 64 ms.
    HeartbeatTimerRounded,
    /// A new heartbeat time while heartbeats are sent causes a burst of them.
    #[row(fuzz = Never(BeforeConfirmation))]
    HeartbeatBurst,
    /// The first heartbeat after a reset comes three periods after the boot-up message.
    #[row(fuzz = Never(AfterStore))]
    HeartbeatLateAfterBootUp,
    /// A heartbeat shows the state at the heartbeat before.
    HeartbeatStateLate,
    /// Reset communication does not reset the toggle bit of node guarding.
    GuardingToggleNotReset,
    /// Node guarding is answered while heartbeats are sent.
    GuardingBesideHeartbeat,
    /// Life guarding begins without a first remote frame of the master.
    #[row(fuzz = Never(LossNoticed))]
    LifeGuardingStartsAtOnce,
    /// The master is missed after the guard time, whatever the life time factor is.
    #[row(fuzz = Never(LossNoticed))]
    LifeTimeFactorIgnored,
    /// The loss of a node is reported although no heartbeat of the node was ever received.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerStartsAtOnce,
    /// Node 1 is not watched, whatever 1016h says.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerDeafToNodeOne,
    /// While the device is stopped, heartbeats of watched nodes do not count.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerDeafWhenStopped,
    /// Each write to any object begins watching anew, as if no heartbeat had come yet.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerRestartedByWrites,
    /// A node is watched on after a reset that has emptied 1016h.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerOutlivesReset,
    /// A node that was missed once is not noticed when it is back.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerNotRearmed,
    /// Only the first entry of 1016h is watched.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerFirstOnly,
    /// 1029h has no effect: the NMT state never changes by an error.
    #[row(fuzz = Never(ErrorBehaviour))]
    ErrorBehaviourIgnored,
    /// 1029h takes reserved values.
    ErrorBehaviourUnchecked,
    /// With 1029h:01 = 0 an error in stopped leads to pre-operational.
    #[row(fuzz = Never(ErrorBehaviour))]
    ErrorBehaviourLeavesStopped,
    /// RPDOs act in pre-operational.
    RpdoInPreOperational,
    /// RPDOs that are too short act, with zeros for what is missing.
    #[row(fuzz = Never(PdoLength))]
    RpdoLengthUnchecked,
    /// An RPDO that is too short is ignored without EMCY.
    #[row(fuzz = Never(PdoLength))]
    ShortRpdoUnreported,
    /// RPDOs that are longer than their mapping don't act.
    #[row(fuzz = Never(PdoLength))]
    LongRpdoIgnored,
    /// An RPDO that is longer than its mapping is reported as one that is late, EMCY 8250h.
    #[row(fuzz = Never(PdoLength))]
    LongRpdoCalledLate,
    /// Synchronous RPDOs don't wait for SYNC.
    #[row(fuzz = Never(WaitingRpdo))]
    SynchronousRpdoActsAtOnce,
    /// An RPDO that is late is not missed.
    #[row(fuzz = Never(WaitingRpdo))]
    RpdoDeadlineIgnored,
    /// The deadline of an RPDO runs on when operational is left.
    #[row(fuzz = Never(WaitingRpdo))]
    RpdoDeadlineOutlivesStop,
    /// The deadline of an RPDO begins with the first one, and no other one restarts it.
    #[row(fuzz = Never(WaitingRpdo))]
    RpdoDeadlineNotRestarted,
    /// Values of a synchronous RPDO that wait for SYNC outlive operational.
    #[row(fuzz = Never(HeldRpdo))]
    RpdoHeldOverStop,
    /// RPDOs act although bit 31 of their COB-ID is set.
    RpdoReceivedWhenInvalid,
    /// An RPDO sets values that an SDO can't.
    #[row(fuzz = Never(ValueByPdo))]
    RpdoRangeUnchecked,
    /// A remote frame with the CAN-ID of an RPDO sets its objects to zero.
    RemoteFrameTakenAsRpdo,
    /// A TPDO carries one object more than sub-index 0 of its mapping says, where the entry after the last is filled.
    #[row(fuzz = Never(TpdoContents))]
    TpdoBeyondCount,
    /// TPDOs come one millisecond later than their event timer says.
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
    /// TPDOs of transmission type n go on counting SYNCs where they stopped.
    #[row(fuzz = Never(SyncCount))]
    SyncCountNotReset,
    /// Event-driven TPDOs are not sent when the device becomes operational.
    #[row(fuzz = Never(TpdoEvent))]
    TpdoNotSentAtStart,
    /// A change of value within the inhibit time of a TPDO is never sent.
    #[row(fuzz = Never(TpdoEvent))]
    TpdoLostWhenInhibited,
    /// Remote frames are answered although bit 30 of the COB-ID is set.
    #[row(fuzz = Never(RemoteFrame))]
    RemoteFrameAnsweredWhenNotAllowed,
    /// A TPDO of transmission type 252 holds the values of the remote frame, not of the SYNC.
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
    /// Sub-index 0 of a mapping takes any number of entries.
    MappingCountUnchecked,
    /// Objects that do not exist can be mapped.
    MissingObjectMapped,
    /// Dummy entries can be mapped into TPDOs.
    DummyMappedIntoTpdo,
    /// SYNC is produced at twice the time of 1006h.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncPeriodDoubled,
    /// SYNC is produced in stopped.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncWhenStopped,
    /// The SYNC counter goes on where it stopped.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncCounterNotReset,
    /// The SYNC counter begins with 0.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncCounterFromZero,
    /// 1019h takes 1 and values above 240.
    SyncOverflowUnchecked,
    /// 1019h can be changed while 1006h is not 0.
    SyncOverflowChangeWhileProducing,
    /// The CAN-ID of SYNC can be changed while SYNC is produced.
    SyncIdChangeWhileProducing,
    /// SYNC messages of a wrong length are obeyed.
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
    /// Errors that come in stopped are never reported.
    #[row(fuzz = Never(EmcyMissing))]
    EmcyLostWhenStopped,
    /// The CAN-ID of EMCY can be changed while EMCY is valid.
    EmcyIdChangeWhileValid,
    /// EMCY messages are sent although bit 31 of 1014h is set.
    EmcySentWhenInvalid,
    /// Each reading of 1001h sends EMCY 0000h.
    #[row(fuzz = Never(AlarmBits))]
    EmcyResetUnasked,
    /// EMCY messages that wait for the inhibit time outlive reset communication.
    #[row(fuzz = Never(AlarmBits))]
    EmcySurvivesReset,
    /// EMCY comes on 080h + node-ID whatever CAN-ID is written to 1014h.
    #[row(fuzz = Never(FoundSometimes))]
    EmcyKeepsCanId,
    /// With another CAN-ID than 080h + node-ID in 1014h EMCY comes as a remote frame.
    #[row(fuzz = Never(FoundSometimes))]
    EmcyMovedIsRemote,
    /// EMCY messages hold 0 instead of the error register.
    EmcyRegisterZero,
    /// 1003h shows the oldest error first.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryReversed,
    /// Emptying 1003h ends all errors, which EMCY 0000h says.
    #[row(fuzz = Never(ErrorHistory))]
    HistoryClearsRegister,
    /// A new error moves no more than two entries of 1003h: those after them show the second.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryMovesTwo,
    /// 1003h:00 counts beyond the entries that there are.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryOverflows,
    /// 1003h:00 takes values other than 0.
    ErrorHistoryNonZeroAccepted,
    /// Entries of 1003h that hold no error read as 0.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryEmptyReadsZero,
    /// 1011h takes any value as its signature.
    #[row(fuzz = Allowed("factory-defaults"))]
    RestoreSignatureUnchecked,
    /// After 1010h each value that is written is stored too.
    #[row(fuzz = Never(AfterStore))]
    LaterValuesStored,
    /// 1010h and 1011h check the signature at sub-index 1 only.
    #[row(fuzz = Allowed("nvm"))]
    StoreSignatureFirstOnly,
    /// 1011h confirms, but the stored values stay.
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
    /// Switch selective takes the parts of the address in any order.
    LssSelectiveAnyOrder,
    /// Identify remote slave excludes the upper bounds.
    LssIdentifyRangeExclusive,
    /// A device with a node-ID answers identify non-configured remote slave.
    LssNonConfiguredAnswered,
    /// Reserved modes of switch global lead to waiting.
    #[row(fuzz = Never(OpenAnswer))]
    LssReservedModeWaits,
    /// LSS confirms bit rates that don't exist.
    #[row(fuzz = Allowed("bit-rate"))]
    LssBitTimingUnchecked,
    /// LSS refuses bit rates with the manufacturer's error code.
    #[row(fuzz = Never(OpenAnswer))]
    LssBitTimingWrongCode,
    /// The confirmation of storing by LSS holds a specific error code although there is no error.
    #[row(fuzz = Allowed("nvm"))]
    LssStoreSpecificError,
    /// LSS confirms storing, but nothing is stored.
    #[row(fuzz = Never(AfterStore))]
    LssStoreNotPersistent,
    /// A node-ID configured by LSS acts before the reset.
    #[row(fuzz = Allowed("node-id"))]
    LssNodeIdAtOnce,
    /// Activate bit timing does not wait for its delay.
    #[row(fuzz = Never(BitRate))]
    LssActivatesAtOnce,
    /// Fastscan ends at any part of the address after which the master goes back.
    FastscanEarlyMatch,
    /// An entry of 1016h for a node-ID above 127 stops the firmware.
    HeartbeatConsumerHangs,
    /// A reset in stopped stops the firmware: it does not start again.
    ResetWhenStoppedHangs,
    /// A Fastscan for a part above 3 stops the firmware.
    FastscanHangs,
    /// A device with a node-ID takes part in Fastscan.
    FastscanAnsweredWhenConfigured,
    /// A device without node-ID starts as node 127.
    UnconfiguredNodeBoots,
    /// Many frames in a short time make the watchdog reset the device.
    #[row(fuzz = Never(AfterManyRequests))]
    WatchdogResetUnderLoad,
    /// The SDO server is out of memory after 500 requests, and silent from then on.
    #[row(fuzz = Never(AfterManyRequests))]
    SdoMemoryLeak,
    /// 11-bit CAN-IDs above 7FFh are accepted for PDOs.
    CanIdTooHighAccepted,
    /// The CAN-IDs 550h to 57Fh are refused as if CiA 301 restricted them.
    #[row(fuzz = Never(Refusal))]
    CanIdsTakenForRestricted,
    /// While a PDO is valid only the bits 7 to 10 of its CAN-ID can't be changed.
    #[row(fuzz = Never(FoundSometimes))]
    CanIdLowBitsMovable,
    /// The bits 11 to 28 of 1005h and 1014h are not checked.
    #[row(fuzz = Never(FoundSometimes))]
    CobIdBitsUnchecked,
    /// Bit 29 of 1014h, 1028h and 1201h is taken, and does nothing.
    #[row(fuzz = Never(FoundSometimes))]
    CobIdFrameBitTaken,
    /// 1012h, which is described as writable, refuses each value with abort 0609 0030h.
    #[row(fuzz = Never(Refusal))]
    TimeIdRefused,
    /// While an entry of 1016h watches a node, the others take no other node: abort 0604 0043h.
    #[row(fuzz = Never(Refusal))]
    ConsumerEntriesExclude,
    /// A SYNC start value does nothing if 1019h is written after it.
    #[row(fuzz = Never(SyncCount))]
    LateSyncCounterOverlooked,
    /// With a SYNC start value each TPDO waits for the SYNC of that number, not only the first.
    #[row(fuzz = Never(SyncCount))]
    SyncStartAgain,
    /// EMCY 0000h carries the error register as it was before.
    #[row(fuzz = Never(EmcyReported))]
    EmcyResetRegisterWrong,
    /// In units per second the speed counts physical steps, whatever 6001h says.
    #[row(model = "reference-406", fuzz = Never(ShaftTurning))]
    SpeedInPhysicalSteps,
    /// With scaling on the position without offset is 0, wherever the shaft stands.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    ScaledPositionStands,
    /// 6001h and 6002h, which are described as writable, refuse each value with abort 0609 0030h.
    #[row(model = "reference-406", fuzz = Never(Refusal))]
    ScalingRefused,
    /// 6001h takes no value below the one that it has.
    #[row(model = "reference-406", fuzz = Never(Refusal))]
    UnitsFewerRefused,
    /// 6002h takes no value below the one that it has.
    #[row(model = "reference-406", fuzz = Never(Refusal))]
    RangeSmallerRefused,
    /// Of the objects that an RPDO maps only the first gets its value.
    #[row(fuzz = Never(FoundSometimes))]
    RpdoFirstObjectOnly,
    /// Inhibit time and SYNC start value of a TPDO, which are described as writable, refuse each other value, also
    /// while the PDO is off.
    #[row(fuzz = Never(Refusal))]
    PdoTimesRefused,
    /// The mapping of TPDO 1 as delivered has a wrong length.
    DefaultMappingWrong,
    /// Dummy entries can't be mapped into RPDOs.
    #[row(fuzz = Never(Refusal))]
    DummyRefused,
    /// 1014h names another CAN-ID than the one that EMCY has.
    EmcyIdWrong,
    /// With 1029h:01 = 1 an error leads to pre-operational all the same.
    #[row(fuzz = Never(ErrorBehaviour))]
    ErrorBehaviourAlwaysLeaves,
    /// 1003h:00 stays 0, whatever happens.
    #[row(fuzz = Never(ErrorHistory))]
    ErrorHistoryNotKept,
    /// Bit 29 of a COB-ID is accepted and has no effect.
    ExtendedBitAccepted,
    /// Every Fastscan matches, whatever it compares.
    FastscanIgnoresBits,
    /// An entry of 1016h that was stored is read back after the start, and nobody is watched.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerForgetsStored,
    /// A watched node is missed after twice its time.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerLate,
    /// Only the first heartbeat of a watched node counts.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerNotRestarted,
    /// An entry of 1016h whose time is set to 0 goes on watching.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerNotStopped,
    /// The loss of a watched node is not reported by EMCY.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerSilent,
    /// Identify remote slave and identify non-configured remote slave are not answered.
    LssIdentifyUnanswered,
    /// Identify remote slave is answered whatever its bounds are.
    LssIdentifyUnchecked,
    /// LSS gives the parts of its address with the bytes in the wrong order.
    LssInquirySwapped,
    /// LSS gives the node-ID plus one.
    LssNodeIdInquiredWrong,
    /// LSS refuses every node-ID.
    #[row(fuzz = Allowed("node-id"))]
    LssNodeIdRefused,
    /// LSS confirms a node-ID and forgets it.
    #[row(fuzz = Allowed("node-id"))]
    LssNodeIdWithoutEffect,
    /// LSS confirms a node-ID and configures the next one.
    #[row(fuzz = Allowed("node-id"))]
    LssNodeIdMistaken,
    /// Switch selective is answered in configuration.
    #[row(fuzz = Never(OpenAnswer))]
    LssSelectiveInConfiguration,
    /// Switch selective compares the serial number only.
    LssSelectiveSerialOnly,
    /// Switch selective is obeyed but not answered.
    LssSelectiveUnanswered,
    /// LSS responses have five bytes.
    LssShortResponse,
    /// LSS requests of fewer than eight bytes are answered.
    #[row(fuzz = Never(ShortLssRequest))]
    LssShortRequestAnswered,
    /// LSS is answered, although the description says that there is none.
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
    /// Objects can be mapped whatever direction they are for.
    MappingDirectionUnchecked,
    /// A mapping that was opened can't be switched on again.
    #[row(fuzz = Never(Refusal))]
    MappingProcedureRefused,
    /// 1800h:01 names another CAN-ID than the predefined one.
    PdoIdNotPredefined,
    /// The bytes of RPDOs are taken in the wrong order.
    RpdoBytesReversed,
    /// RPDO 1 has no effect.
    RpdoIgnored,
    /// An RPDO that gets another CAN-ID is not received with it.
    RpdoKeepsCanId,
    /// RPDOs act in stopped.
    RpdoWhenStopped,
    /// Writing the COB-ID that a PDO has already is refused.
    #[row(fuzz = Never(Refusal))]
    SameCobIdRefused,
    /// A request on the second SDO channel ends the transfer on the first.
    #[row(fuzz = Never(SecondSdoChannel))]
    SdoChannelsShareTransfer,
    /// 1200h names another CAN-ID than the one that the server has.
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
    /// Reading the error register clears it, though the error is still there.
    #[row(fuzz = Never(LossNoticed))]
    ErrorRegisterReadClears,
    /// After a reset, stored heartbeat times read back and do nothing until they are written again.
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
    /// COB-ID and mapping of the first PDO of each direction are protected while it is valid, those of the others are
    /// not.
    PdoRulesFirstOnly,
    /// TIME is not sent, though bit 30 of 1012h is taken.
    #[row(fuzz = Never(TimeProduced))]
    TimeNotProduced,
    /// The clock that TIME sets, and 1013h, stand still.
    #[row(fuzz = Never(TimeConsumed))]
    ClockStands,
    /// Each write of an object sets the high resolution time stamp, 1013h.
    #[row(fuzz = Never(ClockSpeed))]
    StampSetByOthers,
    /// The return of a watched node that was missed makes the device leave operational, as its loss does.
    #[row(fuzz = Never(LossNoticed))]
    ConsumerReturnLeaves,
    /// 1005h, which is described as writable, refuses each value with abort 0609 0030h, even the one that it has.
    #[row(fuzz = Never(Refusal))]
    SyncIdRefused,
    /// A PDO can't be switched off: bit 31 of its COB-ID is refused with abort 0609 0030h.
    #[row(fuzz = Never(Refusal))]
    PdoOffRefused,
    /// 1016h, which is described as writable, refuses each value with abort 0609 0030h.
    #[row(fuzz = Never(Refusal))]
    ConsumerTimeRefused,
    /// 1005h names another CAN-ID than the predefined one.
    SyncIdWrong,
    /// Writing 0 to 1006h does not end SYNC.
    #[row(fuzz = Never(OwnSyncOrTime))]
    SyncNotStopped,
    /// Every seventh SYNC is overlooked.
    SyncOverlooked,
    /// The SYNC that the device produces sends none of its own TPDOs.
    #[row(fuzz = Never(OwnSyncTime))]
    SyncOwnUnheeded,
    /// The first SYNC that the device produces while 1019h is 0 stops the firmware.
    #[row(fuzz = Never(OwnSyncTime))]
    SyncHangsWithoutCounter,
    /// SYNC is listened to without bit 31 of 1005h, too.
    #[row(model = "tr-c65", fuzz = Never(SyncConsumerBit))]
    SyncConsumerBitIgnored,
    /// A device that can't produce SYNC accepts bit 30 of 1005h.
    #[row(model = "kuebler-sendix-58x8")]
    SyncProducerBitAccepted,
    /// 1012h names another CAN-ID than the predefined one.
    #[row(fuzz = Never(WrongFromPowerOn))]
    TimeIdWrong,
    /// The bytes of TPDOs are sent in the wrong order.
    #[row(fuzz = Never(TpdoContent))]
    TpdoBytesReversed,
    /// A TPDO that gets another CAN-ID is sent with the old one.
    TpdoKeepsCanId,
    /// After a reset a TPDO comes on the CAN-ID that it was moved to, whatever 1800h:01 reads.
    #[row(fuzz = Never(FoundSometimes))]
    TpdoIdOutlivesReset,
    /// A TPDO that is due while the SDO server writes is lost.
    TpdoLostAfterSdo,
    /// Remote frames for TPDO 1 are not answered.
    TpdoRemoteIgnored,
    /// TPDO 1 always has eight bytes.
    TpdoTooLong,
    /// A device that got its first node-ID by LSS waits for a reset.
    #[row(fuzz = Allowed("node-id"))]
    UnconfiguredNodeIdWaits,
    /// LSS refuses every bit rate.
    #[row(fuzz = Allowed("bit-rate"))]
    LssBitTimingRefused,
    /// Parts of another address do not end switch selective.
    #[row(fuzz = Never(OpenAnswer))]
    LssSelectiveMismatchIgnored,
    /// A block upload that becomes a normal one loses the first byte.
    SdoBlockSwitchTruncates,
    /// Node guarding answers say pre-operational in every state.
    #[row(model = "kuebler-sendix-58x8")]
    GuardingWrongState,
    /// Node guarding is not answered while the life time is 0.
    #[row(model = "kuebler-sendix-58x8")]
    GuardingSilentWhenOff,
    /// The master is missed one guard time too late.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LossNoticed))]
    LifeTimeFactorOffByOne,
    /// Setting the life time to 0 does not end life guarding.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LossNoticed))]
    LifeGuardingNotStopped,
    /// A lost master is not reported by an EMCY message.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LossNoticed))]
    LifeGuardingUnreported,
    /// 100Dh does not exist, although there is no 1017h either.
    #[row(model = "tr-c65")]
    ErrorControlMissing,
    /// 100Eh holds another COB-ID than the one that node guarding uses.
    #[row(model = "tr-c65", fuzz = Never(WrongFromPowerOn))]
    GuardingCobIdWrong,
    /// 100Bh holds another node-ID than the one in use.
    #[row(model = "tr-c65", fuzz = Never(WrongFromPowerOn))]
    NodeIdObjectWrong,
    /// 1004h counts more PDOs than there are.
    #[row(model = "tr-c65", fuzz = Never(WrongFromPowerOn))]
    PdoCountWrong,
    /// Remote frames for a TPDO that allows them are not answered.
    #[row(model = "tr-c65", fuzz = Never(RemoteSynchronous))]
    TpdoRemoteUnanswered,
    /// 1001h keeps the bits of an error that is gone.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    ErrorRegisterStuck,
    /// Bit 0 of 1001h is set, with or without an error.
    #[row(fuzz = Never(AlarmBits))]
    ErrorRegisterNeverClear,
    /// When one of several errors is gone, 1001h and EMCY 0000h say that all are.
    #[row(fuzz = Never(AlarmBits))]
    ErrorsClearedTogether,
    /// Switch mode selective of LMT is answered with 44h, as LSS does.
    #[row(model = "tr-lmp30")]
    LmtSwitchSelectiveAnswered,
    /// Switch mode selective of LMT takes any serial number.
    #[row(model = "tr-lmp30")]
    LmtSerialNotCompared,
    /// Switch mode selective of LMT takes any manufacturer and product name.
    #[row(model = "tr-lmp30")]
    LmtNamesNotCompared,
    /// Reserved modes of switch mode global of LMT lead into configuration.
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
    /// A node-ID that LMT configures acts at once.
    #[row(model = "tr-lmp30", fuzz = Allowed("node-id"))]
    LmtNodeIdAtOnce,
    /// Store configuration of LMT is not answered.
    #[row(model = "tr-lmp30", fuzz = Allowed("nvm"))]
    LmtStoreSilent,
    /// The device goes on sending while LMT activates a bit timing.
    #[row(model = "tr-lmp30", fuzz = Never(BitRate))]
    LmtActivationNotSilent,
    /// LMT fills names up with FFh instead of 00h.
    #[row(model = "tr-lmp30")]
    LmtNameUnpadded,
    /// Identify remote slave of LMT is not answered.
    #[row(model = "tr-lmp30")]
    LmtIdentifySilent,
    /// Identify remote slave of LMT is answered outside the range of serial numbers.
    #[row(model = "tr-lmp30")]
    LmtIdentifyRangeIgnored,
    /// LMT inquiries give the serial number in binary.
    #[row(model = "tr-lmp30")]
    LmtSerialNotBcd,
    /// Bits 12 and 13 of 6500h are swapped.
    #[row(model = "lika-ax58", fuzz = Never(MeasuredValue))]
    LimitSwitchesSwapped,
    /// A limit switch acts on its limit already, not only beyond.
    #[row(model = "lika-ax58", fuzz = Never(MeasuredValue))]
    LimitSwitchInclusive,
    /// 6001h and 6002h scale the position although bit 2 of 6000h is 0.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    ScalingAlwaysOn,
    /// 1000h says single-turn of a multi-turn encoder.
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
    /// 6000h takes its reserved bits, and shows them.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ProfileLimits))]
    ReservedOperatingBitsAccepted,
    /// 6001h and 6002h take a range of less than one revolution.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ProfileLimits))]
    UnitsAboveRangeAccepted,
    /// 6001h = 0 makes the firmware divide by zero: nothing is answered until a reset.
    #[row(model = "kuebler-sendix-58x8")]
    UnitsZeroWedges,
    /// 6002h = 0, which stands for 2^32, makes 6004h stay 0.
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
    /// A preset outlives a reset without having been stored.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AfterStore))]
    PresetPersists,
    /// 1010h does not store the preset.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AfterStore))]
    PresetLostAfterSave,
    /// TPDOs carry the position without the preset.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    TpdoPositionWithoutPreset,
    /// A TPDO with an event timer is sent first when that has run out, not when the device becomes operational.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(TpdoEvent))]
    FirstPositionMissing,
    /// TPDOs carry what was measured for the TPDO before.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    TpdoPositionLate,
    /// 6200h = 0 does not end the cyclic transmission.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(LinkedTimer))]
    CyclicTimerNotStopped,
    /// 6200h keeps what is written to it, and TPDO 1 its period of before.
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
    /// 6040h shows the speed instead of how it changes.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    AccelerationShowsSpeed,
    /// 6400h has overflow and underflow the other way round.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    WorkAreaBitsSwapped,
    /// Bit 0 of 6400h is set above the work area, and not below it.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    WorkAreaOutsideOneSided,
    /// 6400h stays 0.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    WorkAreaStuck,
    /// 6400h says out of range while the position is in the work area.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(MeasuredValue))]
    WorkAreaInverted,
    /// 6401h takes a low limit above the high limit.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ProfileLimits))]
    WorkAreaLimitsSwappedAccepted,
    /// 6503h has a bit that 6504h does not support.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    UnsupportedAlarmSet,
    /// 6503h and 6504h have a reserved bit set.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(AlarmBits))]
    ReservedAlarmBitSet,
    /// 6505h has a bit that 6506h does not support.
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
    /// 650Bh is another number than 1018h:04.
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
    /// The second channel counts up as the first one does.
    #[row(model = "kuebler-d125", fuzz = Never(MeasuredValue))]
    RedundantChannelNotNegated,
    /// 3003h does not turn the direction of the angle.
    #[row(model = "kuebler-c100", fuzz = Never(MeasuredValue))]
    AngleDirectionIgnored,
    /// 3004h does not change the range of the angle.
    #[row(model = "kuebler-c100", fuzz = Never(MeasuredValue))]
    AngleRangeIgnored,
    /// The second angle does not run opposite to the first one.
    #[row(model = "kuebler-c100", fuzz = Never(MeasuredValue))]
    RedundantAngleSame,
    /// 3010h does not make the angle zero.
    #[row(model = "kuebler-c100", fuzz = Never(MeasuredValue))]
    ZeroPointIgnored,
    /// The EDS has a line that is neither section, field nor comment.
    #[row(fuzz = Never(InDescription))]
    EdsLineWithoutSense,
    /// The EDS has a section twice.
    #[row(fuzz = Never(InDescription))]
    EdsSectionTwice,
    /// The EDS does not describe sub-index 0 of 1018h.
    #[row(fuzz = Never(InDescription))]
    EdsSubIndexMissing,
    /// The EDS has a field twice in a section.
    #[row(fuzz = Never(InDescription))]
    EdsFieldTwice,
    /// The EDS gives 1017h no data type.
    #[row(fuzz = Never(InDescription))]
    EdsDataTypeMissing,
    /// The EDS writes a hexadecimal number with h after it.
    #[row(fuzz = Never(InDescription))]
    EdsNumberUnreadable,
    /// The EDS gives an integer a default with a decimal point.
    #[row(fuzz = Never(InDescription))]
    EdsFloatDefault,
    /// The EDS counts more sub-indexes of 1018h than it describes.
    #[row(fuzz = Never(InDescription))]
    EdsSubNumberWrong,
    /// The EDS counts more TPDOs than it describes.
    #[row(fuzz = Never(InDescription))]
    EdsPdoCountWrong,
    /// The EDS has its creation date with the year first.
    #[row(fuzz = Never(InDescription))]
    EdsDateWrong,
    /// The EDS has a 2 where there can be 0 or 1.
    #[row(fuzz = Never(InDescription))]
    EdsBooleanWrong,
    /// The EDS lists an object twice and another one not at all.
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
    /// The EDS maps an object with a length that it does not have.
    #[row(fuzz = Never(InDescription))]
    EdsMappingWrong,
    /// The EDS gives two TPDOs the same COB-ID.
    #[row(fuzz = Never(InDescription))]
    EdsCobIdTwice,
    /// The EDS gives 1017h another data type than CiA 301 does.
    #[row(fuzz = Never(InDescription))]
    EdsDataTypeWrong,
    /// The device has an object, 200Ah, that its description does not name.
    UndescribedObject,
    /// Sub-index FFh of 1018h exists, but does not tell the structure of the object.
    #[row(fuzz = Never(OpenAnswer))]
    StructureEntryWrong,
    /// 1015h is one more after every reset.
    ParameterDriftsAtReset,
    /// A download to a sub-index that does not exist is refused now for this reason, now as read-only.
    SdoRefusalAlternates,
    /// A maximum below its minimum is refused with abort 0601 0002h.
    #[row(model = "reference-406")]
    LimitsSwappedWrongCode,
    /// Mapping entries take any number of bits of an object.
    #[row(model = "reference-406")]
    MappingLengthUnchecked,
    /// Sub-index 0 of a mapping counts entries that are 0, but for the first.
    LaterEmptyEntryMapped,
    /// Sub-index 0 of a mapping counts entries that are 0.
    EmptyEntryMapped,
    /// After a refused mapping no mapping can be switched on until a reset.
    MappingFailureWedges,
    /// A TPDO that had to wait for its inhibit time is sent again after each further one.
    #[row(fuzz = Never(ApplicationEvent))]
    TpdoRepeatsAfterInhibit,
    /// Another CAN-ID in 1005h has no effect: SYNC is still received and sent with the one of before.
    #[row(fuzz = Never(SyncCanId))]
    SyncKeepsCanId,
    /// Switch state global to configuration, in configuration, has the effects of leaving it: a device without node-ID
    /// boots with the one that it got.
    #[row(fuzz = Never(UnconfiguredStart))]
    LssLeavesWhenToldAgain,
    /// 1007h has no effect: synchronous TPDOs are sent however late.
    #[row(fuzz = Never(SyncCount))]
    SyncWindowIgnored,
    /// A SYNC in pre-operational causes a TPDO at the start.
    #[row(fuzz = Never(SyncCount))]
    SyncRememberedOverStart,
    /// A transfer goes on after the device was stopped.
    SdoTransferSurvivesStop,
    /// A transfer goes on after a reset.
    SdoTransferSurvivesReset,
    /// 1020h is not cleared when a parameter changes.
    #[row(fuzz = Never(ConfigurationDate))]
    ConfigurationDateKept,
    /// 1020h is 0 after a reset, although it was stored.
    #[row(fuzz = Never(AfterStore))]
    ConfigurationDateLost,
    /// 650Ah:03 is half of what the encoder can show.
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
    /// 6050h shows the speed instead of how the acceleration changes.
    #[row(model = "reference-406", fuzz = Never(MeasuredValue))]
    JerkShowsSpeed,
    /// 1029h:02 has no effect.
    #[row(model = "kuebler-sendix-58x8", fuzz = Never(ErrorBehaviour))]
    ProfileErrorIgnored,
    /// With 1029h:02 = 1 an error of the sensor leads to pre-operational all the same.
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
    /// A slave that hears another one answer takes no further part in Fastscan.
    #[row(fuzz = Never(AnotherDevice))]
    FastscanYieldsToOthers,
    /// A node-ID configured by LSS outlives reset node without having been stored.
    #[row(fuzz = Never(AfterStore))]
    LssNodeIdStoredAtOnce,
    /// Of an NMT frame of four bytes or more the second two are obeyed.
    #[row(fuzz = Never(OpenAnswer))]
    NmtLongFrameMisread,
    /// An entry of 1016h whose node-ID does not exist watches every node.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerWatchesEveryone,
    /// A node whose entry in 1016h has the time 0 is missed at once after its first heartbeat.
    #[row(fuzz = Never(LossNoticed))]
    HeartbeatConsumerTimeZero,
    /// A heartbeat of no byte or of two stops the firmware.
    HeartbeatConsumerCrashes,
    /// Guarding requests are answered although there is no 100Ch.
    #[row(model = "kuebler-c100")]
    GuardingAnsweredUnsupported,
    /// 1010h:01 says that the device does not store on command, although it does.
    #[row(fuzz = Never(WrongFromPowerOn))]
    StoreCapabilityDenied,
    /// "save" is not answered in operational.
    #[row(fuzz = Never(StoreSignature))]
    StoreSilentWhenOperational,
    /// RPDOs take no synchronous transmission type.
    #[row(fuzz = Never(Refusal))]
    SynchronousRpdoRefused,
    /// An abort of the client does not end a block download.
    SdoBlockAbortIgnored,
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

    /// Whether the fuzzer claims to find the fault without further touches allowed.
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
#[error("no fault is called \"{0}\": `canvass list faults` shows them")]
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
