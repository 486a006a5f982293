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
    let motion = Motion::constant(0x4CBA, if turns { 30_000 } else { 0 });
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

/// No false alarm: a device without fault passes every case, and nothing stays changed.
#[test]
fn a_good_device_passes() {
    let model = |case: &Case| case.catches.first().map_or(MODEL, |fault| fault.model());
    let reports: Vec<CaseReport> =
        catalogue::cases().into_iter().map(|case| judge(case, model(case), Faults::NONE)).collect();
    let wrong: Vec<String> = reports
        .iter()
        .filter(|report| {
            report.verdict.kind() != Kind::Pass
                || report
                    .notes
                    .iter()
                    .any(|note| note.contains("EMCY") || note.contains("restored") || note.contains("set back"))
        })
        .map(describe)
        .collect();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), reports.len(), wrong.join("\n"));
}

/// Of the usual model nothing but what it does not have is left out.
#[test]
fn most_cases_apply_to_the_usual_model() {
    let applies = |case: &&'static Case| judge(case, MODEL, Faults::NONE).verdict.kind() == Kind::Pass;
    let (applied, left_out): (Vec<_>, Vec<_>) = catalogue::cases().into_iter().partition(applies);
    // Layer management is what older devices have instead of LSS.
    let left_out: Vec<&str> = left_out.iter().map(|case| case.id).filter(|id| !id.starts_with("205/")).collect();
    assert!(applied.len() > 140 && left_out.len() < 16, "{} apply, not {left_out:?}", applied.len());
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

/// Faults whose case is still to be written.
const AWAITING: &[Fault] = &[
    Fault::NmtResetCommunicationRestoresAll,
    Fault::NmtCommandLost,
    Fault::ExtendedFrameObeyed,
    Fault::BootUpSometimesMissing,
    Fault::EmcyBeforeBootUp,
    Fault::SdoAnsweredBeforeBootUp,
    Fault::StartUpIgnored,
    Fault::HeartbeatTimerRounded,
    Fault::HeartbeatBurst,
    Fault::HeartbeatLateAfterBootUp,
    Fault::HeartbeatStateLate,
    Fault::LifeTimeFactorIgnored,
    Fault::HeartbeatConsumerStartsAtOnce,
    Fault::HeartbeatConsumerNotRearmed,
    Fault::HeartbeatConsumerFirstOnly,
    Fault::ErrorBehaviourUnchecked,
    Fault::ErrorBehaviourLeavesStopped,
    Fault::RpdoInPreOperational,
    Fault::RpdoLengthUnchecked,
    Fault::LongRpdoIgnored,
    Fault::SynchronousRpdoActsAtOnce,
    Fault::RpdoDeadlineIgnored,
    Fault::RpdoReceivedWhenInvalid,
    Fault::RpdoRangeUnchecked,
    Fault::RemoteFrameTakenAsRpdo,
    Fault::EventTimerOffByOne,
    Fault::InhibitTimeInMilliseconds,
    Fault::AcyclicTpdoWithoutEvent,
    Fault::SyncStartValueIgnored,
    Fault::SyncCountNotReset,
    Fault::RemoteFrameAnsweredWhenNotAllowed,
    Fault::RtrTypeSampledAtOnce,
    Fault::RtrTypeWithoutRtrAccepted,
    Fault::RtrBitClearable,
    Fault::InhibitTimeChangeWhileValid,
    Fault::SyncStartValueChangeWhileValid,
    Fault::EmptyPdoValidated,
    Fault::MappingCountUnchecked,
    Fault::MissingObjectMapped,
    Fault::DummyMappedIntoTpdo,
    Fault::SyncPeriodDoubled,
    Fault::SyncWhenStopped,
    Fault::SyncCounterNotReset,
    Fault::SyncCounterFromZero,
    Fault::SyncOverflowUnchecked,
    Fault::SyncOverflowChangeWhileProducing,
    Fault::SyncIdChangeWhileProducing,
    Fault::SyncLengthUnchecked,
    Fault::TimeIgnored,
    Fault::TimeIdChangeWhileValid,
    Fault::TimeReservedBitsSet,
    Fault::SdoChannelIdChangeWhileValid,
    Fault::EmcyInhibitTimeIgnored,
    Fault::EmcyLostWhenInhibited,
    Fault::EmcyLostWhenStopped,
    Fault::EmcyIdChangeWhileValid,
    Fault::EmcySentWhenInvalid,
    Fault::EmcyRegisterZero,
    Fault::ErrorHistoryReversed,
    Fault::ErrorHistoryOverflows,
    Fault::ErrorHistoryNonZeroAccepted,
    Fault::ErrorHistoryEmptyReadsZero,
    Fault::RestoreSignatureUnchecked,
    Fault::RestoreWithoutEffect,
    Fault::StoreLosesGroup,
    Fault::StoreGroupIgnored,
    Fault::StoreTornByReset,
    Fault::LssSelectiveThreeParts,
    Fault::LssSelectiveAnyOrder,
    Fault::LssIdentifyRangeExclusive,
    Fault::LssNonConfiguredAnswered,
    Fault::LssReservedModeWaits,
    Fault::LssBitTimingUnchecked,
    Fault::LssBitTimingWrongCode,
    Fault::LssStoreNotPersistent,
    Fault::LssNodeIdAtOnce,
    Fault::LssActivatesAtOnce,
    Fault::FastscanEarlyMatch,
    Fault::FastscanHangs,
    Fault::FastscanAnsweredWhenConfigured,
    Fault::UnconfiguredNodeBoots,
    Fault::WatchdogResetUnderLoad,
    Fault::SdoMemoryLeak,
];

/// No fault goes unnoticed.
#[test]
fn every_fault_is_named_by_a_case() {
    let named: BTreeSet<Fault> = catalogue::cases().iter().flat_map(|case| case.catches).copied().collect();
    let awaited = |fault: &&Fault| !named.contains(fault) && !AWAITING.contains(fault);
    let idle: Vec<&str> = Fault::ALL.iter().filter(awaited).map(|fault| fault.id()).collect();
    assert!(idle.is_empty(), "{idle:?}");
}
