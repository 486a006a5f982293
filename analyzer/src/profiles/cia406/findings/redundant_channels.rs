use super::node::{is_encoder, kind, layout, operands};
use crate::dictionary::{DataClass, DataType, Redundancy};
use crate::findings::{Context, NodeFacts, Operand, Report, Rule, Seen, Sink};
use crate::message::{Message, PdoNumber, Service};
use crate::profiles::cia406::kind::Kind;
use crate::profiles::cia406::objects;
use crate::wire::pdo::extract;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Duration;

#[derive(Clone, Copy, Default)]
struct Channels {
    /// The sum of both channels; the difference of channels that change in the same direction.
    sum: i128,
    /// Number of times the sum was the same.
    agreed: u32,
    /// The last value of the first channel, and how often it changed.
    last: i128,
    moved: u32,
}

/// Number of TPDOs of a node that the rule checks.
const TPDOS: usize = 4;

/// the redundant channels of an encoder disagree
///
/// A TPDO of a draw-wire encoder with two redundant channels carries the position (6020h) twice, and the second channel
/// counts down as the first counts up. Their sum was constant, and has changed. The same holds for other objects that
/// the manual calls redundant, such as the angles Z1 and Z2 of an inclinometer: their sum is constant within a full
/// turn, or their difference if the device is set to channels of the same direction. If no mapping is known, two
/// equally long halves of the first TPDO of a linear encoder count as redundant channels if their sum stays constant
/// while they change. The rule learns the sum again after a download to the node.
///
/// # Why
/// One of the two channels is wrong. The values alone do not tell which.
///
/// # What to do
/// Stop relying on this device. Check which of the two channels jumped or froze.
#[rule(id = "encoder/redundant-channels", severity = Error, rank = Detail, services = [Pdo, BootUp])]
struct RedundantChannels {
    /// permitted deviation of the sum, as the channels are sampled one after the other
    #[threshold(count = 20, unit = "units")]
    tolerance: u64,
    nodes: PerNode<[Channels; TPDOS]>,
}

/// Two values of one object in a PDO.
struct Pair {
    values: [i128; 2],
    /// Whether both values change in the same direction.
    is_same: bool,
    /// The raw value of a full turn of an angle.
    turn: Option<u32>,
    /// Whether a mapping proves that the values are channels; else only their place suggests it.
    is_mapped: bool,
}

/// The channels in a TPDO of a node.
fn channels(context: &Context<'_>, node: NodeId, tpdo: u16) -> Option<Pair> {
    match operands(context) {
        [] => {}
        [a, b] => return mapped(context, node, a, b),
        _ => return None,
    }
    if tpdo != 1 || !is_encoder(context, node) || layout(context).is_some() {
        return None;
    }
    // Without a mapping the halves are compared only for linear devices: angles wrap around.
    if kind(context, node) == Some(Kind::Rotary) {
        return None;
    }
    let payload = context.record.frame.data();
    let bits = match payload.len() {
        4 => 16,
        8 => 32,
        _ => return None,
    };
    let half = |n| extract(payload, n * usize::from(bits), bits).map(i128::from);
    Some(Pair { values: [half(0)?, half(1)?], is_same: false, turn: None, is_mapped: false })
}

/// The channels, if a PDO maps one object twice, and the object is known to be redundant.
fn mapped(context: &Context<'_>, node: NodeId, a: &Operand, b: &Operand) -> Option<Pair> {
    // Some devices have a sub-index for each channel of the position, others map one object twice.
    let is_position = [a, b].into_iter().all(|operand| operand.object.index.0 == POSITION);
    if a.bits != b.bits || !(is_position || a.object == b.object) {
        return None;
    }
    let known = context.scene.bus.node(node)?;
    let annotation = known.device.as_deref().and_then(|device| device.manual.annotations.get(a.object));
    let of_manual = annotation.and_then(|annotation| annotation.redundancy);
    let of_profile = is_position.then_some(Redundancy { same_if: None, turn: None });
    let Redundancy { same_if, turn } = of_manual.or(of_profile)?;
    let is_signed = known.data_type(node, a.object).and_then(DataType::class) == Some(DataClass::Integer);
    let number = |of: &Operand| if is_signed { i128::from(of.signed()) } else { i128::from(of.raw) };
    let is_same = same_if.is_some_and(|state| known.is_in(node, state));
    Some(Pair { values: [number(a), number(b)], is_same, turn, is_mapped: true })
}

