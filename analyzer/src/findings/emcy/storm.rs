use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::Service;
use canvass_traces::{Duration, Timestamp};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Emcy],
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(Storm {
            times: thresholds.get(&METADATA, "times").max(1),
            within: Duration::from_millis(thresholds.get(&METADATA, "within")),
            nodes: vec![(Timestamp::ZERO, 0); 128],
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "emcy/storm",
    severity: Severity::Error,
    title: "a node sends EMCY again and again",
    what: "So many EMCY messages of one node within a short time.",
    why: "EMCY has a high priority: a storm delays everything else, and hides which error came first. CiA 301 wants one \
          EMCY for each event.",
    advice: "Set the EMCY inhibit time (1015h) of the node, and look at the first EMCY: the others follow from it.",
    thresholds: &[
        Threshold { name: "times", default: 10, unit: "", meaning: "so many messages" },
        Threshold { name: "within", default: 1000, unit: "ms", meaning: "within this time" },
    ],
};

struct Storm {
    times: u64,
    within: Duration,
    /// The begin of the time that is counted in, and how many came.
    nodes: Vec<(Timestamp, u64)>,
}

impl Rule for Storm {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node().filter(|_| context.scene.has_times()) else { return };
        let (begin, count) = &mut self.nodes[usize::from(node.raw())];
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
