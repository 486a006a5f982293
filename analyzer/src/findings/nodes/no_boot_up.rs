use crate::NodeId;
use crate::findings::rule::{Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Severity};
use crate::message::Service;
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Nmt],
    make: Some(|thresholds| Box::new(NoBootUp { wait: Duration::from_millis(thresholds.get(&METADATA, "wait")) })),
};

static METADATA: Metadata = Metadata {
    id: "nodes/no-boot-up",
    severity: Severity::Error,
    title: "a node does not come back after a reset",
    what: "A node that was on the bus is reset by an NMT command, and sends nothing more until the capture ends. A \
           node that sends other messages again but no boot-up is not reported here: old and linear devices have none.",
    why: "The node is not available any more: it hangs in initialisation, has changed its node-ID or bit rate, or its \
          boot-up message never gets through.",
    advice: "Look for a new node-ID on the bus. If there is none, look at the device itself.",
    thresholds: &[Threshold { name: "wait", default: 5000, unit: "ms", meaning: "so long a reset may take" }],
};

struct NoBootUp {
    wait: Duration,
}

impl Rule for NoBootUp {
    fn frame(&mut self, _: &Context<'_>, _: &mut Sink<'_>) {}

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for node in NodeId::all() {
            let facts = scene.facts.node(node);
            let (Some(reset), Some(seen)) = (facts.pending_reset, facts.last_seen) else { continue };
            if seen <= reset + Duration::from_millis(50) && scene.now.since(reset) > self.wait {
                sink.report(Report::at(reset).node(node), || {
                    format!("nothing more was heard in the {} after its reset", scene.now.since(reset))
                });
            }
        }
    }
}
