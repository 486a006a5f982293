use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity, is_from_node};
use crate::message::Service;
use canvass_traces::{Duration, Timestamp};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[],
    also: Also::Resetting,
    make: Some(|thresholds| {
        Box::new(BeforeBootUp {
            grace: Duration::from_millis(thresholds.get(&METADATA, "grace")),
            within: Duration::from_millis(thresholds.get(&METADATA, "within")),
            early: (0..128).map(|_| None).collect(),
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "bus/before-boot-up",
    severity: Severity::Warning,
    title: "a node sends before its boot-up message",
    what: "After it was reset by an NMT command, a node sends something else (EMCY, heartbeat, PDO, SDO answer) before \
           its boot-up message. A boot-up that comes much later belongs to something else. What comes within the grace time after the command may still have been queued.",
    why: "The boot-up message says that the node has left initialisation. Before it, a master does not listen, so the \
          message is lost on it; an EMCY lost there never comes again.",
    advice: "A fault of the device's firmware: it must send its boot-up message first (CiA 301, NMT slave states).",
    thresholds: &[
        Threshold { name: "grace", default: 100, unit: "ms", meaning: "what may still be queued" },
        Threshold { name: "within", default: 10_000, unit: "ms", meaning: "a later boot-up is not that of the reset" },
    ],
};

struct BeforeBootUp {
    grace: Duration,
    within: Duration,
    /// The first frame since the reset, by node.
    early: Vec<Option<Seen>>,
}

impl Rule for BeforeBootUp {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let reset = context.scene.facts.node(node).pending_reset;
        let early = &mut self.early[usize::from(node.raw())];
        if context.decoded.service != Service::BootUp {
            let is_meant = context.decoded.service != Service::Guarding && is_from_node(context.decoded);
            let Some(reset) = reset.filter(|_| is_meant) else { return };
            if early.is_none() && context.now().since(reset) > self.grace {
                *early = Some(context.seen());
            }
            return;
        }
        let Some(early) = early.take() else { return };
        // It came after the last reset: the one that this boot-up answers, if it is not from much later.
        let answers = |reset: Timestamp| early.time() > reset && context.now().since(reset) <= self.within;
        if reset.is_some_and(answers) {
            let report = Report::at(early.time()).node(node).evidence(early.evidence()).evidence(context.evidence());
            sink.report(report, || {
                let ahead = context.now().since(early.time());
                format!("{} {ahead} before the boot-up message", early.decoded.service)
            });
        }
    }

    fn interrupted(&mut self) {
        self.early.fill_with(|| None);
    }
}
