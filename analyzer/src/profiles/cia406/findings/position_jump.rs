use super::node::{kind, operands};
use crate::findings::Operand;
use crate::findings::{Context, NodeFacts, Report, Rule, Scene, Seen, Sink};
use crate::message::{Message, Service};
use crate::profiles::cia406::kind::Kind;
use crate::profiles::cia406::objects;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a position changes faster than the shaft can move
///
/// Between two PDOs the position (6004h, or 6020h of the first channel) changes by more than the highest speed allows
/// in that time. The measuring units per revolution are the value of 6001h or 6501h if known, otherwise the threshold
/// `resolution`. On linear devices 6501h is the length of a step, and the description gives the unit of 6020h; without
/// these values the rule reports nothing. Jumps at the end of the range, and within a second after a preset, a write of
/// any parameter or a restart, are not counted.
///
/// # Why
/// The device has lost its position, briefly or permanently, two devices send on one CAN-ID, or the PDO carries another
/// object than assumed.
///
/// # What to do
/// If the next position is the old position again, look for electrical disturbance and for a second sender. If the new
/// position stays, the multi-turn part may be faulty.
#[rule(id = "encoder/position-jump", severity = Error, rank = Detail, services = [BootUp, Nmt], also = ProfileValues)]
struct PositionJump {
    /// highest possible speed of the shaft
    #[threshold(count = 12_000, unit = "rpm")]
    speed: u64,
    /// highest possible speed of a linear device
    #[threshold(count = 20_000, unit = "mm/s")]
    linear_speed: u64,
    /// units per revolution, if neither 6001h nor 6501h is known
    #[threshold(count = 65_536)]
    resolution: u64,
    /// a smaller jump is not reported
    #[threshold(count = 16, unit = "units")]
    least: u64,
    nodes: PerNode<Axis>,
}

#[derive(Clone, Copy, Default)]
struct Axis {
    last: Option<(u64, Timestamp)>,
    /// 6001h and 6002h, as shown in the trace.
    per_revolution: Option<u64>,
    range: Option<u64>,
    /// The largest position seen.
    highest: u64,
    /// The largest possible movement in a second, if computed already.
    a_second: Option<u64>,
}

impl Axis {
    /// The distance between two positions, the shorter way round if the range is known, or if the end of the range is
    /// likely.
    fn distance(&self, from: u64, position: &Operand, allowed: u64) -> u64 {
        let (to, direct) = (position.raw, from.abs_diff(position.raw));
        match self.range {
            // The range of a draw-wire encoder's channel is its number of bits: slightly below zero the position is
            // near the largest value.
            _ if is_channel(position) => {
                let whole = 1_u64.checked_shl(u32::from(position.bits)).unwrap_or(0);
                direct.min(whole.wrapping_sub(direct))
            }
            Some(range) if range > from.max(to) => direct.min(range - direct),
            // If the range is unknown, a jump between nearly the highest position and nearly 0 may be its end.
            _ if from.max(to).saturating_add(allowed) >= self.highest && from.min(to) <= allowed => 0,
            _ => direct,
        }
    }
}

/// Whether the value is the position of one channel (6020h) of an encoder with several.
const fn is_channel(position: &Operand) -> bool {
    position.object.index.0 == objects::CHANNEL_POSITION_VALUES
}

/// More than any number of units.
const NO_LIMIT: u64 = u64::MAX;

impl PositionJump {
    /// The largest possible movement in a second, in units.
    fn units_a_second(&self, position: &Operand, per_revolution: Option<u64>, context: &Context<'_>) -> u64 {
        let node = position.node;
        let known = context.scene.bus.node(node);
        let linear = |millimetres: f64| (self.linear_speed as f64 / millimetres) as u64;
        if is_channel(position) {
            let described = known.and_then(|known| known.device.as_deref());
            let annotated = || described?.manual.annotations.get(position.object)?.unit.clone();
            let unit = known.and_then(|known| known.scale(node, position.object)).or_else(annotated);
            return match unit.filter(|unit| unit.factor > 0.0) {
                Some(unit) if unit.symbol == "mm" => linear(unit.factor),
                Some(unit) if unit.symbol == "°" => (self.speed as f64 * 6.0 / unit.factor) as u64,
                _ => NO_LIMIT,
            };
        }
        // A step of the sensor: a part of a revolution, or a length in nanometres.
        let step = || {
            known
                .and_then(|known| known.certain(node, Multiplexer::new(objects::SINGLE_TURN_RESOLUTION, 0)))
                .map(u64::from)
        };
        match kind(context, node) {
            Some(Kind::Linear) => step().filter(|&step| step > 0).map_or(NO_LIMIT, |step| linear(step as f64 / 1e6)),
            _ => {
                let units = per_revolution.or_else(step).unwrap_or(self.resolution);
                units.saturating_mul(self.speed) / 60
            }
        }
    }

