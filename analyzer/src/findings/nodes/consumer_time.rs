use crate::NodeId;
use crate::findings::rule::{Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::Service;
use crate::network::Event;
use crate::network::sdo::Outcome;
use canvass_traces::{Duration, Timestamp};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Heartbeat, Service::BootUp, Service::Nmt, Service::Sdo],
    make: Some(|_| Box::new(ConsumerTime { consumers: Vec::new(), last: vec![None; 128] })),
};

static METADATA: Metadata = Metadata {
    id: "nodes/consumer-time",
    severity: Severity::Error,
    title: "a heartbeat consumer time is missed",
    what: "The capture shows that a node consumes the heartbeat of another (1016h), and that heartbeat stays away for \
           longer than the consumer time. Where a reset or boot-up is the reason, nothing is said.",
    why: "The consumer sees a heartbeat event: it sends EMCY 8130h and, unless 1029h says otherwise, leaves \
          operational.",
    advice: "The consumer time should be at least one and a half times the producer time. If it is, find out why the \
             producer was silent.",
    thresholds: &[],
};

struct ConsumerTime {
    /// Who consumes whose heartbeat, and how long it waits.
    consumers: Vec<Consumer>,
    last: Vec<Option<Timestamp>>,
}

#[derive(Clone, Copy)]
struct Consumer {
    node: NodeId,
    sub: u8,
    producer: u8,
    time: Duration,
}

impl ConsumerTime {
    /// 127 producers for each of 127 consumers.
    const MOST: usize = 127 * 127;

    fn configured(&mut self, context: &Context<'_>) {
        let Some(node) = context.node() else { return };
        let Some(transfer) = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel)) else {
            return;
        };
        let (object, Some(value)) = (transfer.multiplexer, transfer.data().first_chunk::<4>()) else { return };
        if object.index.0 != 0x1016 || object.sub.0 == 0 || transfer.outcome != Outcome::Complete {
            return;
        }
        let value = u32::from_le_bytes(*value);
        let (producer, time) = ((value >> 16) as u8, Duration::from_millis(u64::from(value & 0xFFFF)));
        self.consumers.retain(|consumer| (consumer.node, consumer.sub) != (node, object.sub.0));
        if time > Duration::ZERO && producer < 128 && self.consumers.len() < Self::MOST {
            self.consumers.push(Consumer { node, sub: object.sub.0, producer, time });
        }
    }
}

impl Rule for ConsumerTime {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match context.decoded.service {
            Service::Sdo if context.decoded.event == Some(Event::TransferEnded) => return self.configured(context),
            Service::Heartbeat => {}
            Service::Nmt => return self.last.fill(None),
            Service::BootUp => {
                if let Some(node) = context.node() {
                    self.consumers.retain(|consumer| consumer.node != node);
                    self.last[usize::from(node.raw())] = None;
                }
                return;
            }
            _ => return,
        }
        let Some(producer) = context.node() else { return };
        let Some(last) = self.last[usize::from(producer.raw())].replace(context.now()) else { return };
        let silence = context.now().since(last);
        for consumer in self.consumers.iter().filter(|consumer| consumer.producer == producer.raw()) {
            if silence > consumer.time + context.scene.slack() {
                let report = Report::at(last).node(consumer.node).detail(u64::from(producer.raw()));
                let report = report.measure(silence.nanos()).evidence(context.previous.map(Seen::evidence));
                sink.report(report.evidence(context.evidence()), || {
                    let time = consumer.time;
                    format!("waits {time} for the heartbeat of node {producer}, which was silent for {silence}")
                });
            }
        }
    }

    fn interrupted(&mut self) {
        self.last.fill(None);
    }
}
