use crate::findings::effect::SOON;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, PdoNumber};
use crate::wire::error_control::State;
use crate::wire::nmt::Command;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Duration;

/// a node is stopped and never started again
///
/// An operational node is told by an NMT command to stop or to enter pre-operational, obeys, and is not started again
/// until the capture ends, while other nodes stay operational and it still sends messages itself. The TPDOs that ended
/// with the command are named. A machine whose nodes are stopped one after the other is switched off: if only one node
/// is left in operational, it is the master, and nothing is reported.
///
/// # Why
/// The node looks alive, as its heartbeat goes on, but takes part in nothing any more: its PDOs have ended, and
/// consumers work with their last values.
///
/// # What to do
/// See why the NMT master has sent the command: an error of the node just before, an operator, or a program that stops
/// one node and forgets to start it. NMT commands do not name their sender; a tool that is connected to the bus may have
/// sent it too.
#[rule(id = "nodes/left-stopped", severity = Warning, rank = State, services = [Nmt])]
struct LeftStopped {
    /// a shorter time until the end of the capture is not reported
    #[threshold(ms = 5000)]
    least: Duration,
    nodes: PerNode<Option<Box<Stop>>>,
}

/// A command that has stopped a node.
struct Stop {
    command: Seen,
    expected: State,
    /// The TPDOs that came until the command.
    pdos: Vec<(u16, String)>,
}

impl Stop {
    /// The numbers of the TPDOs that go on although the node should have stopped; TPDOs that were queued don't count.
    fn goes_on(&self, node: NodeId, scene: &Scene<'_>) -> Vec<u16> {
        const QUEUED: Duration = Duration::from_millis(100);
        let from = self.command.time() + QUEUED;
        let rows = scene.facts.streams.all().filter(|row| row.0 == node);
        rows.filter(|row| row.2.last.is_some_and(|last| last > from)).map(|row| row.1).collect()
    }
}

/// The TPDOs that a node has sent until now, with their periods as far as they are known.
fn pdos(node: NodeId, scene: &Scene<'_>) -> Vec<(u16, String)> {
    let lately = Duration::from_secs(2);
    let rows = scene.facts.streams.all().filter(|row| row.0 == node);
    let rows = rows.filter(|row| row.2.last.is_some_and(|last| scene.now.since(last) <= lately));
    let name = |number: u16, period: Option<Duration>| {
        let period = period.map(|period| format!(" (every {period})")).unwrap_or_default();
        format!("{}{period}", PdoNumber::Transmit(number))
    };
    rows.map(|(_, number, stream)| (number, name(number, stream.period()))).collect()
}

impl LeftStopped {
    /// Whether nodes go on while others are stopped. If several nodes were told to stop and a single one operates, that
    /// one is the master: the machine is switched off, one node after the other.
    fn others_go_on(&self, operating: usize, scene: &Scene<'_>) -> bool {
        let stops = || self.nodes.iter().filter_map(|(_, stop)| stop.as_deref());
        let several = stops().nth(1).is_some();
        let lately = |stop: &Stop| scene.now.since(stop.command.time()) <= self.least;
        // The next node may be about to be stopped.
        let goes_on_stopping = several && stops().any(lately);
        operating > usize::from(several) && !goes_on_stopping
    }
}

impl Rule for LeftStopped {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let Message::Nmt(nmt) = *context.message() else { return };
        let stops = matches!(nmt.command, Command::STOP | Command::ENTER_PRE_OPERATIONAL);
        let Some(expected) = nmt.command.state() else { return };
        for (node, stop) in self.nodes.named_mut(nmt.node) {
            let was_operational = context.scene.facts.node(node).operational;
            match stop {
                // The command that follows a stop at once changes nothing for the PDOs.
                Some(stop) if stops => stop.expected = expected,
                None if stops && was_operational => {
                    let pdos = pdos(node, context.scene);
                    *stop = Some(Box::new(Stop { command: context.seen(), expected, pdos }));
                }
                _ if !stops => *stop = None,
                _ => {}
            }
        }
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let state = |node: NodeId| scene.bus.node(node).and_then(|known| known.state).map(|state| state.0);
        let lives = |node: NodeId| {
            let seen = scene.facts.node(node).last_seen;
            seen.is_some_and(|seen| scene.now.since(seen) <= self.least)
        };
        let operates =
            |node: &NodeId| self.nodes[*node].is_none() && state(*node) == Some(State::OPERATIONAL) && lives(*node);
        let other_operates = self.others_go_on(NodeId::all().filter(operates).count(), scene);
        for (node, stop) in self.nodes.iter() {
            let Some(stop @ Stop { command, expected, pdos }) = stop.as_deref() else { continue };
            let lasted = scene.now.since(command.time());
            // The rule nodes/pdo-outside-operational reports a node that goes on sending.
            if !stop.goes_on(node, scene).is_empty() {
                continue;
            }
            // A node that was operational in between was started by a command that the capture does not show.
            let restarted = scene.facts.node(node).last_operational.is_some_and(|at| at > command.time() + SOON);
            let obeys = state(node) == Some(*expected) && lives(node) && other_operates && !restarted;
            if lasted <= self.least || !obeys {
                continue;
            }
            let report = Report::at(command.time()).until(scene.now).node(node).evidence(command.evidence());
            sink.report(report, || {
                let pdos: Vec<&str> = pdos.iter().map(|(_, name)| name.as_str()).collect();
                let pdos =
                    if pdos.is_empty() { String::new() } else { format!("; ended with it: {}", pdos.join(", ")) };
                format!(
                    "{expected} by an NMT command, and not started again in the {lasted} until the capture ends{pdos}"
                )
            });
        }
    }
}
