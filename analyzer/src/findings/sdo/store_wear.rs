use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold, Thresholds};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::Service;
use crate::network::Event;
use crate::network::sdo::{Direction, Outcome};
use crate::{Multiplexer, NodeId};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Sdo],
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(StoreWear {
            limits: Wear::limits(&METADATA, thresholds),
            nodes: (0..128).map(|_| Wear::default()).collect(),
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "sdo/store-wear",
    severity: Severity::Warning,
    title: "parameters are stored more often than the memory bears",
    what: "Parameters are stored (1010h, or the signature `save` in an object of the manufacturer; with encoders of \
           TR-Electronic also each write of 6000h, 6003h and 6200h, which they keep at once) so often that the memory of the device would be worn out within its service \
           life, if it went on like this.",
    why: "An EEPROM bears some 100 000 writes. Some masters store at every start or even in every cycle; years later the \
          device loses its configuration.",
    advice: "Store once, at commissioning. Configure the rest at every start without storing.",
    thresholds: &[
        Threshold { name: "times", default: 10, unit: "", meaning: "fewer stores in a capture are not judged" },
        Threshold { name: "cycles", default: 100_000, unit: "", meaning: "how many writes the memory bears" },
        Threshold { name: "years", default: 10, unit: "", meaning: "the service life" },
    ],
};

struct StoreWear {
    limits: WearLimits,
    nodes: Box<[Wear]>,
}

/// How often a memory may be written.
#[derive(Clone, Copy)]
pub struct WearLimits {
    times: u64,
    cycles: u64,
    years: u64,
}

/// How often a memory was written.
#[derive(Default)]
pub struct Wear {
    count: u64,
    first: Option<Seen>,
}

impl Wear {
    /// The limits that a rule with the thresholds `times`, `cycles` and `years` has.
    pub fn limits(rule: &'static Metadata, thresholds: &Thresholds) -> WearLimits {
        WearLimits {
            times: thresholds.get(rule, "times").max(1),
            cycles: thresholds.get(rule, "cycles").max(1),
            years: thresholds.get(rule, "years").max(1),
        }
    }

    /// One more write.
    pub fn count(&mut self, context: &Context<'_>) {
        self.count += 1;
        self.first.get_or_insert_with(|| context.seen());
    }

    /// The first write, and what is to be said, if there were too many within the capture.
    pub fn judge(&self, limits: &WearLimits, scene: &Scene<'_>) -> Option<(&Seen, String)> {
        const SECONDS_OF_YEAR: u64 = 365 * 86_400;
        let bearable = SECONDS_OF_YEAR.saturating_mul(limits.years) / limits.cycles;
        let first = self.first.as_ref().filter(|_| scene.has_times() && self.count >= limits.times)?;
        let every = scene.now.since(scene.start).nanos() / 1_000_000_000 / self.count;
        let message = || format!("{} stores, one every {every} s; one every {bearable} s is bearable", self.count);
        (every < bearable).then(|| (first, message()))
    }
}

/// TR-Electronic: its encoders keep operating parameters, preset and cyclic timer at once, without 1010h.
const TR_ELECTRONIC: u32 = 0xD4;

/// Whether a download to that object writes the memory of the node.
fn is_kept(object: Multiplexer, node: NodeId, context: &Context<'_>) -> bool {
    let vendor = || {
        let known = context.scene.bus.node(node)?;
        let described = || known.description.as_deref().and_then(|description| description.device.vendor_number);
        known.certain(node, Multiplexer::new(0x1018, 1)).or_else(described)
    };
    match object.index.0 {
        0x1010 => true,
        0x6000 | 0x6003 | 0x6200 => vendor() == Some(TR_ELECTRONIC),
        _ => false,
    }
}

impl Rule for StoreWear {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let Some(node) = context.node().filter(|_| context.decoded.event == Some(Event::TransferEnded)) else { return };
        let transfer = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel));
        let written = transfer
            .filter(|transfer| transfer.outcome == Outcome::Complete && transfer.direction == Direction::Download);
        let signed = |data: &[u8]| matches!(data, b"save");
        let stored = written.is_some_and(|transfer| match transfer.multiplexer.index.0 {
            0x2000..=0x5FFF => signed(transfer.data()),
            _ => is_kept(transfer.multiplexer, node, context),
        });
        if stored {
            self.nodes[usize::from(node.raw())].count(context);
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, stores) in NodeId::all().zip(self.nodes.iter().skip(1)) {
            let Some((first, message)) = stores.judge(&self.limits, scene) else { continue };
            sink.report(Report::at(first.time()).node(node).evidence(first.evidence()), || message);
        }
    }
}
