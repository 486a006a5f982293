use crate::NodeId;
use crate::findings::rule::{Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::Service;
use crate::network::Event;
use crate::network::sdo::{Direction, Outcome};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Sdo],
    make: Some(|thresholds| {
        Box::new(StoreWear {
            times: thresholds.get(&METADATA, "times"),
            cycles: thresholds.get(&METADATA, "cycles").max(1),
            years: thresholds.get(&METADATA, "years").max(1),
            nodes: (0..128).map(|_| None).collect(),
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "sdo/store-wear",
    severity: Severity::Warning,
    title: "parameters are stored more often than the memory bears",
    what: "Parameters are stored (1010h) so often that the memory of the device would be worn out within its service \
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
    times: u64,
    cycles: u64,
    years: u64,
    nodes: Vec<Option<Stores>>,
}

struct Stores {
    count: u64,
    first: Seen,
}

impl Rule for StoreWear {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if context.decoded.event != Some(Event::TransferEnded) {
            return;
        }
        let Some(node) = context.node() else { return };
        let transfer = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel));
        let stored = transfer.is_some_and(|transfer| {
            let done = transfer.outcome == Outcome::Complete && transfer.direction == Direction::Download;
            done && transfer.multiplexer.index.0 == 0x1010
        });
        if stored {
            let stores =
                self.nodes[usize::from(node.raw())].get_or_insert_with(|| Stores { count: 0, first: context.seen() });
            stores.count += 1;
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        const SECONDS_OF_YEAR: u64 = 365 * 86_400;
        let bearable = SECONDS_OF_YEAR * self.years / self.cycles;
        if !scene.has_times() {
            return;
        }
        for (node, stores) in NodeId::all().zip(self.nodes.iter().skip(1)) {
            let Some(stores) = stores.as_ref().filter(|stores| stores.count >= self.times.max(1)) else { continue };
            let seconds = scene.now.since(scene.start).nanos() / 1_000_000_000;
            if seconds / stores.count < bearable {
                let report = Report::at(stores.first.time()).node(node).evidence(stores.first.evidence());
                sink.report(report, || {
                    let every = seconds / stores.count;
                    format!("{} stores, one every {every} s; one every {bearable} s is bearable", stores.count)
                });
            }
        }
    }
}
