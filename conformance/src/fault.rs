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
    GuardingToggleNotReset = "guarding-toggle-not-reset": "Reset communication does not set the toggle bit of node guarding back to 0.",
    GuardingWrongState = "guarding-wrong-state": "Node guarding answers say pre-operational in every state.",
    GuardingSilentWhenOff = "guarding-silent-when-off": "Node guarding is not answered while the life time is 0.",
    GuardingBesideHeartbeat = "guarding-beside-heartbeat": "Node guarding is answered while the heartbeat is on.",
    LifeTimeFactorOffByOne = "life-time-factor-off-by-one": "The master is missed one guard time too late.",
    LifeGuardingStartsAtOnce = "life-guarding-starts-at-once": "Life guarding begins before the first remote frame of the master.",
    LifeGuardingNotStopped = "life-guarding-not-stopped": "Setting the life time to 0 does not end life guarding.",
    LifeGuardingUnreported = "life-guarding-unreported": "A lost master is not reported by an EMCY message.",
    ErrorBehaviourIgnored = "error-behaviour-ignored": "The device stays operational when its master or a watched node is lost.",
    ErrorControlMissing = "error-control-missing" on "tr-c65": "100Dh does not exist, although there is no 1017h either.",
    GuardingCobIdWrong = "guarding-cob-id-wrong" on "tr-c65": "100Eh holds another COB-ID than the one that node guarding uses.",
    NodeIdObjectWrong = "node-id-object-wrong" on "tr-c65": "100Bh holds another node-ID than the one in use.",
    PdoCountWrong = "pdo-count-wrong" on "tr-c65": "1004h counts more PDOs than there are.",
    SdoRangeUnchecked = "sdo-range-unchecked": "Values outside the limits of the device description are confirmed.",
    TpdoWhenStopped = "tpdo-when-stopped": "TPDOs are sent in stopped.",
    TpdoRemoteUnanswered = "tpdo-remote-unanswered" on "tr-c65": "Remote frames for a TPDO that allows them are not answered.",
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
    ErrorRegisterStuck = "error-register-stuck": "1001h keeps the bits of an error that is gone.",
    ErrorHistoryNotCleared = "error-history-not-cleared": "Writing 0 to 1003h:00 does not clear the history.",
    LssNodeIdUnchecked = "lss-node-id-unchecked": "LSS confirms node-IDs that don't exist.",
    LssAnsweredWhileWaiting = "lss-answered-while-waiting": "LSS inquiries are answered in the waiting state.",
    LmtSwitchSelectiveAnswered = "lmt-switch-selective-answered" on "tr-lmp30": "Switch mode selective of LMT is answered with 44h, as LSS does.",
    LmtSerialNotCompared = "lmt-serial-not-compared" on "tr-lmp30": "Switch mode selective of LMT takes any serial number.",
    LmtNamesNotCompared = "lmt-names-not-compared" on "tr-lmp30": "Switch mode selective of LMT takes any manufacturer and product name.",
    LmtReservedModeObeyed = "lmt-reserved-mode-obeyed" on "tr-lmp30": "Reserved modes of switch mode global of LMT lead into configuration.",
    LmtAnsweredInOperation = "lmt-answered-in-operation" on "tr-lmp30": "LMT inquiries and configurations are answered in operation.",
    LmtBitTimingUnshifted = "lmt-bit-timing-unshifted" on "tr-lmp30": "LMT bit timing uses the table of LSS, whose fifth row is reserved.",
    LmtBitTimingUnchecked = "lmt-bit-timing-unchecked" on "tr-lmp30": "LMT confirms bit timings that don't exist.",
    LmtNodeIdUnchecked = "lmt-node-id-unchecked" on "tr-lmp30": "LMT confirms node-IDs that don't exist.",
    LmtNodeIdAtOnce = "lmt-node-id-at-once" on "tr-lmp30": "A node-ID that LMT configures acts at once.",
    LmtStoreSilent = "lmt-store-silent" on "tr-lmp30": "Store configuration of LMT is not answered.",
    LmtActivationNotSilent = "lmt-activation-not-silent" on "tr-lmp30": "The device goes on sending while LMT activates a bit timing.",
    LmtNameUnpadded = "lmt-name-unpadded" on "tr-lmp30": "LMT fills names up with FFh instead of 00h.",
    LmtIdentifySilent = "lmt-identify-silent" on "tr-lmp30": "Identify remote slave of LMT is not answered.",
    LmtIdentifyRangeIgnored = "lmt-identify-range-ignored" on "tr-lmp30": "Identify remote slave of LMT is answered outside the range of serial numbers.",
    LmtSerialNotBcd = "lmt-serial-not-bcd" on "tr-lmp30": "LMT inquiries give the serial number in binary.",
    LimitSwitchesSwapped = "limit-switches-swapped" on "lika-ax58": "Bits 12 and 13 of 6500h are swapped.",
    LimitSwitchInclusive = "limit-switch-inclusive" on "lika-ax58": "A limit switch acts on its limit already, not only beyond.",
    ScalingAlwaysOn = "scaling-always-on": "6001h and 6002h scale the position although bit 2 of 6000h is 0.",
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
