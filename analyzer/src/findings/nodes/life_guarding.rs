use crate::findings::effect::{Effect, MONITORING, SETTLE, SOON};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen};
use crate::message::{Message, Service};
use crate::object;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Duration;

/// Effects: reactions of the node.
const EFFECTS: &[Effect] = &[
    Effect::on(&["emcy/raised"]).of_same_node().with_codes(MONITORING).during(SOON, SETTLE),
    Effect::on(&["nodes/state-lost"]).of_same_node().during(SOON, SETTLE),
];

/// a guarded node is not asked for its state in time
///
/// The master has begun to guard a node and then sends the next guarding request too late or not at all, although other
/// frames continue. The rule needs the life time of the node (100Ch multiplied by 100Dh), from the capture or from
/// read-only objects of the description. Monitoring begins with the first request and ends with a reset.
///
/// # Why
/// The node detects a life guarding event: it sends EMCY 8130h (or 1000h), and many devices leave operational.
///
/// # What to do
/// Check whether the master was stopped, or guards with a period longer than the life time of the node; 100Ch and 100Dh
/// must fit the master's guarding. A master that uses heartbeat instead should set 100Ch to 0.
#[rule(
    id = "nodes/life-guarding",
    severity = Error,
    rank = Participants,
    services = [Guarding, BootUp, Heartbeat, Nmt],
    leads_to = EFFECTS
)]
struct LifeGuarding {
    /// an interval beyond this share of the life time is reported
    #[threshold(percent = 110, min = 1)]
    percent: Percent,
    nodes: PerNode<Option<Guarded>>,
    /// Whether any node may be guarded.
    guards: bool,
}

/// The state of a guarded node.
struct Guarded {
    request: Seen,
    told: bool,
}

/// The guard time, and its factor.
const GUARD_TIME: Multiplexer = Multiplexer::new(object::GUARD_TIME, 0);
const LIFE_TIME_FACTOR: Multiplexer = Multiplexer::new(object::LIFE_TIME_FACTOR, 0);

/// The life time of a node; `None` if it is unknown, or the node does not monitor its master.
pub(super) fn life_time(node: NodeId, scene: &Scene<'_>) -> Option<Duration> {
    let known = scene.bus.node(node)?;
    let (guard, factor) = (known.certain(node, GUARD_TIME)?, known.certain(node, LIFE_TIME_FACTOR)?);
    let life = Duration::from_millis(u64::from(guard & 0xFFFF) * u64::from(factor & 0xFF));
    (life > Duration::ZERO).then_some(life)
}

impl LifeGuarding {
    /// Reports the node once if its life time is over.
    fn check(&mut self, node: NodeId, next: Option<&Seen>, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(guarded) = &mut self.nodes[node] else { return };
        let silence = scene.now.since(guarded.request.time());
        // Most nodes were asked a moment ago: computing the life time is worthwhile for long silences only.
        if guarded.told && next.is_none() || silence < Duration::from_millis(20) {
            return;
        }
        let Some(life) = life_time(node, scene) else { return };
        if silence <= self.percent.of(life) + scene.slack() {
            return;
        }
        let report = Report::at(guarded.request.time() + life).until(scene.now).node(node).measure(silence.nanos());
        // The next request shows the length of the silence.
        let report = if std::mem::replace(&mut guarded.told, true) { report.amend() } else { report };
        let report = report.evidence(guarded.request.evidence()).evidence(next.map(Seen::evidence));
        sink.report(report, || match next {
            Some(_) => format!("not asked for its state for {silence}; its life time is {life}"),
            None => format!("no longer asked for its state, for more than its life time of {life}"),
        });
    }

    fn forget(&mut self, node: u8) {
        self.nodes.reset_named(node);
    }
}

impl Rule for LifeGuarding {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match (context.decoded.service, context.message()) {
            (_, Message::Nmt(nmt)) if nmt.command.is_reset() => self.forget(nmt.node),
            // A node that sends heartbeats is not guarded.
            (Service::BootUp | Service::Heartbeat, _) => self.forget(context.node().map_or(0, NodeId::raw)),
            (_, Message::GuardingRequest) => {
                let Some(node) = context.node() else { return };
                let seen = context.seen();
                self.check(node, Some(&seen), context.scene, sink);
                self.nodes[node] = Some(Guarded { request: seen, told: false });
                self.guards = true;
            }
            _ => {}
        }
    }

    fn tick(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        if !self.guards {
            return;
        }
        for node in NodeId::all() {
            if self.nodes[node].is_some() {
                self.check(node, None, scene, sink);
            }
        }
    }

    fn interrupted(&mut self) {
        self.forget(0);
    }
}
