//! Answers that a case once judged against CiA 301. Each is tested on right devices, and on a wrong device that the
//! case must still find.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::observation::Observation;
use canvass_device::models::Model;
use canvass_device::{Fault, Faults, Firmware, Liberties, Liberty};
use canvass_suite::clause::Level;
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;
use canvass_suite::{catalogue, selftest};

const EDS: &str = include_str!("../../device/models/reference-301.eds");
const SHEET: &str = include_str!("../../device/models/reference-301.toml");

fn judge(id: &str, firmware: impl Into<Firmware>) -> CaseReport {
    selftest::judge(catalogue::find(id).unwrap(), Model::by_id("reference-301").unwrap(), firmware)
}

/// Requires that a case passes on a device that takes all these liberties.
fn spared(id: &str, liberties: &[Liberty]) {
    let verdict = judge(id, liberties.iter().copied().collect::<Liberties>()).verdict;
    assert_eq!(verdict.kind(), Kind::Pass, "{id} on {liberties:?}: {:?}", verdict.reason());
}

/// Requires that a case is not applicable to a device that takes all these liberties.
fn inapplicable(id: &str, liberties: &[Liberty]) {
    let verdict = judge(id, liberties.iter().copied().collect::<Liberties>()).verdict;
    assert_eq!(verdict.kind(), Kind::NotApplicable, "{id} on {liberties:?}: {:?}", verdict.reason());
}

fn failed(id: &str, fault: Fault) -> CaseReport {
    let report = judge(id, fault);
    assert_eq!(report.verdict.kind(), Kind::Fail, "{id} on {fault}: {:?}", report.verdict.reason());
    report
}

#[test]
fn another_can_id_of_a_cob_id_in_use_is_refused_with_any_code() {
    let rows = [
        ("301/pdo/cob-id/valid", Fault::CobIdChangeWhileValid),
        ("301/pdo/cob-id/every-valid", Fault::CobIdChangeWhileValid),
        ("301/rpdo/cob-id/valid", Fault::CobIdChangeWhileValid),
        ("301/sync/cob-id-while-producing", Fault::SyncIdChangeWhileProducing),
        ("301/emcy/cob-id-while-valid", Fault::EmcyIdChangeWhileValid),
        ("301/sdo/second-server/valid", Fault::SdoChannelIdChangeWhileValid),
    ];
    for (id, fault) in rows {
        for liberty in [Liberty::CobIdCodeGeneral, Liberty::CobIdCodeState, Liberty::CobIdRewriteRefused] {
            spared(id, &[liberty]);
        }
        failed(id, fault);
    }
}

/// Step 3 of the mapping procedure names 0602 0000h and 0604 0041h, step 4 0602 0000h and 0604 0042h.
#[test]
fn a_mapping_that_is_too_long_is_refused_with_either_code_at_either_step() {
    let id = "301/pdo/mapping/too-long";
    for liberties in [
        &[][..],
        &[Liberty::CountCodeMissing],
        &[Liberty::MappingLengthAtEntry],
        &[Liberty::MappingLengthAtEntry, Liberty::CountCodeMissing],
    ] {
        spared(id, liberties);
    }
    failed(id, Fault::MappingTooLongAccepted);
}

#[test]
fn clauses_are_those_that_say_it() {
    let rows = [
        ("301/tpdo/at-start", "CiA 301 annex A", Level::Open),
        ("301/rpdo/too-short", "CiA 301 7.5.2.36", Level::Must),
        ("301/rpdo/too-long", "CiA 301 7.5.2.36", Level::Must),
        ("301/sync/wrong-length", "CiA 301 7.5.2.22", Level::Open),
        ("301/tpdo/sync-latency", "CiA 301 7.2.2.2", Level::Must),
        ("301/tpdo/sync-delay", "CiA 301 7.2.2.2", Level::Open),
    ];
    for (id, clause, level) in rows {
        let case = catalogue::find(id).unwrap();
        assert_eq!((case.clause.bare().as_str(), case.level), (clause, level), "{id}");
    }
}

