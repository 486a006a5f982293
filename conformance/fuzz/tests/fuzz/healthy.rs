//! The fuzzer raises no false alarm. `soak models 5000000` tests the same at length.

use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_fuzzer::detection::fuzz;
use canvass_fuzzer::{Target, reproducer};
use canvass_suite::touch::Touch;

const EXCHANGES: u64 = 6_000;

#[test]
fn healthy_models_violate_nothing() {
    for (seed, model) in (0_u64..).zip(Model::all()) {
        for (n, target) in Target::ALL.into_iter().enumerate() {
            // For every second target all touches are allowed, for the others none.
            let allow = Touch::ALL.into_iter().filter(|_| (n as u64 + seed).is_multiple_of(2)).collect();
            let exchanges = if target == Target::All { EXCHANGES } else { EXCHANGES / 4 };
            let outcome = fuzz(model, Faults::NONE, target, &allow, seed, &mut |done| done < exchanges).unwrap();
            let alarms: Vec<_> = outcome
                .violations
                .iter()
                .map(|found| format!("{:?}\n{}", found.violation, reproducer::candump(&found.sequence)))
                .collect();
            assert!(alarms.is_empty(), "{} {target} {alarms:#?}", model.id());
            assert!(outcome.executions >= exchanges);
        }
    }
}
