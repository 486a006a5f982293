//! Firmware faults that a simulated device can be given, drawn from defects of real devices and stacks.

use std::fmt;
use std::str::FromStr;

/// The model on which a fault shows where its row names no other.
const USUAL_MODEL: &str = "kuebler-sendix-58x8";

/// Defines the faults: one row each, so that name, variant and text can't drift apart. `on "MODEL"` names a model on
/// which the fault shows, where it is not the usual one; `fuzz` says that the fuzzer finds it.
macro_rules! faults {
    ($($variant:ident = $id:literal $($flag:ident $($model:literal)?)*: $summary:literal,)*) => {
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
                let named: Option<&'static str> = match self { $(Self::$variant => faults!(@model $($flag $($model)?)*),)* };
                named.unwrap_or(USUAL_MODEL)
            }

            /// Whether the fuzzer claims to find it.
            pub const fn is_fuzzed(self) -> bool {
                match self { $(Self::$variant => faults!(@fuzz $($flag $($model)?)*),)* }
            }
        }
    };
    (@model) => { None };
    (@model on $model:literal $($rest:tt)*) => { Some($model) };
    (@model fuzz $($rest:tt)*) => { faults!(@model $($rest)*) };
    (@fuzz) => { false };
    (@fuzz on $model:literal $($rest:tt)*) => { faults!(@fuzz $($rest)*) };
    (@fuzz fuzz $($rest:tt)*) => { true };
}

