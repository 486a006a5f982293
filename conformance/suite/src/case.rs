//! What a conformance case is: an item of the catalogue.

use crate::bench::Bench;
use crate::verdict::Judged;
use canvass_device::Fault;
use std::fmt;
use std::str::FromStr;

/// A case of the catalogue, registered by the `#[case]` attribute.
#[derive(Debug)]
pub struct Case {
    /// Stable and textual: `301/sdo/download/read-only`.
    pub id: &'static str,
    /// What the standard demands, in the words of its author: the doc comment of the case.
    pub requirement: &'static str,
    /// Where the standard demands it.
    pub clause: Clause,
    /// How strictly it is demanded.
    pub level: Level,
    /// Features without which the case is not applicable.
    pub needs: &'static [Need],
    /// What the case does that the user must allow first.
    pub touches: &'static [Touch],
    /// Firmware faults, each of which makes the case fail.
    pub catches: &'static [Fault],
    /// The number of a comparable case of CiA's conformance test tool.
    pub cct: Option<&'static str>,
    /// Stimulus and verdict.
    pub run: fn(&mut Bench<'_>) -> Judged,
}

inventory::collect!(Case);

impl Case {
    /// Standard and service: the first two words of the id, such as `301/sdo`.
    pub fn family(&self) -> &'static str {
        self.id.match_indices('/').nth(1).map_or(self.id, |(at, _)| self.id.get(..at).unwrap_or(self.id))
    }

    /// The first sentence of the requirement: a line for lists.
    pub fn summary(&self) -> &'static str {
        let paragraph = self.requirement.split("\n\n").next().unwrap_or(self.requirement);
        paragraph.split_inclusive(". ").next().unwrap_or(paragraph).trim_end()
    }
}

/// A place in a standard, and how sure it is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Clause {
    /// `CiA 301`.
    pub standard: &'static str,
    /// `7.2.8.2.3.1`, where it is known.
    pub section: Option<&'static str>,
    /// How sure the section is.
    pub confidence: Confidence,
}

/// How sure the number of a section is. Of most standards the text is not public: their numbers come from those who cite it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Confidence {
    /// The clause was read, in a public edition of the standard.
    Cited,
    /// An independent source cites it.
    Attested,
    /// Counted between two attested sections.
    Derived,
    /// From general knowledge of the standard's structure.
    Known,
    /// The section is not known.
    Unknown,
}

impl Confidence {
    /// The word for it in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cited => "cited",
            Self::Attested => "attested",
            Self::Derived => "derived",
            Self::Known => "known",
            Self::Unknown => "unknown",
        }
    }
}

impl Clause {
    /// `CiA 301 7.2.8.2.3.1` without a word on how sure it is: only where [`Clause::confidence`] stands beside it.
    pub fn bare(&self) -> String {
        match self.section {
            Some(section) => format!("{} {section}", self.standard),
            None => self.standard.to_owned(),
        }
    }
}

/// Never shows a section as certain that is not: `CiA 301 7.5.2.20 (derived)`.
impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.section, self.confidence) {
            (Some(section), Confidence::Cited | Confidence::Attested) => write!(f, "{} {section}", self.standard),
            (Some(section), Confidence::Derived) => write!(f, "{} {section} (derived)", self.standard),
            (Some(section), _) => write!(f, "{} {section} (unconfirmed)", self.standard),
            (None, _) => write!(f, "{}, section unknown", self.standard),
        }
    }
}

/// How strictly the standard demands something.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Level {
    /// The standard says "shall".
    Must,
    /// The standard recommends it, or several readings are plausible.
    Should,
    /// The standard leaves it open: what the device does is recorded and never fails.
    Open,
}

impl Level {
    /// The word for it in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Must => "must",
            Self::Should => "should",
            Self::Open => "open",
        }
    }
}

