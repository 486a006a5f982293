//! Firmware faults that a simulated device can be given, drawn from defects of real devices and stacks.

use std::fmt;
use std::str::FromStr;

/// The model on which a fault shows where its row names no other.
const USUAL_MODEL: &str = "kuebler-sendix-58x8";

/// Defines the faults: one row each, so that name, variant and text can't drift apart. `on "MODEL"` names a model on
/// which the fault shows, where it is not the usual one; `fuzz` says that the fuzzer finds it, `fuzz allowing "..."` that
/// `--allow` has to name that, `because "..."` why it does not.
macro_rules! faults {
    ($($variant:ident = $id:literal $($key:ident $($argument:literal)?)*: $summary:literal,)*) => {
        /// One defect of a firmware. Each is a switch of its own; they can be combined.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub enum Fault {
            $(#[doc = $summary] $variant,)*
        }

        impl Fault {
            /// All faults, in the order of their definition.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The name on the command line.
            pub const fn id(self) -> &'static str {
                match self { $(Self::$variant => $id,)* }
            }

            /// What the firmware does wrong.
            pub const fn summary(self) -> &'static str {
                match self { $(Self::$variant => $summary,)* }
            }

            /// The id of a model on which it shows.
            pub fn model(self) -> &'static str {
                let named: Option<&'static str> = match self { $(Self::$variant => faults!(@model $($key $($argument)?)*),)* };
                named.unwrap_or(USUAL_MODEL)
            }

            /// Whether the fuzzer claims to find it, without being allowed more.
            pub const fn is_fuzzed(self) -> bool {
                match self { $(Self::$variant => faults!(@fuzz $($key $($argument)?)*),)* }
            }

            /// What the fuzzer has to be allowed so that it finds it; `None`: nothing, or it does not find it.
            pub const fn fuzz_needs(self) -> Option<&'static str> {
                match self { $(Self::$variant => faults!(@needs $($key $($argument)?)*),)* }
            }

            /// Why the fuzzer does not claim to find it; `None`: it does, if it is allowed what that needs.
            pub const fn unfuzzed(self) -> Option<&'static str> {
                match self { $(Self::$variant => faults!(@unfuzzed $($key $($argument)?)*),)* }
            }
        }
    };
    (@model fuzz $(allowing $touch:literal)?) => { None };
    (@model because $why:literal) => { None };
    (@model on $model:literal fuzz $(allowing $touch:literal)?) => { Some($model) };
    (@model on $model:literal because $why:literal) => { Some($model) };
    (@fuzz $(on $model:literal)? because $why:literal) => { false };
    (@fuzz $(on $model:literal)? fuzz) => { true };
    (@fuzz $(on $model:literal)? fuzz allowing $touch:literal) => { false };
    (@needs $(on $model:literal)? because $why:literal) => { None };
    (@needs $(on $model:literal)? fuzz) => { None };
    (@needs $(on $model:literal)? fuzz allowing $touch:literal) => { Some($touch) };
    (@unfuzzed $(on $model:literal)? because $why:literal) => { Some($why) };
    (@unfuzzed $(on $model:literal)? fuzz $(allowing $touch:literal)?) => { None };
}

