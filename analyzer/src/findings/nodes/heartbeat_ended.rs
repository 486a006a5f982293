use crate::PerNode;
use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use canvass_macros::rule;
use canvass_traces::Duration;

/// Effects: consumers that miss the heartbeat.
const EFFECTS: &[Effect] = &[Effect::on(&["nodes/consumer-time"]).of_origin()];

/// a node's heartbeat ends and does not come back
///
/// The capture continues for several periods after the last heartbeat of a node, without a reset command, and with
/// other nodes still sending.
///
/// # Why
/// The node was switched off, was disconnected from the bus, or hangs.
///
/// # What to do
/// Check the last frames of the node, error frames around that time, and the supply of the node.
#[rule(id = "nodes/heartbeat-ended", severity = Error, rank = Loss, services = [Heartbeat], leads_to = EFFECTS)]
struct HeartbeatEnded {
    /// least number of missing heartbeats at the end
    #[threshold(count = 3, min = 1)]
    periods: u64,
    latest: PerNode<Option<Seen>>,
}

impl Rule for HeartbeatEnded {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if let Some(node) = context.node() {
            self.latest[node] = Some(context.seen());
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, rhythm) in scene.facts.heartbeats.all() {
            let seen = self.latest[node].as_ref();
            let (Some(seen), Some(period)) = (seen, rhythm.period()) else { continue };
            let (last, silence) = (seen.time(), scene.now.since(seen.time()));
            let is_late = silence > period.times(self.periods) + scene.slack() + Duration::from_millis(10);
            let facts = scene.facts.node(node);
            // A device without boot-up message need not send after a reset.
            let is_lost = scene.facts.outage(node, scene.now).is_some();
            if !is_late || is_lost || facts.has_moved || facts.is_resetting(scene.now) || facts.is_storing(scene.now) {
                continue;
            }
            let report = Report::at(last).node(node).evidence(seen.evidence());
            sink.report(report, || {
                let also = match facts.last_seen.map(|seen| scene.now.since(seen)) {
                    Some(since) if since <= period.times(self.periods) => "; it still sends other messages",
                    _ => "; nor has it sent anything else lately",
                };
                format!("no heartbeat for the last {silence} of the capture, its period is {period}{also}")
            });
        }
    }
}
