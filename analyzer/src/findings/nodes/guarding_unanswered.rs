use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::Message;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Duration;

/// a guarding request gets no answer
///
/// A node does not answer a guarding request (remote frame) in time. The seconds after a store, in which some devices
/// are silent, and the seconds after a reset are not counted.
///
/// # Why
/// The master declares the node lost. If remote frames do not reach the node, the node in turn detects a life guarding
/// event.
///
/// # What to do
/// A node that sends other messages may not support guarding (100Ch, 100Dh): use heartbeat.
/// Some CAN controllers answer remote frames by themselves, with an old state.
#[rule(id = "nodes/guarding-unanswered", severity = Error, rank = State, services = [Guarding, BootUp, Heartbeat])]
struct GuardingUnanswered {
    /// timeout for an answer
    #[threshold(ms = 100)]
    wait: Duration,
    nodes: PerNode<Option<Seen>>,
    /// Whether any request is unanswered.
    waits: bool,
}

impl GuardingUnanswered {
    fn give_up(&mut self, node: NodeId, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(request) = self.nodes[node].take() else { return };
        let facts = scene.facts.node(node);
        if !facts.is_storing(scene.now) && !facts.is_resetting(scene.now) {
            let report = Report::at(request.time()).node(node).evidence(request.evidence());
            let lives = facts.last_seen.is_some_and(|seen| seen > request.time());
            let also = if lives { ", although the node sends other messages" } else { "" };
            sink.report(report, || format!("no answer within {}{also}", self.wait));
        }
    }
}

impl Rule for GuardingUnanswered {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        if *context.message() == Message::GuardingRequest {
            if let Some(open) = &self.nodes[node]
                && context.now().since(open.time()) > self.wait + context.scene.slack()
            {
                self.give_up(node, context.scene, sink);
            }
            self.nodes[node].get_or_insert_with(|| context.seen());
            self.waits = true;
        } else {
            self.nodes[node] = None;
        }
    }

    fn tick(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        if !self.waits {
            return;
        }
        let limit = self.wait + scene.slack();
        for node in NodeId::all() {
            let open = self.nodes[node].as_ref();
            if open.is_some_and(|open| scene.now.since(open.time()) > limit) {
                self.give_up(node, scene, sink);
            }
        }
        self.waits = self.nodes.iter().any(|(_, open)| open.is_some());
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
    }
}