/// A feature of the device, decided from its description and by asking it. Without it the case is not applicable.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Need {
    /// The device shows its NMT state: by heartbeat (1017h) or by node guarding (100Ch).
    VisibleState,
    /// A heartbeat producer whose period can be set, 1017h.
    Heartbeat,
    /// An object that can be written without consequence, and read back.
    ScratchObject,
    /// A value of more than four bytes that can be read: it comes in segments.
    SegmentedUpload,
    /// TPDO 1, switched on: 1800h and 1A00h.
    Tpdo,
    /// A TPDO with an event timer, 1800h:05.
    EventTimer,
    /// A device name, hardware or software version: 1008h, 1009h, 100Ah.
    Name,
    /// Layer setting services: the description says that they are supported.
    Lss,
    /// Layer management: the slave answers an inquiry.
    Lmt,
    /// The heartbeat consumer, 1016h:01, and a node-ID beside the device's own that the tester can act as.
    HeartbeatConsumer,
    /// Life guarding that can be set, 100Ch and 100Dh, or the heartbeat consumer, 1016h:01.
    Monitoring,
    /// Node guarding, 100Ch.
    Guarding,
    /// The predefined error field, 1003h.
    ErrorHistory,
    /// TPDO 1 with a mapping that can be changed: 1800h:01 and 1A00h.
    DynamicMapping,
    /// The first RPDO, 1400h and 1600h.
    Rpdo,
    /// RPDO 1 with a mapping that can be changed, and an object for it that SDOs can read.
    RpdoMapping,
    /// TPDO 1 with a mapping that can be changed, and an object for it that SDOs can write.
    Changeable,
    /// SYNC, 1005h.
    Sync,
    /// The device can produce SYNC: 1005h bit 30 and 1006h.
    SyncProducer,
    /// The counter of SYNC, 1019h.
    SyncCounter,
    /// TIME, 1012h.
    Time,
    /// The COB-ID of EMCY, 1014h.
    EmcyObject,
    /// A COB-ID of EMCY that can be written, 1014h.
    EmcyId,
    /// The inhibit time of EMCY, 1015h.
    EmcyInhibit,
    /// Error behaviour, 1029h:01.
    ErrorBehaviour,
    /// The device's description names an application object that can be written without consequence.
    ApplicationParameter,
    /// The SDO server parameter, 1200h.
    ServerParameter,
    /// A second SDO server, 1201h.
    SecondServer,
    /// NMT start-up, 1F80h.
    StartUp,
    /// The device has no node-ID as delivered: LSS gives it one.
    Unconfigured,
    /// The device is an encoder (CiA 406).
    Encoder,
    /// A preset (6003h) that a reset takes back, unless `--allow nvm` was given.
    VolatilePreset,
    /// A work area: 6400h, 6401h and 6402h.
    WorkArea,
    /// Alarms and warnings: 6503h to 6506h.
    Alarms,
    /// The temperature limits of Kübler's Sendix encoders, 2120h.
    TemperatureLimit,
    /// The raw position 600Ch.
    RawPosition,
    /// The raw position of Kübler's Sendix encoders with its inverse and checksum, 2160h to 2162h.
    RawData,
    /// The speed 6030h.
    Speed,
    /// The speed 6030h with its parameters 6031h.
    SpeedParameters,
    /// The acceleration 6040h.
    Acceleration,
    /// The jerk 6050h, with the acceleration 6040h.
    Jerk,
    /// Cams: 6300h, 6301h, 6302h, 6310h and 6320h.
    Cams,
    /// The position in 64 bits, 6008h.
    HighPrecision,
    /// The shaft turns, or the wire moves, while the case runs.
    TurningShaft,
    /// Two redundant channels of the position in TPDO 1: 6020h twice in 1A00h.
    RedundantChannels,
    /// The inclinometer of Kübler's draw-wire encoders: 3003h to 3010h, 5000h.
    Inclinometer,
    /// Store parameters, 1010h:01.
    Store,
    /// Verify configuration, 1020h.
    VerifyConfiguration,
    /// The SDO server knows block uploads.
    BlockUpload,
    /// The SDO server knows block downloads.
    BlockDownload,
    /// The SDO server checks the CRC of block downloads.
    BlockCrc,
    /// A string that can be written without consequence, as the description says.
    LongScratch,
    /// A string that is empty.
    EmptyValue,
    /// The device's EDS or built-in model.
    Description,
    /// No other node was heard on the bus or answers, or `--allow other-nodes` was given: the case commands all nodes.
    Alone,
}

