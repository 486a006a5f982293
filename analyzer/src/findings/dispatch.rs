//! Tables of the rules that see each frame.

use super::registry;
use super::rule::{Also, Definition, Make, Metadata, Rule};
use super::thresholds::Thresholds;
use crate::message::Service;
use std::sync::LazyLock;

/// A rule with its metadata.
pub(crate) type Watching = (&'static Metadata, Box<dyn Rule>);

/// Properties of a frame besides its service: a set of [`Also`].
#[derive(Clone, Copy, Default)]
pub(crate) struct Traits(u8);

/// The indexes of the rules for each service and each set of traits, so that a frame needs one look-up.
pub(crate) struct Dispatch(Box<[Box<[u8]>]>);

static DISPATCH: LazyLock<Dispatch> = LazyLock::new(Dispatch::new);

impl Also {
    const COUNT: usize = Self::UnusualPdos as usize + 1;
}

impl Traits {
    const SETS: usize = 1 << Also::COUNT;

    /// Adds `also` to the set if `is_so`.
    #[inline]
    pub const fn with(self, also: Also, is_so: bool) -> Self {
        Self(self.0 | (is_so as u8) << also as u8)
    }
}

impl Dispatch {
    fn new() -> Self {
        // The services, as bits, and the traits that each rule asks for.
        let asked = |definition: &Definition| {
            let services = definition.services.iter().fold(0_u32, |services, service| services | 1 << *service as u8);
            let traits = definition.also.iter().fold(Traits::default(), |traits, also| traits.with(*also, true));
            (services, traits)
        };
        let rules: Vec<(u32, Traits)> = of_buses().map(|rule| asked(rule.0)).collect();
        let places = |row: usize| -> Box<[u8]> {
            let (service, traits) = (1 << (row / Traits::SETS), (row % Traits::SETS) as u8);
            let shown = (0..).zip(&rules).filter(|(_, rule)| rule.0 & service | u32::from(rule.1.0 & traits) != 0);
            shown.map(|(at, _)| at).collect()
        };
        Self((0..Self::row(Service::ALL.len(), Traits::default())).map(places).collect())
    }

    /// The table of all rules.
    pub fn get() -> &'static Self {
        &DISPATCH
    }

    const fn row(service: usize, traits: Traits) -> usize {
        service * Traits::SETS + traits.0 as usize
    }

    /// The indexes, among [`rules`], of the rules that see a frame.
    #[inline]
    pub fn places(&self, service: Service, traits: Traits) -> &[u8] {
        self.0.get(Self::row(service as usize, traits)).map_or(&[], |places| places)
    }
}

/// Makes the state of a rule that watches a bus.
type MakeOfBus = fn(&Thresholds) -> Box<dyn Rule>;

/// The rules that watch a bus, and the constructors of their states.
fn of_buses() -> impl Iterator<Item = (&'static Definition, MakeOfBus)> {
    registry::all().filter_map(|definition| match definition.make {
        Make::Bus(make) => Some((definition, make)),
        Make::Capture(_) | Make::Nothing => None,
    })
}

/// All rules that watch a bus, in their initial state.
pub fn rules(thresholds: &Thresholds) -> Vec<Watching> {
    of_buses().map(|(definition, make)| (definition.metadata, make(thresholds))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(service: Service, traits: Traits) -> Vec<&'static str> {
        let all: Vec<_> = of_buses().map(|(definition, _)| definition.metadata.id).collect();
        Dispatch::get().places(service, traits).iter().map(|at| all[usize::from(*at)]).collect()
    }

    #[test]
    fn a_rule_is_shown_what_it_asks_for_and_once() {
        let ended = Traits::default().with(Also::EndedTransfers, true);
        let unusual = ended.with(Also::UnusualRequests, true);
        assert!(!shown(Service::Sdo, Traits::default()).contains(&"sdo/store-wear"));
        assert!(shown(Service::Sdo, ended).contains(&"sdo/store-wear"));
        assert!(!shown(Service::Sdo, ended).contains(&"sdo/impatient-client"));
        assert!(shown(Service::Sdo, unusual).contains(&"sdo/impatient-client"));
        // The service and both traits of this frame select the rule; it is shown the frame once.
        let known = unusual.with(Also::KnownTpdos, true);
        assert_eq!(shown(Service::Nmt, known).iter().filter(|id| **id == "pdo/period").count(), 1);
        assert!(shown(Service::Lss, Traits::default()).iter().all(|id| !id.starts_with("sdo/")));
    }

    #[test]
    fn every_rule_is_shown_something() {
        let all = Traits((Traits::SETS - 1) as u8);
        for (definition, _) in of_buses() {
            assert!(Service::ALL.iter().any(|service| shown(*service, all).contains(&definition.metadata.id)));
        }
    }
}
