use super::exchange::configured;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::wear::{Wear, WearLimits};
use crate::findings::{Context, Scene};
use crate::wire::layer_setting::ConfigureCommand;
use canvass_macros::rule;

/// node-IDs and bit rates are stored more often than the memory endures
///
/// At the rate of the confirmed LSS or LMT stores, the memory of the devices wears out within their service life.
///
/// # Why
/// An EEPROM endures some 100 000 writes. A master that assigns and stores node-IDs at every start wears it out.
///
/// # What to do
/// Store once, at commissioning, or assign node-IDs at every start without storing them.
#[rule(id = "lss/store-wear", severity = Warning, rank = Detail, services = [Lss, Lmt])]
struct StoreWear {
    /// a lower number of stores is not judged
    #[threshold(count = 10, min = 1)]
    times: u64,
    /// number of writes that the memory bears
    #[threshold(count = 100_000, min = 1)]
    cycles: u64,
    /// service life of the device
    #[threshold(count = 10, unit = "years", min = 1)]
    years: u64,
    stores: Wear,
}

impl Rule for StoreWear {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if matches!(configured(context.message()), Some((ConfigureCommand::Store, 0))) {
            self.stores.count(context);
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let limits = WearLimits { times: self.times, cycles: self.cycles, years: self.years };
        let Some((first, message)) = self.stores.judge(&limits, scene) else { return };
        sink.report(Report::at(first.time()).evidence(first.evidence()), || message);
    }
}
