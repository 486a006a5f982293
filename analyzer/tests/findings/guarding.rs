//! Node guarding and heartbeat are one byte on the same CAN-ID: neither is mistaken for the other.

use crate::traffic::Traffic;

/// Heartbeats of the nodes 3 and 4, every 500 ms.
fn heartbeats() -> Traffic {
    let mut traffic = Traffic::default();
    traffic.every(200, 40_000, 500, |_| "703#7F".to_owned());
    traffic.at(100, "704#00").every(600, 40_000, 500, |_| "704#7F".to_owned());
    traffic
}

#[test]
fn one_guarding_request_ends_no_heartbeats() {
    let mut traffic = heartbeats();
    traffic.at(3_300, "704#R1").at(3_301, "704#7F").only(&[]);
    // Guarding hides no missing heartbeat.
    let mut missing = traffic.clone();
    missing.silence(0x704, 20_000, 20_700).finds("nodes/heartbeat-missing", Some(4), 19_600);
    traffic.silence(0x704, 30_000, 40_000).finds("nodes/lost", Some(4), 29_600);
}

#[test]
fn one_guarding_request_without_an_answer_ends_no_heartbeats() {
    let unanswered = "nodes/guarding-unanswered";
    let mut traffic = heartbeats();
    traffic.at(3_300, "704#R1").finds(unanswered, Some(4), 3_300);
    let rules = [unanswered, "nodes/heartbeat-missing"];
    traffic.silence(0x704, 20_000, 20_700).finds_among(&rules, rules[1], Some(4), 19_600);
}

/// Node 4 sends its state once, is guarded, and is then configured to send heartbeats every 500 ms.
fn guarded_then_heartbeats() -> Traffic {
    let mut traffic = Traffic::default();
    traffic.at(0, "704#05");
    for n in 0..8 {
        traffic.at(300 + n * 300, "704#R1").at(301 + n * 300, &format!("704#{:02X}", 0x85 ^ (n & 1) << 7));
    }
    traffic.sdo(2_500, 4, "2B0C100000000000", "600C100000000000");
    traffic.sdo(2_520, 4, "2B171000F4010000", "6017100000000000");
    traffic.every(3_020, 20_000, 500, |_| "704#05".to_owned());
    traffic.every(50, 20_000, 100, |_| "184#00000000".to_owned());
    traffic
}

#[test]
fn heartbeats_follow_guarding_without_a_boot_up() {
    guarded_then_heartbeats().only(&[]);
    let mut missing = guarded_then_heartbeats();
    missing.silence(0x704, 10_000, 11_900).finds("nodes/heartbeat-missing", Some(4), 9_520);
    let mut ended = guarded_then_heartbeats();
    ended.silence(0x704, 15_000, 20_000).finds("nodes/heartbeat-ended", Some(4), 14_520);
}

#[test]
fn guarding_answers_with_heartbeats_between_them() {
    let mut traffic = heartbeats();
    for n in 0..19 {
        traffic.at(30 + n * 2_000, "704#R1").at(31 + n * 2_000, &format!("704#{:02X}", 0x7F | (n & 1) << 7));
    }
    // The boot-up of node 4 comes later.
    traffic.silence(0x704, 0, 100).only(&[]);
    traffic.silence(0x704, 20_500, 21_500).finds("nodes/heartbeat-missing", Some(4), 20_100);
}

/// A recorder omits the remote frames, and the master stops guarding.
#[test]
fn guarding_without_its_requests_ends() {
    let mut traffic = Traffic::default();
    traffic.every(300, 10_000, 500, |n| format!("704#{:02X}", 0x05 | (n & 1) << 7));
    traffic.every(50, 19_000, 100, |_| "184#00000000".to_owned());
    traffic.only(&[]);
}

/// Node 4 is guarded every 200 ms from 2 s until `end`.
fn guarded(end: u64) -> Traffic {
    let mut traffic = heartbeats();
    traffic.remove(|_, frame| frame.cob_id() == Some(0x704));
    for n in 0..(end - 2_000) / 200 {
        let state = if n % 2 == 0 { "05" } else { "85" };
        traffic.at(2_000 + n * 200, "704#R1").at(2_003 + n * 200, &format!("704#{state}"));
    }
    traffic
}

#[test]
fn guarding_that_ends_or_comes_more_often() {
    let end = guarded(40_000).results().findings.len();
    assert_eq!(end, 0);
    guarded(15_000).finds("nodes/guarding-ended", Some(4), 14_800);
    // The master commands the node, and has a reason.
    let mut stopped = guarded(15_000);
    let found = stopped.at(14_900, "000#0204").results().findings;
    assert!(found.iter().all(|finding| finding.rule.id != "nodes/guarding-ended"), "{found:#?}");
}
