use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::Service;
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Heartbeat],
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(HeartbeatEnded {
            periods: thresholds.get(&METADATA, "periods").max(1),
            latest: (0..128).map(|_| None).collect(),
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "nodes/heartbeat-ended",
    severity: Severity::Error,
    title: "a node's heartbeat ends and does not come back",
    what: "The capture goes on for several periods after the last heartbeat of a node, without a reset command, and \
           with other nodes still sending.",
    why: "The node was switched off, has lost the bus, or hangs.",
    advice: "Look at the last frames of the node, at error frames around that time, and at its supply.",
    thresholds: &[Threshold { name: "periods", default: 3, unit: "", meaning: "so many must be missing at the end" }],
};

struct HeartbeatEnded {
    periods: u64,
    latest: Vec<Option<Seen>>,
}

impl Rule for HeartbeatEnded {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if let Some(node) = context.node() {
            self.latest[usize::from(node.raw())] = Some(context.seen());
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, rhythm) in scene.facts.heartbeats.all() {
            let seen = self.latest[usize::from(node.raw())].as_ref();
            let (Some(seen), Some(period)) = (seen, rhythm.period()) else { continue };
            let (last, silence) = (seen.time(), scene.now.since(seen.time()));
            let is_late = silence > period.times(self.periods) + scene.slack() + Duration::from_millis(10);
            let facts = scene.facts.node(node);
            // A device without boot-up message is not silent after a reset.
            if !is_late || facts.is_resetting(scene.now) || facts.is_storing(scene.now) {
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
