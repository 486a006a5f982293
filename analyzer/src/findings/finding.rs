//! A problem that a rule found.

use super::effect::Rank;
use super::occurrences::Occurrences;
use super::rule::Metadata;
use crate::statistics::CaseName;
use crate::{Multiplexer, NodeId};
use canvass_traces::{ChannelId, Place, Record, Timestamp};
use std::fmt;

/// The severity of a finding.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Severity {
    /// Worth knowing.
    Info,
    /// May become a fault, or is one in some systems.
    Warning,
    /// Something went wrong.
    Error,
}

impl Severity {
    /// All severities, the worst first.
    pub const ALL: [Self; 3] = [Self::Error, Self::Warning, Self::Info];

    /// The name in JSON and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// One fault of one node, of the bus or of the capture, with all its occurrences.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The rule that reported the finding.
    pub rule: &'static Metadata,
    /// The severity of the rule, or a lower one.
    pub severity: Severity,
    /// The rank of the rule, or a higher one.
    pub rank: Rank,
    /// The node concerned; `None` for findings about the bus or the capture.
    pub node: Option<NodeId>,
    /// The channel; `None` for findings about a whole capture.
    pub channel: Option<ChannelId>,
    /// The index of the file, for findings about a whole capture.
    pub source: Option<usize>,
    /// Time of the first occurrence.
    pub first: Timestamp,
    /// Time of the last occurrence.
    pub last: Timestamp,
    /// A number that distinguishes kinds of findings of one rule, such as an error code.
    pub kind: u64,
    /// The object concerned, if the rule distinguishes findings by object.
    pub object: Option<Multiplexer>,
    /// Begin and end of the first occurrences, at most [`Finding::WINDOWS`].
    pub windows: Vec<(Timestamp, Timestamp)>,
    /// All occurrences, near ones together.
    pub occurrences: Occurrences,
    /// The node that causes the finding, if it is not the concerned node.
    pub origin: Option<NodeId>,
    /// Number of occurrences.
    pub count: u64,
    /// The case of a conformance run during which the problem first occurred.
    pub case: Option<CaseName>,
    /// The event, described for the worst occurrence. Text from the bus in it has its control characters escaped.
    pub message: String,
    /// The frames that prove the first and the worst occurrence. At most [`Finding::EVIDENCE`].
    pub evidence: Vec<Exhibit>,
}

impl Finding {
    /// Maximum number of frames of evidence.
    pub const EVIDENCE: usize = 8;
    /// Maximum number of occurrences kept with begin and end.
    pub const WINDOWS: usize = 32;
}

/// A frame that proves a finding, or a place in a capture.
#[derive(Clone, Debug)]
pub struct Exhibit {
    /// Time of the frame.
    pub time: Timestamp,
    /// The place of the frame in the source.
    pub place: Place,
    /// The frame; `None` if there is no frame at the place.
    pub record: Option<Record>,
    /// The decoded frame as text.
    pub text: String,
}
