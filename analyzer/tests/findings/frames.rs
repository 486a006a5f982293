//! Frames of another kind than their message, frames that are repeated or come beside the regular ones, and PDOs and
//! SRDOs that are asked for or stay away.

use crate::traffic::{END, Traffic, machine};
use canvass_analyzer::findings::Severity;

#[test]
fn a_heartbeat_with_29_bits() {
    let mut traffic = machine();
    traffic.silence(0x703, 15_000, 15_200).at(15_060, "00000703#05");
    let found = traffic.finds_among(&["bus/frame-kind", "nodes/heartbeat-missing"], "bus/frame-kind", Some(3), 15_060);
    assert!(found.message.contains("29 bits 703h"), "{}", found.message);
}

#[test]
fn a_command_as_a_remote_frame() {
    let mut traffic = machine();
    traffic.at(15_000, "000#R2").finds("bus/frame-kind", None, 15_000);
    // A consumer may ask for a TPDO, and a master for the state of a node.
    let mut asked = machine();
    asked.at(15_005, "184#R1").at(15_007, "184#00").only(&[]);
}

#[test]
fn an_emcy_that_is_repeated_without_pause() {
    let mut traffic = machine();
    traffic.every(15_000, 15_100, 1, |_| "084#0010010000000000".to_owned());
    let found = traffic.results();
    let head = &found.findings[found.stories[0].head[0]];
    assert_eq!((head.rule.id, head.node.map(|node| node.raw())), ("bus/repeated", Some(4)), "{:#?}", found.stories);
}

/// A TPDO of 2 ms with resting data was always as fast; only one that was slower is repeated.
#[test]
fn a_fast_pdo_is_not_repeated() {
    let mut traffic = machine();
    traffic.every(START_OF_PDO, END, 2, |_| "384#0102".to_owned());
    assert!(traffic.results().findings.iter().all(|finding| finding.rule.id != "bus/repeated"));
    let mut slow = machine();
    slow.every(START_OF_PDO, 15_000, 100, |_| "384#0102".to_owned());
    slow.every(15_000, 15_200, 1, |_| "384#0102".to_owned());
    assert!(slow.results().findings.iter().any(|finding| finding.rule.id == "bus/repeated"));
}

/// A client may read an object again as soon as it has the answer, and a master may make a PDO faster.
#[test]
fn a_poll_and_a_new_period_repeat_nothing() {
    let repeated =
        |traffic: &mut Traffic| traffic.results().findings.iter().any(|found| found.rule.id == "bus/repeated");
    let mut polled = machine();
    for at in (15_000..15_200).step_by(2) {
        polled.at(at, "604#4041600000000000").at(at + 1, "584#4B41600037020000");
    }
    assert!(!repeated(&mut polled));
    let mut unanswered = machine();
    unanswered.every(15_000, 15_200, 2, |_| "604#4041600000000000".to_owned());
    assert!(repeated(&mut unanswered));
    let mut faster = machine();
    faster.every(START_OF_PDO, 15_000, 100, |_| "384#0102".to_owned());
    faster.at(15_010, "604#2B01180502000000").at(15_011, "584#6001180500000000");
    faster.every(15_020, 15_400, 2, |_| "384#0102".to_owned());
    assert!(!repeated(&mut faster));
}

const START_OF_PDO: u64 = 2_001;

#[test]
fn a_heartbeat_beside_the_regular_ones() {
    let mut traffic = machine();
    let found = traffic.at(15_090, "703#05").finds("nodes/heartbeat-additional", Some(3), 15_160);
    assert!(found.message.starts_with("heartbeats after"), "{}", found.message);
    // A node may show a new state at once.
    let mut stopped = machine();
    stopped.at(15_070, "000#8004").silence(0x704, 15_070, END).silence(0x184, 15_070, END);
    stopped.at(15_075, "704#7F").every(15_266, END, 200, |_| "704#7F".to_owned());
    assert!(stopped.results().findings.iter().all(|finding| finding.rule.id != "nodes/heartbeat-additional"));
}

#[test]
fn a_sync_beside_the_regular_ones() {
    let mut traffic = Traffic::default();
    traffic.every(30, 10_000, 100, |_| "701#05".to_owned()).every(0, 10_000, 50, |_| "080#".to_owned());
    traffic.clone().at(5_012, "080#").finds("pdo/sync-additional", None, 5_050);
    traffic.only(&[]);
}

#[test]
fn a_pdo_to_a_node_that_ends() {
    let nodes = || {
        let mut traffic = Traffic::default();
        for node in [1, 2] {
            traffic.every(30 + node, 40_000, 100, |_| format!("70{node}#05"));
        }
        traffic
    };
    let found = nodes().every(5, 20_000, 100, |_| "202#0102".to_owned()).finds("pdo/received-ended", Some(2), 19_905);
    assert_eq!(found.severity, Severity::Warning);
    let mut pause = nodes();
    pause.every(5, 15_000, 100, |_| "202#0102".to_owned()).every(20_005, 40_000, 100, |_| "202#0102".to_owned());
    pause.finds("pdo/received-ended", Some(2), 14_905);
    // A TPDO of the node ends, too: the application on both sides has stopped.
    let mut both = nodes();
    both.every(5, 20_000, 100, |_| "202#0102".to_owned()).every(7, 20_000, 100, |_| "182#0102".to_owned());
    both.only(&[]);
}