faults! {
    BootUpMissing = "boot-up-missing": "No boot-up message after a reset.",
    BootUpTwice = "boot-up-twice": "Two boot-up messages after a reset.",
    BootUpWrongData = "boot-up-wrong-data": "The boot-up message carries the state pre-operational instead of 00h.",
    NmtBroadcastIgnored = "nmt-broadcast-ignored": "NMT commands to node-ID 0 are ignored.",
    NmtNodeIdIgnored = "nmt-node-id-ignored": "NMT commands to other nodes are obeyed.",
    NmtUnknownCommandStops = "nmt-unknown-command-stops": "A reserved NMT command puts the node into stopped.",
    NmtResetWhenStoppedIgnored = "nmt-reset-when-stopped-ignored": "Reset commands are ignored in stopped.",
    NmtStartWhenStoppedIgnored = "nmt-start-when-stopped-ignored": "Start remote node is ignored in stopped.",
    NmtResetCommunicationKeepsParameters = "nmt-reset-communication-keeps-parameters": "Reset communication does not restore unsaved communication parameters.",
    NmtStopWhenOperationalIgnored = "nmt-stop-when-operational-ignored": "Stop remote node is ignored in operational.",
    NmtEnterPreOperationalIgnored = "nmt-enter-pre-operational-ignored": "Enter pre-operational is ignored.",
    NmtRepeatedCommandResets = "nmt-repeated-command-resets": "A command for the state that the node is in already restarts it.",
    NmtShortFrameObeyed = "nmt-short-frame-obeyed": "An NMT frame without node-ID is taken as a command to the node.",
    NmtResetNodeKeepsParameters = "nmt-reset-node-keeps-parameters": "Reset node does not restore unsaved parameters.",
    SdoSilentWhenOperational = "sdo-silent-when-operational": "The SDO server does not answer in operational.",
    SdoStraySegmentSilent = "sdo-stray-segment-silent": "A segment without a transfer is not answered.",
    SdoBusyAfterAbandonedTransfer = "sdo-busy-after-abandoned-transfer": "A new request during a segmented transfer is refused with abort 0504 0001h.",
    SdoUnsizedDownloadSilent = "sdo-unsized-download-silent": "A download that does not state its length is not answered.",
    SdoAnsweredWhenStopped = "sdo-answered-when-stopped": "The SDO server answers in stopped.",
    HeartbeatWrongState = "heartbeat-wrong-state": "Heartbeats say pre-operational in every state.",
    HeartbeatPeriodDoubled = "heartbeat-period-doubled": "Heartbeats come at twice the time of 1017h.",
    HeartbeatNotStopped = "heartbeat-not-stopped": "Writing 0 to 1017h does not end the heartbeat.",
    SdoStaleMultiplexer = "sdo-stale-multiplexer": "Aborts name the object of the transfer before.",
    SdoWrongCodeForNoObject = "sdo-wrong-code-for-no-object" on "reference-301": "An object that does not exist is refused with abort 0609 0011h.",
    SdoWrongCodeForNoSubIndex = "sdo-wrong-code-for-no-sub-index" on "reference-301": "A sub-index that does not exist is refused with abort 0602 0000h.",
    SdoReadOnlyWritable = "sdo-read-only-writable" on "reference-301": "Downloads to read-only objects are confirmed.",
    SdoReadOnlyWrongCode = "sdo-read-only-wrong-code" on "reference-301": "A download to a read-only object is refused with abort 0800 0022h.",
    SdoLengthUnchecked = "sdo-length-unchecked": "Downloads that are too long are confirmed.",
    SdoShortLengthUnchecked = "sdo-short-length-unchecked": "Downloads that are too short are confirmed.",
    SdoUnknownCommandSilent = "sdo-unknown-command-silent": "An unknown SDO command specifier is not answered.",
    SdoFirstUnknownCommandSilent = "sdo-first-unknown-command-silent": "An unknown SDO command specifier as the first request after boot-up is not answered.",
    SdoAbortAnswered = "sdo-abort-answered" on "reference-301": "The server answers an abort of the client with an abort.",
    SdoToggleUnchecked = "sdo-toggle-unchecked": "Segments whose toggle bit does not alternate are accepted.",
    SdoDownloadToggleSilent = "sdo-download-toggle-silent": "A download segment whose toggle bit does not alternate is not answered.",
    SdoToggleWrongCode = "sdo-toggle-wrong-code": "A wrong toggle bit is refused with abort 0504 0001h.",
    SdoUploadToggleStuck = "sdo-upload-toggle-stuck": "The toggle bit of upload segments is always 0.",
    SdoConfirmationToggleStuck = "sdo-confirmation-toggle-stuck": "The toggle bit of confirmed download segments is always 0.",
    SdoUploadEndMissing = "sdo-upload-end-missing" on "reference-301": "The last segment of an upload is not marked as the last.",
    SdoAnnouncedSizeWrong = "sdo-announced-size-wrong" on "reference-301": "A segmented upload announces one byte more than it has.",
    SdoSegmentAfterEndAnswered = "sdo-segment-after-end-answered": "After the last segment of an upload more can be asked for.",
    SdoSegmentsWrittenAtOnce = "sdo-segments-written-at-once": "Each segment of a download goes into the object at once, before the transfer is complete.",
    SdoSegmentedShortRefused = "sdo-segmented-short-refused": "Objects of up to four bytes can't be written in segments.",
    SdoSegmentedSizeRequired = "sdo-segmented-size-required": "A segmented download that does not announce its size is refused.",
    SdoEmptySegmentSilent = "sdo-empty-segment-silent": "A download segment without data is not answered.",
    SdoReadOnlySegmentedAccepted = "sdo-read-only-segmented-accepted": "Read-only objects are protected against expedited downloads only.",
    SdoAbortIgnored = "sdo-abort-ignored": "An abort of the client does not end the transfer.",
    SdoWrongCommandIgnored = "sdo-wrong-command-ignored": "A command that has no place in the transfer under way is not answered.",
    SdoStrayBlockSilent = "sdo-stray-block-silent": "Commands of a block transfer without one are not answered.",
    SdoBusyAfterAbandonedDownload = "sdo-busy-after-abandoned-download": "A new request during a segmented download is refused with abort 0504 0001h.",
    SdoBackToBackMixed = "sdo-back-to-back-mixed": "A request that comes before the answer to the last one changes the object that this answer names.",
    SdoResponseLost = "sdo-response-lost": "Every hundredth request is not answered.",
    SdoShortRequestWedges = "sdo-short-request-wedges": "After a request of less than eight bytes the SDO server is dead.",
    SdoRemoteAnswered = "sdo-remote-answered": "A remote frame with the CAN-ID of SDO requests is answered.",
    SdoExtendedAnswered = "sdo-extended-answered": "A 29-bit frame whose identifier ends like that of SDO requests is answered.",
    SdoOtherNodeAnswered = "sdo-other-node-answered": "SDO requests to the next node-ID are answered too.",
    SdoTimeoutWedges = "sdo-timeout-wedges" on "reference-301": "After a transfer that the client did not go on with the SDO server is dead.",
    SdoNoObjectSilent = "sdo-no-object-silent": "Requests to objects that do not exist are not answered.",
    SdoAbortMultiplexerZero = "sdo-abort-multiplexer-zero": "Aborts name object 0000h:00.",
    SdoLengthWrongCode = "sdo-length-wrong-code" on "reference-301": "A wrong length is refused with abort 0609 0030h.",
    SdoRangeWrongCode = "sdo-range-wrong-code": "A value outside its limits is refused with abort 0601 0002h.",
    SdoCommandWrongCode = "sdo-command-wrong-code": "Wrong command specifiers are refused with abort 0800 0000h.",
    SdoUnknownAbortCode = "sdo-unknown-abort-code": "A sub-index that does not exist is refused with abort 0A00 0001h, which nobody defines.",
    SdoWriteOnlyWrongCode = "sdo-write-only-wrong-code" on "reference-301": "Reading a write-only object is refused with abort 0602 0000h.",
    SdoEmptyValueSilent = "sdo-empty-value-silent" on "reference-301": "The upload of an empty string is not answered.",
    SdoBusyAfterAbandonedBlock = "sdo-busy-after-abandoned-block" on "reference-301": "A new request during a block transfer is refused with abort 0504 0001h.",
    SdoBlockSizeUnchecked = "sdo-block-size-unchecked" on "reference-301": "Block sizes of 0 and above 127 are accepted.",
    SdoBlockSizeWrongCode = "sdo-block-size-wrong-code" on "reference-301": "Wrong block sizes are refused with abort 0609 0030h.",
    SdoBlockConfirmationIgnored = "sdo-block-confirmation-ignored" on "reference-301": "A block upload goes on with the next block, whatever the client confirms.",
    SdoBlockConfirmationUnchecked = "sdo-block-confirmation-unchecked" on "reference-301": "The confirmation of segments that were not sent is accepted.",
    SdoBlockRepeatsAll = "sdo-block-repeats-all" on "reference-301": "After a lost segment the whole block is sent again, not what was not confirmed.",
    SdoBlockNewSizeIgnored = "sdo-block-new-size-ignored" on "reference-301": "All blocks of an upload have the size of the first.",
    SdoBlockAnnouncedSizeWrong = "sdo-block-announced-size-wrong" on "reference-301": "A block upload announces one byte more than it has.",
    SdoBlockLastLengthWrong = "sdo-block-last-length-wrong" on "reference-301": "The end of a block upload counts one unused byte too many.",
    SdoBlockCrcStartWrong = "sdo-block-crc-start-wrong" on "reference-301": "The CRC of block uploads starts with FFFFh.",
    SdoBlockCrcSwapped = "sdo-block-crc-swapped" on "reference-301": "The CRC of block uploads has its bytes in the wrong order.",
    SdoBlockEndUnmarked = "sdo-block-end-unmarked" on "reference-301": "The last segment of a block upload is not marked as the last.",
    SdoBlockNumbersContinue = "sdo-block-numbers-continue" on "reference-301": "The sequence numbers of a block upload do not begin with 1 in every block.",
    SdoBlockSizeZeroOffered = "sdo-block-size-zero-offered" on "reference-301": "The server asks for blocks of no segments.",
    SdoBlockReadOnlyLate = "sdo-block-read-only-late" on "reference-301": "A block download to a read-only object is refused only at its end.",
    SdoBlockSequenceZeroIgnored = "sdo-block-sequence-zero-ignored" on "reference-301": "A segment with sequence number 0 is taken for none.",
    SdoBlockRepeatedAppended = "sdo-block-repeated-appended" on "reference-301": "A segment that comes twice is taken twice.",
    SdoBlockGapAccepted = "sdo-block-gap-accepted" on "reference-301": "A block download goes on over a lost segment.",
    SdoBlockPaddingKept = "sdo-block-padding-kept" on "reference-301": "The unused bytes of the last segment of a block download are taken as data.",
    SdoBlockCrcIgnored = "sdo-block-crc-ignored" on "reference-301": "The CRC of block downloads is not checked.",
    SdoBlockCrcWrongCode = "sdo-block-crc-wrong-code" on "reference-301": "A wrong CRC is refused with abort 0800 0000h.",
    SdoBlockWrittenBeforeCheck = "sdo-block-written-before-check" on "reference-301": "The value of a block download is written before its CRC is checked.",
    SdoBlockSizeMismatchAccepted = "sdo-block-size-mismatch-accepted" on "reference-301": "A block download of another size than announced is accepted.",
    SdoBlockEndSilent = "sdo-block-end-silent" on "reference-301": "The end of a block download is not confirmed.",
    SdoSegmentLengthWrong = "sdo-segment-length-wrong" on "reference-301": "The last segment of an upload announces one byte too few.",
    SdoUnusedBytesNotZero = "sdo-unused-bytes-not-zero": "Reserved bytes of SDO responses hold old data.",
    SdoShortResponse = "sdo-short-response": "SDO responses have only as many bytes as they need.",
    VendorIdZero = "vendor-id-zero": "1018h:01 is 0.",
    DeviceTypeProfileWrong = "device-type-profile-wrong": "1000h names device profile 401 instead of that of an encoder.",
    IdentityRevisionMissing = "identity-revision-missing": "1018h:03 does not exist, although LSS needs it.",
    ErrorRegisterMissing = "error-register-missing": "1001h does not exist.",
    DeviceNameWithGarbage = "device-name-with-garbage": "1008h ends in bytes that are not printable.",
    TpdoInPreOperational = "tpdo-in-pre-operational": "TPDOs are sent in pre-operational.",
    EventTimerDoubled = "event-timer-doubled": "TPDOs come at twice the time of their event timer.",
    HeartbeatToggles = "heartbeat-toggles": "Heartbeats have bit 7 set.",
    HeartbeatLostOnStateChange = "heartbeat-lost-on-state-change": "The heartbeat ends when the NMT state changes.",
    HeartbeatConsumerDoubleAccepted = "heartbeat-consumer-double-accepted": "1016h takes two entries for one node.",
    GuardingToggleStuck = "guarding-toggle-stuck": "The toggle bit of node guarding answers does not alternate.",
    SdoRangeUnchecked = "sdo-range-unchecked": "Values outside the limits of the device description are confirmed.",
    TpdoWhenStopped = "tpdo-when-stopped": "TPDOs are sent in stopped.",
    SyncCycleIgnored = "sync-cycle-ignored": "TPDOs of transmission type n are sent at every SYNC.",
    InhibitTimeIgnored = "inhibit-time-ignored": "The inhibit time of TPDOs is not observed.",
    CobIdChangeWhileValid = "cob-id-change-while-valid": "The CAN-ID of a PDO can be changed while the PDO is valid.",
    RestrictedCanIdAccepted = "restricted-can-id-accepted": "Restricted CAN-IDs are accepted for PDOs, SYNC and EMCY.",
    ReservedTransmissionTypeAccepted = "reserved-transmission-type-accepted": "Reserved transmission types are accepted.",
    MappingChangeWhileValid = "mapping-change-while-valid": "The mapping can be changed while it is in use.",
    MappingTooLongAccepted = "mapping-too-long-accepted": "Mappings of more than 64 bits are accepted.",
    UnmappableObjectMapped = "unmappable-object-mapped": "Objects that are not for PDOs can be mapped.",
    CyclicTimerNotLinked = "cyclic-timer-not-linked": "6200h does not change the event timer of TPDO 1.",
    StoreSignatureUnchecked = "store-signature-unchecked": "1010h and 1011h take any value as their signature.",
    StoreWithoutEffect = "store-without-effect": "1010h confirms, but nothing is stored.",
    RestoreAtOnce = "restore-at-once": "1011h restores the values at once instead of at the next reset.",
    EmcyWhenStopped = "emcy-when-stopped": "EMCY messages are sent in stopped.",
    EmcyResetMissing = "emcy-reset-missing": "No EMCY 0000h when an error is gone.",
    EmcyRepeated = "emcy-repeated": "An EMCY message is sent twice.",
    ErrorRegisterGenericMissing = "error-register-generic-missing": "1001h does not have its generic bit set together with others.",
    ErrorHistoryNotCleared = "error-history-not-cleared": "Writing 0 to 1003h:00 does not clear the history.",
    LssNodeIdUnchecked = "lss-node-id-unchecked": "LSS confirms node-IDs that don't exist.",
    LssAnsweredWhileWaiting = "lss-answered-while-waiting": "LSS inquiries are answered in the waiting state.",
    PresetIgnored = "preset-ignored": "6003h is confirmed, but the position does not change.",
    PresetOutOfRangeAccepted = "preset-out-of-range-accepted": "6003h takes values outside the measuring range.",
    CodeSequenceIgnored = "code-sequence-ignored": "6000h bit 0 does not turn the direction of counting.",
    ScalingIgnored = "scaling-ignored": "6001h and 6002h do not scale the position.",
    OperatingStatusStuck = "operating-status-stuck": "6500h does not follow 6000h.",
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
