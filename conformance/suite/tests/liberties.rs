//! Liberties of the standard that the catalogue once failed, each on a device that takes it.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_device::models::Model;
use canvass_device::{Fault, Liberty};
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;
use canvass_suite::{catalogue, selftest};

/// The report of a case on a device that takes a liberty, with everything allowed.
fn judge(id: &str, liberty: Liberty) -> CaseReport {
    selftest::judge(catalogue::find(id).unwrap(), Model::by_id(liberty.model()).unwrap(), liberty)
}

fn spared(liberty: Liberty, cases: &[&str]) {
    for id in cases {
        let report = judge(id, liberty);
        let verdict = &report.verdict;
        assert_eq!(verdict.kind(), Kind::Pass, "{id} on {}: {:?}", liberty.id(), verdict.reason());
    }
}

#[test]
fn a_repeated_toggle_bit_may_be_ignored() {
    spared(
        Liberty::ToggleIgnored,
        &[
            "301/sdo/download/segment-toggle",
            "301/sdo/download/second-toggle",
            "301/sdo/upload/first-toggle",
            "301/sdo/upload/repeated-toggle",
            "301/sdo/upload/over-after-abort",
            "301/sdo/upload/abort-names-object",
        ],
    );
}

/// A device may refuse a new request during a block transfer, or wait without a timeout for its client: the cases only
/// record this behaviour.
#[test]
fn a_new_request_in_a_block_transfer_is_left_open() {
    let cases = [
        "301/sdo/block-download/abandoned",
        "301/sdo/block-download/silent-client",
        "301/sdo/block-upload/restart",
        "301/sdo/block-upload/end-missing",
    ];
    spared(Liberty::BlockInitiateRefused, &cases);
    spared(Liberty::TransferWithoutTimeout, &cases);
    let recorded = judge("301/sdo/block-upload/restart", Liberty::BlockInitiateRefused);
    assert!(!recorded.verdict.breaches().is_empty(), "what the device does is in the report");
}

#[test]
fn one_of_several_codes() {
    let signatures = ["301/store/wrong-signature", "301/restore/wrong-signature"];
    spared(Liberty::SignatureCodeValue, &signatures);
    spared(Liberty::SignatureCodeGeneral, &signatures);
    spared(Liberty::HistoryCodeGeneral, &["301/error-history/empty", "301/dictionary/described"]);
    spared(Liberty::CobIdCodeGeneral, &["301/sdo/second-server/valid"]);
    spared(Liberty::CobIdCodeState, &["301/sdo/second-server/valid"]);
    spared(Liberty::LengthCodeGeneral, &["301/sdo/download/every-too-long", "301/sdo/download/every-too-short"]);
    let lengths = ["301/sdo/block-download/too-few-bytes", "301/sdo/block-download/wrong-crc"];
    spared(Liberty::LengthBeforeCrc, &lengths);
}

/// A device may accept only one length for a string. Cases that need other lengths are then not applicable; cases
/// that can work with any length use the accepted one.
#[test]
fn a_string_may_have_one_length() {
    let fits = ["301/sdo/block-download/block-ends", "301/sdo/block-download/complete"];
    spared(Liberty::StringsOfOneLength, &fits);
    // The five bytes of the string are one segment.
    for case in ["sequence-zero", "segment-lost", "segment-repeated", "segments-swapped"] {
        let report = judge(&format!("301/sdo/block-download/{case}"), Liberty::StringsOfOneLength);
        assert_eq!(report.verdict.kind(), Kind::NotApplicable, "{case}: {:?}", report.verdict.reason());
    }
    spared(Liberty::StringsOfOneLength, &["301/sdo/download/segment-ends", "301/sdo/block-upload/lengths"]);
}

#[test]
fn which_sync_of_a_cycle_counts_is_the_devices_matter() {
    spared(Liberty::SyncCountFromMiddle, &["301/tpdo/sync-count-restarts", "301/tpdo/sync-cycle"]);
}

#[test]
fn names_may_end_in_nul() {
    spared(Liberty::NamesEndInNul, &["301/identity/names", "301/sdo/block-upload/complete"]);
}

#[test]
fn errors_in_stopped_need_not_be_kept_and_codes_are_the_devices_own() {
    spared(Liberty::StoppedEmcyDropped, &["301/state/stopped/error-history"]);
    spared(Liberty::GenericErrorCodes, &["301/error-history/entry"]);
    let follow_up = judge("301/error-history/entry", Liberty::NoEmcy).verdict;
    assert_eq!(follow_up.kind(), Kind::Inconclusive, "without EMCY there is nothing to be kept");
}

