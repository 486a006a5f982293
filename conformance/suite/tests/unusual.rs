//! Right but unusual devices: no case may fail on them, or be left out although they have all that it needs.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_device::models::Model;
use canvass_device::{Fault, Faults};
use canvass_suite::bench::Target;
use canvass_suite::case::Case;
use canvass_suite::catalogue;
use canvass_suite::clause::Level;
use canvass_suite::needs;
use canvass_suite::selftest::{judge, judge_target};
use canvass_suite::verdict::Kind;
use std::collections::BTreeMap;

const EDS: &str = include_str!("../../device/models/reference-301.eds");
const SHEET: &str = include_str!("../../device/models/reference-301.toml");

/// The EDS without the sections whose names begin with one of `names`.
fn without(eds: &str, names: &[&str]) -> String {
    let mut is_kept = true;
    let lines = eds.lines().filter(|line| {
        if let Some(name) = line.strip_prefix('[') {
            is_kept = !names.iter().any(|gone| name.starts_with(gone));
        }
        is_kept
    });
    lines.map(|line| format!("{line}\n")).collect()
}

/// The EDS with `line` of a section replaced by `other`.
fn with(eds: &str, section: &str, line: &str, other: &str) -> String {
    let (before, rest) = eds.split_once(&format!("[{section}]\n")).unwrap();
    let (own, after) = rest.split_once("\n\n").unwrap();
    assert!(own.contains(line), "{section} has {line}");
    format!("{before}[{section}]\n{}\n\n{after}", own.replace(line, other))
}

/// The verdict of each case on the reference device with another description. Requires that none is bad.
fn verdicts(eds: &str) -> BTreeMap<&'static str, Kind> {
    let model: &'static Model = Box::leak(Box::new(Model::read(eds, SHEET).unwrap()));
    let target = Target::of(model, model.default_node().unwrap());
    let (mut verdicts, mut wrong) = (BTreeMap::new(), Vec::new());
    // The cases of CiA 306 judge the file, whose lists and counts still contain the removed sections.
    for case in catalogue::cases().into_iter().filter(|case| !case.id.starts_with("306/")) {
        let report = judge_target(case, model, Faults::NONE, &target);
        let kind = report.verdict.kind();
        if matches!(kind, Kind::Fail | Kind::Inconclusive | Kind::Error) {
            wrong.push(format!("{}: {kind}: {:?}", case.id, report.verdict.reason()));
        }
        verdicts.insert(case.id, kind);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    verdicts
}

#[test]
fn a_heartbeat_whose_period_is_fixed() {
    let eds = with(EDS, "1017", "AccessType=rw", "AccessType=const");
    let verdicts = verdicts(&with(&eds, "1017", "DefaultValue=0", "DefaultValue=200"));
    // The device shows its state by itself.
    for id in ["301/nmt/pre-operational/start", "301/nmt/operational/stop", "301/nmt/back-to-back"] {
        assert_eq!(verdicts[id], Kind::Pass, "{id}");
    }
    let heartbeat = verdicts.iter().filter(|(id, _)| id.starts_with("301/heartbeat/"));
    assert!(heartbeat.clone().count() > 5);
    for (id, kind) in heartbeat {
        assert_eq!(*kind, Kind::NotApplicable, "{id}");
    }
}

#[test]
fn tpdos_without_event_timer() {
    let verdicts = verdicts(&without(EDS, &["1800sub5", "1801sub5", "1802sub5", "1803sub5"]));
    for id in [
        "301/pdo/cob-id/valid",
        "301/pdo/mapping/procedure",
        "301/state/pre-operational/tpdo",
        "301/state/stopped/tpdo",
        "301/tpdo/sync-cycle",
    ] {
        assert_eq!(verdicts[id], Kind::Pass, "{id}");
    }
    assert_eq!(verdicts["301/tpdo/event-timer"], Kind::NotApplicable);
}

