//! `canopen-rs` 0.6.1.

use super::{Expected, Outcome, PDO_PARAMETERS_UNCHECKED, Peer, expect, judge, passed, trace};
use canvass_stacks::canopen_rs::{CanopenRs, EDS, NODE};
use canvass_suite::verdict::Kind::{Fail, Inconclusive};

/// Defects of the stack, explained in `docs/peers.md`; PDO parameters are stored with few checks or none.
const EXPECTED: &Expected = &[
    ("301/dictionary/highest-sub-index", Fail, NO_SUB_INDEX),
    ("301/dictionary/structure", Fail, NO_SUB_INDEX),
    ("301/pdo/reserved-entry", Fail, NO_SUB_INDEX),
    ("301/sdo/download/segmented-missing", Fail, NO_SUB_INDEX),
    ("301/sdo/upload/no-sub-index", Fail, NO_SUB_INDEX),
    ("301/error-history/empty", Fail, "entries of 1003h are there, and 0, while there is no error"),
    ("301/error-history/not-zero", Fail, "any value written to 1003h:00 is confirmed"),
    ("301/heartbeat/length", Fail, LENGTH),
    ("301/sdo/download/every-too-short", Fail, LENGTH),
    ("301/sdo/download/too-short", Fail, LENGTH),
    ("301/sdo/download/segments-too-long", Fail, "more bytes than announced are called too few"),
    ("301/sdo/download/size-not-announced", Fail, "a segmented download must announce its size"),
    ("301/pdo/mapping/dummy-in-rpdo", Fail, PDO_PARAMETERS),
    ("301/pdo/mapping/dummy-in-tpdo", Fail, PDO_PARAMETERS),
    ("301/pdo/mapping/entry-in-use", Fail, PDO_PARAMETERS),
    ("301/pdo/mapping/missing", Fail, PDO_PARAMETERS),
    ("301/pdo/mapping/missing-sub-index", Fail, PDO_PARAMETERS),
    ("301/rpdo/synchronous", Fail, "an RPDO acts when it comes, whatever its transmission type"),
    ("301/tpdo/sync-count-restarts", Fail, EVERY_SYNC),
    ("301/tpdo/sync-cycle", Fail, EVERY_SYNC),
    ("301/tpdo/remote-sampled", Fail, REMOTE),
    ("301/tpdo/remote-triggered", Fail, REMOTE),
    ("301/rpdo/too-short", Fail, "an RPDO that is too short causes no EMCY"),
    ("301/sdo/download/several-reasons", Fail, NO_SUB_INDEX),
    ("305/bit-timing/activate", Inconclusive, BIT_TIMING),
    ("305/bit-timing/reserved", Fail, BIT_TIMING),
    ("305/bit-timing/table", Fail, BIT_TIMING),
    ("305/fastscan/out-of-range", Fail, "bit checks 32 to 127 and 129 to 255 begin a Fastscan"),
    ("305/identify/at-bounds", Fail, IDENTIFY),
    ("305/identify/halving", Fail, IDENTIFY),
    ("305/identify/within", Fail, IDENTIFY),
    ("305/identify/outside", Inconclusive, IDENTIFY),
    ("305/unconfigured/identify", Fail, "the search for slaves without node-ID (4Ch) is not answered"),
    ("305/switch-global/reserved-mode", Fail, "every mode but 1 leads to waiting"),
    ("305/switch-selective/in-configuration", Fail, "the address is answered in configuration too"),
];

const NO_SUB_INDEX: &str = "a missing sub-index is called a missing object";
const LENGTH: &str = "too few bytes are called too many";
const PDO_PARAMETERS: &str = "PDO parameters are stored without a check";
const EVERY_SYNC: &str = "every SYNC sends every synchronous TPDO";
const REMOTE: &str = "transmission types for remote frames are taken, and remote frames not answered";
const BIT_TIMING: &str = "configure bit timing is not answered";
const IDENTIFY: &str = "identify remote slave (46h to 4Bh) is not answered";

fn peer() -> Peer {
    Peer::new(CanopenRs::new(), EDS, NODE)
}

fn outcome() -> Outcome {
    judge(peer(), true, "")
}

#[test]
fn fails_what_is_documented() {
    let outcome = outcome();
    expect(&outcome, EXPECTED, &PDO_PARAMETERS_UNCHECKED);
    assert!(passed(&outcome) >= 163, "{} passed", passed(&outcome));
    assert_eq!(outcome.notices, Vec::<String>::new());
    assert_eq!(outcome.memorial.deaths(), []);
}

#[test]
fn runs_the_same_each_time() {
    assert_eq!(trace(&outcome()), trace(&outcome()));
}

/// Without its description fewer cases apply, and no further case fails.
#[test]
fn without_description() {
    let outcome = judge(peer(), false, "");
    let known: Vec<&str> = EXPECTED.iter().map(|(id, ..)| *id).chain(PDO_PARAMETERS_UNCHECKED).collect();
    let failed = outcome.reports.iter().filter(|report| report.verdict.kind() == Fail);
    let new: Vec<&str> = failed.map(|report| report.case.id).filter(|id| !known.contains(id)).collect();
    assert_eq!(new, Vec::<&str>::new());
}
