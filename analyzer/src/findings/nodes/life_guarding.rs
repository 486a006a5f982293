use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, Service};
use crate::{Multiplexer, NodeId};
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Guarding, Service::BootUp, Service::Heartbeat, Service::Nmt],
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(LifeGuarding {
            percent: thresholds.get(&METADATA, "percent").max(1),
            nodes: (0..128).map(|_| None).collect(),
            guards: false,
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "nodes/life-guarding",
    severity: Severity::Error,
    title: "a guarded node is not asked for its state in time",
    what: "The capture, or what the description says of objects that can't be written, shows the life time of a node \
           (100Ch times 100Dh), the master has begun to guard it, and then asks it for its state too late or not at all, \
           although other frames go on. Monitoring begins with the first request and ends with a reset.",
    why: "The node sees a life guarding event: it sends EMCY 8130h (or 1000h), and many leave operational.",
    advice: "See whether the master was stopped or guards at a time that is longer than the node's life time; 100Ch and \
             100Dh must fit the master's guarding. A master that uses heartbeat instead should set 100Ch to 0.",
    thresholds: &[Threshold { name: "percent", default: 110, unit: "%", meaning: "of the life time; later is lost" }],
};

struct LifeGuarding {
    percent: u64,
    nodes: Vec<Option<Guarded>>,
    /// Some node may be guarded.
    guards: bool,
}

/// A node that is being guarded.
struct Guarded {
    request: Seen,
    told: bool,
}

/// The guard time, and by what it is multiplied.
const GUARD_TIME: Multiplexer = Multiplexer::new(0x100C, 0);
const LIFE_TIME_FACTOR: Multiplexer = Multiplexer::new(0x100D, 0);

/// The life time of a node; `None` where it is not known, or the node does not watch its master.
fn life_time(node: NodeId, scene: &Scene<'_>) -> Option<Duration> {
    let known = scene.bus.node(node)?;
    let (guard, factor) = (known.certain(node, GUARD_TIME)?, known.certain(node, LIFE_TIME_FACTOR)?);
    let life = Duration::from_millis(u64::from(guard & 0xFFFF) * u64::from(factor & 0xFF));
    (life > Duration::ZERO).then_some(life)
}

impl LifeGuarding {
    /// Reports the node once if it waits for too long.
    fn check(&mut self, node: NodeId, next: Option<&Seen>, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(guarded) = &mut self.nodes[usize::from(node.raw())] else { return };
        let silence = scene.now.since(guarded.request.time());
        // Most nodes were asked a moment ago: only then is it worth looking for the life time.
        if guarded.told && next.is_none() || silence < Duration::from_millis(20) {
            return;
        }
        let Some(life) = life_time(node, scene) else { return };
        if silence <= Duration(life.nanos().saturating_mul(self.percent) / 100) + scene.slack() {
            return;
        }
        let report = Report::at(guarded.request.time() + life).node(node).measure(silence.nanos());
        // When the next request comes, it is known how long it took.
        let report = if std::mem::replace(&mut guarded.told, true) { report.amend() } else { report };
        let report = report.evidence(guarded.request.evidence()).evidence(next.map(Seen::evidence));
        sink.report(report, || match next {
            Some(_) => format!("not asked for its state for {silence}; its life time is {life}"),
            None => format!("not asked for its state any more, for more than its life time of {life}"),
        });
    }

    fn forget(&mut self, node: u8) {
        match self.nodes.get_mut(usize::from(node)) {
            Some(guarded) if node != 0 => *guarded = None,
            _ if node == 0 => self.nodes.fill_with(|| None),
            _ => {}
        }
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
                self.nodes[usize::from(node.raw())] = Some(Guarded { request: seen, told: false });
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
            if self.nodes[usize::from(node.raw())].is_some() {
                self.check(node, None, scene, sink);
            }
        }
    }

    fn interrupted(&mut self) {
        self.forget(0);
    }
}
