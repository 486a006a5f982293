//! The interface of a rule: its metadata, and its state on a bus.

use super::context::{Context, Scene};
use super::effect::{Effect, Rank};
use super::finding::Severity;
use super::sink::Sink;
use super::source::SourceQuality;
use super::thresholds::{Threshold, Thresholds};
use crate::NodeId;
use crate::message::Service;

/// The metadata of a rule, the only source of `canvass explain` and the reference page.
#[derive(Debug)]
pub struct Metadata {
    /// The id of the rule, which never changes, such as `nodes/heartbeat-missing`.
    pub id: &'static str,
    /// The severity of the rule's findings; single findings may be less severe.
    pub severity: Severity,
    /// The consequence of the rule's findings for a machine; higher ranks are reported first.
    pub rank: Rank,
    /// Effects of the rule's findings.
    pub leads_to: &'static [Effect],
    /// The rules whose findings cause findings of this rule, each with the effect. Only rules of a device profile have
    /// this list: no other rule names them.
    pub follows: &'static [(&'static str, Effect)],
    /// The problem in one line.
    pub title: &'static str,
    /// The exact condition of a finding, and its exceptions.
    pub what: &'static str,
    /// The reason why the problem matters.
    pub why: &'static str,
    /// The next steps for the user.
    pub advice: &'static str,
    /// The settings of the rule.
    pub thresholds: &'static [Threshold],
}

/// A rule: its metadata, and the constructor of its state. `#[rule]` makes it.
#[derive(Debug)]
pub struct Definition {
    /// The metadata of the rule.
    pub metadata: &'static Metadata,
    /// The services whose frames the rule sees.
    pub services: &'static [Service],
    /// Further frames that the rule sees.
    pub also: &'static [Also],
    /// The constructor of the rule's state.
    pub make: Make,
}

inventory::collect!(Definition);

/// Special frames that a rule asks for, so that all other frames cost the rule nothing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Also {
    /// Frames with values of objects of a device profile, in a TPDO or an SDO transfer.
    ProfileValues,
    /// TPDOs with a parameter that the capture has shown.
    KnownTpdos,
    /// Frames that concern a node which was reset and has not booted yet.
    Resetting,
    /// Frames of a node after a silence that may have been an outage.
    Returning,
    /// SDO messages that end a transfer.
    EndedTransfers,
    /// SDO messages that repeat or abandon a request, or that answer an abandoned one.
    UnusualRequests,
    /// TPDOs with an unusual length, or out of the rhythm that was learned.
    UnusualPdos,
}

/// Constructor of a rule's state.
#[derive(Clone, Copy, Debug)]
pub enum Make {
    /// State for one bus.
    Bus(fn(&Thresholds) -> Box<dyn Rule>),
    /// State for all sources of a capture.
    Capture(fn(&Thresholds) -> Box<dyn CaptureRule>),
    /// No state: other code reports its findings.
    Nothing,
}

/// A rule's state on one bus. It does no I/O and reads no clock; all times come from the capture.
pub trait Rule {
    /// Handles a frame of one of its services.
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>);

    /// Tells that time has advanced: called at most every [`super::Diagnosis::TICK`], before the frame with the
    /// new time.
    fn tick(&mut self, _scene: &Scene<'_>, _sink: &mut Sink<'_>) {}

    /// Tells that the parameters of a node's TPDOs may change, or become known, with the following frame.
    fn reconfigured(&mut self, _node: NodeId, _scene: &Scene<'_>) {}

    /// Tells that frames may be missing here, or the clock has stepped: expected messages may have been missed.
    fn interrupted(&mut self) {}

    /// Tells that the capture has ended.
    fn finish(&mut self, _scene: &Scene<'_>, _sink: &mut Sink<'_>) {}
}

/// A rule about whole captures.
pub trait CaptureRule {
    /// Checks a source, given with its index.
    fn check(&self, at: usize, source: &SourceQuality<'_>, sink: &mut Sink<'_>);
}