/// Of the communication profile only PDO parameters can be written: values of the application serve.
#[test]
fn few_objects_that_can_be_written() {
    let mut eds = with(EDS, "1017", "AccessType=rw", "AccessType=const");
    eds = with(&eds, "1017", "DefaultValue=0", "DefaultValue=200");
    eds = with(&eds, "1005", "AccessType=rw", "AccessType=const");
    let gone = ["1006", "1007", "100C", "100D", "1015", "1019", "1029", "1800sub5", "1801sub5", "1802sub5", "1803sub5"];
    let verdicts = verdicts(&without(&eds, &gone));
    for id in ["301/sdo/download/expedited", "301/sdo/download/too-short", "301/sync/consumer-only"] {
        assert_eq!(verdicts[id], Kind::Pass, "{id}");
    }
}

/// All objects in PDOs have eight bytes, which no expedited SDO can carry.
#[test]
fn only_values_of_eight_bytes_in_pdos() {
    const WIDE: [&str; 4] = ["2021]", "2030subE]", "2030subF]", "2030sub10]"];
    let section = |text: &str| {
        let is_wide = WIDE.iter().any(|name| text.starts_with(name));
        let is_mapping = ["160", "1A0"].iter().any(|index| text.starts_with(index)) && text.contains("sub");
        let text = if is_wide { text.to_owned() } else { text.replace("PDOMapping=1", "PDOMapping=0") };
        let line = |line: &str| {
            if is_mapping && line.starts_with("DefaultValue=") { "DefaultValue=0" } else { line }.to_owned()
        };
        text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
    };
    let eds = EDS.split("\n[").map(section).collect::<Vec<_>>().join("\n[");
    let verdicts = verdicts(&eds);
    for id in [
        "301/rpdo/event-driven",
        "301/rpdo/synchronous",
        "301/rpdo/too-short",
        "301/rpdo/other-frames",
        "301/rpdo/load",
        "301/rpdo/cob-id/moved",
        "301/state/stopped/rpdo",
        "301/tpdo/sync-cycle",
        "301/tpdo/inhibit-time",
    ] {
        assert_eq!(verdicts.get(id), Some(&Kind::Pass), "{id}");
    }
    assert_eq!(verdicts["301/rpdo/too-long"], Kind::NotApplicable);
}

/// Behaviours that CiA 301 leaves open fail no case on NMT, error control, EMCY, SYNC, TIME or PDOs.
#[test]
fn what_the_text_leaves_open_fails_no_case() {
    let open = [
        Fault::LifeGuardingUnreported,
        Fault::HeartbeatConsumerSilent,
        Fault::GuardingSilentWhenOff,
        Fault::TpdoNotSentAtStart,
        Fault::AcyclicTpdoWithoutEvent,
        Fault::SyncLengthUnchecked,
        Fault::SyncWindowIgnored,
        Fault::RpdoDeadlineIgnored,
        Fault::RpdoRangeUnchecked,
        Fault::SynchronousRpdoRefused,
        Fault::EmptyPdoValidated,
        Fault::TimeIgnored,
        Fault::EmcyLostWhenStopped,
    ];
    let families = [
        "nmt",
        "boot-up",
        "state",
        "heartbeat",
        "heartbeat-consumer",
        "guarding",
        "life-guarding",
        "emcy",
        "error-behaviour",
        "time",
        "sync",
        "pdo",
        "rpdo",
        "tpdo",
    ];
    let is_one = |id: &str| families.iter().any(|family| id.starts_with(&format!("301/{family}/")));
    for fault in open {
        let model = Model::by_id(fault.model()).unwrap();
        // Other cases judge the contents of the error history.
        let is_judged = |case: &&Case| is_one(case.id) && !case.requires(&needs::ERROR_HISTORY);
        for case in catalogue::cases().into_iter().filter(is_judged) {
            let report = judge(case, model, Faults::from(fault));
            assert!(report.verdict.kind() != Kind::Fail, "{} with {fault}: {:?}", case.id, report.verdict.reason());
            let records = case.level == Level::Open && case.catches.contains(&fault);
            assert!(!records || !report.verdict.breaches().is_empty(), "{} records {fault}", case.id);
        }
    }
}

