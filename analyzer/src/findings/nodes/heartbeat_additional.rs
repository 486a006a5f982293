use crate::PerNode;
use crate::findings::rhythm::Additional;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::{Message, Service};
use crate::wire::error_control::State;
use canvass_macros::rule;

/// a heartbeat comes beside the regular ones
///
/// A period of the heartbeat is divided into two unequal parts by a heartbeat that does not show a new state. Nodes that
/// report a change of their state at once are not reported.
///
/// # Why
/// The node sends a heartbeat twice, or a second device with the same node-ID sends now and then.
///
/// # What to do
/// Compare the data and the times of both heartbeats. If it happens again and again, look for a second device with this
/// node-ID.
#[rule(id = "nodes/heartbeat-additional", severity = Warning, rank = Detail, services = [Heartbeat, BootUp, Nmt])]
struct HeartbeatAdditional {
    nodes: PerNode<Beating>,
}

/// The heartbeats of a node.
#[derive(Clone, Copy, Default)]
struct Beating {
    additional: Additional,
    /// The last two states, the later one last.
    states: [Option<State>; 2],
}

impl Rule for HeartbeatAdditional {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = context.message() {
            return self.nodes.named_mut(nmt.node).for_each(|(_, beating)| *beating = Beating::default());
        }
        let (Some(node), Message::ErrorControl(message)) = (context.node(), context.message()) else { return };
        let beating = &mut self.nodes[node];
        if context.decoded.service != Service::Heartbeat {
            *beating = Beating::default();
            return;
        }
        let [earlier, before] = beating.states;
        beating.states = [before, Some(message.state)];
        let Some(interval) = context.news().heartbeat else { return beating.additional.restart() };
        let divided = beating.additional.beat(interval);
        // A node that reports a new state at once keeps the new state.
        let is_back = earlier == Some(message.state) && before.is_some();
        let Some((first, second)) = divided.filter(|_| is_back) else { return };
        let report = Report::at(context.now()).node(node);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || {
            format!("heartbeats after {first} and after {second}, which together are a period: one more than regular")
        });
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
    }
}
