use crate::PerNode;
use crate::findings::rhythm::Additional;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, Service};
use crate::wire::error_control::State;
use canvass_macros::rule;

/// a heartbeat comes beside the regular ones
///
/// A period of the heartbeat is divided into two unequal parts by a heartbeat that does not show a new state, once or
/// a few times; bus/duplicate-node-id reports heartbeats that come like that again and again. Nodes that report a change
/// of their state at once are not reported.
///
/// # Why
/// The node sends a heartbeat twice, or a second device with the same node-ID sends now and then.
///
/// # What to do
/// Compare the data and the times of both heartbeats. If it happens again and again, look for a second device with this
/// node-ID.
#[rule(id = "nodes/heartbeat-additional", severity = Warning, rank = Detail, services = [Heartbeat, BootUp, Nmt])]
struct HeartbeatAdditional {
    /// more are no single ones
    #[threshold(count = 6, min = 1)]
    most: u64,
    nodes: PerNode<Beating>,
    /// The first additional heartbeat of each node, between the ones before and after it, with its text.
    found: PerNode<Option<Box<(Seen, Seen, String)>>>,
}

/// The heartbeats of a node.
#[derive(Clone, Default)]
struct Beating {
    additional: Additional,
    /// The last two states, the later one last.
    states: [Option<State>; 2],
    /// Number of divided periods.
    times: u64,
}

impl Rule for HeartbeatAdditional {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = context.message() {
            return self.nodes.named_mut(nmt.node).for_each(|(_, beating)| beating.restart());
        }
        let (Some(node), Message::ErrorControl(message)) = (context.node(), context.message()) else { return };
        let beating = &mut self.nodes[node];
        if context.decoded.service != Service::Heartbeat {
            return beating.restart();
        }
        let [earlier, before] = beating.states;
        beating.states = [before, Some(message.state)];
        let Some(interval) = context.news().heartbeat else { return beating.additional.restart() };
        let divided = beating.additional.beat(interval);
        // A node that reports a new state at once keeps the new state.
        let is_back = earlier == Some(message.state) && before.is_some();
        let Some((first, second)) = divided.filter(|_| is_back) else { return };
        beating.times += 1;
        if let (None, Some(previous)) = (&self.found[node], context.previous) {
            let text = format!("heartbeats after {first} and after {second}, which together are a period");
            self.found[node] = Some(Box::new((previous.clone(), context.seen(), text)));
        }
    }

    fn interrupted(&mut self) {
        self.nodes.values_mut().for_each(Beating::restart);
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, found) in self.found.iter() {
            let times = self.nodes[node].times;
            let Some((before, after, text)) = found.as_deref().filter(|_| times <= self.most) else { continue };
            let report = Report::at(after.time()).node(node).times(times);
            sink.report(report.evidence(before.evidence()).evidence(after.evidence()), || text.clone());
        }
    }
}

impl Beating {
    /// Begins anew: the next heartbeat may come at any time.
    fn restart(&mut self) {
        *self = Self { times: self.times, ..Self::default() };
    }
}