/// A new initiate ends a segmented transfer and starts a new transfer. The standard does not say that an initiate ends
/// a block transfer.
#[test]
fn a_new_initiate_replaces_a_segmented_transfer() {
    let rows = [
        ("301/sdo/transfer/restart", Fault::SdoBusyAfterAbandonedTransfer),
        ("301/sdo/transfer/abandoned-download", Fault::SdoBusyAfterAbandonedDownload),
    ];
    for (id, fault) in rows {
        assert_eq!(catalogue::find(id).unwrap().level, Level::Must, "{id}");
        let report = failed(id, fault);
        let refused = Observation::Abort(AbortCode::COMMAND_SPECIFIER);
        let is_it = report.verdict.breaches().iter().any(|ruled| ruled.breach.actual == refused);
        assert!(is_it, "{id}: {:?}", report.verdict.reason());
    }
    for id in ["301/sdo/block-upload/restart", "301/sdo/block-download/abandoned"] {
        assert_eq!(catalogue::find(id).unwrap().level, Level::Open, "{id}");
        spared(id, &[Liberty::BlockInitiateRefused]);
    }
}

/// If an expected EMCY is missing, its consequences are not a second failure of the device.
#[test]
fn without_any_emcy_what_follows_from_one_is_inconclusive() {
    let unreported = Faults::from_iter([Fault::LifeGuardingUnreported, Fault::HeartbeatConsumerSilent]);
    let rows = [
        "301/emcy/inhibit-time",
        "301/emcy/generic-bit",
        "301/emcy/error-reset",
        "301/emcy/register-read",
        "301/error-history/entry",
        "301/error-history/full",
        "301/error-history/clear",
    ];
    for id in rows {
        let verdict = judge(id, unreported).verdict;
        assert_eq!(verdict.kind(), Kind::Inconclusive, "{id}: {:?}", verdict.reason());
        let reason = format!("{:?}", verdict.reason());
        assert!(reason.contains("EMCY"), "{id} names the cause: {reason}");
    }
    // 1015h is absent like EMCY; 1001h and 1003h remain.
    for id in ["301/emcy/generic-bit", "301/error-history/entry", "301/error-history/full"] {
        let verdict = judge(id, Liberties::from(Liberty::NoEmcy)).verdict;
        assert_eq!(verdict.kind(), Kind::Inconclusive, "{id}: {:?}", verdict.reason());
    }
}

/// The EDS without the objects of the device profile, and without the entries that map them.
fn without_profile() -> Model {
    let mut is_kept = true;
    let lines = EDS.lines().filter(|line| {
        if let Some(name) = line.strip_prefix('[') {
            is_kept = !name.starts_with('6');
        }
        is_kept
    });
    Model::read(&lines.map(|line| format!("{line}\n")).collect::<String>(), SHEET).unwrap()
}

/// Manufacturer variables need not be stored, and a reset may leave them unchanged.
#[test]
fn what_is_stored_of_the_manufacturers_variables_is_his_choice() {
    let model: &'static Model = Box::leak(Box::new(without_profile()));
    let rows = [
        ("301/store/all", Kind::Pass),
        ("301/store/persists", Kind::Pass),
        ("301/store/communication-only", Kind::NotApplicable),
        ("301/store/application-only", Kind::NotApplicable),
        ("301/store/reset-at-once", Kind::NotApplicable),
    ];
    for (id, right) in rows {
        for liberties in [Liberties::NONE, Liberties::from(Liberty::VariablesKept)] {
            let verdict = selftest::judge(catalogue::find(id).unwrap(), model, liberties).verdict;
            assert_eq!(verdict.kind(), right, "{id} on {liberties:?}: {:?}", verdict.reason());
        }
    }
    for id in ["301/store/all", "301/store/communication-only", "301/store/application-only", "301/store/reset-at-once"]
    {
        spared(id, &[Liberty::VariablesKept]);
    }
    failed("301/store/all", Fault::StoreLosesGroup);
    failed("301/store/communication-only", Fault::StoreGroupIgnored);
    failed("301/store/reset-at-once", Fault::StoreTornByReset);
}

