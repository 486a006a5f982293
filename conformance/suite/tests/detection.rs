//! Tests of the catalogue: every case passes on a device without fault, and fails on every fault that it names.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_device::Fault;
use canvass_device::Faults;
use canvass_device::Liberty;
use canvass_device::models::Model;
use canvass_suite::bench::Target;
use canvass_suite::case::Case;
use canvass_suite::catalogue;
use canvass_suite::clause::Level;
use canvass_suite::glob;
use canvass_suite::runner::CaseReport;
use canvass_suite::selftest::{self, Chance, Extent, Matrix, judge_target};
use canvass_suite::verdict::Kind;
use std::collections::BTreeSet;

fn describe(report: &CaseReport) -> String {
    let frames: Vec<String> = report
        .evidence
        .frames()
        .map(|exhibit| {
            format!("    ({}) {} {}", exhibit.record.timestamp, exhibit.record.frame, exhibit.record.direction)
        })
        .collect();
    let tail = &frames[frames.len().saturating_sub(12)..];
    format!(
        "{}: {}: {:?} {:?}\n{}",
        report.case.id,
        report.verdict.kind(),
        report.verdict.reason(),
        report.notes,
        tail.join("\n")
    )
}

/// There are no false alarms: on a model without fault no case fails or is inconclusive, and no value stays changed.
#[test]
fn good_devices_pass() {
    let mut wrong = Vec::new();
    for model in Model::all() {
        for case in catalogue::cases() {
            let report = selftest::judge(case, model, Faults::NONE);
            let is_wrong = matches!(report.verdict.kind(), Kind::Fail | Kind::Error | Kind::Inconclusive);
            let is_left = |note: &String| ["EMCY at", "restored", "set back"].iter().any(|word| note.contains(word));
            if is_wrong || report.notes.iter().any(is_left) {
                wrong.push(format!("{}: {}", model.id(), describe(&report)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

/// On the usual model, only cases about features that it lacks are not applicable.
#[test]
fn most_encoder_cases_apply_to_the_usual_model() {
    let model = Model::by_id("kuebler-sendix-58x8").unwrap();
    let cases = catalogue::cases().into_iter().filter(|case| case.id.starts_with("406/"));
    let applies = |case: &&'static Case| selftest::judge(case, model, Faults::NONE).verdict.kind() == Kind::Pass;
    let (applied, left_out): (Vec<_>, Vec<_>) = cases.partition(applies);
    let left_out: Vec<&str> = left_out.iter().map(|case| case.id).collect();
    assert!(applied.len() > 50 && left_out.len() < 24, "{} apply, not {left_out:?}", applied.len());
}

/// Without a description the tester asks the device itself; cases that need unknown facts are not applicable, and none
/// fails.
#[test]
fn a_good_device_passes_without_a_description() {
    let model = Model::by_id("kuebler-sendix-58x8").unwrap();
    // The announcements of the manual hold without an EDS, too.
    let target = Target { description: None, ..Target::of(model, model.default_node().unwrap()) };
    let reports = catalogue::cases().into_iter().map(|case| judge_target(case, model, Faults::NONE, &target));
    let (good, wrong): (Vec<_>, Vec<_>) = reports
        .filter(|report| report.verdict.kind() != Kind::NotApplicable)
        .partition(|report| matches!(report.verdict.kind(), Kind::Pass | Kind::Deviation));
    let wrong: Vec<String> = wrong.iter().map(describe).collect();
    assert!(wrong.is_empty() && good.len() > 80, "{} passed, {}", good.len(), wrong.join("\n"));
}

fn matrix() -> Matrix {
    // Only `canvass selftest` fills all cells.
    selftest::run(&catalogue::cases(), Fault::ALL, &[], Extent::OneIn(16), Chance::NONE)
}

/// Every case that names a fault detects it, no case is vacuous, and no case fails outside its chapter.
#[test]
fn every_case_catches_what_it_names_and_nothing_else() {
    let matrix = matrix();
    let mut wrong = Vec::new();
    for row in &matrix.faults {
        wrong.extend(row.missed.iter().map(|(case, kind)| format!("{} misses {}: {kind}", case.id, row.fault)));
        wrong.extend(row.unrelated.iter().map(|case| format!("{} fails on {}, not its matter", case.id, row.fault)));
        if !row.is_detected() {
            wrong.push(format!("{} is not detected", row.fault));
        }
    }
    wrong.extend(matrix.vacuous_cases().iter().map(|case| format!("{} fails on no fault", case.id)));
    assert!(wrong.is_empty() && matrix.is_good(), "{}:\n{}", wrong.len(), wrong.join("\n"));
    assert_eq!(matrix.faults.len(), Fault::ALL.len(), "every fault's model exists");
}

/// A documented deviation never hides a fault of the same case: tested with all faults that these cases name, on all
/// models whose manuals announce deviations.
#[test]
fn no_documented_deviation_hides_a_fault() {
    let models: Vec<&'static Model> = Model::all().iter().filter(|model| !model.deviations().is_empty()).collect();
    let deviates = |case: &&'static Case| {
        let rows = models.iter().flat_map(|model| model.deviations());
        rows.into_iter().any(|row| glob::matches(&row.case, case.id))
    };
    let cases: Vec<&'static Case> = catalogue::cases().into_iter().filter(deviates).collect();
    let faults = selftest::named_by(&cases);
    let masking = selftest::run(&cases, &faults, &models, Extent::OneIn(usize::MAX), Chance::NONE).masking;
    let masked = masking.masked.iter().map(|row| format!("{} on {}: {}", row.fault, row.model, row.case.id));
    assert_eq!(masked.collect::<Vec<_>>(), Vec::<String>::new());
    assert!(masking.tried > 100 && masking.beside_deviations > 5, "{masking:?}");
}

/// No case fails a liberty of the standard, alone or in combinations. `canvass selftest` tries more of them.
#[test]
fn what_the_standard_leaves_free_is_spared() {
    let chance = Chance { seed: 2, combinations: 20, ..Chance::NONE };
    let sparing = selftest::run(&catalogue::cases(), &[], &[], Extent::OneIn(usize::MAX), chance).sparing;
    let rows = sparing.alone.iter().chain(&sparing.combined);
    let alarms =
        rows.flat_map(|row| row.alarms.iter().map(move |(case, kind, why)| (row.liberties, case.id, kind, why)));
    let alarms: Vec<String> = alarms.map(|alarm| format!("{alarm:?}")).collect();
    assert!(alarms.is_empty(), "{}", alarms.join("\n"));
    assert_eq!((sparing.alone.len(), sparing.combined.len()), (Liberty::ALL.len(), 20));
    assert!(Liberty::ALL.len() >= 60);
}

/// No case fails on a correct device because it moves. `canvass selftest` runs all cases; here those of the profile and
/// of SDO, which read measured values, from all positions.
#[test]
fn what_moves_is_spared() {
    let reads_values = |case: &&'static Case| case.id.starts_with("406/") || case.id.starts_with("301/sdo/");
    let cases: Vec<&'static Case> = catalogue::cases().into_iter().filter(reads_values).collect();
    let models: Vec<&'static Model> = Model::all().iter().filter(|model| model.id() != "reference-301").collect();
    let chance = Chance { starts: 3, motions: 30, ..Chance::NONE };
    let faults = selftest::named_by(&cases);
    let moving = selftest::run(&cases, &faults, &models, Extent::OneIn(usize::MAX), chance).moving;
    let alarms = moving.rows.iter().flat_map(|row| {
        let place = format!("{} {} from {}", row.model, row.motion, row.start);
        row.alarms.iter().map(move |(case, kind, why)| format!("{place}: {} {kind}: {why}", case.id))
    });
    let alarms: Vec<String> = alarms.collect();
    assert!(alarms.is_empty(), "{}", alarms.join("\n"));
    assert_eq!(moving.missed, Vec::<Fault>::new());
    assert_eq!(moving.rows.len(), 10 * (12 * 3 + 30));
    assert!(moving.tried > 150, "{}", moving.tried);
}

/// A requirement of a standard deserves a case only if its violation can be seen.
#[test]
fn every_demand_is_justified_by_a_fault() {
    let is_idle = |case: &&'static Case| case.level == Level::Must && case.catches.is_empty();
    assert_eq!(catalogue::cases().into_iter().find(is_idle).map(|case| case.id), None);
}

/// A case names every fault.
#[test]
fn every_fault_is_named_by_a_case() {
    let named: BTreeSet<Fault> = catalogue::cases().iter().flat_map(|case| case.catches).copied().collect();
    let idle: Vec<&str> = Fault::ALL.iter().filter(|fault| !named.contains(fault)).map(|fault| fault.id()).collect();
    assert!(idle.is_empty(), "{idle:?}");
}
