use super::operands::{is_encoder, layout};
use crate::findings::rule::{Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::Service;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Pdo, Service::BootUp],
    make: Some(|thresholds| {
        Box::new(RedundantChannels {
            tolerance: thresholds.get(&METADATA, "tolerance"),
            nodes: vec![Channels::default(); 128],
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "encoder/redundant-channels",
    severity: Severity::Error,
    title: "the redundant channels of an encoder disagree",
    what: "A PDO of a draw-wire encoder with two redundant channels carries the position (6020h) twice, the second one \
           counting down as the first counts up. Their sum has been constant, and now is another.",
    why: "One of the two channels is wrong. Which one, the values alone don't tell.",
    advice: "Stop relying on this device. See which of the two channels jumped or froze.",
    thresholds: &[Threshold {
        name: "tolerance",
        default: 20,
        unit: "units",
        meaning: "the sum may be off, as both are taken one after the other",
    }],
};

#[derive(Clone, Copy, Default)]
struct Channels {
    sum: u64,
    /// How often the sum was the same.
    agreed: u32,
}

struct RedundantChannels {
    tolerance: u64,
    nodes: Vec<Channels>,
}

impl RedundantChannels {
    /// From so many PDOs on the sum is known.
    const ENOUGH: u32 = 5;
}

impl Rule for RedundantChannels {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let known = &mut self.nodes[usize::from(node.raw())];
        if context.decoded.service == Service::BootUp {
            *known = Channels::default();
            return;
        }
        let Some([a, b]) = layout(context).map(|layout| layout.signals.as_slice()) else { return };
        let doubled = a.object.index.0 == 0x6020 && b.object.index.0 == 0x6020 && a.bits == b.bits;
        if !doubled || !is_encoder(context, node) {
            return;
        }
        let payload = context.record.frame.data();
        let (Some(a), Some(b)) = (a.raw(payload), b.raw(payload)) else { return };
        let sum = a.saturating_add(b);
        if known.agreed < Self::ENOUGH {
            let same = sum.abs_diff(known.sum) <= self.tolerance;
            *known = Channels { sum, agreed: if same { known.agreed + 1 } else { 0 } };
            return;
        }
        let off = sum.abs_diff(known.sum);
        if off > self.tolerance {
            let report = Report::at(context.now()).node(node).measure(off);
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            sink.report(report, || format!("{a} and {b} make {sum}, the sum was always {}", known.sum));
        }
    }
}
