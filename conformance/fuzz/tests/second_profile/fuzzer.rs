//! A property of the profile, and a dialogue that shows its violation.

use super::{INPUTS, NUMBER, OUTPUTS, STUCK, model, node};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::Request;
use canvass_device::Faults;
use canvass_fuzzer::campaign::{Plan, run};
use canvass_fuzzer::profile::{Broken, Dialogue, Profile, Registered};
use canvass_fuzzer::stand::simulated;
use canvass_fuzzer::{Knowledge, ProfileProperty, Property, Target};
use std::collections::BTreeSet;

#[derive(Debug)]
struct DigitalIo;

inventory::submit! { Registered(&DigitalIo) }

/// The inputs follow the outputs, whatever was written to these.
static WIRED: ProfileProperty = ProfileProperty {
    id: "PROP-18",
    title: "inputs show the outputs that they are wired to",
    explanation: "6000h:01 has the value that 6200h:01 was given.\n",
};

impl Profile for DigitalIo {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn properties(&self) -> &'static [&'static ProfileProperty] {
        static PROPERTIES: [&ProfileProperty; 1] = [&WIRED];
        &PROPERTIES
    }

    fn judge(
        &self,
        at: Multiplexer,
        value: &[u8],
        _: &Knowledge,
        expected: &dyn Fn(Multiplexer) -> Option<u64>,
    ) -> Option<Broken> {
        let outputs = expected(OUTPUTS).filter(|_| at == INPUTS)?;
        let inputs = u64::from(*value.first()?);
        (inputs != outputs).then(|| Broken {
            property: &WIRED,
            expected: format!("6000h:01 {outputs:02X}h as 6200h:01"),
            actual: format!("{inputs:02X}h"),
        })
    }

    fn dialogue(&self, script: &mut dyn Dialogue) -> bool {
        let value = script.number() as u8;
        script.ask(Request::download(OUTPUTS, &[value]));
        script.ask(Request::upload(INPUTS));
        true
    }
}

/// The ids of the violated properties that a run finds.
fn broken(name: &str) -> BTreeSet<&'static str> {
    let plan = Plan {
        targets: Target::Sdo.into(),
        seed: 1,
        allow: BTreeSet::new(),
        shrink_budget: 50,
        time: canvass_fuzzer::time_limit::TimeLimit::default(),
        stop_at_first: false,
        regressions: Vec::new(),
        only_regressions: false,
        corpus: Vec::new(),
    };
    let (mut stand, knowledge) = simulated(model(name), node(), Faults::NONE, 250_000, 0);
    let outcome = run(&mut stand, knowledge, &plan, &mut |progress| progress.sequences < 400).unwrap();
    outcome.violations.iter().map(|found| found.violation.property.id()).collect()
}

#[test]
fn the_property_is_listed_and_found_broken_on_a_faulty_device_only() {
    let of_profile: Vec<_> = Property::all().filter(|property| matches!(property, Property::OfProfile(_))).collect();
    assert!(of_profile.contains(&"PROP-18".parse().unwrap()));
    assert!(broken("io").is_empty());
    assert_eq!(broken(STUCK), BTreeSet::from(["PROP-18"]));
}
