use super::life_guarding::life_time;
use crate::findings::rhythm::{Additional, Rhythm};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen};
use crate::message::{Message, Service};
use crate::{NodeId, PerNode};
use canvass_macros::rule;

/// the master no longer guards a node, or guards it once more
///
/// The guarding requests (remote frames) to a node had a period. Then they stay away until the capture ends, for many periods.
/// The node has answered the last request and sends no heartbeat, and no NMT command to it explains the silence. If the life
/// time of the node is known, nodes/life-guarding judges the silence instead. The rule also reports an additional request
/// within a period.
///
/// # Why
/// A node with a life time (100Ch multiplied by 100Dh) detects a life guarding event, and may leave operational. The master
/// does not notice when the node fails.
///
/// # What to do
/// See what the master did at this time. If a request is additional, look for a second master, such as a configuration tool.
#[rule(id = "nodes/guarding-ended", severity = Info, rank = State, services = [Guarding, Nmt, BootUp])]
struct GuardingEnded {
    /// a silence beyond this share of the period is reported
    #[threshold(percent = 1000)]
    percent: Percent,
    nodes: PerNode<Option<Box<Guarded>>>,
}

/// The guarding requests to a node.
struct Guarded {
    rhythm: Rhythm,
    additional: Additional,
    last: Seen,
    answered: bool,
}

impl GuardingEnded {
    fn asked(&mut self, node: NodeId, context: &Context<'_>, sink: &mut Sink<'_>) {
        let slot = &mut self.nodes[node];
        let guarded = slot.get_or_insert_with(|| {
            let (rhythm, additional) = Default::default();
            Box::new(Guarded { rhythm, additional, last: context.seen(), answered: false })
        });
        let interval = guarded.rhythm.beat(context.now());
        let before = std::mem::replace(&mut guarded.last, context.seen());
        guarded.answered = false;
        let Some((first, second)) = interval.and_then(|interval| guarded.additional.beat(interval)) else { return };
        let report = Report::at(context.now()).node(node).detail(1);
        sink.report(report.evidence(before.evidence()).evidence(context.evidence()), || {
            let period = first + second;
            format!("a guarding request more: after {first} and after {second}, while the others come every {period}")
        });
    }

    /// Forgets the requests to a node, or to all nodes (0): its master begins anew.
    fn forget(&mut self, node: u8) {
        self.nodes.named_mut(node).for_each(|(_, slot)| *slot = None);
    }
}

impl Rule for GuardingEnded {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match (context.message(), context.node()) {
            (Message::Nmt(nmt), _) => self.forget(nmt.node),
            (Message::GuardingRequest, Some(node)) => self.asked(node, context, sink),
            (_, Some(node)) if context.decoded.service == Service::BootUp => self.forget(node.raw()),
            (_, Some(node)) => {
                if let Some(guarded) = &mut self.nodes[node] {
                    guarded.answered = true;
                }
            }
            _ => {}
        }
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, guarded) in self.nodes.iter().filter_map(|(node, slot)| Some((node, slot.as_deref()?))) {
            let Some(period) = guarded.rhythm.learned().filter(|_| guarded.answered) else { continue };
            let silence = scene.now.since(guarded.last.time());
            let has_heartbeat = scene.facts.heartbeats.of(node).period().is_some();
            // The rule nodes/life-guarding reports a node that monitors its master.
            let is_told = life_time(node, scene).is_some();
            if has_heartbeat || is_told || silence <= self.percent.of(period) + scene.slack() {
                continue;
            }
            let report = Report::at(guarded.last.time()).until(scene.now).node(node);
            sink.report(report.evidence(guarded.last.evidence()), || {
                format!("no guarding request for the last {silence} of the capture; before it came every {period}")
            });
        }
    }
}
