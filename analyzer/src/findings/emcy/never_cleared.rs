use crate::NodeId;
use crate::findings::rule::{Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, Service};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Emcy, Service::BootUp],
    make: Some(|_| Box::new(NeverCleared { nodes: (0..128).map(|_| None).collect() })),
};

static METADATA: Metadata = Metadata {
    id: "emcy/never-cleared",
    severity: Severity::Warning,
    title: "an error is still present when the capture ends",
    what: "A node has reported an error by EMCY, and neither the end of the error (code 00xxh) nor a restart follows.",
    why: "Either the error is still there, or the device does not report its end, as CiA 301 wants.",
    advice: "Read 1001h and 1003h of the node: if 1001h is 0, the error is gone and its end was not reported.",
    thresholds: &[],
};

struct NeverCleared {
    /// The latest error of each node.
    nodes: Vec<Option<Seen>>,
}

impl Rule for NeverCleared {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let present = match context.message() {
            Message::Emcy(emcy) if context.decoded.service == Service::Emcy => match emcy.code() {
                Some(code) => !code.is_reset(),
                None => return,
            },
            _ => false,
        };
        self.nodes[usize::from(node.raw())] = present.then(|| context.seen());
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, seen) in NodeId::all().zip(self.nodes.iter().skip(1)) {
            let Some(seen) = seen else { continue };
            let Message::Emcy(emcy) = &seen.decoded.message else { continue };
            sink.report(Report::at(seen.time()).node(node).evidence(seen.evidence()), || {
                format!("EMCY {emcy}, still present {} later at the end", scene.now.since(seen.time()))
            });
        }
    }
}
