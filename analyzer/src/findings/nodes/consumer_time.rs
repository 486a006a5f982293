use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, Service};
use crate::network::Event;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_analyzer_macros::rule;
use canvass_traces::Duration;

/// a heartbeat consumer time is missed
///
/// The capture, or the device configuration that was given for it, shows that a node consumes the heartbeat of another
/// (1016h), and that heartbeat stays away for longer than the consumer time, or does not come back. Monitoring begins
/// with the first heartbeat. Where a reset or boot-up is the reason, nothing is said.
///
/// # Why
/// The consumer sees a heartbeat event: it sends EMCY 8130h and, unless 1029h says otherwise, leaves operational.
///
/// # What to do
/// The consumer time should be at least one and a half times the producer time. If it is, find out why the producer was
/// silent.
#[rule(id = "nodes/consumer-time", severity = Error, services = [Heartbeat, BootUp, Nmt, Sdo])]
struct ConsumerTime {
    /// Who consumes whose heartbeat, and how long it waits.
    consumers: Vec<Consumer>,
    /// The nodes whose description or stored parameters were looked at.
    known: PerNode<bool>,
    last: PerNode<Option<Seen>>,
}

#[derive(Clone, Copy)]
struct Consumer {
    node: NodeId,
    producer: u8,
    time: Duration,
    /// The silence under way was reported.
    told: bool,
}

impl ConsumerTime {
    /// 127 producers for each of 127 consumers.
    const MOST: usize = 127 * 127;

    /// Takes the entries of 1016h of a node as they are at this moment.
    fn configure(&mut self, node: NodeId, scene: &Scene<'_>) {
        self.known[node] = true;
        self.consumers.retain(|consumer| consumer.node != node);
        let Some(known) = scene.bus.node(node) else { return };
        // A description says only what the default is; nobody delivers a device with a consumer switched on, unless
        // it is a device configuration file.
        let entries = |sub: u8| known.parameter(node, Multiplexer::new(0x1016, sub));
        let most = entries(0).map_or(127, |count| count.min(127) as u8);
        for value in (1..=most).filter_map(entries) {
            let (producer, time) = ((value >> 16) as u8, Duration::from_millis(u64::from(value & 0xFFFF)));
            if time > Duration::ZERO && (1..128).contains(&producer) && self.consumers.len() < Self::MOST {
                self.consumers.push(Consumer { node, producer, time, told: false });
            }
        }
    }

    /// Reports the consumers that have waited for too long.
    fn check(&mut self, producer: NodeId, next: Option<&Context<'_>>, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(last) = &self.last[producer] else { return };
        let silence = scene.now.since(last.time());
        for consumer in self.consumers.iter_mut().filter(|consumer| consumer.producer == producer.raw()) {
            if silence <= consumer.time + scene.slack() || consumer.told && next.is_none() {
                continue;
            }
            let report = Report::at(last.time())
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
    }

    fn forget(&mut self, producer: u8) {
        self.last.reset_named(producer);
        for consumer in self.consumers.iter_mut().filter(|consumer| producer == 0 || consumer.producer == producer) {
            consumer.told = false;
        }
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
            Service::Sdo => {
                let object = context.decoded.object.is_some_and(|object| object.index.0 == 0x1016);
                if object && context.decoded.event == Some(Event::TransferEnded) {
                    self.configure(node, context.scene);
                }
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
        if self.consumers.is_empty() {
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
