use super::axes::{Axes, FOLLOWS, Word, has_unknown_rpdo, prefix, signs};
use crate::NodeId;
use crate::findings::{Context, NodeFacts, Report, Rule, Seen, Severity, Sink};
use crate::message::Service;
use crate::profiles::cia402::state::{Command, State};
use crate::wire::nmt;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a drive leaves operation without a command
///
/// The statusword (6041h) of an axis goes from "operation enabled" to a state other than fault, although the last
/// controlword (6040h) commands to enable operation, and no NMT command has stopped the node just before. If the capture
/// shows no controlword of the axis, or RPDOs of which the mapping is unknown, or the drive is controlled locally (bit 9
/// of the statusword is 0), the severity is info, as the command may only be invisible.
///
/// # Why
/// The motor is without torque, or stops, while the controller believes that it follows its set-points.
///
/// # What to do
/// "Switch on disabled" is the state after the power stage was switched off: check the enable input, the safety input
/// (STO) and the supply of the power stage. "Quick stop active" comes from a limit switch or an input. If bit 9 (remote)
/// of the statusword is 0, the drive is controlled locally.
#[rule(
    id = "drive/left-operation",
    severity = Error,
    rank = DeviceError,
    services = [BootUp],
    also = ProfileValues,
    follows = FOLLOWS
)]
struct LeftOperation {
    /// time within which an NMT command or a former controlword explains the change
    #[threshold(ms = 5000)]
    settle: Duration,
    axes: Axes<Axis>,
}

#[derive(Clone, Copy, Default)]
struct Axis {
    state: Option<State>,
    /// The last controlword.
    control: Option<u16>,
    /// Time of the last controlword.
    at: Timestamp,
    /// Time of the last controlword that did not enable operation.
    commanded: Option<Timestamp>,
}

/// The bit of the statusword that is 1 while the drive follows the controlword.
const REMOTE: u16 = 1 << 9;

impl LeftOperation {
    /// Whether an NMT command has just taken the node out of operational.
    fn is_stopped(&self, node: NodeId, context: &Context<'_>) -> bool {
        let command = context.scene.facts.node(node).command;
        command.is_some_and(|(command, at)| command != nmt::Command::START && context.now().since(at) <= self.settle)
    }

    fn left(&self, (node, axis): (NodeId, usize), change: (u16, State), context: &Context<'_>, sink: &mut Sink<'_>) {
        let (word, state) = change;
        if self.is_stopped(node, context) {
            return;
        }
        let known = self.axes.peek(node, axis).copied().unwrap_or_default();
        let control = known.control.filter(|_| !has_unknown_rpdo(node, known.at, context.scene));
        let is_local = word & REMOTE == 0;
        let report = Report::at(context.now()).node(node).detail((axis as u64) << 8 | state as u64);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        let report = if control.is_some() && !is_local { report } else { report.severity(Severity::Info) };
        sink.report(report, || {
            let local = if is_local { ", which is controlled locally" } else { "" };
            let control = match control {
                Some(control) => format!("although the controlword {control:04X}h enables operation"),
                None => "and the capture does not show the controlword".to_owned(),
            };
            format!("{}from operation enabled to {state}{local}, {control}", prefix(axis))
        });
    }
}

impl Rule for LeftOperation {
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
                Word::Control(word) => {
                    (axis.control, axis.at) = (Some(word), context.now());
                    if Command::of(word) != Command::EnableOperation {
                        axis.commanded = Some(context.now());
                    }
                }
                Word::Status(word) => {
                    let Some(state) = State::of(word) else { continue };
                    let before = axis.state.replace(state);
                    // A drive may take its time, and the controller may enable it again meanwhile.
                    let is_commanded = axis.control.is_some_and(|word| Command::of(word) != Command::EnableOperation)
                        || NodeFacts::is_recent(axis.commanded, context.now(), self.settle);
                    let leaves = before == Some(State::OperationEnabled) && state != State::OperationEnabled;
                    if leaves && !state.is_fault() && !is_commanded {
                        self.left((sign.node, sign.axis), (word, state), context, sink);
                    }
                }
                Word::Error(_) => {}
            }
        }
    }

    fn interrupted(&mut self) {
        self.axes.all().for_each(|(.., axis)| *axis = Axis::default());
    }
}