#[test]
fn a_request_for_a_pdo_that_gets_no_answer() {
    let mut traffic = Traffic::default();
    traffic.every(30, 20_000, 100, |_| "702#05".to_owned()).every(500, 20_000, 500, |_| "182#R4".to_owned());
    traffic.every(502, 20_000, 500, |n| format!("182#{:02X}000000", n & 0xFF)).only(&[]);
    traffic.silence(0x182, 10_002, 10_003).finds("pdo/request-unanswered", Some(2), 10_000);
}

/// The node answers after 2 ms; one request gets none before the next one comes.
#[test]
fn a_request_for_a_pdo_that_is_asked_again() {
    let mut traffic = Traffic::default();
    traffic.every(30, 20_000, 100, |_| "702#05".to_owned()).every(500, 20_000, 100, |_| "182#R4".to_owned());
    traffic.every(502, 20_000, 100, |n| format!("182#{:02X}000000", n & 0xFF)).only(&[]);
    let asked = traffic.silence(0x182, 10_002, 10_003).finds("pdo/request-unanswered", Some(2), 10_000);
    assert!(asked.message.contains("before the next request"), "{}", asked.message);
}

#[test]
fn a_request_for_a_pdo_with_29_bits() {
    let mut traffic = Traffic::default();
    traffic.every(30, 20_000, 100, |_| "702#05".to_owned()).every(500, 20_000, 500, |_| "182#R4".to_owned());
    traffic.every(502, 20_000, 500, |n| format!("182#{:02X}000000", n & 0xFF));
    let found = traffic.at(10_100, "00000182#R4").finds("bus/frame-kind", Some(2), 10_100);
    assert!(found.message.starts_with("a remote frame of 29 bits 182h"), "{}", found.message);
}

#[test]
fn a_pdo_on_request_that_comes_unrequested() {
    let polled = |transmission_type: &str| {
        let mut traffic = Traffic::default();
        traffic.at(10, &format!("602#2F001802{transmission_type}000000")).at(11, "582#6000180200000000");
        traffic.every(30, 20_000, 100, |_| "702#05".to_owned()).every(500, 20_000, 500, |_| "182#R4".to_owned());
        traffic.every(502, 20_000, 500, |n| format!("182#{:02X}000000", n & 0xFF));
        traffic
    };
    polled("FD").only(&[]);
    polled("FD").at(10_100, "182#55000000").finds("pdo/unrequested", Some(2), 10_100);
    // An event may send a PDO of another type.
    polled("FF").at(10_100, "182#55000000").only(&[]);
}

/// Node 2 sends an SRDO every 50 ms.
fn safety() -> Traffic {
    let mut traffic = Traffic::default();
    traffic.every(30, 20_000, 100, |_| "702#05".to_owned());
    traffic.every(10, 20_000, 50, |n| format!("103#{:02X}00", n & 0xFF));
    traffic.every(11, 20_000, 50, |n| format!("104#{:02X}FF", !n & 0xFF));
    traffic
}

#[test]
fn halves_of_an_srdo_that_do_not_fit() {
    let among = ["bus/unknown-ids", "srdo/halves"];
    safety().only(&["bus/unknown-ids"]);
    safety().silence(0x104, 10_000, 10_040).finds_among(&among, "srdo/halves", Some(2), 10_060);
    safety().silence(0x104, 10_000, 10_040).at(10_011, "104#0000").finds_among(&among, "srdo/halves", Some(2), 10_011);
}

#[test]
fn an_srdo_that_changes_its_length() {
    let among = ["bus/unknown-ids", "srdo/halves"];
    let mut traffic = safety();
    traffic.silence(0x103, 10_000, 10_040).at(10_010, "103#55").silence(0x104, 10_000, 10_040).at(10_011, "104#AA");
    let found = traffic.finds_among(&among, "srdo/halves", Some(2), 10_010);
    assert!(found.message.starts_with("1 bytes, the 199 before had 2"), "{}", found.message);
}

#[test]
fn an_srdo_that_ends() {
    let mut traffic = safety();
    traffic.silence(0x103, 10_000, 20_000).silence(0x104, 10_000, 20_000);
    traffic.finds_among(&["bus/unknown-ids", "srdo/ended"], "srdo/ended", Some(2), 9_960);
}

/// Old bytes in a request do no harm.
#[test]
fn reserved_bytes_are_an_information() {
    let mut traffic = machine();
    traffic.sdo(15_000, 3, "4000100001020304", "4300100096010200");
    assert_eq!(traffic.finds("sdo/reserved-bits", Some(3), 15_000).severity, Severity::Info);
}

/// A command to one node explains no silence of SYNC that began long before.
#[test]
fn sync_that_ends_before_a_command() {
    let mut traffic = Traffic::default();
    traffic.every(30, 40_000, 100, |_| "701#05".to_owned()).every(31, 40_000, 100, |_| "702#05".to_owned());
    traffic.every(0, 20_000, 50, |_| "080#".to_owned()).at(25_000, "000#0102");
    traffic.finds("pdo/sync-missing", None, 19_950);
}