/// A device that stores autonomously has no unstored values, and if that is its only way of storing, no store command
/// either.
#[test]
fn a_device_may_store_by_itself() {
    let by_command = ["wrong-signature", "persists", "all", "communication-only", "operational", "acts"];
    for name in by_command {
        inapplicable(&format!("301/store/{name}"), &[Liberty::StoresByItself]);
    }
    for name in ["wrong-signature", "persists", "all", "operational", "acts"] {
        spared(&format!("301/store/{name}"), &[Liberty::StoresBothWays]);
    }
    for id in ["301/store/not-stored", "301/store/communication-only", "301/store/reset-at-once"] {
        inapplicable(id, &[Liberty::StoresBothWays]);
    }
    for liberty in [Liberty::StoresByItself, Liberty::StoresBothWays] {
        spared("301/store/capability", &[liberty]);
    }
    spared("301/store/not-supported", &[Liberty::StoresByItself]);
}

/// Segments are mandatory only if an object has more than four bytes.
#[test]
fn a_device_of_short_objects_need_not_know_segments() {
    for case in catalogue::cases() {
        let verdict = judge(case.id, Liberties::from(Liberty::NoSegmentedTransfer)).verdict;
        let spared = matches!(verdict.kind(), Kind::Pass | Kind::NotApplicable);
        assert!(spared, "{}: {} {:?}", case.id, verdict.kind(), verdict.reason());
    }
    inapplicable("301/sdo/download/segmented-read-only", &[Liberty::NoSegmentedTransfer]);
    // A device with names that refuses segments is wrong.
    failed("301/sdo/download/segmented", Fault::SdoSegmentedShortRefused);
}

/// A write to a read-only object must be refused, but the refusal may come at once or at the end.
#[test]
fn a_refusal_may_come_at_the_end() {
    let rows = [
        ("301/sdo/download/segmented-read-only", Fault::SdoReadOnlySegmentedAccepted),
        ("301/sdo/download/segmented-missing", Fault::SdoWrongCodeForNoObject),
        ("301/sdo/block-download/read-only", Fault::SdoBlockReadOnlyAccepted),
        ("301/sdo/block-download/missing", Fault::SdoWrongCodeForNoSubIndex),
    ];
    for (id, fault) in rows {
        spared(id, &[Liberty::RefusedAtEnd]);
        failed(id, fault);
    }
}

/// The standard does not limit the time from SYNC to a synchronous TPDO, but overlooking a SYNC is wrong.
#[test]
fn synchronous_tpdos_take_their_time() {
    for id in ["301/tpdo/sync-latency", "301/tpdo/sync-cycle", "301/tpdo/sync-delay"] {
        spared(id, &[Liberty::SyncTpdoIn40Ms]);
    }
    let recorded = judge("301/tpdo/sync-delay", Liberties::from(Liberty::SyncTpdoIn40Ms));
    assert!(!recorded.verdict.breaches().is_empty(), "how long it takes is in the report");
    failed("301/tpdo/sync-latency", Fault::SyncOverlooked);
    failed("301/tpdo/sync-cycle", Fault::SyncCycleIgnored);
}

/// Sub-index 4 of a PDO communication parameter does not exist, even if a description contains it.
#[test]
fn the_reserved_entry_does_not_exist_though_it_is_described() {
    let id = "301/pdo/reserved-entry";
    spared(id, &[]);
    let sub = "[1800sub4]\nParameterName=reserved\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nDefaultValue=0\nPDOMapping=0\n\n";
    let (before, after) = EDS.split_once("[1800sub5]").unwrap();
    let (before, object) = before.rsplit_once("[1800]").unwrap();
    let eds = format!("{before}[1800]{object}{sub}[1800sub5]{after}");
    let model: &'static Model = Box::leak(Box::new(Model::read(&eds, SHEET).unwrap()));
    let verdict = selftest::judge(catalogue::find(id).unwrap(), model, Faults::NONE).verdict;
    assert_eq!(verdict.kind(), Kind::Fail, "{:?}", verdict.reason());
}
