use crate::findings::rule::{Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::Service;
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Heartbeat],
    make: Some(|thresholds| {
        Box::new(HeartbeatLate {
            percent: thresholds.get(&METADATA, "percent"),
            missing: super::heartbeat_missing::percent(thresholds),
            least: Duration::from_millis(thresholds.get(&METADATA, "least")),
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "nodes/heartbeat-late",
    severity: Severity::Warning,
    title: "a heartbeat comes late",
    what: "A heartbeat comes later than its period and half of it, but none was left out. The period is that of 1017h \
           where the capture shows it, else the one that the node has kept before. Pauses around NMT commands, resets \
           and stores are not counted.",
    why: "A consumer that waits for one and a half or two periods is about to declare the node lost. The node, or the \
          bus, is too busy to send in time.",
    advice: "Look at the bus load at that time, and at what the node was doing. If a heartbeat time is below 20 ms, \
             lengthen it.",
    thresholds: &[
        Threshold { name: "percent", default: 150, unit: "%", meaning: "of the period; later is late" },
        Threshold { name: "least", default: 10, unit: "ms", meaning: "being late by less is not reported" },
    ],
};

struct HeartbeatLate {
    percent: u64,
    missing: u64,
    least: Duration,
}

impl Rule for HeartbeatLate {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(interval) = context.news().heartbeat else { return };
        let slack = context.scene.slack() + self.least;
        let Some(period) = interval.exceeds(self.percent, slack) else { return };
        if interval.misses(self.missing, context.scene.slack()).is_some() {
            return;
        }
        let report = Report::at(context.now()).node(context.node()).measure(interval.length.nanos());
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("a heartbeat after {}, its period is {period}", interval.length));
    }
}
