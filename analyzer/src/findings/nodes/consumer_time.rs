use crate::findings::effect::{Effect, MONITORING, SETTLE, SOON};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, Service};
use crate::object;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Duration;

/// Effects: reactions of the consumer.
const EFFECTS: &[Effect] = &[
    Effect::on(&["emcy/raised"]).of_same_node().with_codes(MONITORING).during(SOON, SETTLE),
    Effect::on(&["nodes/state-lost"]).of_same_node().during(SOON, SETTLE),
];

/// a heartbeat consumer time is missed
///
/// The capture, or the device configuration that was given for it, shows that a node consumes the heartbeat of another
/// node (1016h), and that heartbeat is absent for longer than the consumer time, or does not return. Monitoring begins
/// with the first heartbeat. Silence because of a reset or boot-up is not reported.
///
/// # Why
/// The consumer detects a heartbeat event: it sends EMCY 8130h and leaves operational, unless 1029h demands otherwise.
///
/// # What to do
/// Set the consumer time to at least one and a half times the producer time. If it is that long, find out why the
/// producer was silent.
#[rule(
    id = "nodes/consumer-time",
    severity = Error,
    rank = Participants,
    services = [Heartbeat, BootUp, Nmt],
    also = EndedTransfers,
    leads_to = EFFECTS
)]
struct ConsumerTime {
    /// The heartbeat consumers of each node, with their consumer times.
    consumers: PerNode<Consumers>,
    /// Number of all consumers.
    count: usize,
    /// Whether the description or the stored parameters of a node have been read.
    known: PerNode<bool>,
    last: PerNode<Option<Seen>>,
}

#[derive(Clone, Copy)]
struct Consumer {
    node: NodeId,
    time: Duration,
    /// Whether the current silence was reported.
    told: bool,
}

/// The consumers of one node's heartbeat.
#[derive(Default)]
struct Consumers {
    list: Vec<Consumer>,
    /// The shortest consumer time of the consumers without a report: before this time there is nothing to check.
    patience: Option<Duration>,
}

impl Consumers {
    fn changed(&mut self) {
        self.patience = self.list.iter().filter(|consumer| !consumer.told).map(|consumer| consumer.time).min();
    }

    fn forget(&mut self) {
        if self.list.is_empty() {
            return;
        }
        self.list.iter_mut().for_each(|consumer| consumer.told = false);
        self.changed();
    }
}

impl ConsumerTime {
    /// Maximum number of consumers: 127 producers for each of 127 nodes.
    const MOST: usize = 127 * 127;

    /// Takes over the current entries of a node's 1016h.
    fn configure(&mut self, node: NodeId, scene: &Scene<'_>) {
        self.known[node] = true;
        if self.count > 0 {
            for consumers in self.consumers.values_mut() {
                let before = consumers.list.len();
                consumers.list.retain(|consumer| consumer.node != node);
                self.count -= before - consumers.list.len();
                consumers.changed();
            }
        }
        let Some(known) = scene.bus.node(node) else { return };
        // A description gives only the default, and no device is delivered with a consumer switched on; a device
        // configuration file gives the real value.
        let entries = |sub: u8| known.parameter(node, Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, sub));
        let most = entries(0).map_or(127, |count| count.min(127) as u8);
        for value in (1..=most).filter_map(entries) {
            let (producer, time) = (NodeId::new((value >> 16) as u8), Duration::from_millis(u64::from(value & 0xFFFF)));
            if let Some(producer) = producer.filter(|_| time > Duration::ZERO && self.count < Self::MOST) {
                let consumers = &mut self.consumers[producer];
                consumers.list.push(Consumer { node, time, told: false });
                consumers.changed();
                self.count += 1;
            }
        }
    }

    /// Reports the consumers whose time is over.
    fn check(&mut self, producer: NodeId, next: Option<&Context<'_>>, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(last) = &self.last[producer] else { return };
        let silence = scene.now.since(last.time());
        let consumers = &mut self.consumers[producer];
        let due = consumers.patience.is_some_and(|patience| silence > patience);
        // The heartbeat that ends a silence completes the text of the report.
        let amends = next.is_some() && consumers.list.iter().any(|consumer| consumer.told);
        if !due && !amends {
            return;
        }
        for consumer in &mut consumers.list {
            if silence <= consumer.time + scene.slack() || consumer.told && next.is_none() {
                continue;
            }
            // The event happens when the consumer time is over, not when it begins.
            let report = Report::at(last.time() + consumer.time)
                .node(consumer.node)
                .origin(producer)
                .until(scene.now)
                .detail(u64::from(producer.raw()));
            let report = if consumer.told { report.amend() } else { report };
            let report = report.measure(silence.nanos()).evidence(last.evidence());
            sink.report(report.evidence(next.map(Context::evidence)), || {
                let time = consumer.time;
                let silent = if next.is_some() { "was silent for" } else { "has been silent for more than" };
                format!("waits {time} for the heartbeat of node {producer}, which {silent} {silence}")
            });
            consumer.told = next.is_none();
        }
        consumers.changed();
    }

    fn forget(&mut self, producer: u8) {
        self.last.reset_named(producer);
        self.consumers.named_mut(producer).for_each(|(_, consumers)| consumers.forget());
    }
}

impl Rule for ConsumerTime {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = context.message() {
            return if context.begins_anew() {
                self.forget(nmt.node);
            };
        }
        let Some(node) = context.node() else { return };
        if !self.known[node] {
            self.configure(node, context.scene);
        }
        match context.decoded.service {
            Service::Sdo
                if context.decoded.object.is_some_and(|object| object.index.0 == object::CONSUMER_HEARTBEAT_TIME) =>
            {
                self.configure(node, context.scene);
            }
            Service::BootUp => {
                self.configure(node, context.scene);
                self.forget(node.raw());
            }
            Service::Heartbeat => {
                if !context.scene.facts.node(node).is_storing(context.now()) {
                    self.check(node, Some(context), context.scene, sink);
                }
                self.last[node] = Some(context.seen());
            }
            _ => {}
        }
    }

    fn tick(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        if self.count == 0 {
            return;
        }
        for producer in NodeId::all() {
            let facts = scene.facts.node(producer);
            if !facts.is_storing(scene.now) && !facts.is_resetting(scene.now) {
                self.check(producer, None, scene, sink);
            }
        }
    }

    fn interrupted(&mut self) {
        self.forget(0);
    }
}