    /// The result of [`Self::units_a_second`], kept until one of its inputs is shown again.
    #[cold]
    fn work_out(&mut self, position: &Operand, context: &Context<'_>) -> u64 {
        let node = position.node;
        let a_second = self.units_a_second(position, self.nodes[node].per_revolution, context);
        // The unit of a channel may change at any time.
        self.nodes[node].a_second = Some(a_second).filter(|_| !is_channel(position));
        a_second
    }

    fn moved(&mut self, position: &Operand, context: &Context<'_>, sink: &mut Sink<'_>) {
        let node = position.node;
        let axis = &mut self.nodes[node];
        let last = axis.last.replace((position.raw, context.now()));
        let before_this = *axis;
        axis.highest = axis.highest.max(position.raw);
        // Small movements are always allowed.
        let moved = last.filter(|(before, _)| before.abs_diff(position.raw) > self.least);
        let Some((before, at)) = moved else { return };
        let facts = context.scene.facts.node(node);
        if NodeFacts::is_recent(facts.last_download, context.now(), Duration::from_secs(1)) {
            return;
        }
        // PDOs wait for the bus, and recorders for the processor, so the interval may be longer than measured.
        let elapsed = context.now().since(at) + context.scene.slack() + Duration::from_millis(5);
        let a_second = before_this.a_second.unwrap_or_else(|| self.work_out(position, context));
        // The allowed movement, in billionths of a unit.
        let allowed = u128::from(a_second) * u128::from(elapsed.nanos());
        // The direct distance is the longest, and usually short enough; this saves the slower division.
        if u128::from(before.abs_diff(position.raw)) * 1_000_000_000 <= allowed {
            return;
        }
        let allowed = u64::try_from(allowed / 1_000_000_000).unwrap_or(u64::MAX).max(self.least);
        let distance = before_this.distance(before, position, allowed);
        if distance > allowed {
            let report = Report::at(context.now()).node(node).measure(distance);
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            sink.report(report, || {
                let within = context.now().since(at);
                format!("from {before} to {} within {within}: {allowed} units are possible", position.raw)
            });
        }
    }
}

impl Rule for PositionJump {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match (context.decoded.service, context.message()) {
            (Service::BootUp, _) => {
                if let Some(node) = context.node() {
                    self.nodes[node] = Axis::default();
                }
                return;
            }
            (Service::Nmt, Message::Nmt(_)) if context.begins_anew() => return self.interrupted(),
            _ => {}
        }
        let mut position = None;
        for operand in operands(context) {
            let axis = &mut self.nodes[operand.node];
            match operand.object.index.0 {
                objects::POSITION_VALUE if context.decoded.service == Service::Pdo => position = Some(operand),
                // Only the first of several channels is checked.
                objects::CHANNEL_POSITION_VALUES if context.decoded.service == Service::Pdo => {
                    position = position.or(Some(operand));
                }
                objects::UNITS_PER_REVOLUTION => (axis.per_revolution, axis.a_second) = (Some(operand.raw), None),
                objects::SINGLE_TURN_RESOLUTION => axis.a_second = None,
                objects::TOTAL_MEASURING_RANGE => {
                    axis.range = Some(if operand.raw == 0 { 1 << 32 } else { operand.raw });
                }
                _ => {}
            }
        }
        if let Some(position) = position {
            self.moved(position, context, sink);
        }
    }

    fn reconfigured(&mut self, node: NodeId, _: &Scene<'_>) {
        // The kind of encoder may be known from now on.
        self.nodes[node].a_second = None;
    }

    fn interrupted(&mut self) {
        self.nodes.values_mut().for_each(|axis| axis.last = None);
    }
}
