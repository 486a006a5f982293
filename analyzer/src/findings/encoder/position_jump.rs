use super::operands::{Kind, kind};
use crate::findings::rule::{Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, NodeFacts, Seen, Severity};
use crate::message::{Message, Service};
use crate::{Multiplexer, NodeId};
use canvass_traces::{Duration, Timestamp};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Pdo, Service::Sdo, Service::BootUp, Service::Nmt],
    make: Some(|thresholds| {
        Box::new(PositionJump {
            speed: thresholds.get(&METADATA, "speed"),
            linear_speed: thresholds.get(&METADATA, "linear-speed"),
            resolution: thresholds.get(&METADATA, "resolution"),
            least: thresholds.get(&METADATA, "least"),
            nodes: vec![Axis::default(); 128],
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "encoder/position-jump",
    severity: Severity::Error,
    title: "a position jumps as no shaft can",
    what: "Between two PDOs the position (6004h) changes by more than the highest speed allows in that time. The \
           measuring units per revolution are those of 6001h or 6501h where they are known, else the given resolution is \
           taken; of linear devices 6501h is the length of a step, and without it nothing is said. \
           The end of the range, and the second after a preset, a write of any parameter or a restart are not counted.",
    why: "The device has lost its position for a moment or for good, two devices send on one CAN-ID, or the PDO carries \
          something else than is believed.",
    advice: "If the next position is the old one again, look for electrical disturbance and for a second sender. If it \
             stays, the multi-turn part may be at fault.",
    thresholds: &[
        Threshold { name: "speed", default: 12_000, unit: "rpm", meaning: "the highest speed of the shaft" },
        Threshold {
            name: "linear-speed",
            default: 20_000,
            unit: "mm/s",
            meaning: "the highest speed of a linear device",
        },
        Threshold { name: "resolution", default: 65_536, unit: "", meaning: "units per revolution if not known" },
        Threshold { name: "least", default: 16, unit: "units", meaning: "a smaller jump is not reported" },
    ],
};

struct PositionJump {
    speed: u64,
    linear_speed: u64,
    resolution: u64,
    least: u64,
    nodes: Vec<Axis>,
}

#[derive(Clone, Copy, Default)]
struct Axis {
    last: Option<(u64, Timestamp)>,
    /// 6001h and 6002h, as the trace has shown them.
    per_revolution: Option<u64>,
    range: Option<u64>,
    /// The largest position seen.
    highest: u64,
}

impl Axis {
    /// How far the shaft has turned, the shorter way round if the range is known; at its end if that is likely.
    fn distance(&self, from: u64, to: u64, allowed: u64) -> u64 {
        let direct = from.abs_diff(to);
        match self.range {
            Some(range) if range > from.max(to) => direct.min(range - direct),
            // Where the range ends is not known: a fall from near the highest to near 0 and back may be its end.
            _ if from.max(to).saturating_add(allowed) >= self.highest && from.min(to) <= allowed => 0,
            _ => direct,
        }
    }
}

impl PositionJump {
    /// How far the position can get in a second.
    fn units_a_second(&self, per_revolution: Option<u64>, node: NodeId, context: &Context<'_>) -> u128 {
        // A step of the sensor: of a revolution, or in nanometres.
        let known = context.scene.bus.node(node);
        let step = known.and_then(|known| known.certain(node, Multiplexer::new(0x6501, 0))).map(u64::from);
        match kind(context, node) {
            Some(Kind::Linear) => {
                let millimetres = u128::from(self.linear_speed);
                step.filter(|&step| step > 0).map_or(u128::MAX >> 64, |step| millimetres * 1_000_000 / u128::from(step))
            }
            _ => {
                let units = per_revolution.or(step).unwrap_or(self.resolution);
                u128::from(units) * u128::from(self.speed) / 60
            }
        }
    }

    fn moved(&mut self, position: u64, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let axis = &mut self.nodes[usize::from(node.raw())];
        let last = axis.last.replace((position, context.now()));
        let highest = axis.highest;
        axis.highest = highest.max(position);
        let Some((before, at)) = last else { return };
        let facts = context.scene.facts.node(node);
        if NodeFacts::is_recent(facts.last_download, context.now(), Duration::from_secs(1)) {
            return;
        }
        // PDOs wait for the bus, and recorders for the processor.
        let elapsed = context.now().since(at) + context.scene.slack() + Duration::from_millis(5);
        let per_revolution = axis.per_revolution;
        let a_second = self.units_a_second(per_revolution, node, context);
        let allowed = a_second * u128::from(elapsed.nanos()) / 1_000_000_000;
        let allowed = u64::try_from(allowed).unwrap_or(u64::MAX).max(self.least);
        let axis = &self.nodes[usize::from(node.raw())];
        let known = Axis { highest, ..*axis };
        let distance = known.distance(before, position, allowed);
        if distance > allowed {
            let report = Report::at(context.now()).node(node).measure(distance);
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            sink.report(report, || {
                let within = context.now().since(at);
                format!("from {before} to {position} within {within}: {allowed} units are possible")
            });
        }
    }
}

impl Rule for PositionJump {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match (context.decoded.service, context.message()) {
            (Service::BootUp, _) => {
                if let Some(node) = context.node() {
                    self.nodes[usize::from(node.raw())] = Axis::default();
                }
                return;
            }
            (Service::Nmt, Message::Nmt(_)) if context.begins_anew() => return self.interrupted(),
            _ => {}
        }
        let mut position = None;
        for operand in &context.news().operands {
            let axis = &mut self.nodes[usize::from(operand.node.raw())];
            match operand.object.index.0 {
                0x6004 if context.decoded.service == Service::Pdo => position = Some(operand.raw),
                0x6001 => axis.per_revolution = Some(operand.raw),
                0x6002 => axis.range = Some(if operand.raw == 0 { 1 << 32 } else { operand.raw }),
                _ => {}
            }
        }
        if let Some(position) = position {
            self.moved(position, context, sink);
        }
    }

    fn interrupted(&mut self) {
        self.nodes.iter_mut().for_each(|axis| axis.last = None);
    }
}
