use crate::PerNode;
use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::{Message, Service};
use crate::wire::error_control::State;
use canvass_macros::rule;

/// Effects: messages that show the entered state.
const EFFECTS: &[Effect] = &[Effect::on(&["nodes/pdo-outside-operational", "pdo/sync-pdo-missing"]).of_same_node()];

/// a node leaves operational by itself
///
/// Heartbeats or guarding answers show that a node which was operational is now in another state, without an NMT
/// command or a boot-up in between.
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
    nodes: PerNode<Option<State>>,
}

impl Rule for StateLost {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = context.message() {
            if !context.begins_anew() {
                return;
            }
            self.nodes.reset_named(nmt.node);
            return;
        }
        if let (Some(node), Service::BootUp) = (context.node(), context.decoded.service) {
            self.nodes[node] = None;
            return;
        }
        let (Some(node), Message::ErrorControl(message)) = (context.node(), context.message()) else { return };
        let known = &mut self.nodes[node];
        let before = known.replace(message.state);
        let known_states = [State::STOPPED, State::PRE_OPERATIONAL];
        if before == Some(State::OPERATIONAL) && known_states.contains(&message.state) {
            let report = Report::at(context.now()).node(node).detail(u64::from(message.state.0));
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            sink.report(report, || format!("from operational to {} without a command", message.state));
        }
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
    }
}
