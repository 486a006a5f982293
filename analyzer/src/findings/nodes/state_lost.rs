use crate::findings::effect::{Effect, Rank};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, Service};
use crate::wire::error_control::State;
use crate::wire::nmt::{Command, Nmt};
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// Effects: messages that show the entered state.
const EFFECTS: &[Effect] = &[Effect::on(&["nodes/pdo-outside-operational", "pdo/sync-pdo-missing"]).of_same_node()];

/// a node leaves operational by itself
///
/// Heartbeats or guarding answers show that a node which was operational is now in another state, without an NMT
/// command or a boot-up in between. The finding says how long the node stays away at most; a node that is away for long
/// is as good as lost, and told first. If a node comes back without a command too, the capture may lack the commands, as
/// a recorder that does not see its own frames makes it: the severity is then warning.
///
/// # Why
/// The node has reacted to an error according to 1029h: a heartbeat or guarding event, bus-off, or an internal error.
/// Its process data have stopped.
///
/// # What to do
/// Look for an EMCY of the node just before, and check which heartbeats it consumes (1016h).
#[rule(
    id = "nodes/state-lost",
    severity = Error,
    rank = State,
    services = [Nmt, Heartbeat, Guarding, BootUp],
    leads_to = EFFECTS
)]
struct StateLost {
    /// an absence from operational that is as grave as the loss of the node
    #[threshold(ms = 60_000)]
    long: Duration,
    nodes: PerNode<Option<State>>,
    away: PerNode<Option<Away>>,
    /// The longest absence of each node that has ended.
    longest: PerNode<Duration>,
    /// Whether each node has been away without coming back by an unseen command.
    certain: PerNode<bool>,
}

/// A node that has left operational.
#[derive(Clone, Copy)]
struct Away {
    since: Timestamp,
    state: State,
    /// Whether a command to start has come since.
    started: bool,
}

impl StateLost {
    /// The node is operational again. Without a command in the capture that has started it, the command that has stopped
    /// it may be missing too.
    fn returned(&mut self, node: NodeId, now: Timestamp, sink: &mut Sink<'_>) {
        let Some(Away { since, state, started }) = self.away[node] else { return };
        if started {
            return self.back(node, now, "for", sink);
        }
        self.away[node] = None;
        let length = now.since(since);
        if self.certain[node] {
            return;
        }
        let longest = self.longest[node].max(length);
        self.longest[node] = longest;
        let report = Report::at(since).node(node).detail(u64::from(state.0)).measure(length.nanos()).amend();
        sink.report(report.lower_to(Severity::Warning), || {
            format!(
                "from operational to {state} and back within {longest}, both without a command: commands may be \
                 missing in the capture"
            )
        });
    }

    /// Completes the text when the node is operational again, when a command tells the node to leave operational, or
    /// when the capture ends.
    fn back(&mut self, node: NodeId, now: Timestamp, how: &str, sink: &mut Sink<'_>) {
        let Some(Away { since, state, .. }) = self.away[node].take() else { return };
        if !std::mem::replace(&mut self.certain[node], true) {
            self.longest[node] = Duration::ZERO;
        }
        let length = now.since(since);
        if length <= self.longest[node] {
            return;
        }
        self.longest[node] = length;
        let report = Report::at(since).node(node).detail(u64::from(state.0)).measure(length.nanos()).amend();
        let report = if length > self.long { report.rank(Rank::Loss) } else { report };
        sink.report(report, || format!("from operational to {state} without a command, {how} {length}"));
    }

    fn commanded(&mut self, nmt: Nmt, context: &Context<'_>, sink: &mut Sink<'_>) {
        if nmt.command == Command::START {
            self.away.named_mut(nmt.node).filter_map(|row| row.1.as_mut()).for_each(|away| away.started = true);
        } else {
            let named: Vec<NodeId> = self.away.named(nmt.node).filter(|row| row.1.is_some()).map(|row| row.0).collect();
            for node in named {
                self.back(node, context.now(), "until a command changed it after", sink);
            }
        }
        if context.begins_anew() {
            self.nodes.reset_named(nmt.node);
        }
    }
}

impl Rule for StateLost {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = *context.message() {
            return self.commanded(nmt, context, sink);
        }
        let Some(node) = context.node() else { return };
        if context.decoded.service == Service::BootUp {
            self.nodes[node] = None;
            return self.back(node, context.now(), "until its next boot-up after", sink);
        }
        let Message::ErrorControl(message) = *context.message() else { return };
        let before = self.nodes[node].replace(message.state);
        if message.state == State::OPERATIONAL && before != Some(State::OPERATIONAL) {
            return self.returned(node, context.now(), sink);
        }
        let known_states = [State::STOPPED, State::PRE_OPERATIONAL];
        if before == Some(State::OPERATIONAL) && known_states.contains(&message.state) {
            let report = Report::at(context.now()).node(node).detail(u64::from(message.state.0));
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            sink.report(report, || format!("from operational to {} without a command", message.state));
            self.away[node] = Some(Away { since: context.now(), state: message.state, started: false });
        }
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
        self.away.reset();
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for node in NodeId::all() {
            self.back(node, scene.now, "and not back in the remaining", sink);
        }
    }
}
