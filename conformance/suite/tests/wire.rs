//! Devices with one wrong field in one message are found.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_device::models::Model;
use canvass_suite::catalogue;
use canvass_suite::selftest::wire::{Outcome, Primitive, Sample, WireRow, run};

/// Minimum percentage of mutants that are found, among those of the sample that change the traffic and are not left
/// open.
const FOUND: usize = 97;
/// Minimum percentage of found mutants that are named rightly.
const NAMED: usize = 98;

/// Each new field changes the sample: the required percentages are those of all mutants, less the deviation of a
/// sample.
#[test]
fn most_wrong_fields_are_found_and_named() {
    let count = std::env::var("CANVASS_WIRE_COUNT").ok().and_then(|count| count.parse().ok()).unwrap_or(400);
    let sample = Sample { only: Vec::new(), seed: 1, count: Some(count) };
    let matrix = run(&catalogue::select(&[]).unwrap(), Model::all(), &sample).unwrap();
    let unsent: Vec<String> = matrix.unsent.iter().map(Primitive::id).collect();
    assert!(unsent.is_empty(), "no case makes a model send {unsent:?}");
    let all = matrix.counts(|_| true);
    let told = || matrix.rows.iter().map(tell).collect::<Vec<_>>().join("\n");
    assert!(all.found * 100 >= (all.changed - all.open) * FOUND, "{all:?}\n{}", told());
    assert!(all.named * 100 >= all.found * NAMED, "{all:?}\n{}", told());
}

fn tell(row: &WireRow) -> String {
    let outcome = match &row.outcome {
        Outcome::Unchanged => "unchanged".to_owned(),
        Outcome::LeftOpen(reason) => format!("open: {reason}"),
        Outcome::Found { case, is_named, breach } => format!("found, named {is_named}, {}: {breach}", case.id),
        Outcome::Inconclusive(case, count) => format!("inconclusive {count}, first {}", case.id),
        Outcome::Passed => "passed".to_owned(),
    };
    format!("{} on {}: {outcome}", row.mutant, row.model)
}
