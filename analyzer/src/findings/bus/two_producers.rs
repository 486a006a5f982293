use super::interleaving::Interleaving;
use crate::findings::rule::{Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::{Message, Service};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Sync, Service::Nmt],
    make: Some(|_| Box::new(TwoProducers::default())),
};

static METADATA: Metadata = Metadata {
    id: "bus/two-producers",
    severity: Severity::Error,
    title: "two nodes produce SYNC",
    what: "The intervals between SYNC messages alternate between a long and a short one, again and again, or counters \
           of two series are mixed: there are two producers with the same period.",
    why: "Everything synchronous happens twice in a cycle, and at changing distances. Devices whose synchronous window \
          is short drop their PDOs.",
    advice: "Read 1005h of all nodes: bit 30 must be set in one only. A configuration tool that was left connected is \
             a frequent second producer.",
    thresholds: &[],
};

#[derive(Default)]
struct TwoProducers {
    interleaving: Interleaving,
}

impl Rule for TwoProducers {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if !matches!(context.message(), Message::Sync(_)) {
            self.interleaving.restart();
            return;
        }
        let Some((a, b)) = self.interleaving.beat(context.now(), context.scene.slack()) else { return };
        let report = Report::at(context.now());
        let report = report.evidence(context.previous.map(|seen| seen.evidence())).evidence(context.evidence());
        sink.report(report, || format!("SYNC comes after {a} and after {b} in turn: two producers of {}", a + b));
    }

    fn interrupted(&mut self) {
        self.interleaving.restart();
    }
}
