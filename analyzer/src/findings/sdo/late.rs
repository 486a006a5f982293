use super::pending::Step;
use crate::findings::rule::{Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::Service;
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Sdo],
    make: Some(|thresholds| {
        Box::new(Late {
            answer: Duration::from_millis(thresholds.get(&METADATA, "answer")),
            store: Duration::from_millis(thresholds.get(&METADATA, "store")),
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "sdo/late",
    severity: Severity::Warning,
    title: "an SDO server answers late",
    what: "The answer to an SDO request comes later than usual time-outs allow. Storing and restoring parameters may \
           take longer.",
    why: "Many clients give up after 500 ms, repeat the request, and then take the late answer for the answer to the \
          next one.",
    advice: "Compare with the other response times of the node in the statistics. If only some objects are late, they \
             touch slow memory: lengthen the client's time-out for them.",
    thresholds: &[
        Threshold { name: "answer", default: 500, unit: "ms", meaning: "later is late" },
        Threshold { name: "store", default: 5000, unit: "ms", meaning: "later is late for 1010h, 1011h, 1F50h, 1F51h" },
    ],
};

struct Late {
    answer: Duration,
    store: Duration,
}

impl Rule for Late {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Step::Answered(pending) = &context.news().request else { return };
        let limit = if pending.is_store() { self.store } else { self.answer };
        let took = context.now().since(pending.since);
        if took <= limit + context.scene.slack() {
            return;
        }
        let report = Report::at(context.now()).node(context.node()).detail(pending.detail()).measure(took.nanos());
        sink.report(report.evidence(pending.request.evidence()).evidence(context.evidence()), || {
            format!("the answer{} took {took}", pending.about())
        });
    }
}
