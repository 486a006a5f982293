use crate::PerNode;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, Service};
use crate::network::OpenErrors;
use canvass_analyzer_macros::rule;
use canvass_traces::Duration;

/// an error is still present when the capture ends
///
/// A node has reported an error by EMCY, and neither the end of the error (code 00xxh) nor a restart follows.
///
/// # Why
/// Either the error is still there, or the device does not report its end, as CiA 301 wants.
///
/// # What to do
/// Read 1001h and 1003h of the node: if 1001h is 0, the error is gone and its end was not reported.
#[rule(id = "emcy/never-cleared", severity = Warning, services = [Emcy, BootUp])]
struct NeverCleared {
    nodes: PerNode<OpenErrors<Seen>>,
}

impl Rule for NeverCleared {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let errors = &mut self.nodes[node];
        match context.message() {
            _ if context.decoded.service == Service::BootUp => errors.clear(),
            Message::Emcy(emcy) => {
                errors.handle(emcy, || context.seen());
            }
            _ => {}
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, errors) in self.nodes.iter() {
            for (code, seen) in errors.iter() {
                let Message::Emcy(emcy) = &seen.decoded.message else { continue };
                let report = Report::at(seen.time())
                    .node(node)
                    .detail(u64::from(code.0))
                    .kind(u64::from(code.0))
                    .evidence(seen.evidence());
                sink.report(report, || match scene.now.since(seen.time()) {
                    Duration::ZERO => format!("EMCY {emcy}, with which the capture ends"),
                    later => format!("EMCY {emcy}, still present {later} later at the end"),
                });
            }
        }
    }
}
