use crate::PerNode;
use crate::findings::rhythm::Jitter;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene};
use canvass_macros::rule;
use canvass_traces::Duration;

/// heartbeats are irregular
///
/// More than the given share of a node's heartbeats come earlier or later than their period allows. Missing heartbeats
/// are not counted.
///
/// # Why
/// The node's firmware does not keep its period. The same task often sends cyclic PDOs as well.
///
/// # What to do
/// Compare with other nodes: if all are irregular, the cause is the recorder or the bus load. If a single node is
/// irregular, the cause is its firmware.
#[rule(id = "nodes/heartbeat-jitter", severity = Warning, rank = Detail, services = [Heartbeat])]
struct HeartbeatJitter {
    /// deviation from the period, in percent, that counts
    #[threshold(percent = 20)]
    percent: Percent,
    /// share of deviating intervals that is reported
    #[threshold(percent = 10)]
    share: Percent,
    /// a smaller deviation is never counted
    #[threshold(ms = 10)]
    least: Duration,
    nodes: PerNode<Jitter>,
}

impl Rule for HeartbeatJitter {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let (Some(interval), Some(node)) = (context.news().heartbeat, context.node()) else { return };
        let slack = context.scene.slack() + self.least;
        self.nodes[node].count(context.now(), interval, self.percent, slack);
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, jitter) in self.nodes.iter() {
            if let Some(share) = jitter.share().filter(|share| *share > self.share) {
                sink.report(Report::at(jitter.worst_at).node(node), || {
                    format!("{share} of the heartbeats are too early or too late, by at most {}", jitter.worst)
                });
            }
        }
    }
}