/// A device with EMCY must report an RPDO that is too short; a device without EMCY need not.
#[test]
fn what_is_reported_by_emcy() {
    spared(Liberty::NoEmcy, &["301/rpdo/too-short"]);
    spared(Liberty::GenericErrorCodes, &["301/rpdo/too-short"]);
    let model = Model::by_id("reference-301").unwrap();
    let silent = selftest::judge(catalogue::find("301/rpdo/too-short").unwrap(), model, Fault::ShortRpdoUnreported);
    assert_eq!(silent.verdict.kind(), Kind::Fail);
    let lost = ["301/emcy/monitoring-lost", "301/heartbeat-consumer/lost", "301/heartbeat-consumer/all-entries"];
    spared(Liberty::LostHeartbeatUnreported, &lost);
    spared(Liberty::SyncLengthUnreported, &["301/sync/wrong-length"]);
    for id in ["301/emcy/inhibit-time", "301/emcy/generic-bit", "301/error-history/full"] {
        let verdict = judge(id, Liberty::NoEmcy).verdict;
        assert!(matches!(verdict.kind(), Kind::Inconclusive | Kind::NotApplicable), "{id}: {:?}", verdict.reason());
    }
}

#[test]
fn a_device_may_start_itself_and_choose_its_events() {
    let resets = ["pre-operational", "operational", "stopped"]
        .map(|state| ["reset-node", "reset-communication"].map(|reset| format!("301/nmt/{state}/{reset}")));
    let resets: Vec<&str> = resets.iter().flatten().map(String::as_str).collect();
    spared(Liberty::SelfStart, &resets);
    spared(Liberty::SelfStartByObject, &resets);
    spared(Liberty::OwnEvents, &["301/tpdo/acyclic", "301/tpdo/change"]);
    spared(Liberty::LongInhibitTime, &["301/tpdo/event-timer-mean"]);
}

#[test]
fn refusals_may_be_more_precise_or_come_earlier() {
    spared(Liberty::LimitCodePrecise, &["301/pdo/transmission-type/reserved", "301/sync/overflow-range"]);
    // The model whose objects have limits, on which the fault of unchecked limits shows.
    let model = Model::by_id(Fault::SdoRangeUnchecked.model()).unwrap();
    for id in ["301/sdo/download/out-of-range", "301/sdo/download/below-range"] {
        let report = selftest::judge(catalogue::find(id).unwrap(), model, Liberty::RangeCodeGeneral);
        assert!(!matches!(report.verdict.kind(), Kind::Fail | Kind::Error), "{id}: {:?}", report.verdict.reason());
        let checked = selftest::judge(catalogue::find(id).unwrap(), model, Fault::SdoRangeUnchecked);
        assert_eq!(checked.verdict.kind(), Kind::Fail, "{id} applies");
    }
    spared(Liberty::OverflowCodeGeneral, &["301/sync/overflow-while-running"]);
    let mapping = ["301/pdo/mapping/unmappable", "301/pdo/mapping/missing", "301/pdo/mapping/missing-sub-index"];
    spared(Liberty::EntryCodeMissing, &mapping);
    spared(Liberty::EntryCodeUnmappable, &mapping);
    spared(Liberty::CountCodeMissing, &["301/pdo/mapping/count"]);
    spared(Liberty::CobIdRewriteRefused, &["301/pdo/mapping/recovery", "301/emcy/cob-id"]);
}

#[test]
fn layer_setting_takes_its_time_and_fastscan_is_optional() {
    spared(Liberty::LssStoreIn2S, &["305/store/answer", "305/store/persists"]);
    spared(Liberty::BitRateTakenLate, &["305/bit-timing/activate", "305/bit-timing/takes-effect"]);
    for case in catalogue::cases().into_iter().filter(|case| case.id.starts_with("305/fastscan/")) {
        let verdict = judge(case.id, Liberty::NoFastscan).verdict;
        // This rule holds for all devices: a slave with a node-ID does not answer.
        let right = if case.id == "305/fastscan/configured" { Kind::Pass } else { Kind::NotApplicable };
        assert_eq!(verdict.kind(), right, "{}: {:?}", case.id, verdict.reason());
    }
}

#[test]
fn descriptions_that_other_tools_take() {
    spared(Liberty::EdsOneDigitHour, &["306/file/header"]);
    spared(Liberty::EdsListsOutOfOrder, &["306/file/counts", "306/file/sections"]);
}

#[test]
fn what_is_stored_is_the_devices_choice() {
    spared(Liberty::VariablesKept, &["301/store/all", "301/store/persists", "301/store/reset-at-once"]);
}

#[test]
fn blocks_and_answers_of_any_length() {
    let blocks = ["segment-lost", "segment-repeated", "segments-swapped", "block-ends"];
    spared(
        Liberty::SmallBlocks,
        &blocks.map(|name| format!("301/sdo/block-download/{name}")).each_ref().map(|id| &**id),
    );
    let slow =
        ["301/sdo/block-download/client-abort", "301/sdo/second-server/parallel", "301/sdo/transfer/back-to-back"];
    spared(Liberty::AnswersIn900Ms, &slow);
    spared(Liberty::AnswersVary, &slow);
    spared(Liberty::PdoParametersLocked, &["301/sdo/download/expedited", "301/store/persists"]);
}
