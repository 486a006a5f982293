//! What a rule found.

use super::rule::Metadata;
use crate::statistics::CaseName;
use crate::{Multiplexer, NodeId};
use canvass_traces::{ChannelId, Place, Record, Timestamp};
use std::fmt;

/// How bad a finding is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Severity {
    /// Worth knowing.
    Info,
    /// Will become a fault, or is one in some systems.
    Warning,
    /// Something went wrong.
    Error,
}

impl Severity {
    /// All, the worst first.
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

/// One fault of one node, or of the bus or the capture, however often it was seen.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The rule that found it.
    pub rule: &'static Metadata,
    /// How bad it is: the rule's severity, or less.
    pub severity: Severity,
    /// The node that it is about; `None` where it is about the bus or the capture.
    pub node: Option<NodeId>,
    /// The channel; `None` where it is about a whole capture.
    pub channel: Option<ChannelId>,
    /// The file, where it is about a whole capture: its place among those read.
    pub source: Option<usize>,
    /// When it was first seen.
    pub first: Timestamp,
    /// When it was last seen.
    pub last: Timestamp,
    /// What tells kinds of the same rule apart that are worth telling apart, such as a code.
    pub kind: u64,
    /// The object that it is about, where findings are distinguished by that.
    pub object: Option<Multiplexer>,
    /// When it was under way, of the first times: at most [`Finding::WINDOWS`].
    pub windows: Vec<(Timestamp, Timestamp)>,
    /// The node that it comes from, where that is another one than it is about.
    pub origin: Option<NodeId>,
    /// How often it was seen.
    pub count: u64,
    /// The case of a conformance run that was under way when it was first seen.
    pub case: Option<CaseName>,
    /// What happened: of several times the worst. It may hold text that came off the bus, with control characters
    /// escaped.
    pub message: String,
    /// The frames that prove it: of the first time, and of the worst. At most [`Finding::EVIDENCE`].
    pub evidence: Vec<Exhibit>,
}

impl Finding {
    /// How many frames of evidence are kept.
    pub const EVIDENCE: usize = 8;
    /// How many times are kept with their begin and end.
    pub const WINDOWS: usize = 32;
}

/// A frame that proves a finding, or only a place in a capture.
#[derive(Clone, Debug)]
pub struct Exhibit {
    /// When it was seen.
    pub time: Timestamp,
    /// Where it stands in its source.
    pub place: Place,
    /// The frame; `None` where something stands there that is none.
    pub record: Option<Record>,
    /// What it means.
    pub text: String,
}