/// The position of draw-wire encoders, once for each channel.
const POSITION: u16 = objects::CHANNEL_POSITION_VALUES;

impl Pair {
    /// The value that stays the same as long as both channels agree.
    fn sum(&self) -> i128 {
        let [a, b] = self.values;
        self.within_turn(if self.is_same { a - b } else { a + b })
    }

    fn within_turn(&self, value: i128) -> i128 {
        self.turn.map_or(value, |turn| value.rem_euclid(i128::from(turn.max(1))))
    }

    /// The distance of two sums; of angles, the shorter way round.
    fn distance(&self, a: i128, b: i128) -> u64 {
        let ahead = self.within_turn(a - b);
        let distance =
            self.turn.map_or(ahead.unsigned_abs(), |turn| ahead.min(i128::from(turn.max(1)) - ahead).unsigned_abs());
        u64::try_from(distance).unwrap_or(u64::MAX)
    }

    /// The permitted deviation of the sum. The two sensors of an angle differ by up to a degree.
    fn tolerance(&self, of_positions: u64) -> u64 {
        self.turn.map_or(of_positions, |turn| u64::from(turn) / 360)
    }
}

impl RedundantChannels {
    /// Number of PDOs with the same sum after which this sum is the expected one, if the mapping is known.
    const ENOUGH: u32 = 5;
    /// If the mapping is unknown, two halves count as channels after this number of PDOs with the same sum, in which
    /// the first half has changed at least this number of times.
    const SHOWN: u32 = 20;
}

impl Rule for RedundantChannels {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        if context.decoded.service == Service::BootUp {
            self.nodes[node] = Default::default();
        } else if let Message::Pdo(PdoNumber::Transmit(tpdo)) = *context.message()
            && usize::from(tpdo) <= TPDOS
            && let Some(pair) = channels(context, node, tpdo)
        {
            self.compare(node, tpdo, &pair, context, sink);
        }
    }
}

impl RedundantChannels {
    /// Compares the two channels. A function of its own, so that PDOs without two channels cost nothing.
    #[inline(never)]
    fn compare(&mut self, node: NodeId, tpdo: u16, pair: &Pair, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(known) = self.nodes[node].get_mut(usize::from(tpdo).wrapping_sub(1)) else { return };
        // Zero point, direction or mapping may just have been changed.
        let facts = context.scene.facts.node(node);
        if NodeFacts::is_recent(facts.last_download, context.now(), Duration::from_secs(1)) {
            *known = Channels::default();
        }
        let ([a, b], sum) = (pair.values, pair.sum());
        let (off, tolerance) = (pair.distance(sum, known.sum), pair.tolerance(self.tolerance));
        let enough = known.agreed >= if pair.is_mapped { Self::ENOUGH } else { Self::SHOWN };
        if !(enough && (pair.is_mapped || known.moved >= Self::SHOWN)) {
            let (same, moved) = (off <= tolerance, known.moved + u32::from(a != known.last));
            *known = if same {
                Channels { agreed: known.agreed + 1, last: a, moved, ..*known }
            } else {
                Channels { sum, last: a, ..Channels::default() }
            };
            return;
        }
        known.last = a;
        if off > tolerance {
            let report = Report::at(context.now()).node(node).detail(u64::from(tpdo)).measure(off);
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            let of = if pair.is_same { "have the difference" } else { "make" };
            sink.report(report, || format!("{a} and {b} {of} {sum}, which was always {}", known.sum));
        }
    }
}
