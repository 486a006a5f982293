//! All faults in one capture: no fault hides another, and no fault looks like one that does not exist.

use crate::traffic::{END, Traffic, hex, machine, shown};
use canvass_analyzer::findings::all;
use std::collections::BTreeSet;

/// The expected findings: rule, node, and time of the first occurrence in milliseconds.
const EXPECTED: &[(&str, Option<u8>, u64)] = &[
    ("bus/before-boot-up", Some(4), 20_110),
    ("bus/duplicate-node-id", Some(3), 27_060),
    ("bus/overlapping-cob-id", Some(6), 583),
    ("bus/restricted-cob-id", Some(4), 593),
    ("bus/unknown-ids", None, 2_000),
    ("emcy/contradiction", Some(5), 17_100),
    ("emcy/never-cleared", Some(3), 17_000),
    ("emcy/raised", Some(3), 17_000),
    ("emcy/raised", Some(5), 17_100),
    ("emcy/raised", Some(6), 18_000),
    ("emcy/storm", Some(6), 18_000),
    ("encoder/alarm", Some(3), 25_560),
    ("encoder/parameter-changed", Some(3), 25_880),
    ("encoder/position-jump", Some(3), 25_700),
    ("encoder/position-outside-range", Some(3), 25_820),
    ("encoder/redundant-channels", Some(10), 14_000),
    ("encoder/warning", Some(3), 25_580),
    ("lss/dialogue", None, 653),
    ("lss/not-stored", None, 653),
    ("lss/refused", None, 663),
    ("lss/unanswered", None, 670),
    ("nodes/boot-up-without-command", Some(4), 25_100),
    ("nodes/command-not-obeyed", Some(4), 10_031),
    ("nodes/consumer-time", Some(3), 7_110),
    ("nodes/guarding-toggle", Some(6), 15_400),
    ("nodes/guarding-unanswered", Some(6), 15_100),
    ("nodes/heartbeat-ended", Some(10), 19_530),
    ("nodes/heartbeat-jitter", Some(7), 0),
    ("nodes/heartbeat-late", Some(1), 5_075),
    ("nodes/heartbeat-missing", Some(1), 6_910),
    ("nodes/life-guarding", Some(6), 20_500),
    ("nodes/lost", Some(5), 27_960),
    ("nodes/no-boot-up", Some(9), 22_000),
    ("nodes/pdo-outside-operational", Some(8), 12_010),
    ("nodes/repeated-resets", Some(4), 27_100),
    ("nodes/sdo-in-stopped", Some(9), 13_503),
    ("nodes/state-lost", Some(5), 15_060),
    ("pdo/inhibit-time", Some(3), 11_508),
    ("pdo/jitter", Some(5), 0),
    ("pdo/length", Some(3), 9_000),
    ("pdo/period", Some(3), 9_457),
    ("pdo/sync-counter", None, 14_020),
    ("pdo/sync-missing", None, 13_980),
    ("pdo/sync-pdo-missing", Some(3), 14_520),
    ("pdo/sync-window", Some(3), 14_709),
    ("pdo/time-jump", None, 16_500),
    ("sdo/aborted", Some(3), 3_123),
    ("sdo/late", Some(6), 22_900),
    ("sdo/protocol-violation", Some(6), 24_003),
    ("sdo/retries", Some(6), 23_300),
    ("sdo/store-wear", Some(8), 3_000),
    ("sdo/unanswered", Some(4), 21_500),
];

/// Rules with captures of their own, because their faults would disturb all others here: a full bus, an irregular SYNC,
/// a damaged file.
const ELSEWHERE: &[&str] = &[
    "bus/flying-master",
    "bus/frame-kind",
    "bus/load",
    "bus/malformed",
    "bus/no-canopen",
    "bus/repeated",
    "bus/two-producers",
    "capture/bus-off",
    "capture/clock-steps",
    "capture/coarse-timestamps",
    "capture/copies",
    "capture/damaged",
    "capture/dropped",
    "capture/error-flood",
    "capture/error-frames",
    "capture/error-passive",
    "capture/gaps",
    "capture/out-of-order",
    "capture/overrun",
    "drive/fault",
    "drive/left-operation",
    "drive/not-enabled",
    "encoder/position-frozen",
    "encoder/raw-position",
    "lss/address-series",
    "lss/left-in-configuration",
    "lss/not-in-configuration",
    "lss/same-address",
    "lss/store-wear",
    "lss/undefined-request",
    "nodes/boot-unfinished",
    "nodes/guarding-ended",
    "nodes/heartbeat-additional",
    "nodes/left-stopped",
    "nodes/starts-twice",
    "pdo/cycle-too-short",
    "pdo/ended",
    "pdo/length-changed",
    "pdo/of-unknown-node",
    "pdo/out-of-rhythm",
    "pdo/received-ended",
    "pdo/request-unanswered",
    "pdo/sync-additional",
    "pdo/sync-jitter",
    "pdo/unrequested",
    "sdo/impatient-client",
    "sdo/reserved-bits",
    "sdo/too-early",
    "sdo/unfinished",
    "srdo/ended",
    "srdo/halves",
];

