use crate::findings::rule::{Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::{Message, Service};
use crate::wire::emcy::EmcyCode;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Emcy, Service::BootUp],
    make: Some(|_| Box::new(Raised { nodes: vec![Vec::new(); 128] })),
};

static METADATA: Metadata = Metadata {
    id: "emcy/raised",
    severity: Severity::Error,
    title: "a node reports an error",
    what: "An EMCY with an error code. Findings are told apart by code; each says how long the error lasted, where the \
           end was reported.",
    why: "The device itself says that something is wrong, inside or on its bus.",
    advice: "The code and the manufacturer's bytes tell the cause; 1003h holds the history. Look at what happened on the \
             bus just before.",
    thresholds: &[],
};

struct Raised {
    /// The errors that are present, by node.
    nodes: Vec<Vec<Seen>>,
}

impl Raised {
    /// A node that reports more different errors than this without any reset is reported as a storm.
    const MOST: usize = 16;
}

impl Rule for Raised {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let open = &mut self.nodes[usize::from(node.raw())];
        if context.decoded.service == Service::BootUp {
            return open.clear();
        }
        let Message::Emcy(emcy) = context.message() else { return };
        let Some(code) = emcy.code() else { return };
        if !code.is_reset() {
            let report = Report::at(context.now()).node(node).detail(u64::from(code.0));
            sink.report(report.evidence(context.evidence()), || format!("EMCY {emcy}"));
            let known = open.iter().any(|seen| self::code(seen) == Some(code));
            if !known && open.len() < Self::MOST {
                open.push(context.seen());
            }
            return;
        }
        // The end of all errors, unless the register says that others remain: then which one it was is not said.
        if emcy.register().is_some_and(|register| register.0 != 0) && open.len() > 1 {
            return;
        }
        for raised in open.drain(..) {
            let Some(code) = self::code(&raised) else { continue };
            let lasted = context.now().since(raised.time());
            let report = Report::at(context.now()).node(node).detail(u64::from(code.0)).amend();
            let report = report.measure(lasted.nanos()).evidence(raised.evidence()).evidence(context.evidence());
            sink.report(report, || {
                let text = match &raised.decoded.message {
                    Message::Emcy(emcy) => emcy.to_string(),
                    _ => code.to_string(),
                };
                format!("EMCY {text}; it lasted {lasted}")
            });
        }
    }
}

fn code(seen: &Seen) -> Option<EmcyCode> {
    match &seen.decoded.message {
        Message::Emcy(emcy) => emcy.code(),
        _ => None,
    }
}
