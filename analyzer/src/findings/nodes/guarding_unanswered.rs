use crate::NodeId;
use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, Service};
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Guarding, Service::BootUp, Service::Heartbeat],
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(GuardingUnanswered {
            wait: Duration::from_millis(thresholds.get(&METADATA, "wait")),
            nodes: (0..128).map(|_| None).collect(),
            waits: false,
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "nodes/guarding-unanswered",
    severity: Severity::Error,
    title: "a guarding request gets no answer",
    what: "A remote frame asks for a node's state, and no answer comes in time. The seconds after a store, in which \
           some devices are silent, and those after a reset are not counted.",
    why: "The master declares the node lost. If remote frames do not get through, the node in turn sees a life \
          guarding event.",
    advice: "See whether the node sends anything else. If it does, it may not support guarding (100Ch, 100Dh): use \
             heartbeat. Some CAN controllers answer remote frames by themselves, with an old state.",
    thresholds: &[Threshold { name: "wait", default: 100, unit: "ms", meaning: "time to answer" }],
};

struct GuardingUnanswered {
    wait: Duration,
    nodes: Vec<Option<Seen>>,
    /// Some request may be waiting for its answer.
    waits: bool,
}

impl GuardingUnanswered {
    fn give_up(&mut self, node: NodeId, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(request) = self.nodes[usize::from(node.raw())].take() else { return };
        let facts = scene.facts.node(node);
        if !facts.is_storing(scene.now) && !facts.is_resetting(scene.now) {
            let report = Report::at(request.time()).node(node).evidence(request.evidence());
            sink.report(report, || format!("no answer within {}", self.wait));
        }
    }
}

impl Rule for GuardingUnanswered {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        if *context.message() == Message::GuardingRequest {
            if let Some(open) = &self.nodes[usize::from(node.raw())]
                && context.now().since(open.time()) > self.wait + context.scene.slack()
            {
                self.give_up(node, context.scene, sink);
            }
            self.nodes[usize::from(node.raw())].get_or_insert_with(|| context.seen());
            self.waits = true;
        } else {
            self.nodes[usize::from(node.raw())] = None;
        }
    }

    fn tick(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        if !self.waits {
            return;
        }
        let limit = self.wait + scene.slack();
        for node in NodeId::all() {
            let open = self.nodes[usize::from(node.raw())].as_ref();
            if open.is_some_and(|open| scene.now.since(open.time()) > limit) {
                self.give_up(node, scene, sink);
            }
        }
        self.waits = self.nodes.iter().any(Option::is_some);
    }

    fn interrupted(&mut self) {
        self.nodes.fill_with(|| None);
    }
}
