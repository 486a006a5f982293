use crate::NodeId;
use crate::findings::rhythm::Jitter;
use crate::findings::rule::{Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Severity};
use crate::message::Service;
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Heartbeat],
    make: Some(|thresholds| {
        Box::new(HeartbeatJitter {
            percent: thresholds.get(&METADATA, "percent"),
            share: thresholds.get(&METADATA, "share"),
            least: Duration::from_millis(thresholds.get(&METADATA, "least")),
            nodes: vec![Jitter::default(); 128],
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "nodes/heartbeat-jitter",
    severity: Severity::Warning,
    title: "heartbeats are irregular",
    what: "More than a share of a node's heartbeats come earlier or later than their period allows. Missing ones are \
           not counted.",
    why: "The node's firmware does not keep its own times. The same task often sends cyclic PDOs too.",
    advice: "Compare with other nodes: if all are irregular, the recorder or the bus load is the reason. If a single \
             one is, its firmware is.",
    thresholds: &[
        Threshold { name: "percent", default: 20, unit: "%", meaning: "of the period that an interval may be off" },
        Threshold { name: "least", default: 10, unit: "ms", meaning: "being off by less is never counted" },
        Threshold { name: "share", default: 10, unit: "%", meaning: "of the intervals may be off" },
    ],
};

struct HeartbeatJitter {
    percent: u64,
    share: u64,
    least: Duration,
    nodes: Vec<Jitter>,
}

impl Rule for HeartbeatJitter {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let (Some(interval), Some(node)) = (context.news().heartbeat, context.node()) else { return };
        let slack = context.scene.slack() + self.least;
        self.nodes[usize::from(node.raw())].count(context.now(), interval, self.percent, slack);
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, jitter) in NodeId::all().zip(self.nodes.iter().skip(1)) {
            if let Some(share) = jitter.share().filter(|share| *share > self.share) {
                sink.report(Report::at(jitter.worst_at).node(node), || {
                    format!("{share} % of the heartbeats are too early or too late, by at most {}", jitter.worst)
                });
            }
        }
    }
}
