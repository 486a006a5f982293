use crate::findings::rule::{Also, Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::{Message, Service};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Guarding, Service::BootUp, Service::Nmt],
    also: Also::Nothing,
    make: Some(|_| Box::new(GuardingToggle { nodes: vec![None; 128], asked: vec![false; 128] })),
};

static METADATA: Metadata = Metadata {
    id: "nodes/guarding-toggle",
    severity: Severity::Error,
    title: "the toggle bit of guarding does not alternate",
    what: "Two guarding answers in a row, each to a request of its own, have the same toggle bit, without a reset \
           between them.",
    why: "The master takes the answer for an old one and may declare the node lost. Usually a CAN controller answers \
          by itself from a buffer that the firmware has not renewed.",
    advice: "A fault of the device, unless two masters guard the same node: then each sees every other answer.",
    thresholds: &[],
};

struct GuardingToggle {
    nodes: Vec<Option<bool>>,
    asked: Vec<bool>,
}

impl Rule for GuardingToggle {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if context.decoded.service == Service::Nmt {
            // A reset sets the bit back; which commands do, devices disagree about.
            if context.begins_anew() {
                self.nodes.fill(None);
            }
            return;
        }
        let Some(node) = context.node() else { return };
        let at = usize::from(node.raw());
        match context.message() {
            Message::GuardingRequest => self.asked[at] = true,
            _ if context.decoded.service == Service::BootUp => self.nodes[at] = None,
            Message::ErrorControl(message) => {
                let asked = std::mem::take(&mut self.asked[at]);
                if self.nodes[at] == Some(message.toggle) && asked {
                    let report = Report::at(context.now()).node(node);
                    let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
                    sink.report(report, || format!("toggle bit {} twice in a row", u8::from(message.toggle)));
                }
                // An answer that nobody was seen to ask for may be a heartbeat.
                self.nodes[at] = asked.then_some(message.toggle);
            }
            _ => {}
        }
    }

    fn interrupted(&mut self) {
        self.nodes.fill(None);
        self.asked.fill(false);
    }
}
