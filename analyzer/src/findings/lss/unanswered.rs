use super::exchange::{SERVICES, Sender, command, is_store, sender, wants_answer, words};
use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: SERVICES,
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(Unanswered {
            wait: Duration::from_millis(thresholds.get(&METADATA, "wait")),
            store: Duration::from_millis(thresholds.get(&METADATA, "store")),
            open: None,
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "lss/unanswered",
    severity: Severity::Warning,
    title: "an LSS or LMT request gets no answer",
    what: "A request that one slave must answer (configure, store, inquire, the last of a switch selective) is followed \
           by none. Identify and Fastscan are answered only where a slave fits, and LMT is silent when it switches: \
           neither is reported.",
    why: "No slave is in configuration state, or none has the address that was given. The node-ID or bit rate has not \
          changed.",
    advice: "Check the four numbers of the address against the label. LSS works in stopped and pre-operational only \
             with many devices.",
    thresholds: &[
        Threshold { name: "wait", default: 1000, unit: "ms", meaning: "time to answer" },
        Threshold { name: "store", default: 5000, unit: "ms", meaning: "time to answer a store" },
    ],
};

struct Unanswered {
    wait: Duration,
    store: Duration,
    open: Option<Seen>,
}

impl Unanswered {
    fn limit(&self, seen: &Seen) -> Duration {
        if is_store(&seen.decoded.message) { self.store } else { self.wait }
    }

    fn tell(seen: &Seen, why: &str, sink: &mut Sink<'_>) {
        let report = Report::at(seen.time()).detail(u64::from(command(seen))).evidence(seen.evidence());
        sink.report(report, || format!("no answer to \"{}\": {why}", words(&seen.decoded.message)));
    }
}

impl Rule for Unanswered {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match sender(context.message()) {
            Some(Sender::Master) => {
                if let Some(open) = self.open.take() {
                    Self::tell(&open, "the master goes on", sink);
                }
                self.open = wants_answer(context.message()).then(|| context.seen());
            }
            _ => self.open = None,
        }
    }

    fn tick(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(open) = &self.open else { return };
        let limit = self.limit(open);
        if scene.now.since(open.time()) > limit + scene.slack() {
            Self::tell(open, &format!("nothing came within {limit}"), sink);
            self.open = None;
        }
    }

    fn interrupted(&mut self) {
        self.open = None;
    }
}