/// A device that starts by itself, as 1F80h allows, is operational after each reset.
#[test]
fn a_device_that_starts_by_itself() {
    let verdicts = verdicts(&with(EDS, "1F80", "DefaultValue=4", "DefaultValue=0"));
    for id in ["301/nmt/operational/reset-node", "301/nmt/stopped/reset-communication", "301/nmt/pre-operational/start"]
    {
        assert_eq!(verdicts[id], Kind::Pass, "{id}");
    }
}

/// An inhibit time as delivered that is longer than the event timers of the cases, and that equals the value that they
/// would write.
#[test]
fn an_inhibit_time_as_delivered() {
    let eds = with(EDS, "1800sub3", "DefaultValue=0", "DefaultValue=500");
    let verdicts = verdicts(&eds);
    for id in ["301/tpdo/event-timer", "301/tpdo/event-timer-mean", "301/pdo/inhibit-time/valid"] {
        assert_eq!(verdicts[id], Kind::Pass, "{id}");
    }
    let model: &'static Model = Box::leak(Box::new(Model::read(&eds, SHEET).unwrap()));
    let case = catalogue::find("301/pdo/inhibit-time/valid").unwrap();
    let report = judge(case, model, Faults::from(Fault::InhibitTimeChangeWhileValid));
    assert_eq!(report.verdict.kind(), Kind::Fail, "the value that is there is no change");
}

/// The cases write only values within the limits of the description by RPDO.
#[test]
fn an_object_with_narrow_limits() {
    let limits = "DefaultValue=0\nLowLimit=-5\nHighLimit=0";
    let verdicts = verdicts(&with(EDS, "2030sub3", "DefaultValue=0", limits));
    for id in ["301/rpdo/event-driven", "301/rpdo/synchronous", "301/rpdo/layout", "301/rpdo/too-long"] {
        assert_eq!(verdicts[id], Kind::Pass, "{id}");
    }
}

/// The cases that fail if the general data of the file differ from 1018h.
fn failing_identity(change: fn(&mut canvass_analyzer::dictionary::DeviceInfo)) -> Vec<&'static str> {
    let model = Model::by_id("reference-301").unwrap();
    let mut target = Target::of(model, model.default_node().unwrap());
    change(&mut target.description.as_mut().unwrap().device);
    let cases = catalogue::cases().into_iter().filter(|case| case.id.starts_with("301/identity/"));
    let failing = cases.filter(|case| judge_target(case, model, Faults::NONE, &target).verdict.kind() == Kind::Fail);
    failing.map(|case| case.id).collect()
}

#[test]
fn a_file_names_the_vendor_but_may_number_products_its_own_way() {
    let none: [&str; 0] = [];
    assert_eq!(failing_identity(|device| device.product_number = Some(4_711)), none);
    assert_eq!(failing_identity(|device| device.revision_number = Some(0x0009_0000)), none);
    assert_eq!(failing_identity(|device| device.vendor_number = Some(0)), none);
    assert_eq!(failing_identity(|device| device.vendor_number = Some(0x13)), ["301/identity/vendor-id"]);
}

/// A case that is marked as one that does not start the device does not make it operational: a run of only such cases
/// does not check the behaviour in operational.
#[test]
fn who_does_not_start_the_device_does_not_start_it() {
    let model = Model::by_id("reference-301").unwrap();
    let node = model.default_node().unwrap().raw();
    let target = Target::of(model, model.default_node().unwrap());
    let (starting, others): (Vec<_>, Vec<_>) =
        catalogue::cases().into_iter().partition(|case| case.may_start_the_device());
    assert!(others.len() > 100 && starting.len() > 100);
    for case in others {
        let report = judge_target(case, model, Faults::NONE, &target);
        let starts = report.evidence.frames().any(|exhibit| {
            exhibit.record.frame.cob_id() == Some(0)
                && matches!(exhibit.record.data(), [1, of] if *of == 0 || *of == node)
        });
        assert!(!starts, "{}", case.id);
    }
}
