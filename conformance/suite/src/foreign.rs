//! Messages that others send to the device under test or for it, and the breaches and passes that they may cause: one
//! table for all cases.

use crate::glob;
use crate::verdict::Breach;
use canvass_analyzer::{Service, object};
use canvass_bus::observation::{Observation, Subject};
use std::fmt;
use std::ops::RangeInclusive;

/// A kind of messages that others send to the device under test or for it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum ForeignKind {
    /// Requests to the SDO server of the device that change no object.
    SdoRead,
    /// Requests to the SDO server of the device that write objects.
    SdoWrite,
    /// NMT commands to the device or to all nodes.
    Nmt,
    /// SYNC messages.
    Sync,
    /// TIME messages.
    Time,
    /// PDOs that the device receives.
    Rpdo,
    /// Requests of an LSS or LMT master.
    LayerSetting,
    /// Remote frames that guard the device.
    Guarding,
    /// Heartbeats of nodes that the device monitors.
    Heartbeat,
}

/// Messages of one sort that others sent.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct ForeignMessages {
    /// The kind of the messages.
    pub kind: ForeignKind,
    /// The CAN-ID of the messages.
    pub can_id: u16,
    /// Number of messages.
    pub count: u64,
}

/// The effects that messages of one kind may have on a case.
struct Influence {
    kind: ForeignKind,
    /// Breaches that the messages may cause.
    breaches: &'static [Reach],
    /// Cases whose pass the messages may cause, too: patterns over ids.
    passes: &'static [&'static str],
    /// Whether the messages may prevent the precondition of a case.
    preconditions: bool,
}

/// The breaches that an influence reaches, by their subject.
enum Reach {
    /// All breaches.
    Anything,
    /// Answers of the SDO server, and values read by SDO.
    Answers,
    /// PDOs in both directions.
    Pdos,
    /// Objects of the device's application.
    Application,
    /// Errors that the device reports or records.
    Errors,
    /// The NMT state, and whether the device is present.
    State,
    /// Messages of a service.
    Of(Service),
    /// Objects with these indexes.
    Objects(RangeInclusive<u16>),
}

/// Each kind of message with its possible effects. A message affects the listed services only: a breach that no row
/// explains remains the device's.
const TABLE: &[Influence] = &[
    Influence { kind: ForeignKind::SdoRead, breaches: &[Reach::Answers], passes: &[], preconditions: true },
    Influence { kind: ForeignKind::SdoWrite, breaches: &[Reach::Anything], passes: &[], preconditions: true },
    Influence {
        kind: ForeignKind::Nmt,
        breaches: &[Reach::Anything],
        passes: &["301/nmt/*", "301/state/*", "301/boot-up/*", "301/heartbeat/*state", "301/guarding/state"],
        preconditions: true,
    },
    Influence {
        kind: ForeignKind::Sync,
        breaches: &[
            Reach::Of(Service::Sync),
            Reach::Objects(object::COB_ID_SYNC..=object::SYNCHRONOUS_WINDOW_LENGTH),
            Reach::Objects(object::SYNCHRONOUS_COUNTER_OVERFLOW..=object::SYNCHRONOUS_COUNTER_OVERFLOW),
            Reach::Pdos,
            Reach::Application,
            Reach::Errors,
        ],
        passes: &[
            "301/sync/*",
            "301/tpdo/sync*",
            "301/rpdo/synchronous",
            "301/state/stopped/sync",
            "*/tpdo/second-synchronous",
        ],
        preconditions: false,
    },
    Influence {
        kind: ForeignKind::Time,
        breaches: &[
            Reach::Of(Service::Time),
            Reach::Objects(object::COB_ID_TIME..=object::HIGH_RESOLUTION_TIME_STAMP),
            Reach::Application,
        ],
        passes: &["301/time/consumer", "301/time/produce*"],
        preconditions: false,
    },
    Influence {
        kind: ForeignKind::Rpdo,
        breaches: &[Reach::Pdos, Reach::Application, Reach::Errors, Reach::State],
        passes: &["301/rpdo/*", "301/state/*/rpdo"],
        preconditions: false,
    },
    Influence {
        kind: ForeignKind::LayerSetting,
        breaches: &[Reach::Of(Service::Lss), Reach::Of(Service::Lmt), Reach::Of(Service::BootUp), Reach::State],
        passes: &["305/*", "205/*"],
        preconditions: true,
    },
    Influence {
        kind: ForeignKind::Guarding,
        breaches: &[Reach::Of(Service::Guarding), Reach::Of(Service::Heartbeat), Reach::Errors, Reach::State],
        passes: &["301/guarding/*", "301/life-guarding/*"],
        preconditions: false,
    },
    Influence {
        kind: ForeignKind::Heartbeat,
        breaches: &[
            Reach::Objects(object::CONSUMER_HEARTBEAT_TIME..=object::CONSUMER_HEARTBEAT_TIME),
            Reach::Of(Service::Heartbeat),
            Reach::Errors,
            Reach::State,
        ],
        passes: &["301/heartbeat-consumer/*"],
        preconditions: false,
    },
];

