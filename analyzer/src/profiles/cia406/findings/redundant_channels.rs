use super::node::{is_encoder, kind, layout, operands};
use crate::findings::{Context, NodeFacts, Report, Rule, Seen, Sink};
use crate::message::{Message, PdoNumber, Service};
use crate::profiles::cia406::kind::Kind;
use crate::profiles::cia406::objects;
use crate::wire::pdo::extract;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Duration;

#[derive(Clone, Copy, Default)]
struct Channels {
    sum: u64,
    /// Number of times the sum was the same.
    agreed: u32,
    /// The last value of the first channel, and how often it changed.
    last: u64,
    moved: u32,
}

/// the redundant channels of an encoder disagree
///
/// The first TPDO of a draw-wire encoder with two redundant channels carries the position (6020h) twice, and the second
/// channel counts down as the first counts up. Their sum was constant, and has changed. If no mapping is known, two
/// equally long halves of the TPDO of a linear encoder count as redundant channels if their sum stays constant while
/// they change. The rule learns the sum again after a download to the node.
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
    nodes: PerNode<Channels>,
}

/// The two channels in a PDO; the flag tells whether a mapping proves that they are positions, or only their place
/// suggests it.
fn channels(context: &Context<'_>, node: NodeId) -> Option<([u64; 2], bool)> {
    match operands(context) {
        [] => {}
        [a, b] => {
            let doubled = a.bits == b.bits && a.object.index == b.object.index && a.object.index.0 == POSITION;
            return doubled.then_some(([a.raw, b.raw], true));
        }
        _ => return None,
    }
    if !is_encoder(context, node) || layout(context).is_some() {
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
    Some(([extract(payload, 0, bits)?, extract(payload, usize::from(bits), bits)?], false))
}

/// The position of draw-wire encoders, once for each channel.
const POSITION: u16 = objects::CHANNEL_POSITION_VALUES;

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
            self.nodes[node] = Channels::default();
        } else if matches!(context.message(), Message::Pdo(PdoNumber::Transmit(1)))
            && let Some(values) = channels(context, node)
        {
            self.compare(node, values, context, sink);
        }
    }
}

impl RedundantChannels {
    /// Compares the two channels. A function of its own, so that PDOs without two channels cost nothing.
    #[inline(never)]
    fn compare(
        &mut self,
        node: NodeId,
        ([a, b], mapped): ([u64; 2], bool),
        context: &Context<'_>,
        sink: &mut Sink<'_>,
    ) {
        let known = &mut self.nodes[node];
        // Zero point, direction or mapping may just have been changed.
        let facts = context.scene.facts.node(node);
        if NodeFacts::is_recent(facts.last_download, context.now(), Duration::from_secs(1)) {
            *known = Channels::default();
        }
        let sum = a.saturating_add(b);
        let off = sum.abs_diff(known.sum);
        let enough = known.agreed >= if mapped { Self::ENOUGH } else { Self::SHOWN };
        if !(enough && (mapped || known.moved >= Self::SHOWN)) {
            let (same, moved) = (off <= self.tolerance, known.moved + u32::from(a != known.last));
            *known = if same {
                Channels { agreed: known.agreed + 1, last: a, moved, ..*known }
            } else {
                Channels { sum, last: a, ..Channels::default() }
            };
            return;
        }
        known.last = a;
        if off > self.tolerance {
            let report = Report::at(context.now()).node(node).measure(off);
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            sink.report(report, || format!("{a} and {b} make {sum}, the sum was always {}", known.sum));
        }
    }
}