impl Need {
    /// What the device or the bus would have to have.
    pub const fn text(self) -> &'static str {
        match self {
            Self::VisibleState => "a heartbeat (1017h) or node guarding (100Ch), which show the NMT state",
            Self::Heartbeat => "the heartbeat producer (1017h)",
            Self::ScratchObject => "an object that can be written and read back without consequence",
            Self::SegmentedUpload => "a readable value of more than four bytes",
            Self::Tpdo => "a TPDO that is switched on (1800h, 1A00h)",
            Self::EventTimer => "a TPDO with an event timer (1800h:05)",
            Self::Name => "a device name or version (1008h, 1009h or 100Ah)",
            Self::Lss => "layer setting services (LSS)",
            Self::Lmt => "layer management (LMT)",
            Self::HeartbeatConsumer => "the heartbeat consumer (1016h:01)",
            Self::Monitoring => "life guarding (100Ch, 100Dh) or a heartbeat consumer (1016h:01)",
            Self::Guarding => "node guarding (100Ch)",
            Self::ErrorHistory => "the predefined error field (1003h)",
            Self::DynamicMapping => "a TPDO 1 whose mapping can be changed (1800h:01, 1A00h)",
            Self::Rpdo => "an RPDO (1400h, 1600h)",
            Self::RpdoMapping => "an RPDO 1 whose mapping can be changed, and an object for it that SDOs can read",
            Self::Changeable => "a TPDO 1 whose mapping can be changed, and an object for it that SDOs can write",
            Self::Sync => "SYNC (1005h)",
            Self::SyncProducer => "a SYNC producer (1005h bit 30, 1006h)",
            Self::SyncCounter => "the SYNC counter (1019h)",
            Self::Time => "TIME (1012h)",
            Self::EmcyObject => "the COB-ID of EMCY (1014h)",
            Self::EmcyId => "a COB-ID of EMCY that can be written (1014h)",
            Self::EmcyInhibit => "the inhibit time of EMCY (1015h)",
            Self::ErrorBehaviour => "error behaviour (1029h:01)",
            Self::ApplicationParameter => "an application object that can be written without consequence",
            Self::ServerParameter => "the SDO server parameter (1200h)",
            Self::SecondServer => "a second SDO server (1201h)",
            Self::StartUp => "NMT start-up (1F80h)",
            Self::Unconfigured => "no node-ID as delivered",
            Self::Encoder => "an encoder of CiA 406 with a position (6004h)",
            Self::VolatilePreset => "a preset that is not stored at once (or --allow nvm)",
            Self::WorkArea => "a work area (6400h to 6402h)",
            Self::Alarms => "alarms and warnings (6503h to 6506h)",
            Self::TemperatureLimit => "temperature limits of Kübler's Sendix encoders (2120h)",
            Self::RawPosition => "a raw position (600Ch)",
            Self::RawData => "the raw position of Kübler's Sendix encoders with its checksum (2160h to 2162h)",
            Self::Speed => "a speed (6030h)",
            Self::SpeedParameters => "a speed with parameters (6030h, 6031h)",
            Self::Acceleration => "an acceleration (6040h)",
            Self::Jerk => "a jerk (6050h) and an acceleration (6040h)",
            Self::Cams => "cams (6300h to 6302h, 6310h, 6320h)",
            Self::HighPrecision => "a position in 64 bits (6008h)",
            Self::TurningShaft => "a shaft that turns while the case runs",
            Self::RedundantChannels => "two redundant channels of the position (6020h twice in 1A00h)",
            Self::Inclinometer => "the inclinometer of Kübler's draw-wire encoders (3003h to 3010h, 5000h)",
            Self::Store => "store parameters (1010h:01)",
            Self::VerifyConfiguration => "verify configuration (1020h)",
            Self::BlockUpload => "SDO block uploads",
            Self::BlockDownload => "SDO block downloads",
            Self::BlockCrc => "a CRC in SDO block downloads",
            Self::LongScratch => "a string that can be written without consequence",
            Self::EmptyValue => "a string that is empty",
            Self::Description => "a description of the device (an EDS or a built-in model)",
            Self::Alone => "a bus without other nodes, because the case commands all of them",
        }
    }
}

/// What a case does to a device or a bus that is not done without the user's leave.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Touch {
    /// Writes non-volatile memory, which wears out.
    Nvm,
    /// Changes the node-ID.
    NodeId,
    /// Changes the bit rate.
    BitRate,
    /// Commands other nodes than the device under test.
    OtherNodes,
    /// Restores the factory defaults: what the user had configured is lost.
    FactoryDefaults,
}

impl Touch {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Nvm, Self::NodeId, Self::BitRate, Self::OtherNodes, Self::FactoryDefaults];

    /// The name for `--allow`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nvm => "nvm",
            Self::NodeId => "node-id",
            Self::BitRate => "bit-rate",
            Self::OtherNodes => "other-nodes",
            Self::FactoryDefaults => "factory-defaults",
        }
    }

    /// What the case would do.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Nvm => "writes non-volatile memory",
            Self::NodeId => "changes the node-ID",
            Self::BitRate => "changes the bit rate",
            Self::OtherNodes => "commands other nodes",
            Self::FactoryDefaults => "restores the factory defaults",
        }
    }
}

impl fmt::Display for Touch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// There is nothing of that name to allow.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("nothing to allow is called \"{0}\": there are nvm, node-id, bit-rate, other-nodes and factory-defaults")]
pub struct UnknownTouch(pub String);

impl FromStr for Touch {
    type Err = UnknownTouch;

    fn from_str(name: &str) -> Result<Self, UnknownTouch> {
        Self::ALL.into_iter().find(|touch| touch.name() == name).ok_or_else(|| UnknownTouch(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clause_that_is_not_attested_never_looks_certain() {
        let clause = |section, confidence| Clause { standard: "CiA 301", section, confidence }.to_string();
        assert_eq!(clause(Some("7.2.8.2.3.1"), Confidence::Attested), "CiA 301 7.2.8.2.3.1");
        assert_eq!(clause(Some("7.5.2.20"), Confidence::Derived), "CiA 301 7.5.2.20 (derived)");
        assert_eq!(clause(Some("7.2.4.3.6"), Confidence::Known), "CiA 301 7.2.4.3.6 (unconfirmed)");
        assert_eq!(clause(None, Confidence::Unknown), "CiA 301, section unknown");
    }

    #[test]
    fn names_to_allow_are_found() {
        for touch in Touch::ALL {
            assert_eq!(touch.name().parse(), Ok(touch));
        }
        assert!("everything".parse::<Touch>().is_err());
    }
}