impl ForeignKind {
    /// All kinds.
    pub const ALL: [Self; 9] = [
        Self::SdoRead,
        Self::SdoWrite,
        Self::Nmt,
        Self::Sync,
        Self::Time,
        Self::Rpdo,
        Self::LayerSetting,
        Self::Guarding,
        Self::Heartbeat,
    ];

    /// The name of the kind in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SdoRead => "sdo-read",
            Self::SdoWrite => "sdo-write",
            Self::Nmt => "nmt",
            Self::Sync => "sync",
            Self::Time => "time",
            Self::Rpdo => "rpdo",
            Self::LayerSetting => "layer-setting",
            Self::Guarding => "guarding",
            Self::Heartbeat => "heartbeat",
        }
    }

    /// The sender of the messages and its action.
    pub const fn text(self) -> &'static str {
        match self {
            Self::SdoRead => "another SDO client reads its objects",
            Self::SdoWrite => "another SDO client writes its objects",
            Self::Nmt => "another NMT master commands it",
            Self::Sync => "another node sends SYNC",
            Self::Time => "another node sends TIME",
            Self::Rpdo => "another node sends PDOs that it receives",
            Self::LayerSetting => "another LSS or LMT master sends requests",
            Self::Guarding => "another NMT master guards it",
            Self::Heartbeat => "a node that it monitors sends heartbeats",
        }
    }

    /// Whether the messages concern every device, whatever its object dictionary holds.
    pub(crate) const fn concerns_all(self) -> bool {
        matches!(self, Self::SdoRead | Self::SdoWrite | Self::Nmt | Self::Guarding)
    }

    fn influence(self) -> Option<&'static Influence> {
        TABLE.iter().find(|influence| influence.kind == self)
    }

    /// Whether messages of this kind may have caused a breach.
    pub(crate) fn may_cause(self, breach: &Breach) -> bool {
        self.influence().is_some_and(|influence| influence.breaches.iter().any(|reach| reach.covers(breach)))
    }

    /// Whether messages of this kind may be the reason why this case passed.
    pub(crate) fn may_pass(self, case: &str) -> bool {
        self.influence().is_some_and(|influence| influence.passes.iter().any(|pattern| glob::matches(pattern, case)))
    }

    /// Whether messages of this kind may prevent the precondition of a case.
    pub(crate) fn may_keep_out(self) -> bool {
        self.influence().is_some_and(|influence| influence.preconditions)
    }
}

impl Reach {
    fn covers(&self, breach: &Breach) -> bool {
        let index = match breach.subject {
            Subject::Entry(entry) => Some(entry.index.0),
            Subject::Object(index) => Some(index.0),
            _ => None,
        };
        match self {
            Self::Anything => true,
            Self::Answers => {
                index.is_some()
                    || breach.subject == Subject::Service(Service::Sdo)
                    || breach.subject == Subject::Device && breach.actual == Observation::Silence
            }
            Self::Pdos => {
                matches!(breach.subject, Subject::Pdo { .. } | Subject::Service(Service::Pdo))
                    || index.is_some_and(object::is_pdo_communication)
            }
            Self::Application => index.is_some_and(|index| index >= 0x2000),
            Self::Errors => {
                matches!(breach.actual, Observation::Emcy(_))
                    || breach.subject == Subject::Service(Service::Emcy)
                    || matches!(index, Some(object::ERROR_REGISTER | object::PREDEFINED_ERROR_FIELD))
            }
            Self::State => breach.subject == Subject::Device || matches!(breach.actual, Observation::State(_)),
            Self::Of(service) => breach.subject == Subject::Service(*service),
            Self::Objects(indices) => index.is_some_and(|index| indices.contains(&index)),
        }
    }
}

impl fmt::Display for ForeignKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// `another SDO client reads its objects (12 frames with CAN-ID 63F)`.
impl fmt::Display for ForeignMessages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.count == 1 { "" } else { "s" };
        write!(f, "{} ({} frame{plural} with CAN-ID {:03X})", self.kind.text(), self.count, self.can_id)
    }
}

/// The patterns of the table that match none of these cases.
#[cfg(test)]
pub(crate) fn unmatched(cases: &[&str]) -> Vec<&'static str> {
    let patterns = TABLE.iter().flat_map(|influence| influence.passes.iter().copied());
    patterns.filter(|pattern| !cases.iter().any(|case| glob::matches(pattern, case))).collect()
}

/// All messages in one sentence.
pub fn told(messages: &[ForeignMessages]) -> String {
    messages.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
