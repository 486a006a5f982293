//! What a rule is: what is said of it, and how it watches a bus.

use super::context::{Context, Scene};
use super::effect::{Effect, Rank};
use super::finding::Severity;
use super::sink::Sink;
use super::source::SourceQuality;
use super::thresholds::{Threshold, Thresholds};
use crate::NodeId;
use crate::message::Service;

/// What is said of a rule. `canvass explain` and the reference page of rules have no other source.
#[derive(Debug)]
pub struct Metadata {
    /// Its id, which never changes, such as `nodes/heartbeat-missing`.
    pub id: &'static str,
    /// The severity of its findings; single findings may be less severe.
    pub severity: Severity,
    /// How grave its findings are for a machine: what is told first.
    pub rank: Rank,
    /// What follows from its findings.
    pub leads_to: &'static [Effect],
    /// Rules from whose findings its own follow, and when: for a rule of a device profile, which no other rule names.
    pub follows: &'static [(&'static str, Effect)],
    /// What it finds, in one line.
    pub title: &'static str,
    /// What exactly is found, and what is not.
    pub what: &'static str,
    /// Why it matters.
    pub why: &'static str,
    /// What to look at next.
    pub advice: &'static str,
    /// What can be set.
    pub thresholds: &'static [Threshold],
}

/// A rule: what is said of it, and how its state is made. `#[rule]` makes it.
#[derive(Debug)]
pub struct Definition {
    /// What is said of it.
    pub metadata: &'static Metadata,
    /// The services whose frames it is shown.
    pub services: &'static [Service],
    /// Frames that it is shown beside these.
    pub also: &'static [Also],
    /// How its state is made.
    pub make: Make,
}

inventory::collect!(Definition);

/// Frames of which only some are worth a rule's while: so that the others cost it nothing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Also {
    /// Those with values of objects of a device profile, be it in a TPDO or an SDO transfer.
    ProfileValues,
    /// TPDOs of whose communication parameters the capture has shown something.
    KnownTpdos,
    /// Those that are about a node which was told to reset itself, and whose boot-up has not come yet.
    Resetting,
    /// Those of a node that has sent nothing for so long that it was lost.
    Returning,
    /// SDO messages that end a transfer.
    EndedTransfers,
    /// SDO messages by which a request is repeated or given up, or that answer one which was given up.
    UnusualRequests,
}

/// Makes a rule's state.
#[derive(Clone, Copy, Debug)]
pub enum Make {
    /// For one bus.
    Bus(fn(&Thresholds) -> Box<dyn Rule>),
    /// For all sources of a capture.
    Capture(fn(&Thresholds) -> Box<dyn CaptureRule>),
    /// None: what it finds, other code reports.
    Nothing,
}

/// A rule's state on one bus. It does no I/O and reads no clock; time is that of the capture.
pub trait Rule {
    /// A frame of one of its services.
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>);

    /// Time has gone on: called at most every [`super::Diagnosis::TICK`], before the frame that shows it.
    fn tick(&mut self, _scene: &Scene<'_>, _sink: &mut Sink<'_>) {}

    /// The parameters of a node's TPDOs may have changed with the frame that comes next, or are known with it.
    fn reconfigured(&mut self, _node: NodeId, _scene: &Scene<'_>) {}

    /// Frames may be missing here, or the clock has stepped: what was waited for may have come unseen.
    fn interrupted(&mut self) {}

    /// The capture has ended.
    fn finish(&mut self, _scene: &Scene<'_>, _sink: &mut Sink<'_>) {}
}

/// A rule about whole captures.
pub trait CaptureRule {
    /// Looks at a source, by its place among those that were read.
    fn check(&self, at: usize, source: &SourceQuality<'_>, sink: &mut Sink<'_>);
}
