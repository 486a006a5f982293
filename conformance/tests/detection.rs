//! The catalogue is tested itself: every case passes on a device without fault, and fails on every fault that it names.

// `cfg(test)` says nothing new here, but clippy tells by it where a test may unwrap.
#![cfg(test)]

use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_conformance::bench::{Bench, Options, Target};
use canvass_conformance::bus::SimulatedBus;
use canvass_conformance::case::{Case, Need, Touch};
use canvass_conformance::device::{Device, Motion};
use canvass_conformance::models::Model;
use canvass_conformance::runner::{CaseReport, run_case};
use canvass_conformance::verdict::Kind;
use canvass_conformance::{Fault, Faults, catalogue};
use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;

const MODEL: &str = "kuebler-sendix-58x8";

/// Runs one case on a new device of that model with those faults.
fn judge(case: &'static Case, model: &str, faults: Faults) -> CaseReport {
    let model = Model::by_id(model).unwrap();
    judge_described(case, model, faults, Some(model.description().clone()))
}

fn judge_described(
    case: &'static Case,
    model: &'static Model,
    faults: Faults,
    description: Option<DeviceDescription>,
) -> CaseReport {
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    // 30 revolutions per minute where the case needs a shaft that turns.
    let turns = case.needs.contains(&Need::TurningShaft);
    let motion = Motion { start: 0x4CBA, milli_rpm: if turns { 30_000 } else { 0 } };
    let node = model.default_node().or_else(|| NodeId::new(63));
    bus.attach(Box::new(Device::with_motion(model, node, faults, 0, motion)));
    let target = Target { node: node.unwrap(), model: model.id().to_owned(), description, deviations: Vec::new() };
    let options = Options { allow: Touch::ALL.into_iter().collect(), ..Options::default() };
    let cancel = AtomicBool::new(false);
    let mut annotate = |_: &canvass_traces::Record| String::new();
    run_case(&mut Bench::new(&mut bus, &target, &options, &mut annotate, &cancel), case)
}

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

/// No false alarm: a device without fault fails no case, leaves none open, and nothing stays changed.
#[test]
fn good_devices_pass() {
    let mut wrong = Vec::new();
    for model in Model::all() {
        for case in catalogue::cases() {
            let report = judge(case, model.id(), Faults::NONE);
            let is_wrong = !matches!(report.verdict.kind(), Kind::Pass | Kind::NotApplicable);
            let is_left = |note: &String| ["EMCY", "restored", "set back"].iter().any(|word| note.contains(word));
            if is_wrong || report.notes.iter().any(is_left) {
                wrong.push(format!("{}: {}", model.id(), describe(&report)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

/// Of the usual model nothing but what it does not have is left out.
#[test]
fn most_cases_apply_to_the_usual_model() {
    let applies = |case: &&'static Case| judge(case, MODEL, Faults::NONE).verdict.kind() == Kind::Pass;
    let (applied, left_out): (Vec<_>, Vec<_>) = catalogue::cases().into_iter().partition(applies);
    let left_out: Vec<&str> = left_out.iter().map(|case| case.id).collect();
    assert!(applied.len() > 100 && left_out.len() < 16, "{} apply, not {left_out:?}", applied.len());
}

/// Without a description the device itself is asked; what can't be known is not applicable, and nothing fails.
#[test]
fn a_good_device_passes_without_a_description() {
    let model = Model::by_id(MODEL).unwrap();
    let reports = catalogue::cases().into_iter().map(|case| judge_described(case, model, Faults::NONE, None));
    let (good, wrong): (Vec<_>, Vec<_>) = reports
        .filter(|report| report.verdict.kind() != Kind::NotApplicable)
        .partition(|report| report.verdict.kind() == Kind::Pass);
    let wrong: Vec<String> = wrong.iter().map(describe).collect();
    assert!(wrong.is_empty() && good.len() > 80, "{} passed, {}", good.len(), wrong.join("\n"));
}

/// No vacuous case: each fails on each fault that it names.
#[test]
fn every_case_catches_what_it_names() {
    let mut missed = Vec::new();
    for case in catalogue::cases() {
        for &fault in case.catches {
            let report = judge(case, fault.model(), Faults::from(fault));
            if report.verdict.kind() != Kind::Fail {
                missed.push(format!("{fault} by {}", describe(&report)));
            }
        }
    }
    assert!(missed.is_empty(), "{} missed:\n{}", missed.len(), missed.join("\n"));
}

/// No fault goes unnoticed.
#[test]
fn every_fault_is_named_by_a_case() {
    let named: BTreeSet<Fault> = catalogue::cases().iter().flat_map(|case| case.catches).copied().collect();
    let idle: Vec<&str> = Fault::ALL.iter().filter(|fault| !named.contains(fault)).map(|fault| fault.id()).collect();
    assert!(idle.is_empty(), "{idle:?}");
}
