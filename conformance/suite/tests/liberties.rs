//! Where the catalogue was once stricter than the text: what the standard leaves free, on a device that makes use of it.

// `cfg(test)` says nothing new here, but clippy tells by it where a test may unwrap.
#![cfg(test)]

use canvass_device::Liberty;
use canvass_device::models::Model;
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;
use canvass_suite::{catalogue, selftest};

/// How a case ends on a device that takes a liberty, with everything allowed.
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

/// What only these devices do is recorded, and fails nothing.
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
