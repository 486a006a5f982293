use super::axes::{Axes, FOLLOWS, Word, prefix, signs};
use crate::NodeId;
use crate::dictionary::names::ErrorName;
use crate::findings::{Context, Effect, Report, Rule, SETTLE, SOON, Scene, Seen, Sink};
use crate::message::Service;
use crate::profiles::cia402::NUMBER;
use crate::profiles::cia402::state::{Command, State};
use crate::wire::emcy::EmcyCode;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// Effects: a drive in fault follows no command.
const EFFECTS: &[Effect] =
    &[Effect::on(&["drive/not-enabled", "drive/left-operation"]).of_same_node().during(SOON, SETTLE)];

/// a drive is in fault
///
/// The statusword (6041h) of an axis, in a PDO or read by SDO, shows "fault" or "fault reaction active". The finding says
/// from which state, how long it lasts, whether a reset was tried (a rising edge of bit 7 of the controlword, 6040h), and
/// the error code (603Fh) if the capture shows it. A fault that the drive has at its first statusword is reported too.
///
/// # Why
/// The drive has switched its power off and follows no set-point, until the fault is acknowledged.
///
/// # What to do
/// The error code (603Fh), or the EMCY at the same time, tells the cause. Remove it, then set bit 7 of the controlword
/// from 0 to 1. A reset that has no effect shows that the cause is still present.
#[rule(
    id = "drive/fault",
    severity = Error,
    rank = DeviceError,
    services = [BootUp],
    also = ProfileValues,
    leads_to = EFFECTS,
    follows = FOLLOWS
)]
struct Fault {
    axes: Axes<Axis>,
}

#[derive(Default)]
struct Axis {
    state: Option<State>,
    /// Whether bit 7 of the last controlword is set.
    resets: bool,
    error: Option<u16>,
    fault: Option<Box<Episode>>,
    /// The longest fault that has ended.
    longest: Option<Duration>,
}

/// A fault that is present.
struct Episode {
    since: Timestamp,
    from: Option<State>,
    first: Seen,
    tried: u32,
}

impl Axis {
    fn shown(&mut self, state: State, (node, axis): (NodeId, usize), context: &Context<'_>, sink: &mut Sink<'_>) {
        let before = self.state.replace(state);
        match (state.is_fault(), self.fault.is_some()) {
            (true, false) => {
                let episode = Episode { since: context.now(), from: before, first: context.seen(), tried: 0 };
                let report = report(&episode, node, axis).evidence(context.previous.map(Seen::evidence));
                sink.report(report.evidence(context.evidence()), || format!("{}{}", prefix(axis), episode.begin()));
                self.fault = Some(Box::new(episode));
            }
            (false, true) => self.ended(&format!("then {state}"), (node, axis), context.now(), sink),
            _ => {}
        }
    }

    /// Completes the text at the end of a fault, or of the capture.
    #[cold]
    fn ended(&mut self, how: &str, (node, axis): (NodeId, usize), now: Timestamp, sink: &mut Sink<'_>) {
        let Some(episode) = self.fault.take() else { return };
        let error = self.error.take();
        let lasted = now.since(episode.since);
        if self.longest.is_some_and(|longest| longest >= lasted) {
            return;
        }
        self.longest = Some(lasted);
        let report = report(&episode, node, axis).measure(lasted.nanos()).amend().evidence(episode.first.evidence());
        sink.report(report, || {
            let code = error.filter(|code| *code != 0).map(EmcyCode);
            let code = code.map(|code| format!(", error code {}", ErrorName { code, profile: Some(NUMBER) }));
            let tried = match episode.tried {
                0 => "no reset was tried".to_owned(),
                1 => "a reset was tried once".to_owned(),
                times => format!("a reset was tried {times} times"),
            };
            let code = code.unwrap_or_default();
            format!("{}{}{code}, for {lasted}, {how}; {tried}", prefix(axis), episode.begin())
        });
    }
}

impl Episode {
    fn begin(&self) -> String {
        match self.from {
            Some(state) => format!("from {state} to fault"),
            None => "in fault from the first statusword on".to_owned(),
        }
    }
}

fn report<'e>(episode: &Episode, node: NodeId, axis: usize) -> Report<'e> {
    Report::at(episode.since).node(node).detail(axis as u64)
}

impl Rule for Fault {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if context.decoded.service == Service::BootUp {
            let Some(node) = context.node() else { return };
            for (axis, entry) in self.axes.of(node) {
                entry.ended("until its boot-up", (node, axis), context.now(), sink);
                (entry.state, entry.resets) = (None, false);
            }
            return;
        }
        for sign in signs(context) {
            let place = (sign.node, sign.axis);
            let Some(axis) = self.axes.get(sign.node, sign.axis) else { continue };
            match sign.word {
                Word::Status(word) => {
                    if let Some(state) = State::of(word) {
                        axis.shown(state, place, context, sink);
                    }
                }
                Word::Control(word) => {
                    let resets = Command::of(word) == Command::FaultReset;
                    let rises = resets && !std::mem::replace(&mut axis.resets, resets);
                    axis.resets = resets;
                    if let Some(fault) = axis.fault.as_mut().filter(|_| rises) {
                        fault.tried += 1;
                    }
                }
                Word::Error(code) => axis.error = Some(code),
            }
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, axis, entry) in self.axes.all() {
            entry.ended("and still at the end of the capture", (node, axis), scene.now, sink);
        }
    }
}
