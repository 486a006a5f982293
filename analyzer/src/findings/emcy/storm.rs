use crate::PerNode;
use crate::findings::Context;
use crate::findings::effect::{Effect, SOON};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// Effects of a storm: the messages in it, and the load of the bus.
const EFFECTS: &[Effect] = &[
    Effect::on(&["emcy/raised", "emcy/contradiction", "emcy/never-cleared"]).of_same_node(),
    Effect::on(&["bus/load"]).spanning(SOON),
];

/// a node sends EMCY again and again
///
/// A node sends many EMCY messages within a short time.
///
/// # Why
/// EMCY has a high priority: a storm delays all other messages, and hides which error came first. CiA 301 demands one
/// EMCY for each event.
///
/// # What to do
/// Set the EMCY inhibit time (1015h) of the node, and check the first EMCY: it causes the others.
#[rule(id = "emcy/storm", severity = Error, rank = DeviceError, services = [Emcy], leads_to = EFFECTS)]
struct Storm {
    /// least number of messages
    #[threshold(count = 10, min = 1)]
    times: u64,
    /// time within which the messages come
    #[threshold(ms = 1000)]
    within: Duration,
    /// The begin of the counted time, and the number of messages in it.
    nodes: PerNode<(Timestamp, u64)>,
}

impl Rule for Storm {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node().filter(|_| context.scene.has_times()) else { return };
        let (begin, count) = &mut self.nodes[node];
        if *count == 0 || context.now().since(*begin) > self.within {
            (*begin, *count) = (context.now(), 0);
        }
        *count += 1;
        if *count >= self.times {
            let (count, within) = (*count, context.now().since(*begin));
            sink.report(Report::at(*begin).node(node).measure(count).evidence(context.evidence()), || {
                format!("{count} EMCY messages within {within}")
            });
        }
    }
}