/// The time of findings that depends on their worst moment; it is not compared.
const ANY: u64 = 0;

fn faults() -> Traffic {
    let mut traffic = machine();
    further_nodes(&mut traffic);
    configuration(&mut traffic);
    heartbeats_and_states(&mut traffic);
    process_data(&mut traffic);
    transfers(&mut traffic);
    errors(&mut traffic);
    traffic
}

/// Node 5 with a cyclic PDO, the irregular node 7, the nodes 8 and 9, which nobody starts, and the draw-wire encoder
/// 10.
fn further_nodes(traffic: &mut Traffic) {
    traffic.at(105, "705#00").every(200, 1_000, 100, |_| "705#7F".to_owned());
    traffic.sdo(540, 5, "2F001802FE000000", "6000180200000000").sdo(550, 5, "2B00180532000000", "6000180500000000");
    for n in 0..240_u64 {
        traffic.at(2_007 + n * 50 + if n % 3 == 0 { 20 } else { 0 }, "185#0000");
    }
    traffic.every(1_060, 15_000, 100, |_| "705#05".to_owned()).every(15_060, 16_000, 100, |_| "705#7F".to_owned());
    traffic.at(16_010, "000#0105").every(16_060, 28_000, 100, |_| "705#05".to_owned());
    for n in 0..285_u64 {
        traffic.at(1_060 + n * 100 + n * 37 % 7 * 8, "707#05");
    }
    traffic.at(2_000, "708#00").every(2_090, END, 100, |_| "708#7F".to_owned()).at(12_010, "188#01");
    traffic.at(2_010, "709#00").at(13_000, "000#0209").sdo(13_500, 9, "4000100000000000", "4300100091010000");
    traffic.at(22_000, "000#8109");
    traffic.sdo(410, 10, "4000100000000000", "4300100096010000").sdo(420, 10, "40001A0000000000", "4F001A0002000000");
    traffic.sdo(430, 10, "40001A0100000000", "43001A0110002060").sdo(440, 10, "40001A0200000000", "43001A0210002060");
    traffic.every(2_030, 20_000, 500, |_| "70A#05".to_owned());
    traffic.every(2_000, END, 100, |n| {
        let (a, b) = ((100 + n) as u16, if n == 120 { 4_000 } else { (47_000 - 100 - n) as u16 });
        format!("18A#{:04X}{:04X}", a.swap_bytes(), b.swap_bytes())
    });
}

fn configuration(traffic: &mut Traffic) {
    traffic.sdo(570, 4, "23021801A0030040", "6002180100000000").sdo(580, 6, "23021801A0030040", "6002180100000000");
    traffic.sdo(590, 4, "2301180101010040", "6001180100000000");
    traffic.sdo(600, 3, "23161001C8000100", "6016100100000000").sdo(610, 3, "2307100088130000", "6007100000000000");
    traffic.sdo(620, 6, "2B0C10002C010000", "600C100000000000").sdo(630, 6, "2F0D100002000000", "600D100000000000");
    traffic.at(640, "7E5#0401000000000000").at(650, "7E5#112A000000000000");
    traffic.at(653, "7E4#1100000000000000").micros(653_500, "7E4#1100000000000000");
    traffic.at(660, "7E5#1300040000000000").at(663, "7E4#1301000000000000").at(670, "7E5#1700000000000000");
    traffic.at(690, "7E5#0400000000000000").every(2_000, 3_000, 100, |_| "6E1#0102".to_owned());
}

