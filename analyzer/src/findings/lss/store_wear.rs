use super::exchange::{SERVICES, Setting, configured};
use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sdo::Wear;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Severity};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: SERVICES,
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(StoreWear { limits: Wear::limits(&METADATA, thresholds), stores: Wear::default() })
    }),
};

static METADATA: Metadata = Metadata {
    id: "lss/store-wear",
    severity: Severity::Warning,
    title: "node-IDs and bit rates are stored more often than the memory bears",
    what: "LSS or LMT stores are confirmed so often that the memory of the devices would be worn out within their \
           service life, if it went on like this.",
    why: "An EEPROM bears some 100 000 writes. A master that assigns and stores node-IDs at every start wears it out.",
    advice: "Store once, at commissioning; or assign node-IDs at every start and don't store them.",
    thresholds: &[
        Threshold { name: "times", default: 10, unit: "", meaning: "fewer stores in a capture are not judged" },
        Threshold { name: "cycles", default: 100_000, unit: "", meaning: "how many writes the memory bears" },
        Threshold { name: "years", default: 10, unit: "", meaning: "the service life" },
    ],
};

struct StoreWear {
    limits: crate::findings::sdo::WearLimits,
    stores: Wear,
}

impl Rule for StoreWear {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if matches!(configured(context.message()), Some((Setting::Store, 0))) {
            self.stores.count(context);
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some((first, message)) = self.stores.judge(&self.limits, scene) else { return };
        sink.report(Report::at(first.time()).evidence(first.evidence()), || message);
    }
}