faults! {
    BootUpMissing = "boot-up-missing" on "reference-301" fuzz: "No boot-up message after a reset.",
    BootUpTwice = "boot-up-twice" on "reference-301" fuzz: "Two boot-up messages after a reset.",
    BootUpWrongData = "boot-up-wrong-data" on "reference-301" fuzz: "The boot-up message carries the state pre-operational instead of 00h.",
    NmtBroadcastIgnored = "nmt-broadcast-ignored" on "reference-301" fuzz allowing "other-nodes": "NMT commands to node-ID 0 are ignored.",
    NmtNodeIdIgnored = "nmt-node-id-ignored" on "reference-301" fuzz allowing "other-nodes": "NMT commands to other nodes are obeyed.",
    NmtUnknownCommandStops = "nmt-unknown-command-stops" on "reference-301" fuzz: "A reserved NMT command puts the node into stopped.",
    NmtResetWhenStoppedIgnored = "nmt-reset-when-stopped-ignored" on "reference-301" fuzz: "Reset commands are ignored in stopped.",
    NmtStartWhenStoppedIgnored = "nmt-start-when-stopped-ignored" on "reference-301" fuzz: "Start remote node is ignored in stopped.",
    NmtResetCommunicationKeepsParameters = "nmt-reset-communication-keeps-parameters" on "reference-301" fuzz: "Reset communication does not restore unsaved communication parameters.",
    NmtStartRefusedInError = "nmt-start-refused-in-error" on "reference-301" fuzz: "A lasting error of the hardware, which EMCY 5000h tells after each start, keeps the device out of operational.",
    NmtStopWhenOperationalIgnored = "nmt-stop-when-operational-ignored" on "reference-301" fuzz: "Stop remote node is ignored in operational.",
    NmtEnterPreOperationalIgnored = "nmt-enter-pre-operational-ignored" on "reference-301" fuzz: "Enter pre-operational is ignored.",
    NmtRepeatedCommandResets = "nmt-repeated-command-resets" on "reference-301" fuzz: "A command for the state that the node is in already restarts it.",
    NmtShortFrameObeyed = "nmt-short-frame-obeyed" on "reference-301" fuzz allowing "other-nodes": "An NMT frame without node-ID is taken as a command to the node.",
    NmtResetNodeKeepsParameters = "nmt-reset-node-keeps-parameters" on "reference-301" fuzz: "Reset node does not restore unsaved parameters.",
    SdoSilentWhenOperational = "sdo-silent-when-operational" on "reference-301" fuzz: "The SDO server does not answer in operational.",
    SdoRefusedSegmentServed = "sdo-refused-segment-served" on "reference-301" fuzz: "The bytes of a segment that was refused are given as the next value of four bytes that is read.",
    SdoSegmentWrittenInUpload = "sdo-segment-written-in-upload" on "reference-301" because "changes a string: the models remember values of up to eight bytes": "A download segment during an upload is refused, and overwrites the value that is being uploaded.",
    SdoStraySegmentSilent = "sdo-stray-segment-silent" on "reference-301" fuzz: "A segment without a transfer is not answered.",
    SdoBusyAfterAbandonedTransfer = "sdo-busy-after-abandoned-transfer" on "reference-301" fuzz: "A new request during a segmented transfer is refused with abort 0504 0001h.",
    SdoUnsizedDownloadSilent = "sdo-unsized-download-silent" on "reference-301" fuzz: "A download that does not state its length is not answered.",
    SdoAnsweredWhenStopped = "sdo-answered-when-stopped" on "reference-301" fuzz: "The SDO server answers in stopped.",
    SdoRequestKeptOverStop = "sdo-request-kept-over-stop" on "reference-301" fuzz: "A request that comes in stopped is answered once stopped is left.",
    HeartbeatWrongState = "heartbeat-wrong-state" on "reference-301" fuzz: "Heartbeats say pre-operational in every state.",
    HeartbeatPeriodDoubled = "heartbeat-period-doubled" on "reference-301" fuzz: "Heartbeats come at twice the time of 1017h.",
    HeartbeatNotStopped = "heartbeat-not-stopped" on "reference-301" fuzz: "Writing 0 to 1017h does not end the heartbeat.",
    SdoStaleMultiplexer = "sdo-stale-multiplexer" on "reference-301" fuzz: "Aborts name the object of the transfer before.",
    SdoWrongCodeForNoObject = "sdo-wrong-code-for-no-object" on "reference-301" fuzz: "An object that does not exist is refused with abort 0609 0011h.",
    SdoWrongCodeForNoSubIndex = "sdo-wrong-code-for-no-sub-index" on "reference-301" fuzz: "A sub-index that does not exist is refused with abort 0602 0000h.",
    SdoReadOnlyWritable = "sdo-read-only-writable" on "reference-301" fuzz: "Downloads to read-only objects are confirmed.",
    SdoReadOnlyWrongCode = "sdo-read-only-wrong-code" on "reference-301" fuzz: "A download to a read-only object is refused with abort 0800 0022h.",
    SdoLengthUnchecked = "sdo-length-unchecked" on "reference-301" fuzz: "Downloads that are too long are confirmed.",
    SdoShortLengthUnchecked = "sdo-short-length-unchecked" on "reference-301" fuzz: "Downloads that are too short are confirmed.",
    SdoUnknownCommandSilent = "sdo-unknown-command-silent" on "reference-301" fuzz: "An unknown SDO command specifier is not answered.",
    SdoFirstUnknownCommandSilent = "sdo-first-unknown-command-silent" on "reference-301" fuzz: "An unknown SDO command specifier as the first request after boot-up is not answered.",
    SdoAbortAnswered = "sdo-abort-answered" on "reference-301" fuzz: "The server answers an abort of the client with an abort.",
    SdoToggleUnchecked = "sdo-toggle-unchecked" on "reference-301" fuzz: "Segments whose toggle bit does not alternate are accepted.",
    SdoToggleWrongCode = "sdo-toggle-wrong-code" on "reference-301" fuzz: "A wrong toggle bit is refused with abort 0504 0001h.",
    SdoUploadToggleStuck = "sdo-upload-toggle-stuck" on "reference-301" fuzz: "The toggle bit of upload segments is always 0.",
    SdoConfirmationToggleStuck = "sdo-confirmation-toggle-stuck" on "reference-301" fuzz: "The toggle bit of confirmed download segments is always 0.",
    SdoUploadEndMissing = "sdo-upload-end-missing" on "reference-301" fuzz: "The last segment of an upload is not marked as the last.",
    SdoAnnouncedSizeWrong = "sdo-announced-size-wrong" on "reference-301" fuzz: "A segmented upload announces one byte more than it has.",
    SdoSegmentAfterEndAnswered = "sdo-segment-after-end-answered" on "reference-301" fuzz: "After the last segment of an upload more can be asked for.",
    SdoSegmentsWrittenAtOnce = "sdo-segments-written-at-once" on "reference-301" fuzz: "Each segment of a download goes into the object at once, before the transfer is complete.",
    SdoSegmentedShortRefused = "sdo-segmented-short-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "Objects of up to four bytes can't be written in segments.",
    SdoSegmentedSizeRequired = "sdo-segmented-size-required" on "reference-301" fuzz: "A segmented download that does not announce its size is refused.",
    SdoEmptySegmentSilent = "sdo-empty-segment-silent" on "reference-301" fuzz: "A download segment without data is not answered.",
    SdoReadOnlySegmentedAccepted = "sdo-read-only-segmented-accepted" on "reference-301" fuzz: "Read-only objects are protected against expedited downloads only.",
    SdoAbortIgnored = "sdo-abort-ignored" on "reference-301" fuzz: "An abort of the client does not end the transfer.",
    SdoWrongCommandIgnored = "sdo-wrong-command-ignored" on "reference-301" fuzz: "A command that has no place in the transfer under way is not answered.",
    SdoStrayBlockSilent = "sdo-stray-block-silent" on "reference-301" fuzz: "Commands of a block transfer without one are not answered.",
    SdoBusyAfterAbandonedDownload = "sdo-busy-after-abandoned-download" on "reference-301" fuzz: "A new request during a segmented download is refused with abort 0504 0001h.",
    SdoBackToBackMixed = "sdo-back-to-back-mixed" because "is about a request that overlaps another: what a server does with a second request before its answer to the first is nowhere written": "A request that comes before the answer to the last one changes the object that this answer names.",
    SdoResponseLost = "sdo-response-lost" on "reference-301" because "shows after more requests or resets in one go than a sequence has": "Every hundredth request is not answered.",
    SdoShortRequestWedges = "sdo-short-request-wedges" on "reference-301" fuzz: "After a request of less than eight bytes the SDO server is dead.",
    SdoRemoteAnswered = "sdo-remote-answered" on "reference-301" fuzz: "A remote frame with the CAN-ID of SDO requests is answered.",
    SdoExtendedAnswered = "sdo-extended-answered" on "reference-301" fuzz: "A 29-bit frame whose identifier ends like that of SDO requests is answered.",
    SdoOtherNodeAnswered = "sdo-other-node-answered" on "reference-301" fuzz allowing "other-nodes": "SDO requests to the next node-ID are answered too.",
    SdoTimeoutWedges = "sdo-timeout-wedges" on "reference-301" fuzz: "After a transfer that the client did not go on with the SDO server is dead.",
    SdoNoObjectSilent = "sdo-no-object-silent" on "reference-301" fuzz: "Requests to objects that do not exist are not answered.",
    SdoAbortMultiplexerZero = "sdo-abort-multiplexer-zero" on "reference-301" fuzz: "Aborts name object 0000h:00.",
    SdoLengthWrongCode = "sdo-length-wrong-code" on "reference-301" fuzz: "A wrong length is refused with abort 0609 0030h.",
    SdoRangeWrongCode = "sdo-range-wrong-code" fuzz: "A value outside its limits is refused with abort 0601 0002h.",
    SdoCommandWrongCode = "sdo-command-wrong-code" on "reference-301" fuzz: "Wrong command specifiers are refused with abort 0800 0000h.",
    SdoUnknownAbortCode = "sdo-unknown-abort-code" on "reference-301" fuzz: "A sub-index that does not exist is refused with abort 0A00 0001h, which nobody defines.",
    SdoWriteOnlyWrongCode = "sdo-write-only-wrong-code" on "reference-301" fuzz: "Reading a write-only object is refused with abort 0602 0000h.",
    SdoEmptyValueSilent = "sdo-empty-value-silent" on "reference-301" fuzz: "The upload of an empty string is not answered.",
    SdoBusyAfterAbandonedBlock = "sdo-busy-after-abandoned-block" on "reference-301" because "is what the standard leaves open: a request that begins a transfer in the middle of a block transfer may be refused": "A new request during a block transfer is refused with abort 0504 0001h.",
    SdoBlockSizeUnchecked = "sdo-block-size-unchecked" on "reference-301" fuzz: "Block sizes of 0 and above 127 are accepted.",
    SdoBlockSizeWrongCode = "sdo-block-size-wrong-code" on "reference-301" fuzz: "Wrong block sizes are refused with abort 0609 0030h.",
    SdoBlockConfirmationIgnored = "sdo-block-confirmation-ignored" on "reference-301" fuzz: "A block upload goes on with the next block, whatever the client confirms.",
    SdoBlockConfirmationUnchecked = "sdo-block-confirmation-unchecked" on "reference-301" fuzz: "The confirmation of segments that were not sent is accepted.",
    SdoBlockRepeatsAll = "sdo-block-repeats-all" on "reference-301" fuzz: "After a lost segment the whole block is sent again, not what was not confirmed.",
    SdoBlockNewSizeIgnored = "sdo-block-new-size-ignored" on "reference-301" fuzz: "All blocks of an upload have the size of the first.",
    SdoBlockAnnouncedSizeWrong = "sdo-block-announced-size-wrong" on "reference-301" fuzz: "A block upload announces one byte more than it has.",
    SdoBlockLastLengthWrong = "sdo-block-last-length-wrong" on "reference-301" fuzz: "The end of a block upload counts one unused byte too many.",
    SdoBlockSevenEndsEmpty = "sdo-block-seven-ends-empty" on "reference-301" fuzz: "The end of a block upload of 7 bytes, or a multiple, says that the last segment holds none.",
    SdoBlockCrcStartWrong = "sdo-block-crc-start-wrong" on "reference-301" fuzz: "The CRC of block uploads starts with FFFFh.",
    SdoBlockCrcSwapped = "sdo-block-crc-swapped" on "reference-301" fuzz: "The CRC of block uploads has its bytes in the wrong order.",
    SdoBlockCrcUnasked = "sdo-block-crc-unasked" on "reference-301" fuzz: "The end of a block upload without CRC holds one all the same.",
    SdoBlockEndUnmarked = "sdo-block-end-unmarked" on "reference-301" fuzz: "The last segment of a block upload is not marked as the last.",
    SdoBlockNumbersContinue = "sdo-block-numbers-continue" on "reference-301" fuzz: "The sequence numbers of a block upload do not begin with 1 in every block.",
    SdoBlockSizeZeroOffered = "sdo-block-size-zero-offered" on "reference-301" fuzz: "The server asks for blocks of no segments.",
    SdoBlockReadOnlyAccepted = "sdo-block-read-only-accepted" on "reference-301" fuzz: "A block download to a read-only object is confirmed, without effect.",
    SdoBlockDownloadRefused = "sdo-block-download-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "Every block download is refused with abort 0607 0013h.",
    SdoBlockSequenceZeroIgnored = "sdo-block-sequence-zero-ignored" on "reference-301" because "is an answer that the standard leaves open, so that every choice is right": "A segment with sequence number 0 is taken for none.",
    SdoBlockRepeatedAppended = "sdo-block-repeated-appended" on "reference-301" fuzz: "A segment that comes twice is taken twice.",
    SdoBlockGapAccepted = "sdo-block-gap-accepted" on "reference-301" fuzz: "A block download goes on over a lost segment.",
    SdoBlockPaddingKept = "sdo-block-padding-kept" on "reference-301" fuzz: "The unused bytes of the last segment of a block download are taken as data.",
    SdoBlockCrcIgnored = "sdo-block-crc-ignored" on "reference-301" fuzz: "The CRC of block downloads is not checked.",
    SdoBlockCrcKept = "sdo-block-crc-kept" on "reference-301" fuzz: "A block download without CRC is checked for one, once another one had it.",
    SdoBlockCrcWrongCode = "sdo-block-crc-wrong-code" on "reference-301" fuzz: "A wrong CRC is refused with abort 0800 0000h.",
    SdoBlockWrittenBeforeCheck = "sdo-block-written-before-check" on "reference-301" fuzz: "The value of a block download is written before its CRC is checked.",
    SdoBlockSizeMismatchAccepted = "sdo-block-size-mismatch-accepted" on "reference-301" fuzz: "A block download of another size than announced is accepted.",
    SdoBlockCountOffByOne = "sdo-block-count-off-by-one" on "reference-301" fuzz: "The confirmation of a downloaded block counts one segment too few.",
    SdoBlockEndSilent = "sdo-block-end-silent" on "reference-301" fuzz: "The end of a block download is not confirmed.",
    SdoSegmentLengthWrong = "sdo-segment-length-wrong" on "reference-301" fuzz: "The last segment of an upload announces one byte too few.",
    SdoUnusedBytesNotZero = "sdo-unused-bytes-not-zero" fuzz: "Reserved bytes of SDO responses hold old data.",
    SdoShortResponse = "sdo-short-response" fuzz: "SDO responses have only as many bytes as they need.",
    VendorIdZero = "vendor-id-zero" on "reference-301" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1018h:01 is 0.",
    DeviceTypeProfileWrong = "device-type-profile-wrong" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1000h names device profile 401 instead of that of an encoder.",
    IdentityRevisionMissing = "identity-revision-missing" on "reference-301" fuzz: "1018h:03 does not exist, although LSS needs it.",
    ErrorRegisterMissing = "error-register-missing" on "reference-301" fuzz: "1001h does not exist.",
    DeviceNameWithGarbage = "device-name-with-garbage" on "reference-301" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1008h ends in bytes that are not printable.",
    TpdoInPreOperational = "tpdo-in-pre-operational" on "reference-301" fuzz: "TPDOs are sent in pre-operational.",
    EventTimerDoubled = "event-timer-doubled" on "reference-301" fuzz: "TPDOs come at twice the time of their event timer.",
    HeartbeatToggles = "heartbeat-toggles" on "reference-301" fuzz: "Heartbeats have bit 7 set.",
    HeartbeatLostOnStateChange = "heartbeat-lost-on-state-change" on "reference-301" fuzz: "The heartbeat ends when the NMT state changes.",
    HeartbeatConsumerDoubleAccepted = "heartbeat-consumer-double-accepted" on "reference-301" fuzz: "1016h takes two entries for one node.",
    GuardingToggleStuck = "guarding-toggle-stuck" on "reference-301" fuzz: "The toggle bit of node guarding answers does not alternate.",
    SdoRangeUnchecked = "sdo-range-unchecked" fuzz: "Values outside the limits of the device description are confirmed.",
    TpdoWhenStopped = "tpdo-when-stopped" on "reference-301" fuzz: "TPDOs are sent in stopped.",
    SyncCycleIgnored = "sync-cycle-ignored" on "reference-301" fuzz: "TPDOs of transmission type n are sent at every SYNC.",
    InhibitTimeIgnored = "inhibit-time-ignored" on "reference-301" fuzz: "The inhibit time of TPDOs is not observed.",
    CobIdChangeWhileValid = "cob-id-change-while-valid" on "reference-301" fuzz: "The CAN-ID of a PDO can be changed while the PDO is valid.",
    RestrictedCanIdAccepted = "restricted-can-id-accepted" on "reference-301" fuzz: "Restricted CAN-IDs are accepted for PDOs, SYNC and EMCY.",
    ReservedTransmissionTypeAccepted = "reserved-transmission-type-accepted" on "reference-301" fuzz: "Reserved transmission types are accepted.",
    MappingChangeWhileValid = "mapping-change-while-valid" on "reference-301" fuzz: "The mapping can be changed while it is in use.",
    MappingTooLongAccepted = "mapping-too-long-accepted" fuzz: "Mappings of more than 64 bits are accepted.",
    UnmappableObjectMapped = "unmappable-object-mapped" on "reference-301" fuzz: "Objects that are not for PDOs can be mapped.",
    CyclicTimerNotLinked = "cyclic-timer-not-linked" because "is about the event timer that an object of the profile is linked to: after a write to the one the models take the other for unknown": "6200h does not change the event timer of TPDO 1.",
    StoreSignatureUnchecked = "store-signature-unchecked" on "reference-301" fuzz allowing "nvm": "1010h and 1011h take any value as their signature.",
    StoreWithoutEffect = "store-without-effect" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "1010h confirms, but nothing is stored.",
    RestoreAtOnce = "restore-at-once" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "1011h restores the values at once instead of at the next reset.",
    EmcyWhenStopped = "emcy-when-stopped" on "reference-301" fuzz: "EMCY messages are sent in stopped.",
    EmcyResetMissing = "emcy-reset-missing" on "reference-301" fuzz: "No EMCY 0000h when an error is gone.",
    EmcyRepeated = "emcy-repeated" on "reference-301" fuzz: "An EMCY message is sent twice.",
    ErrorRegisterGenericMissing = "error-register-generic-missing" on "reference-301" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "1001h does not have its generic bit set together with others.",
    ErrorHistoryNotCleared = "error-history-not-cleared" on "reference-301" because "is about the history of errors: what stands in 1003h depends on errors that only the device knows": "Writing 0 to 1003h:00 does not clear the history.",
    LssNodeIdUnchecked = "lss-node-id-unchecked" on "reference-301" fuzz allowing "node-id": "LSS confirms node-IDs that don't exist.",
    LssAnsweredWhileWaiting = "lss-answered-while-waiting" on "reference-301" fuzz: "LSS inquiries are answered in the waiting state.",
    PresetIgnored = "preset-ignored" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6003h is confirmed, but the position does not change.",
    PresetOutOfRangeAccepted = "preset-out-of-range-accepted" because "accepts a value that CiA 406 or the manual forbids: the models know the limits of the description and the rules of CiA 301 for values, not those of a profile": "6003h takes values outside the measuring range.",
    CodeSequenceIgnored = "code-sequence-ignored" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6000h bit 0 does not turn the direction of counting.",
    ScalingIgnored = "scaling-ignored" fuzz: "6001h and 6002h do not scale the position.",
    OperatingStatusStuck = "operating-status-stuck" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6500h does not follow 6000h.",
    NmtResetCommunicationRestoresAll = "nmt-reset-communication-restores-all" on "reference-301" fuzz: "Reset communication loads application parameters anew too.",
    NmtCommandLost = "nmt-command-lost" on "reference-301" fuzz: "Of NMT commands within one millisecond only the first one is obeyed.",
    ExtendedFrameObeyed = "extended-frame-obeyed" on "reference-301" fuzz: "Frames with 29-bit identifiers are taken for those with the same lower 11 bits.",
    BootUpSometimesMissing = "boot-up-sometimes-missing" on "reference-301" because "shows after more requests or resets in one go than a sequence has": "Every eighth reset ends without a boot-up message.",
    EmcyBeforeBootUp = "emcy-before-boot-up" on "reference-301" because "comes in the moment of a reset, when a frame may still have been on its way": "An EMCY message is sent before the boot-up message.",
    SdoAnsweredBeforeBootUp = "sdo-answered-before-boot-up" on "reference-301" fuzz: "The SDO server answers before the boot-up message.",
    StartUpIgnored = "start-up-ignored" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "The device waits in pre-operational, whatever 1F80h says.",
    HeartbeatTimerRounded = "heartbeat-timer-rounded" on "reference-301" fuzz: "Heartbeat times are rounded up to multiples of 64 ms.",
    HeartbeatBurst = "heartbeat-burst" on "reference-301" because "shows before the write that causes it is confirmed, when the new heartbeat time may be in force or not": "A new heartbeat time while heartbeats are sent causes a burst of them.",
    HeartbeatLateAfterBootUp = "heartbeat-late-after-boot-up" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "The first heartbeat after a reset comes three periods after the boot-up message.",
    HeartbeatStateLate = "heartbeat-state-late" on "reference-301" fuzz: "A heartbeat shows the state at the heartbeat before.",
    GuardingToggleNotReset = "guarding-toggle-not-reset" on "reference-301" fuzz: "Reset communication does not reset the toggle bit of node guarding.",
    GuardingBesideHeartbeat = "guarding-beside-heartbeat" on "reference-301" fuzz: "Node guarding is answered while heartbeats are sent.",
    LifeGuardingStartsAtOnce = "life-guarding-starts-at-once" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "Life guarding begins without a first remote frame of the master.",
    LifeTimeFactorIgnored = "life-time-factor-ignored" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "The master is missed after the guard time, whatever the life time factor is.",
    HeartbeatConsumerStartsAtOnce = "heartbeat-consumer-starts-at-once" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "A node is missed that was never heard.",
    HeartbeatConsumerDeafToNodeOne = "heartbeat-consumer-deaf-to-node-one" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "Node 1 is not watched, whatever 1016h says.",
    HeartbeatConsumerDeafWhenStopped = "heartbeat-consumer-deaf-when-stopped" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "While the device is stopped, heartbeats of watched nodes do not count.",
    HeartbeatConsumerRestartedByWrites = "heartbeat-consumer-restarted-by-writes" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "Each write to any object begins watching anew, as if no heartbeat had come yet.",
    HeartbeatConsumerOutlivesReset = "heartbeat-consumer-outlives-reset" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "A node is watched on after a reset that has emptied 1016h.",
    HeartbeatConsumerNotRearmed = "heartbeat-consumer-not-rearmed" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "A node that was missed once is not noticed when it is back.",
    HeartbeatConsumerFirstOnly = "heartbeat-consumer-first-only" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "Only the first entry of 1016h is watched.",
    ErrorBehaviourIgnored = "error-behaviour-ignored" on "reference-301" because "is about what a device does on an error (1029h), or whether: what the error is, only its application knows, and a change of state by itself is followed, not demanded": "1029h has no effect: the NMT state never changes by an error.",
    ErrorBehaviourUnchecked = "error-behaviour-unchecked" on "reference-301" fuzz: "1029h takes reserved values.",
    ErrorBehaviourLeavesStopped = "error-behaviour-leaves-stopped" on "reference-301" because "is about what a device does on an error (1029h), or whether: what the error is, only its application knows, and a change of state by itself is followed, not demanded": "With 1029h:01 = 0 an error in stopped leads to pre-operational.",
    RpdoInPreOperational = "rpdo-in-pre-operational" on "reference-301" fuzz: "RPDOs act in pre-operational.",
    RpdoLengthUnchecked = "rpdo-length-unchecked" on "reference-301" because "is about PDOs longer or shorter than their mapping: CiA 301 lets a device process or ignore the first, and only asks for an EMCY message on the second": "RPDOs that are too short act, with zeros for what is missing.",
    ShortRpdoUnreported = "short-rpdo-unreported" on "reference-301" because "is about PDOs longer or shorter than their mapping: CiA 301 lets a device process or ignore the first, and only asks for an EMCY message on the second": "An RPDO that is too short is ignored without EMCY.",
    LongRpdoIgnored = "long-rpdo-ignored" on "reference-301" because "is about PDOs longer or shorter than their mapping: CiA 301 lets a device process or ignore the first, and only asks for an EMCY message on the second": "RPDOs that are longer than their mapping don't act.",
    LongRpdoCalledLate = "long-rpdo-called-late" on "reference-301" because "is about PDOs longer or shorter than their mapping: CiA 301 lets a device process or ignore the first, and only asks for an EMCY message on the second": "An RPDO that is longer than its mapping is reported as one that is late, EMCY 8250h.",
    SynchronousRpdoActsAtOnce = "synchronous-rpdo-acts-at-once" on "reference-301" because "is about RPDOs that wait for SYNC or for their deadline: the models follow only those that act at once": "Synchronous RPDOs don't wait for SYNC.",
    RpdoDeadlineIgnored = "rpdo-deadline-ignored" on "reference-301" because "is about RPDOs that wait for SYNC or for their deadline: the models follow only those that act at once": "An RPDO that is late is not missed.",
    RpdoDeadlineOutlivesStop = "rpdo-deadline-outlives-stop" on "reference-301" because "is about RPDOs that wait for SYNC or for their deadline: the models follow only those that act at once": "The deadline of an RPDO runs on when operational is left.",
    RpdoDeadlineNotRestarted = "rpdo-deadline-not-restarted" on "reference-301" because "is about RPDOs that wait for SYNC or for their deadline: the models follow only those that act at once": "The deadline of an RPDO begins with the first one, and no other one restarts it.",
    RpdoHeldOverStop = "rpdo-held-over-stop" on "reference-301" because "is about what an RPDO held when operational was left, of which CiA 301 says nothing": "Values of a synchronous RPDO that wait for SYNC outlive operational.",
    RpdoReceivedWhenInvalid = "rpdo-received-when-invalid" on "reference-301" fuzz: "RPDOs act although bit 31 of their COB-ID is set.",
    RpdoRangeUnchecked = "rpdo-range-unchecked" on "reference-301" because "is a value beyond its limits that comes by PDO: nobody is answered, so that the models don't know whether it was taken": "An RPDO sets values that an SDO can't.",
    RemoteFrameTakenAsRpdo = "remote-frame-taken-as-rpdo" on "reference-301" fuzz: "A remote frame with the CAN-ID of an RPDO sets its objects to zero.",
    TpdoBeyondCount = "tpdo-beyond-count" on "reference-301" because "is in the contents of TPDOs, which the models do not judge": "A TPDO carries one object more than sub-index 0 of its mapping says, where the entry after the last is filled.",
    EventTimerOffByOne = "event-timer-off-by-one" on "reference-301" because "is later or earlier than it should be by no more than the tolerance that a timer in milliseconds and a bus in use need": "TPDOs come one millisecond later than their event timer says.",
    InhibitTimeInMilliseconds = "inhibit-time-in-milliseconds" on "reference-301" because "makes a PDO wait longer than it should after an event: when a value has changed, only the device knows": "The inhibit time counts in milliseconds instead of 100 microseconds.",
    AcyclicTpdoWithoutEvent = "acyclic-tpdo-without-event" on "reference-301" because "is about what counts as an event of a TPDO, which the manufacturer decides": "TPDOs of transmission type 0 are sent at every SYNC.",
    SyncWithoutStartValueIgnored = "sync-without-start-value-ignored" on "reference-301" because "is about SYNC start value, window and counter of TPDOs, whose count the models take as unknown while one of them is in use": "A TPDO without SYNC start value waits for a SYNC whose counter is 0, which never comes.",
    SynchronousTpdoAtStart = "synchronous-tpdo-at-start" on "reference-301" because "is about what counts as an event of a TPDO, which the manufacturer decides": "Synchronous TPDOs are sent once when the device starts.",
    SyncStartValueIgnored = "sync-start-value-ignored" on "reference-301" because "is about SYNC start value, window and counter of TPDOs, whose count the models take as unknown while one of them is in use": "The SYNC start value of TPDOs has no effect.",
    SyncCountNotReset = "sync-count-not-reset" on "reference-301" because "is about SYNC start value, window and counter of TPDOs, whose count the models take as unknown while one of them is in use": "TPDOs of transmission type n go on counting SYNCs where they stopped.",
    TpdoNotSentAtStart = "tpdo-not-sent-at-start" on "reference-301" because "is about what counts as an event of a TPDO, which the manufacturer decides": "Event-driven TPDOs are not sent when the device becomes operational.",
    TpdoLostWhenInhibited = "tpdo-lost-when-inhibited" on "reference-301" because "is about what counts as an event of a TPDO, which the manufacturer decides": "A change of value within the inhibit time of a TPDO is never sent.",
    RemoteFrameAnsweredWhenNotAllowed = "remote-frame-answered-when-not-allowed" on "reference-301" because "is about a remote frame to a PDO that does not allow one, or about the moment whose values it shows: an answer is followed, not forbidden, and contents of PDOs are not judged": "Remote frames are answered although bit 30 of the COB-ID is set.",
    RtrTypeSampledAtOnce = "rtr-type-sampled-at-once" on "reference-301" because "is about a remote frame to a PDO that does not allow one, or about the moment whose values it shows: an answer is followed, not forbidden, and contents of PDOs are not judged": "A TPDO of transmission type 252 holds the values of the remote frame, not of the SYNC.",
    RtrTypeWithoutRtrAccepted = "rtr-type-without-rtr-accepted" on "reference-406" because "is an answer that the standard leaves open, so that every choice is right": "Transmission types 252 and 253 are accepted although remote frames are not supported.",
    RtrBitClearable = "rtr-bit-clearable" on "reference-406" because "is an answer that the standard leaves open, so that every choice is right": "Bit 30 of a COB-ID can be cleared although remote frames are not supported.",
    InhibitTimeChangeWhileValid = "inhibit-time-change-while-valid" on "reference-301" because "is found too, but in some runs only by nine or ten frames: what the fuzzer claims, it shows by eight at most": "The inhibit time can be changed while the PDO is valid.",
    SyncStartValueChangeWhileValid = "sync-start-value-change-while-valid" on "reference-301" fuzz: "The SYNC start value can be changed while the PDO is valid.",
    EmptyPdoValidated = "empty-pdo-validated" on "reference-301" because "switches a PDO on that carries nothing: a device may refuse that, or never send it": "A PDO without mapping can be made valid.",
    MappingCountUnchecked = "mapping-count-unchecked" on "reference-301" fuzz: "Sub-index 0 of a mapping takes any number of entries.",
    MissingObjectMapped = "missing-object-mapped" on "reference-301" fuzz: "Objects that do not exist can be mapped.",
    DummyMappedIntoTpdo = "dummy-mapped-into-tpdo" on "reference-301" fuzz: "Dummy entries can be mapped into TPDOs.",
    SyncPeriodDoubled = "sync-period-doubled" on "reference-301" because "is about SYNC or TIME that the device itself produces: the models follow its identifier, not its period and content": "SYNC is produced at twice the time of 1006h.",
    SyncWhenStopped = "sync-when-stopped" on "reference-301" because "is about SYNC or TIME that the device itself produces: the models follow its identifier, not its period and content": "SYNC is produced in stopped.",
    SyncCounterNotReset = "sync-counter-not-reset" on "reference-301" because "is about SYNC or TIME that the device itself produces: the models follow its identifier, not its period and content": "The SYNC counter goes on where it stopped.",
    SyncCounterFromZero = "sync-counter-from-zero" on "reference-301" because "is about SYNC or TIME that the device itself produces: the models follow its identifier, not its period and content": "The SYNC counter begins with 0.",
    SyncOverflowUnchecked = "sync-overflow-unchecked" on "reference-301" fuzz: "1019h takes 1 and values above 240.",
    SyncOverflowChangeWhileProducing = "sync-overflow-change-while-producing" on "reference-301" fuzz: "1019h can be changed while 1006h is not 0.",
    SyncIdChangeWhileProducing = "sync-id-change-while-producing" on "reference-301" fuzz: "The CAN-ID of SYNC can be changed while SYNC is produced.",
    SyncLengthUnchecked = "sync-length-unchecked" on "reference-301" because "is an answer that the standard leaves open, so that every choice is right": "SYNC messages of a wrong length are obeyed.",
    TimeIgnored = "time-ignored" on "reference-301" because "is about the clock of the device, which no service shows but objects of the manufacturer": "TIME does not set the clock.",
    TimeIdChangeWhileValid = "time-id-change-while-valid" on "reference-301" fuzz: "The CAN-ID of TIME can be changed while TIME is in use.",
    TimeReservedBitsSet = "time-reserved-bits-set" on "reference-301" because "is about SYNC or TIME that the device itself produces: the models follow its identifier, not its period and content": "TIME is produced with reserved bits set.",
    SdoChannelIdChangeWhileValid = "sdo-channel-id-change-while-valid" on "reference-301" fuzz: "The COB-IDs of 1201h can be changed while the channel is valid.",
    EmcyInhibitTimeIgnored = "emcy-inhibit-time-ignored" on "reference-301" because "is an EMCY message that is missing or comes too soon after another: which errors there are, only the device knows": "1015h has no effect.",
    EmcyMutedByInhibitTime = "emcy-muted-by-inhibit-time" on "reference-301" because "is an EMCY message that is missing or comes too soon after another: which errors there are, only the device knows": "No error is signalled while the inhibit time of EMCY is not 0.",
    EmcyLostWhenInhibited = "emcy-lost-when-inhibited" on "reference-301" because "is an EMCY message that is missing or comes too soon after another: which errors there are, only the device knows": "Errors within the inhibit time of EMCY are never reported.",
    EmcyLostWhenStopped = "emcy-lost-when-stopped" on "reference-301" because "is an EMCY message that is missing or comes too soon after another: which errors there are, only the device knows": "Errors that come in stopped are never reported.",
    EmcyIdChangeWhileValid = "emcy-id-change-while-valid" on "reference-301" fuzz: "The CAN-ID of EMCY can be changed while EMCY is valid.",
    EmcySentWhenInvalid = "emcy-sent-when-invalid" on "reference-301" fuzz: "EMCY messages are sent although bit 31 of 1014h is set.",
    EmcyResetUnasked = "emcy-reset-unasked" on "reference-301" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "Each reading of 1001h sends EMCY 0000h.",
    EmcySurvivesReset = "emcy-survives-reset" on "reference-301" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "EMCY messages that wait for the inhibit time outlive reset communication.",
    EmcyKeepsCanId = "emcy-keeps-can-id" on "reference-301" because "is found only in some runs: few of the values that the fuzzer draws show it": "EMCY comes on 080h + node-ID whatever CAN-ID is written to 1014h.",
    EmcyMovedIsRemote = "emcy-moved-is-remote" on "reference-301" because "is found only in some runs: few of the values that the fuzzer draws show it": "With another CAN-ID than 080h + node-ID in 1014h EMCY comes as a remote frame.",
    EmcyRegisterZero = "emcy-register-zero" on "reference-301" fuzz: "EMCY messages hold 0 instead of the error register.",
    ErrorHistoryReversed = "error-history-reversed" on "reference-301" because "is about the history of errors: what stands in 1003h depends on errors that only the device knows": "1003h shows the oldest error first.",
    HistoryClearsRegister = "history-clears-register" on "reference-301" because "is about the history of errors: what stands in 1003h depends on errors that only the device knows": "Emptying 1003h ends all errors, which EMCY 0000h says.",
    ErrorHistoryMovesTwo = "error-history-moves-two" on "reference-301" because "is about the history of errors: what stands in 1003h depends on errors that only the device knows": "A new error moves no more than two entries of 1003h: those after them show the second.",
    ErrorHistoryOverflows = "error-history-overflows" on "reference-301" because "is about the history of errors: what stands in 1003h depends on errors that only the device knows": "1003h:00 counts beyond the entries that there are.",
    ErrorHistoryNonZeroAccepted = "error-history-non-zero-accepted" on "reference-301" fuzz: "1003h:00 takes values other than 0.",
    ErrorHistoryEmptyReadsZero = "error-history-empty-reads-zero" on "reference-301" because "is about the history of errors: what stands in 1003h depends on errors that only the device knows": "Entries of 1003h that hold no error read as 0.",
    RestoreSignatureUnchecked = "restore-signature-unchecked" on "reference-301" fuzz allowing "factory-defaults": "1011h takes any value as its signature.",
    LaterValuesStored = "later-values-stored" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "After 1010h each value that is written is stored too.",
    StoreSignatureFirstOnly = "store-signature-first-only" on "reference-301" fuzz allowing "nvm": "1010h and 1011h check the signature at sub-index 1 only.",
    RestoreWithoutEffect = "restore-without-effect" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "1011h confirms, but the stored values stay.",
    RestoreGroupIgnored = "restore-group-ignored" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "Every sub-index of 1011h restores all parameters.",
    StoreLosesGroup = "store-loses-group" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "1010h does not store application parameters.",
    StoreGroupIgnored = "store-group-ignored" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "Every sub-index of 1010h stores all parameters.",
    StoreTornByReset = "store-torn-by-reset" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "A reset while parameters are being stored leaves some of them new and some old.",
    LssSelectiveThreeParts = "lss-selective-three-parts" on "reference-301" fuzz: "Switch selective does not compare the serial number.",
    LssSelectiveAnyOrder = "lss-selective-any-order" on "reference-301" fuzz: "Switch selective takes the parts of the address in any order.",
    LssIdentifyRangeExclusive = "lss-identify-range-exclusive" on "reference-301" fuzz: "Identify remote slave excludes the upper bounds.",
    LssNonConfiguredAnswered = "lss-non-configured-answered" on "reference-301" fuzz: "A device with a node-ID answers identify non-configured remote slave.",
    LssReservedModeWaits = "lss-reserved-mode-waits" on "reference-301" because "is an answer that the standard leaves open, so that every choice is right": "Reserved modes of switch global lead to waiting.",
    LssBitTimingUnchecked = "lss-bit-timing-unchecked" on "reference-301" fuzz allowing "bit-rate": "LSS confirms bit rates that don't exist.",
    LssBitTimingWrongCode = "lss-bit-timing-wrong-code" on "reference-301" because "is an answer that the standard leaves open, so that every choice is right": "LSS refuses bit rates with the manufacturer's error code.",
    LssStoreSpecificError = "lss-store-specific-error" on "reference-301" fuzz allowing "nvm": "The confirmation of storing by LSS holds a specific error code although there is no error.",
    LssStoreNotPersistent = "lss-store-not-persistent" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "LSS confirms storing, but nothing is stored.",
    LssNodeIdAtOnce = "lss-node-id-at-once" on "reference-301" fuzz allowing "node-id": "A node-ID configured by LSS acts before the reset.",
    LssActivatesAtOnce = "lss-activates-at-once" on "reference-301" because "is about the bit rate: after its activation nobody can follow on a bus of the old one": "Activate bit timing does not wait for its delay.",
    FastscanEarlyMatch = "fastscan-early-match" on "reference-301" fuzz: "Fastscan ends at any part of the address after which the master goes back.",
    HeartbeatConsumerHangs = "heartbeat-consumer-hangs" on "reference-301" fuzz: "An entry of 1016h for a node-ID above 127 stops the firmware.",
    ResetWhenStoppedHangs = "reset-when-stopped-hangs" on "reference-301" fuzz: "A reset in stopped stops the firmware: it does not start again.",
    FastscanHangs = "fastscan-hangs" on "reference-301" fuzz: "A Fastscan for a part above 3 stops the firmware.",
    FastscanAnsweredWhenConfigured = "fastscan-answered-when-configured" on "reference-301" fuzz: "A device with a node-ID takes part in Fastscan.",
    UnconfiguredNodeBoots = "unconfigured-node-boots" on "reference-301" fuzz: "A device without node-ID starts as node 127.",
    WatchdogResetUnderLoad = "watchdog-reset-under-load" on "reference-301" because "shows after more requests or resets in one go than a sequence has": "Many frames in a short time make the watchdog reset the device.",
    SdoMemoryLeak = "sdo-memory-leak" on "reference-301" because "shows after more requests or resets in one go than a sequence has": "The SDO server is out of memory after 500 requests, and silent from then on.",
    CanIdTooHighAccepted = "can-id-too-high-accepted" on "reference-301" fuzz: "11-bit CAN-IDs above 7FFh are accepted for PDOs.",
    CanIdsTakenForRestricted = "can-ids-taken-for-restricted" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "The CAN-IDs 550h to 57Fh are refused as if CiA 301 restricted them.",
    CanIdLowBitsMovable = "can-id-low-bits-movable" on "reference-301" because "is found only in some runs: few of the values that the fuzzer draws show it": "While a PDO is valid only the bits 7 to 10 of its CAN-ID can't be changed.",
    CobIdBitsUnchecked = "cob-id-bits-unchecked" on "reference-301" because "is found only in some runs: few of the values that the fuzzer draws show it": "The bits 11 to 28 of 1005h and 1014h are not checked.",
    CobIdFrameBitTaken = "cob-id-frame-bit-taken" on "reference-301" because "is found only in some runs: few of the values that the fuzzer draws show it": "Bit 29 of 1014h, 1028h and 1201h is taken, and does nothing.",
    TimeIdRefused = "time-id-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "1012h, which is described as writable, refuses each value with abort 0609 0030h.",
    ConsumerEntriesExclude = "consumer-entries-exclude" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "While an entry of 1016h watches a node, the others take no other node: abort 0604 0043h.",
    LateSyncCounterOverlooked = "late-sync-counter-overlooked" on "reference-301" because "is about SYNC start value, window and counter of TPDOs, whose count the models take as unknown while one of them is in use": "A SYNC start value does nothing if 1019h is written after it.",
    SyncStartAgain = "sync-start-again" on "reference-301" because "is about SYNC start value, window and counter of TPDOs, whose count the models take as unknown while one of them is in use": "With a SYNC start value each TPDO waits for the SYNC of that number, not only the first.",
    EmcyResetRegisterWrong = "emcy-reset-register-wrong" on "reference-301" because "is about EMCY messages, of which the models take what the device reports and don't demand": "EMCY 0000h carries the error register as it was before.",
    SpeedInPhysicalSteps = "speed-in-physical-steps" on "reference-406" because "shows only while the shaft turns": "In units per second the speed counts physical steps, whatever 6001h says.",
    ScaledPositionStands = "scaled-position-stands" on "reference-406" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "With scaling on the position without offset is 0, wherever the shaft stands.",
    ScalingRefused = "scaling-refused" on "reference-406" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "6001h and 6002h, which are described as writable, refuse each value with abort 0609 0030h.",
    UnitsFewerRefused = "units-fewer-refused" on "reference-406" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "6001h takes no value below the one that it has.",
    RangeSmallerRefused = "range-smaller-refused" on "reference-406" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "6002h takes no value below the one that it has.",
    RpdoFirstObjectOnly = "rpdo-first-object-only" on "reference-301" because "is found only in some runs: few of the values that the fuzzer draws show it": "Of the objects that an RPDO maps only the first gets its value.",
    PdoTimesRefused = "pdo-times-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "Inhibit time and SYNC start value of a TPDO, which are described as writable, refuse each other value, also while the PDO is off.",
    DefaultMappingWrong = "default-mapping-wrong" on "reference-301" fuzz: "The mapping of TPDO 1 as delivered has a wrong length.",
    DummyRefused = "dummy-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "Dummy entries can't be mapped into RPDOs.",
    EmcyIdWrong = "emcy-id-wrong" on "reference-301" fuzz: "1014h names another CAN-ID than the one that EMCY has.",
    ErrorBehaviourAlwaysLeaves = "error-behaviour-always-leaves" on "reference-301" because "is about what a device does on an error (1029h), or whether: what the error is, only its application knows, and a change of state by itself is followed, not demanded": "With 1029h:01 = 1 an error leads to pre-operational all the same.",
    ErrorHistoryNotKept = "error-history-not-kept" on "reference-301" because "is about the history of errors: what stands in 1003h depends on errors that only the device knows": "1003h:00 stays 0, whatever happens.",
    ExtendedBitAccepted = "extended-bit-accepted" on "reference-301" fuzz: "Bit 29 of a COB-ID is accepted and has no effect.",
    FastscanIgnoresBits = "fastscan-ignores-bits" on "reference-301" fuzz: "Every Fastscan matches, whatever it compares.",
    HeartbeatConsumerForgetsStored = "heartbeat-consumer-forgets-stored" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "An entry of 1016h that was stored is read back after the start, and nobody is watched.",
    HeartbeatConsumerLate = "heartbeat-consumer-late" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "A watched node is missed after twice its time.",
    HeartbeatConsumerNotRestarted = "heartbeat-consumer-not-restarted" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "Only the first heartbeat of a watched node counts.",
    HeartbeatConsumerNotStopped = "heartbeat-consumer-not-stopped" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "An entry of 1016h whose time is set to 0 goes on watching.",
    HeartbeatConsumerSilent = "heartbeat-consumer-silent" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "The loss of a watched node is not reported by EMCY.",
    LssIdentifyUnanswered = "lss-identify-unanswered" on "reference-301" fuzz: "Identify remote slave and identify non-configured remote slave are not answered.",
    LssIdentifyUnchecked = "lss-identify-unchecked" on "reference-301" fuzz: "Identify remote slave is answered whatever its bounds are.",
    LssInquirySwapped = "lss-inquiry-swapped" on "reference-301" fuzz: "LSS gives the parts of its address with the bytes in the wrong order.",
    LssNodeIdInquiredWrong = "lss-node-id-inquired-wrong" on "reference-301" fuzz: "LSS gives the node-ID plus one.",
    LssNodeIdRefused = "lss-node-id-refused" on "reference-301" fuzz allowing "node-id": "LSS refuses every node-ID.",
    LssNodeIdWithoutEffect = "lss-node-id-without-effect" on "reference-301" fuzz allowing "node-id": "LSS confirms a node-ID and forgets it.",
    LssNodeIdMistaken = "lss-node-id-mistaken" on "reference-301" fuzz allowing "node-id": "LSS confirms a node-ID and configures the next one.",
    LssSelectiveInConfiguration = "lss-selective-in-configuration" on "reference-301" because "is an answer that the standard leaves open, so that every choice is right": "Switch selective is answered in configuration.",
    LssSelectiveSerialOnly = "lss-selective-serial-only" on "reference-301" fuzz: "Switch selective compares the serial number only.",
    LssSelectiveUnanswered = "lss-selective-unanswered" on "reference-301" fuzz: "Switch selective is obeyed but not answered.",
    LssShortResponse = "lss-short-response" on "reference-301" fuzz: "LSS responses have five bytes.",
    LssShortRequestAnswered = "lss-short-request-answered" on "reference-301" because "is about requests of fewer than eight bytes, of which CiA 305 says nothing": "LSS requests of fewer than eight bytes are answered.",
    LssUndescribed = "lss-undescribed" on "tr-c65" because "contradicts the description: the models hold what the device does against the standards": "LSS is answered, although the description says that there is none.",
    LssStoreUnanswered = "lss-store-unanswered" on "reference-301" fuzz allowing "nvm": "Store configuration is not answered.",
    LssSwitchGlobalIgnored = "lss-switch-global-ignored" on "reference-301" because "is found too, but in some runs only by nine or ten frames: what the fuzzer claims, it shows by eight at most": "Switch global is ignored.",
    LssUnknownAnswered = "lss-unknown-answered" on "reference-301" fuzz: "Reserved LSS commands are answered.",
    MappingDirectionUnchecked = "mapping-direction-unchecked" on "reference-301" fuzz: "Objects can be mapped whatever direction they are for.",
    MappingProcedureRefused = "mapping-procedure-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "A mapping that was opened can't be switched on again.",
    PdoIdNotPredefined = "pdo-id-not-predefined" on "reference-301" fuzz: "1800h:01 names another CAN-ID than the predefined one.",
    RpdoBytesReversed = "rpdo-bytes-reversed" on "reference-301" fuzz: "The bytes of RPDOs are taken in the wrong order.",
    RpdoIgnored = "rpdo-ignored" on "reference-301" fuzz: "RPDO 1 has no effect.",
    RpdoKeepsCanId = "rpdo-keeps-can-id" on "reference-301" fuzz: "An RPDO that gets another CAN-ID is not received with it.",
    RpdoWhenStopped = "rpdo-when-stopped" on "reference-301" fuzz: "RPDOs act in stopped.",
    SameCobIdRefused = "same-cob-id-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "Writing the COB-ID that a PDO has already is refused.",
    SdoChannelsShareTransfer = "sdo-channels-share-transfer" on "reference-301" because "is about the second SDO channel: the models follow the default one": "A request on the second SDO channel ends the transfer on the first.",
    SdoServerIdWrong = "sdo-server-id-wrong" on "reference-301" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1200h names another CAN-ID than the one that the server has.",
    StoreCapabilityWrong = "store-capability-wrong" on "reference-301" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1010h:01 reads as the signature instead of the capability.",
    RestoreCapabilityWrong = "restore-capability-wrong" on "reference-301" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1011h:01 reads as the signature instead of the capability.",
    SyncAlwaysCounts = "sync-always-counts" on "reference-301" because "is about SYNC or TIME that the device itself produces: the models follow its identifier, not its period and content": "SYNC carries a counter although 1019h is 0.",
    SyncMovedCounts = "sync-moved-counts" on "reference-301" because "is about SYNC or TIME that the device itself produces: the models follow its identifier, not its period and content": "SYNC with another CAN-ID than the predefined one carries a counter although 1019h is 0.",
    ErrorRegisterReadClears = "error-register-read-clears" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "Reading the error register clears it, though the error is still there.",
    StoredConfigurationIdle = "stored-configuration-idle" on "reference-301" because "shows only after a configuration was stored, which the fuzzer does not do": "After a reset, stored heartbeat times read back and do nothing until they are written again.",
    RawPositionStands = "raw-position-stands" on "reference-406" because "shows only while the shaft turns": "600Ch does not change while the shaft turns.",
    OperatingParametersRefused = "operating-parameters-refused" on "reference-406" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "6000h, which is described as writable, refuses each value with abort 0609 0030h.",
    RightRpdoReported = "right-rpdo-reported" on "reference-301" because "is about EMCY messages, of which the models take what the device reports and don't demand": "An RPDO that is as long as its mapping is reported by EMCY 8220h.",
    RightSyncReported = "right-sync-reported" on "reference-301" because "is about EMCY messages, of which the models take what the device reports and don't demand": "SYNC of the right length is reported by EMCY 8240h.",
    PdoRulesFirstOnly = "pdo-rules-first-only" on "reference-301" fuzz: "COB-ID and mapping of the first PDO of each direction are protected while it is valid, those of the others are not.",
    TimeNotProduced = "time-not-produced" on "reference-301" because "is about what CiA 301 leaves open: when a producer sends TIME": "TIME is not sent, though bit 30 of 1012h is taken.",
    ClockStands = "clock-stands" on "reference-301" because "is about what CiA 301 leaves open: what a device does with the time": "The clock that TIME sets, and 1013h, stand still.",
    StampSetByOthers = "stamp-set-by-others" on "reference-301" because "is about a clock of the device: how it goes, the models do not know": "Each write of an object sets the high resolution time stamp, 1013h.",
    ConsumerReturnLeaves = "consumer-return-leaves" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "The return of a watched node that was missed makes the device leave operational, as its loss does.",
    SyncIdRefused = "sync-id-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "1005h, which is described as writable, refuses each value with abort 0609 0030h, even the one that it has.",
    PdoOffRefused = "pdo-off-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "A PDO can't be switched off: bit 31 of its COB-ID is refused with abort 0609 0030h.",
    ConsumerTimeRefused = "consumer-time-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "1016h, which is described as writable, refuses each value with abort 0609 0030h.",
    SyncIdWrong = "sync-id-wrong" on "reference-301" fuzz: "1005h names another CAN-ID than the predefined one.",
    SyncNotStopped = "sync-not-stopped" on "reference-301" because "is about SYNC or TIME that the device itself produces: the models follow its identifier, not its period and content": "Writing 0 to 1006h does not end SYNC.",
    SyncOverlooked = "sync-overlooked" on "reference-301" fuzz: "Every seventh SYNC is overlooked.",
    SyncOwnUnheeded = "sync-own-unheeded" on "reference-301" because "is about the SYNC that a device produces itself, of which the models know the time alone": "The SYNC that the device produces sends none of its own TPDOs.",
    SyncHangsWithoutCounter = "sync-hangs-without-counter" on "reference-301" because "is about the SYNC that a device produces itself, of which the models know the time alone": "The first SYNC that the device produces while 1019h is 0 stops the firmware.",
    SyncConsumerBitIgnored = "sync-consumer-bit-ignored" on "tr-c65" because "is about bit 31 of 1005h, which only DS-301 V3.0 gives a meaning": "SYNC is listened to without bit 31 of 1005h, too.",
    SyncProducerBitAccepted = "sync-producer-bit-accepted" fuzz: "A device that can't produce SYNC accepts bit 30 of 1005h.",
    TimeIdWrong = "time-id-wrong" on "reference-301" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1012h names another CAN-ID than the predefined one.",
    TpdoBytesReversed = "tpdo-bytes-reversed" on "reference-301" because "is about the content of a TPDO, which the models don't judge": "The bytes of TPDOs are sent in the wrong order.",
    TpdoKeepsCanId = "tpdo-keeps-can-id" on "reference-301" fuzz: "A TPDO that gets another CAN-ID is sent with the old one.",
    TpdoIdOutlivesReset = "tpdo-id-outlives-reset" on "reference-301" because "is found only in some runs: few of the values that the fuzzer draws show it": "After a reset a TPDO comes on the CAN-ID that it was moved to, whatever 1800h:01 reads.",
    TpdoLostAfterSdo = "tpdo-lost-after-sdo" on "reference-301" fuzz: "A TPDO that is due while the SDO server writes is lost.",
    TpdoRemoteIgnored = "tpdo-remote-ignored" on "reference-301" fuzz: "Remote frames for TPDO 1 are not answered.",
    TpdoTooLong = "tpdo-too-long" on "reference-301" fuzz: "TPDO 1 always has eight bytes.",
    UnconfiguredNodeIdWaits = "unconfigured-node-id-waits" on "reference-301" fuzz allowing "node-id": "A device that got its first node-ID by LSS waits for a reset.",
    LssBitTimingRefused = "lss-bit-timing-refused" on "reference-301" fuzz allowing "bit-rate": "LSS refuses every bit rate.",
    LssSelectiveMismatchIgnored = "lss-selective-mismatch-ignored" on "reference-301" because "is an answer that the standard leaves open, so that every choice is right": "Parts of another address do not end switch selective.",
    SdoBlockSwitchTruncates = "sdo-block-switch-truncates" on "reference-301" fuzz: "A block upload that becomes a normal one loses the first byte.",
    GuardingWrongState = "guarding-wrong-state" fuzz: "Node guarding answers say pre-operational in every state.",
    GuardingSilentWhenOff = "guarding-silent-when-off" fuzz: "Node guarding is not answered while the life time is 0.",
    LifeTimeFactorOffByOne = "life-time-factor-off-by-one" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "The master is missed one guard time too late.",
    LifeGuardingNotStopped = "life-guarding-not-stopped" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "Setting the life time to 0 does not end life guarding.",
    LifeGuardingUnreported = "life-guarding-unreported" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "A lost master is not reported by an EMCY message.",
    ErrorControlMissing = "error-control-missing" on "tr-c65" fuzz: "100Dh does not exist, although there is no 1017h either.",
    GuardingCobIdWrong = "guarding-cob-id-wrong" on "tr-c65" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "100Eh holds another COB-ID than the one that node guarding uses.",
    NodeIdObjectWrong = "node-id-object-wrong" on "tr-c65" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "100Bh holds another node-ID than the one in use.",
    PdoCountWrong = "pdo-count-wrong" on "tr-c65" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1004h counts more PDOs than there are.",
    TpdoRemoteUnanswered = "tpdo-remote-unanswered" on "tr-c65" because "is a remote frame to a synchronous TPDO, of which CiA 301 does not say that it is answered": "Remote frames for a TPDO that allows them are not answered.",
    ErrorRegisterStuck = "error-register-stuck" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "1001h keeps the bits of an error that is gone.",
    ErrorRegisterNeverClear = "error-register-never-clear" on "reference-301" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "Bit 0 of 1001h is set, with or without an error.",
    ErrorsClearedTogether = "errors-cleared-together" on "reference-301" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "When one of several errors is gone, 1001h and EMCY 0000h say that all are.",
    LmtSwitchSelectiveAnswered = "lmt-switch-selective-answered" on "tr-lmp30" fuzz: "Switch mode selective of LMT is answered with 44h, as LSS does.",
    LmtSerialNotCompared = "lmt-serial-not-compared" on "tr-lmp30" fuzz: "Switch mode selective of LMT takes any serial number.",
    LmtNamesNotCompared = "lmt-names-not-compared" on "tr-lmp30" fuzz: "Switch mode selective of LMT takes any manufacturer and product name.",
    LmtReservedModeObeyed = "lmt-reserved-mode-obeyed" on "tr-lmp30" because "is an answer that the standard leaves open, so that every choice is right": "Reserved modes of switch mode global of LMT lead into configuration.",
    LmtAnsweredInOperation = "lmt-answered-in-operation" on "tr-lmp30" fuzz: "LMT inquiries and configurations are answered in operation.",
    LmtBitTimingUnshifted = "lmt-bit-timing-unshifted" on "tr-lmp30" fuzz allowing "bit-rate": "LMT bit timing uses the table of LSS, whose fifth row is reserved.",
    LmtBitTimingUnchecked = "lmt-bit-timing-unchecked" on "tr-lmp30" fuzz allowing "bit-rate": "LMT confirms bit timings that don't exist.",
    LmtNodeIdUnchecked = "lmt-node-id-unchecked" on "tr-lmp30" fuzz allowing "node-id": "LMT confirms node-IDs that don't exist.",
    LmtNodeIdAtOnce = "lmt-node-id-at-once" on "tr-lmp30" fuzz allowing "node-id": "A node-ID that LMT configures acts at once.",
    LmtStoreSilent = "lmt-store-silent" on "tr-lmp30" fuzz allowing "nvm": "Store configuration of LMT is not answered.",
    LmtActivationNotSilent = "lmt-activation-not-silent" on "tr-lmp30" because "is about the bit rate: after its activation nobody can follow on a bus of the old one": "The device goes on sending while LMT activates a bit timing.",
    LmtNameUnpadded = "lmt-name-unpadded" on "tr-lmp30" fuzz: "LMT fills names up with FFh instead of 00h.",
    LmtIdentifySilent = "lmt-identify-silent" on "tr-lmp30" fuzz: "Identify remote slave of LMT is not answered.",
    LmtIdentifyRangeIgnored = "lmt-identify-range-ignored" on "tr-lmp30" fuzz: "Identify remote slave of LMT is answered outside the range of serial numbers.",
    LmtSerialNotBcd = "lmt-serial-not-bcd" on "tr-lmp30" fuzz: "LMT inquiries give the serial number in binary.",
    LimitSwitchesSwapped = "limit-switches-swapped" on "lika-ax58" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "Bits 12 and 13 of 6500h are swapped.",
    LimitSwitchInclusive = "limit-switch-inclusive" on "lika-ax58" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "A limit switch acts on its limit already, not only beyond.",
    ScalingAlwaysOn = "scaling-always-on" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6001h and 6002h scale the position although bit 2 of 6000h is 0.",
    DeviceTypeTurnsWrong = "device-type-turns-wrong" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1000h says single-turn of a multi-turn encoder.",
    OperatingStatusMissing = "operating-status-missing" fuzz: "6500h does not exist.",
    AlarmsMissing = "alarms-missing" fuzz: "6503h does not exist.",
    PositionSixteenBit = "position-sixteen-bit" fuzz: "6004h has 16 bits instead of 32.",
    OperatingParametersThirtyTwoBit = "operating-parameters-thirty-two-bit" fuzz: "6000h has 32 bits instead of 16.",
    PositionWritable = "position-writable" fuzz: "6004h can be written.",
    ReservedOperatingBitsAccepted = "reserved-operating-bits-accepted" because "accepts a value that CiA 406 or the manual forbids: the models know the limits of the description and the rules of CiA 301 for values, not those of a profile": "6000h takes its reserved bits, and shows them.",
    UnitsAboveRangeAccepted = "units-above-range-accepted" because "accepts a value that CiA 406 or the manual forbids: the models know the limits of the description and the rules of CiA 301 for values, not those of a profile": "6001h and 6002h take a range of less than one revolution.",
    UnitsZeroWedges = "units-zero-wedges" fuzz: "6001h = 0 makes the firmware divide by zero: nothing is answered until a reset.",
    RangeZeroStops = "range-zero-stops" on "kuebler-sendix-f58" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6002h = 0, which stands for 2^32, makes 6004h stay 0.",
    ScalingOverflow = "scaling-overflow" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "The product of position and 6001h is calculated with 32 bits.",
    WrapAtPowerOfTwo = "wrap-at-power-of-two" fuzz: "The position wraps at the next power of two instead of at 6002h.",
    OffsetSignWrong = "offset-sign-wrong" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6509h has the wrong sign.",
    OffsetNotReported = "offset-not-reported" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6509h stays 0 after a preset.",
    PresetGlitch = "preset-glitch" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "After a preset 6004h shows the old position for some milliseconds.",
    PresetPersists = "preset-persists" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "A preset outlives a reset without having been stored.",
    PresetLostAfterSave = "preset-lost-after-save" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "1010h does not store the preset.",
    TpdoPositionWithoutPreset = "tpdo-position-without-preset" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "TPDOs carry the position without the preset.",
    FirstPositionMissing = "first-position-missing" because "is about what counts as an event of a TPDO, which the manufacturer decides": "A TPDO with an event timer is sent first when that has run out, not when the device becomes operational.",
    TpdoPositionLate = "tpdo-position-late" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "TPDOs carry what was measured for the TPDO before.",
    CyclicTimerNotStopped = "cyclic-timer-not-stopped" because "is about the event timer that an object of the profile is linked to: after a write to the one the models take the other for unknown": "6200h = 0 does not end the cyclic transmission.",
    CyclicTimerIdle = "cyclic-timer-idle" on "tr-c65" because "is about the event timer that an object of the profile is linked to: after a write to the one the models take the other for unknown": "6200h keeps what is written to it, and TPDO 1 its period of before.",
    EventTimerNotInCyclicTimer = "event-timer-not-in-cyclic-timer" because "is about the event timer that an object of the profile is linked to: after a write to the one the models take the other for unknown": "6200h does not follow the event timer of TPDO 1.",
    SpeedNotZeroAtRest = "speed-not-zero-at-rest" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6030h is not 0 while the shaft is at rest.",
    SpeedSignIgnoresCodeSequence = "speed-sign-ignores-code-sequence" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "The sign of 6030h does not follow the code sequence.",
    SpeedDoubledBackwards = "speed-doubled-backwards" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "With the other code sequence 6030h is twice the speed.",
    SpeedFormatIgnored = "speed-format-ignored" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6000h does not change the unit of the speed.",
    SpeedTenfold = "speed-tenfold" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6030h is ten times too high.",
    SpeedDivisorIgnored = "speed-divisor-ignored" on "kuebler-sendix-f58" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6031h:04 does not divide the speed.",
    AccelerationShowsSpeed = "acceleration-shows-speed" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6040h shows the speed instead of how it changes.",
    WorkAreaBitsSwapped = "work-area-bits-swapped" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6400h has overflow and underflow the other way round.",
    WorkAreaOutsideOneSided = "work-area-outside-one-sided" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "Bit 0 of 6400h is set above the work area, and not below it.",
    WorkAreaStuck = "work-area-stuck" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6400h stays 0.",
    WorkAreaInverted = "work-area-inverted" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6400h says out of range while the position is in the work area.",
    WorkAreaLimitsSwappedAccepted = "work-area-limits-swapped-accepted" because "accepts a value that CiA 406 or the manual forbids: the models know the limits of the description and the rules of CiA 301 for values, not those of a profile": "6401h takes a low limit above the high limit.",
    UnsupportedAlarmSet = "unsupported-alarm-set" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "6503h has a bit that 6504h does not support.",
    ReservedAlarmBitSet = "reserved-alarm-bit-set" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "6503h and 6504h have a reserved bit set.",
    UnsupportedWarningSet = "unsupported-warning-set" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "6505h has a bit that 6506h does not support.",
    AlarmWithoutEmcy = "alarm-without-emcy" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "A position error is shown by 6503h, but neither by an EMCY nor by 1001h.",
    EmcyWithoutAlarm = "emcy-without-alarm" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "A position error is reported by an EMCY, but not by 6503h.",
    WarningWithoutEmcy = "warning-without-emcy" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "A temperature beyond its limits is shown by 6505h, but not reported by an EMCY.",
    WarningNotSet = "warning-not-set" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "A temperature beyond its limits is reported by an EMCY, but not shown by 6505h.",
    WarningNotCleared = "warning-not-cleared" because "sets or keeps bits of alarms and warnings wrongly: which error a device has, only its application knows": "6505h keeps a warning whose cause is gone.",
    OperatingTimeBackwards = "operating-time-backwards" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6508h counts down.",
    OperatingTimeInSeconds = "operating-time-in-seconds" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6508h counts seconds instead of tenths of an hour.",
    SerialNumberDiffers = "serial-number-differs" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "650Bh is another number than 1018h:04.",
    SingleTurnResolutionFollowsScaling = "single-turn-resolution-follows-scaling" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6501h shows 6001h instead of the physical resolution.",
    RevolutionsZero = "revolutions-zero" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "6502h is 0.",
    ProfileVersionUnset = "profile-version-unset" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "6507h is FFFF FFFFh.",
    RawInverseWrong = "raw-inverse-wrong" on "kuebler-sendix-f58" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "2161h is the raw position itself instead of its inverse.",
    RawCrcStartWrong = "raw-crc-start-wrong" on "kuebler-sendix-f58" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "The checksum 2162h begins with FFFFh instead of 1021h.",
    RawPositionFollowsPreset = "raw-position-follows-preset" on "kuebler-sendix-f58m" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "A preset changes the raw position 600Ch.",
    RedundantChannelDrift = "redundant-channel-drift" on "kuebler-c100" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "The second channel of the position drifts.",
    RedundantChannelNotNegated = "redundant-channel-not-negated" on "kuebler-d125" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "The second channel counts up as the first one does.",
    AngleDirectionIgnored = "angle-direction-ignored" on "kuebler-c100" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "3003h does not turn the direction of the angle.",
    AngleRangeIgnored = "angle-range-ignored" on "kuebler-c100" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "3004h does not change the range of the angle.",
    RedundantAngleSame = "redundant-angle-same" on "kuebler-c100" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "The second angle does not run opposite to the first one.",
    ZeroPointIgnored = "zero-point-ignored" on "kuebler-c100" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "3010h does not make the angle zero.",
    EdsLineWithoutSense = "eds-line-without-sense" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS has a line that is neither section, field nor comment.",
    EdsSectionTwice = "eds-section-twice" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS has a section twice.",
    EdsSubIndexMissing = "eds-sub-index-missing" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS does not describe sub-index 0 of 1018h.",
    EdsFieldTwice = "eds-field-twice" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS has a field twice in a section.",
    EdsDataTypeMissing = "eds-data-type-missing" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS gives 1017h no data type.",
    EdsNumberUnreadable = "eds-number-unreadable" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS writes a hexadecimal number with h after it.",
    EdsFloatDefault = "eds-float-default" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS gives an integer a default with a decimal point.",
    EdsSubNumberWrong = "eds-sub-number-wrong" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS counts more sub-indexes of 1018h than it describes.",
    EdsPdoCountWrong = "eds-pdo-count-wrong" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS counts more TPDOs than it describes.",
    EdsDateWrong = "eds-date-wrong" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS has its creation date with the year first.",
    EdsBooleanWrong = "eds-boolean-wrong" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS has a 2 where there can be 0 or 1.",
    EdsObjectListedTwice = "eds-object-listed-twice" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS lists an object twice and another one not at all.",
    EdsAccessTypeUnknown = "eds-access-type-unknown" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS gives 1001h an access type that does not exist.",
    EdsVendorNumberDiffers = "eds-vendor-number-differs" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS has another vendor number in DeviceInfo than in 1018h:01.",
    EdsDefaultBeyondLimit = "eds-default-beyond-limit" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS has a default below its low limit.",
    EdsMappingWrong = "eds-mapping-wrong" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS maps an object with a length that it does not have.",
    EdsCobIdTwice = "eds-cob-id-twice" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS gives two TPDOs the same COB-ID.",
    EdsDataTypeWrong = "eds-data-type-wrong" on "reference-301" because "is in the device description, not in the device: the cases of CiA 306 read it": "The EDS gives 1017h another data type than CiA 301 does.",
    UndescribedObject = "undescribed-object" on "reference-301" fuzz: "The device has an object, 200Ah, that its description does not name.",
    StructureEntryWrong = "structure-entry-wrong" on "reference-301" because "is an answer that the standard leaves open, so that every choice is right": "Sub-index FFh of 1018h exists, but does not tell the structure of the object.",
    ParameterDriftsAtReset = "parameter-drifts-at-reset" on "reference-301" fuzz: "1015h is one more after every reset.",
    SdoRefusalAlternates = "sdo-refusal-alternates" on "reference-301" fuzz: "A download to a sub-index that does not exist is refused now for this reason, now as read-only.",
    LimitsSwappedWrongCode = "limits-swapped-wrong-code" on "reference-406" fuzz: "A maximum below its minimum is refused with abort 0601 0002h.",
    MappingLengthUnchecked = "mapping-length-unchecked" on "reference-406" fuzz: "Mapping entries take any number of bits of an object.",
    LaterEmptyEntryMapped = "later-empty-entry-mapped" on "reference-301" fuzz: "Sub-index 0 of a mapping counts entries that are 0, but for the first.",
    EmptyEntryMapped = "empty-entry-mapped" on "reference-301" fuzz: "Sub-index 0 of a mapping counts entries that are 0.",
    MappingFailureWedges = "mapping-failure-wedges" on "reference-301" fuzz: "After a refused mapping no mapping can be switched on until a reset.",
    TpdoRepeatsAfterInhibit = "tpdo-repeats-after-inhibit" on "reference-301" because "is about events of TPDOs, which are the application's matter": "A TPDO that had to wait for its inhibit time is sent again after each further one.",
    SyncKeepsCanId = "sync-keeps-can-id" on "reference-301" because "is about SYNC, which the fuzzer sends with one CAN-ID": "Another CAN-ID in 1005h has no effect: SYNC is still received and sent with the one of before.",
    LssLeavesWhenToldAgain = "lss-leaves-when-told-again" on "reference-301" because "shows in the start of a device without node-ID, whose time the models leave open": "Switch state global to configuration, in configuration, has the effects of leaving it: a device without node-ID boots with the one that it got.",
    SyncWindowIgnored = "sync-window-ignored" on "reference-301" because "is about SYNC start value, window and counter of TPDOs, whose count the models take as unknown while one of them is in use": "1007h has no effect: synchronous TPDOs are sent however late.",
    SyncRememberedOverStart = "sync-remembered-over-start" on "reference-301" because "is about SYNC start value, window and counter of TPDOs, whose count the models take as unknown while one of them is in use": "A SYNC in pre-operational causes a TPDO at the start.",
    SdoTransferSurvivesStop = "sdo-transfer-survives-stop" on "reference-301" fuzz: "A transfer goes on after the device was stopped.",
    SdoTransferSurvivesReset = "sdo-transfer-survives-reset" on "reference-301" fuzz: "A transfer goes on after a reset.",
    ConfigurationDateKept = "configuration-date-kept" on "reference-301" because "is about 1020h, which other writes change": "1020h is not cleared when a parameter changes.",
    ConfigurationDateLost = "configuration-date-lost" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "1020h is 0 after a reset, although it was stored.",
    HighestPositionWrong = "highest-position-wrong" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "650Ah:03 is half of what the encoder can show.",
    HighPrecisionWithoutPreset = "high-precision-without-preset" on "reference-406" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6008h does not follow the preset.",
    SecondTpdoMissing = "second-tpdo-missing" fuzz: "TPDO 2 is never sent.",
    PresetStopsCounting = "preset-stops-counting" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "After a preset the position stands still for a while.",
    JerkShowsSpeed = "jerk-shows-speed" on "reference-406" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6050h shows the speed instead of how the acceleration changes.",
    ProfileErrorIgnored = "profile-error-ignored" because "is about what a device does on an error (1029h), or whether: what the error is, only its application knows, and a change of state by itself is followed, not demanded": "1029h:02 has no effect.",
    ProfileErrorAlwaysLeaves = "profile-error-always-leaves" because "is about what a device does on an error (1029h), or whether: what the error is, only its application knows, and a change of state by itself is followed, not demanded": "With 1029h:02 = 1 an error of the sensor leads to pre-operational all the same.",
    SyncTpdoLate = "sync-tpdo-late" on "reference-301" because "is later or earlier than it should be by no more than the tolerance that a timer in milliseconds and a bus in use need": "Synchronous TPDOs come 30 ms after SYNC.",
    SdoResponseSlow = "sdo-response-slow" on "reference-301" because "shows after more requests or resets in one go than a sequence has": "Every hundred and fiftieth SDO response takes 1.2 s.",
    CamStuck = "cam-stuck" on "reference-406" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6300h stays 0.",
    CamHighLimitIgnored = "cam-high-limit-ignored" on "reference-406" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "A cam has no high limit.",
    CamEnableIgnored = "cam-enable-ignored" on "reference-406" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6301h has no effect: every cam is active.",
    CamPolarityIgnored = "cam-polarity-ignored" on "reference-406" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6302h has no effect.",
    CamHysteresisIgnored = "cam-hysteresis-ignored" on "reference-406" because "is a measured value that is wrong or does not follow what was configured: of what an encoder measures the models know the range of the position alone": "6330h has no effect.",
    FastscanYieldsToOthers = "fastscan-yields-to-others" on "reference-301" because "shows only where another device answers: a simulated device is alone on its bus": "A slave that hears another one answer takes no further part in Fastscan.",
    LssNodeIdStoredAtOnce = "lss-node-id-stored-at-once" on "reference-301" because "shows only in what is loaded after something was stored or restored: each sequence begins with a device as delivered, and after a store the models can't know any more what a reset brings": "A node-ID configured by LSS outlives reset node without having been stored.",
    NmtLongFrameMisread = "nmt-long-frame-misread" on "reference-301" because "is an answer that the standard leaves open, so that every choice is right": "Of an NMT frame of four bytes or more the second two are obeyed.",
    HeartbeatConsumerWatchesEveryone = "heartbeat-consumer-watches-everyone" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "An entry of 1016h whose node-ID does not exist watches every node.",
    HeartbeatConsumerTimeZero = "heartbeat-consumer-time-zero" on "reference-301" because "is about when a lost node or master is noticed: whether and when a device reports an error, the models take from its EMCY messages and don't demand": "A node whose entry in 1016h has the time 0 is missed at once after its first heartbeat.",
    HeartbeatConsumerCrashes = "heartbeat-consumer-crashes" on "reference-301" fuzz: "A heartbeat of no byte or of two stops the firmware.",
    GuardingAnsweredUnsupported = "guarding-answered-unsupported" on "kuebler-c100" fuzz: "Guarding requests are answered although there is no 100Ch.",
    StoreCapabilityDenied = "store-capability-denied" on "reference-301" because "is a value that is wrong from power-on on and stays so: identity, serial number and capabilities differ from device to device, so that the fuzzer takes what it reads after power-on for right": "1010h:01 says that the device does not store on command, although it does.",
    StoreSilentWhenOperational = "store-silent-when-operational" on "reference-301" because "shows only with the right signature of a store, which the fuzzer never makes up": "\"save\" is not answered in operational.",
    SynchronousRpdoRefused = "synchronous-rpdo-refused" on "reference-301" because "is a refusal: a server may refuse a transfer or a value for reasons of its own, with codes that say so": "RPDOs take no synchronous transmission type.",
    SdoBlockAbortIgnored = "sdo-block-abort-ignored" on "reference-301" fuzz: "An abort of the client does not end a block download.",
}

/// A set of faults, one bit for each.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Faults([u64; WORDS]);

const WORDS: usize = Fault::ALL.len().div_ceil(u64::BITS as usize);

impl Faults {
    /// A firmware without any of them.
    pub const NONE: Self = Self([0; WORDS]);

    /// The same set with one more.
    pub const fn with(mut self, fault: Fault) -> Self {
        self.0[fault as usize / u64::BITS as usize] |= Self::bit(fault);
        self
    }

    /// Whether the set holds it.
    pub const fn has(self, fault: Fault) -> bool {
        self.0[fault as usize / u64::BITS as usize] & Self::bit(fault) != 0
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