fn heartbeats_and_states(traffic: &mut Traffic) {
    traffic.silence(0x701, 5_005, 5_015).at(5_075, "701#05").silence(0x701, 7_000, 7_150);
    traffic.silence(0x704, 10_031, 11_045).every(10_066, 11_045, 200, |_| "704#05".to_owned());
    traffic.remove(|ms, frame| ms == 15_100 && frame.cob_id() == Some(0x706)).silence(0x706, 20_000, 21_450);
    traffic.at(20_110, "704#7F").silence(0x704, 25_000, END).silence(0x184, 25_000, END);
    for n in 0..3 {
        traffic
            .at(25_100 + n * 1_000, "704#00")
            .every(25_300 + n * 1_000, 26_000 + n * 1_000, 200, |_| "704#7F".to_owned());
    }
}

fn process_data(traffic: &mut Traffic) {
    let synchronous = |at: u64| move |ms: u64, frame: &canvass_traces::Frame| ms == at && frame.cob_id() == Some(0x183);
    traffic.remove(synchronous(9_000)).micros(9_000_400, "183#0102").silence(0x283, 9_500, 9_650);
    traffic.at(11_508, "283#0000").at(11_509, "283#0001");
    traffic.remove(|ms, frame| (14_000..14_020).contains(&ms) && matches!(frame.cob_id(), Some(0x080 | 0x183)));
    traffic.remove(synchronous(14_500)).remove(synchronous(14_700));
    traffic.micros(14_709_000, &format!("183#{}", hex(4096 + 684 * 3)));
    traffic.silence(0x100, 16_000, END);
    traffic.every(16_500, END, 1_000, |n| format!("100#{} 0010", hex(7_200_000 + (n + 15) * 1000)));
    traffic.remove(synchronous(25_700)).micros(25_700_400, &format!("183#{}", hex(9_000_000)));
}

fn transfers(traffic: &mut Traffic) {
    for n in 0..12 {
        traffic.sdo(3_000 + n * 500, 8, "2310100173617665", "6010100100000000");
    }
    traffic.sdo(3_120, 3, "2304600000000000", "8004600002000106").at(21_500, "604#4000100000000000");
    traffic.at(22_000, "606#4000100000000000").at(22_900, "586#4300100091010000");
    traffic.at(23_000, "606#4000100000000000").sdo(23_300, 6, "4000100000000000", "4300100091010000");
    traffic.sdo(24_000, 6, "4000100000000000", "4300100196010200");
    traffic.sdo(25_560, 3, "4003650000000000", "4B03650001000000").sdo(
        25_580,
        3,
        "4005650000000000",
        "4B05650010000000",
    );
    traffic.sdo(25_820, 3, "4004600000000000", "4304600000000002").sdo(
        25_880,
        3,
        "2303600000000000",
        "6003600000000000",
    );
    traffic.sdo(27_060, 3, "4018100400000000", "4318100400000001");
}

fn errors(traffic: &mut Traffic) {
    traffic.at(17_000, "083#1081110000000000");
    traffic.at(17_100, "085#0042000000000000").at(17_200, "085#0000000000000000");
    traffic.every(18_000, 18_240, 20, |n| {
        format!("086#{}", if n % 2 == 0 { "1081110000000000" } else { "0000000000000000" })
    });
}

#[test]
fn every_fault_is_found_among_all_others() {
    let findings = faults().results().findings;
    let begin = 1_700_000_000_000_000_000_u64;
    let mut missing = Vec::new();
    for &(rule, node, ms) in EXPECTED {
        let own =
            findings.iter().filter(|finding| finding.rule.id == rule && finding.node.map(|node| node.raw()) == node);
        let near = |first: u64| ms == ANY || (first / 1_000_000).abs_diff(ms) <= 100;
        if !own.clone().any(|finding| near(finding.first.nanos().saturating_sub(begin))) {
            missing.push(format!("{rule} of {node:?} at {ms} ms: {:?}", own.map(shown).collect::<Vec<_>>()));
        }
    }
    let expected = |rule: &str, node: Option<u8>| EXPECTED.iter().any(|row| (row.0, row.1) == (rule, node));
    let others = findings.iter().filter(|finding| !expected(finding.rule.id, finding.node.map(|node| node.raw())));
    let others: Vec<_> = others.map(shown).collect();
    assert!(missing.is_empty() && others.is_empty(), "missing: {missing:#?}\nwrong: {others:#?}");
}

/// Every rule needs a capture in which it finds something.
#[test]
fn every_rule_has_its_fault() {
    let proven: BTreeSet<&str> = EXPECTED.iter().map(|row| row.0).chain(ELSEWHERE.iter().copied()).collect();
    let rules: BTreeSet<&str> = all().map(|definition| definition.metadata.id).collect();
    assert_eq!(rules, proven);
}
