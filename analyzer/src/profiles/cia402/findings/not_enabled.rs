use super::axes::{Axes, FOLLOWS, Word, has_unknown_rpdo, prefix, signs};
use crate::NodeId;
use crate::findings::{Context, Report, Rule, Scene, Seen, Sink};
use crate::message::Service;
use crate::profiles::cia402::state::{Command, State};
use canvass_macros::rule;
use canvass_traces::Duration;

/// a drive does not become operational although it is commanded to
///
/// The controlword (6040h) of an axis has commanded to enable operation for a while, and the statusword (6041h) still
/// shows another state that is not a fault. Only drives whose statusword the capture has shown are judged.
///
/// # Why
/// The axis does not move, and many controllers wait for it without an error.
///
/// # What to do
/// In "switch on disabled" the drive lacks an enable input, the safety input (STO) or the supply of the power stage; or
/// the controller has not sent "shutdown" (06h) first, without which "enable operation" has no effect. In "ready to
/// switch on" and "switched on" check the supply of the power stage, and the mode of operation (6060h).
#[rule(
    id = "drive/not-enabled",
    severity = Warning,
    rank = State,
    services = [BootUp],
    also = ProfileValues,
    follows = FOLLOWS
)]
struct NotEnabled {
    /// time that a drive may take to enable operation
    #[threshold(ms = 3000)]
    wait: Duration,
    axes: Axes<Axis>,
}

#[derive(Default)]
struct Axis {
    state: Option<State>,
    /// The frame with the first controlword that enables operation; `None` once another command came.
    asked: Option<Box<Seen>>,
    /// Whether the drive has enabled operation since this controlword, or the rule has reported it.
    settled: bool,
}

impl Axis {
    fn judge(&mut self, (node, axis): (NodeId, usize), scene: &Scene<'_>, wait: Duration, sink: &mut Sink<'_>) {
        let now = scene.now;
        let (Some(asked), Some(state), false) = (&self.asked, self.state, self.settled) else { return };
        let waited = now.since(asked.time());
        if waited <= wait || state.is_fault() {
            return;
        }
        self.settled = true;
        if has_unknown_rpdo(node, asked.time(), scene) {
            return;
        }
        let report = Report::at(asked.time()).until(now).node(node).detail(axis as u64).measure(waited.nanos());
        sink.report(report.evidence(asked.evidence()), || {
            let hint = match state {
                State::SwitchOnDisabled => ", from which only \"shutdown\" (06h) leads on",
                _ => "",
            };
            format!("{}still {state} {waited} after the command to enable operation{hint}", prefix(axis))
        });
    }
}

impl Rule for NotEnabled {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if context.decoded.service == Service::BootUp {
            if let Some(node) = context.node() {
                self.axes.of(node).for_each(|(_, axis)| *axis = Axis::default());
            }
            return;
        }
        for sign in signs(context) {
            let Some(axis) = self.axes.get(sign.node, sign.axis) else { continue };
            match sign.word {
                Word::Control(word) if Command::of(word) != Command::EnableOperation => {
                    (axis.asked, axis.settled) = (None, false);
                }
                Word::Control(_) if axis.asked.is_none() => {
                    axis.asked = Some(Box::new(context.seen()));
                    axis.settled = axis.state == Some(State::OperationEnabled);
                }
                Word::Control(_) => axis.judge((sign.node, sign.axis), context.scene, self.wait, sink),
                Word::Status(word) => {
                    axis.state = State::of(word);
                    axis.settled |= axis.state == Some(State::OperationEnabled);
                    axis.judge((sign.node, sign.axis), context.scene, self.wait, sink);
                }
                Word::Error(_) => {}
            }
        }
    }

    fn interrupted(&mut self) {
        self.axes.all().for_each(|(.., axis)| *axis = Axis::default());
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let wait = self.wait;
        for (node, axis, entry) in self.axes.all() {
            // A node that is lost has its own finding.
            if scene.facts.node(node).last_seen.is_some_and(|seen| scene.now.since(seen) <= wait) {
                entry.judge((node, axis), scene, wait, sink);
            }
        }
    }
}
