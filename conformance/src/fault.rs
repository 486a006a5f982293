//! Firmware faults that a simulated device can be given, drawn from defects of real devices and stacks.

use std::fmt;
use std::str::FromStr;

/// The model on which a fault shows where its row names no other.
const USUAL_MODEL: &str = "kuebler-sendix-58x8";

/// Defines the faults: one row each, so that name, variant and text can't drift apart. `on "MODEL"` names a model on
/// which the fault shows, where it is not the usual one; `fuzz` says that the fuzzer finds it.
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

            /// Whether the fuzzer claims to find it.
            pub const fn is_fuzzed(self) -> bool {
                match self { $(Self::$variant => faults!(@fuzz $($key $($argument)?)*),)* }
            }
        }
    };
    (@model $(fuzz)?) => { None };
    (@model on $model:literal $(fuzz)?) => { Some($model) };
    (@fuzz $(on $model:literal)?) => { false };
    (@fuzz $(on $model:literal)? fuzz) => { true };
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
    SdoWrongCodeForNoObject = "sdo-wrong-code-for-no-object": "An object that does not exist is refused with abort 0609 0011h.",
    SdoWrongCodeForNoSubIndex = "sdo-wrong-code-for-no-sub-index": "A sub-index that does not exist is refused with abort 0602 0000h.",
    SdoReadOnlyWritable = "sdo-read-only-writable": "Downloads to read-only objects are confirmed.",
    SdoReadOnlyWrongCode = "sdo-read-only-wrong-code": "A download to a read-only object is refused with abort 0800 0022h.",
    SdoLengthUnchecked = "sdo-length-unchecked": "Downloads that are too long are confirmed.",
    SdoShortLengthUnchecked = "sdo-short-length-unchecked": "Downloads that are too short are confirmed.",
    SdoUnknownCommandSilent = "sdo-unknown-command-silent": "An unknown SDO command specifier is not answered.",
    SdoFirstUnknownCommandSilent = "sdo-first-unknown-command-silent": "An unknown SDO command specifier as the first request after boot-up is not answered.",
    SdoAbortAnswered = "sdo-abort-answered": "The server answers an abort of the client with an abort.",
    SdoToggleUnchecked = "sdo-toggle-unchecked": "Segments whose toggle bit does not alternate are accepted.",
    SdoSegmentLengthWrong = "sdo-segment-length-wrong": "The last segment of an upload announces one byte too few.",
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
    DeviceTypeTurnsWrong = "device-type-turns-wrong": "1000h says single-turn of a multi-turn encoder.",
    OperatingStatusMissing = "operating-status-missing": "6500h does not exist.",
    AlarmsMissing = "alarms-missing": "6503h does not exist.",
    PositionSixteenBit = "position-sixteen-bit": "6004h has 16 bits instead of 32.",
    OperatingParametersThirtyTwoBit = "operating-parameters-thirty-two-bit": "6000h has 32 bits instead of 16.",
    PositionWritable = "position-writable": "6004h can be written.",
    ReservedOperatingBitsAccepted = "reserved-operating-bits-accepted": "6000h takes its reserved bits, and shows them.",
    UnitsAboveRangeAccepted = "units-above-range-accepted": "6001h and 6002h take a range of less than one revolution.",
    UnitsZeroWedges = "units-zero-wedges": "6001h = 0 makes the firmware divide by zero: nothing is answered until a reset.",
    RangeZeroStops = "range-zero-stops" on "kuebler-sendix-f58": "6002h = 0, which stands for 2^32, makes 6004h stay 0.",
    ScalingOverflow = "scaling-overflow": "The product of position and 6001h is calculated with 32 bits.",
    WrapAtPowerOfTwo = "wrap-at-power-of-two": "The position wraps at the next power of two instead of at 6002h.",
    OffsetSignWrong = "offset-sign-wrong": "6509h has the wrong sign.",
    OffsetNotReported = "offset-not-reported": "6509h stays 0 after a preset.",
    PresetGlitch = "preset-glitch": "After a preset 6004h shows the old position for some milliseconds.",
    PresetPersists = "preset-persists": "A preset outlives a reset without having been stored.",
    PresetLostAfterSave = "preset-lost-after-save": "1010h does not store the preset.",
    TpdoPositionWithoutPreset = "tpdo-position-without-preset": "TPDOs carry the position without the preset.",
    TpdoPositionLate = "tpdo-position-late": "TPDOs carry what was measured for the TPDO before.",
    TpdoNotSentOnStart = "tpdo-not-sent-on-start": "Event-driven TPDOs are not sent when the device becomes operational.",
    CyclicTimerNotStopped = "cyclic-timer-not-stopped": "6200h = 0 does not end the cyclic transmission.",
    EventTimerNotInCyclicTimer = "event-timer-not-in-cyclic-timer": "6200h does not follow the event timer of TPDO 1.",
    SpeedNotZeroAtRest = "speed-not-zero-at-rest": "6030h is not 0 while the shaft is at rest.",
    SpeedSignIgnoresCodeSequence = "speed-sign-ignores-code-sequence": "The sign of 6030h does not follow the code sequence.",
    SpeedFormatIgnored = "speed-format-ignored": "6000h does not change the unit of the speed.",
    SpeedTenfold = "speed-tenfold": "6030h is ten times too high.",
    SpeedDivisorIgnored = "speed-divisor-ignored" on "kuebler-sendix-f58": "6031h:04 does not divide the speed.",
    AccelerationShowsSpeed = "acceleration-shows-speed": "6040h shows the speed instead of how it changes.",
    WorkAreaBitsSwapped = "work-area-bits-swapped": "6400h has overflow and underflow the other way round.",
    WorkAreaStuck = "work-area-stuck": "6400h stays 0.",
    WorkAreaInverted = "work-area-inverted": "6400h says out of range while the position is in the work area.",
    WorkAreaLimitsSwappedAccepted = "work-area-limits-swapped-accepted": "6401h takes a low limit above the high limit.",
    UnsupportedAlarmSet = "unsupported-alarm-set": "6503h has a bit that 6504h does not support.",
    ReservedAlarmBitSet = "reserved-alarm-bit-set": "6503h and 6504h have a reserved bit set.",
    UnsupportedWarningSet = "unsupported-warning-set": "6505h has a bit that 6506h does not support.",
    AlarmWithoutEmcy = "alarm-without-emcy": "A position error is shown by 6503h, but neither by an EMCY nor by 1001h.",
    EmcyWithoutAlarm = "emcy-without-alarm": "A position error is reported by an EMCY, but not by 6503h.",
    WarningWithoutEmcy = "warning-without-emcy": "A temperature beyond its limits is shown by 6505h, but not reported by an EMCY.",
    WarningNotSet = "warning-not-set": "A temperature beyond its limits is reported by an EMCY, but not shown by 6505h.",
    WarningNotCleared = "warning-not-cleared": "6505h keeps a warning whose cause is gone.",
    OperatingTimeBackwards = "operating-time-backwards": "6508h counts down.",
    OperatingTimeInSeconds = "operating-time-in-seconds": "6508h counts seconds instead of tenths of an hour.",
    SerialNumberDiffers = "serial-number-differs": "650Bh is another number than 1018h:04.",
    SingleTurnResolutionFollowsScaling = "single-turn-resolution-follows-scaling": "6501h shows 6001h instead of the physical resolution.",
    RevolutionsZero = "revolutions-zero": "6502h is 0.",
    ProfileVersionUnset = "profile-version-unset": "6507h is FFFF FFFFh.",
    RawInverseWrong = "raw-inverse-wrong" on "kuebler-sendix-f58": "2161h is the raw position itself instead of its inverse.",
    RawCrcStartWrong = "raw-crc-start-wrong" on "kuebler-sendix-f58": "The checksum 2162h begins with FFFFh instead of 1021h.",
    RawPositionFollowsPreset = "raw-position-follows-preset" on "kuebler-sendix-f58m": "A preset changes the raw position 600Ch.",
    RedundantChannelDrift = "redundant-channel-drift" on "kuebler-c100": "The second channel of the position drifts.",
    RedundantChannelNotNegated = "redundant-channel-not-negated" on "kuebler-d125": "The second channel counts up as the first one does.",
    AngleDirectionIgnored = "angle-direction-ignored" on "kuebler-c100": "3003h does not turn the direction of the angle.",
    AngleRangeIgnored = "angle-range-ignored" on "kuebler-c100": "3004h does not change the range of the angle.",
    RedundantAngleSame = "redundant-angle-same" on "kuebler-c100": "The second angle does not run opposite to the first one.",
    ZeroPointIgnored = "zero-point-ignored" on "kuebler-c100": "3010h does not make the angle zero.",
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
