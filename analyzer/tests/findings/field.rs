//! Situations in captures from real machines. Each is a small machine that shows one situation, with the expected
//! findings.

use crate::traffic::{Traffic, diagnose, shown};
use canvass_analyzer::findings::{Finding, Severity};
use canvass_analyzer::{Service, findings};

/// A master that sends heartbeats for `seconds` seconds.
fn master(seconds: u64) -> Traffic {
    let mut traffic = Traffic::default();
    traffic.every(50, seconds * 1_000, 1_000, |_| "701#05".to_owned());
    traffic
}

/// Adds the heartbeat of node 15, every 1.4 s.
fn beats(traffic: &mut Traffic, from: u64, to: u64, state: &str) {
    traffic.every(from, to, 1_400, |_| format!("70F#{state}"));
}

fn one<'a>(findings: &'a [Finding], rule: &str) -> &'a Finding {
    let own: Vec<_> = findings.iter().filter(|finding| finding.rule.id == rule).collect();
    let [finding] = own.as_slice() else { panic!("{rule}: {:#?}", findings.iter().map(shown).collect::<Vec<_>>()) };
    finding
}

#[track_caller]
fn says(finding: &Finding, parts: &[&str]) {
    for part in parts {
        assert!(finding.message.contains(part), "{part:?} in {}", finding.message);
    }
}

/// The node is silent for 88 s, with two resets in between, and then restarts by itself.
#[test]
fn a_node_that_was_away_whatever_the_master_did() {
    let mut traffic = master(300);
    beats(&mut traffic, 200, 110_000, "05");
    traffic.at(113_800, "000#810F").at(138_100, "000#810F").at(197_600, "70F#00").at(203_000, "000#010F");
    beats(&mut traffic, 198_000, 203_000, "7F");
    beats(&mut traffic, 203_200, 300_000, "05");
    let found = traffic.only(&["nodes/lost", "nodes/boot-up-without-command"]);
    let lost = one(&found, "nodes/lost");
    says(lost, &["silent for 88.2", "2 resets without effect", "restarted by itself", "heartbeat period is 1.4 s"]);
    assert_eq!((lost.node.map(|node| node.raw()), lost.count), (Some(15), 1));
    one(&found, "nodes/boot-up-without-command");
}

#[test]
fn a_node_that_no_reset_brings_back() {
    let mut traffic = master(300);
    beats(&mut traffic, 200, 110_000, "05");
    traffic.at(113_800, "000#810F").at(138_100, "000#810F");
    let found = traffic.only(&["nodes/lost"]);
    says(one(&found, "nodes/lost"), &["2 resets without effect", "not back when the capture ends"]);
}

/// The command comes long after the last heartbeat, so it does not explain the silence before it.
#[test]
fn a_loss_that_a_command_ends() {
    let mut reset = master(130);
    beats(&mut reset, 200, 46_000, "05");
    reset.at(56_000, "000#810F").at(56_100, "70F#00").at(60_000, "000#010F");
    beats(&mut reset, 56_500, 60_000, "7F");
    beats(&mut reset, 60_200, 130_000, "05");
    let lost = reset.finds("nodes/lost", Some(15), 45_000);
    says(&lost, &["silent for 11.1", "after a reset"]);
    let mut start = master(130);
    beats(&mut start, 200, 46_000, "05");
    start.at(56_000, "000#010F");
    beats(&mut start, 56_200, 130_000, "05");
    let lost = start.finds("nodes/lost", Some(15), 45_000);
    says(&lost, &["silent for 11.2", "told to start after 11", "back by itself without a boot-up"]);
}

/// A master starts, stops and resets healthy nodes, at any moment of their heartbeat periods.
#[test]
fn commands_to_nodes_that_are_there_are_no_losses() {
    for offset in (0..1_400).step_by(70) {
        let mut traffic = master(60);
        beats(&mut traffic, 200, 20_000 + offset, "7F");
        // The heartbeat timer restarts with the change of state.
        traffic.at(20_000 + offset, "000#010F");
        beats(&mut traffic, 21_400 + offset, 40_000 + offset, "05");
        traffic.at(40_000 + offset, "000#810F").at(43_000 + offset, "70F#00");
        beats(&mut traffic, 44_400 + offset, 60_000, "7F");
        traffic.only(&[]);
    }
}

#[test]
fn a_reset_that_is_not_obeyed() {
    let mut traffic = master(300);
    traffic.every(200, 68_600, 1_400, |_| "728#7F".to_owned()).at(50_000, "000#8128").at(68_600, "000#8128");
    traffic.at(68_620, "728#00").every(70_020, 300_000, 1_400, |_| "728#7F".to_owned());
    let finding = traffic.finds("nodes/command-not-obeyed", Some(40), 50_000);
    says(&finding, &["after the command to reset it, and no boot-up"]);
}

#[test]
fn resets_that_are_not_obeyed_are_one_finding() {
    let mut traffic = master(300);
    beats(&mut traffic, 200, 300_000, "7F");
    traffic.at(100_000, "000#810F").at(150_000, "000#810F").at(200_000, "000#810F");
    let finding = traffic.finds("nodes/command-not-obeyed", Some(15), 100_000);
    assert_eq!(finding.count, 3);
    says(&finding, &["3 commands not obeyed", "99.9", "149.9", "199.9"]);
    // A node that has sent a boot-up before gives the same finding.
    let mut booted = traffic;
    booted.at(100, "70F#00");
    assert_eq!(booted.finds("nodes/command-not-obeyed", Some(15), 100_000).count, 3);
}

/// Old devices have no boot-up message: their heartbeat begins anew with the reset.
#[test]
fn a_reset_without_a_boot_up_that_is_obeyed() {
    for restart in [20, 300, 900] {
        let mut traffic = master(100);
        beats(&mut traffic, 200, 50_000, "7F");
        traffic.at(50_000, "000#810F");
        beats(&mut traffic, 51_400 + restart, 100_000, "7F");
        traffic.only(&[]);
    }
}

/// A reset long ago explains no restart, whether the node obeyed it or has no boot-up message.
#[test]
fn a_reset_long_ago_explains_nothing() {
    for answered in [true, false] {
        let mut traffic = master(100);
        traffic.at(1_000, "000#8100");
        if answered {
            traffic.at(1_100, "70F#00");
        }
        beats(&mut traffic, 1_500, 30_000, "05");
        traffic.at(50_000, "70F#00");
        beats(&mut traffic, 51_400, 100_000, "7F");
        // The master does not obey its own reset to all nodes, and rightly so.
        let found = traffic.only(&["nodes/lost", "nodes/boot-up-without-command", "nodes/command-not-obeyed"]);
        says(one(&found, "nodes/lost"), &["silent for 2", "restarted by itself"]);
        one(&found, "nodes/boot-up-without-command");
    }
}

/// Node 9 is guarded every 2 s; its toggle bit alternates.
fn guarded(traffic: &mut Traffic, from: u64, to: u64, state: u8) {
    for (n, ms) in (from..to).step_by(2_000).enumerate() {
        traffic.at(ms, "709#R1").at(ms + 1, &format!("709#{:02X}", state | (n as u8 & 1) << 7));
    }
}

#[test]
fn a_reset_before_the_node_was_heard_explains_no_restart() {
    let mut traffic = master(25);
    traffic.at(100, "000#8200").at(500, "000#0109");
    guarded(&mut traffic, 1_000, 21_000, 5);
    traffic.at(21_500, "709#00");
    guarded(&mut traffic, 22_000, 25_000, 0x7F);
    let rules = ["nodes/boot-up-without-command", "nodes/command-not-obeyed"];
    let found = traffic.only(&rules);
    one(&found, rules[0]);
    assert!(found.iter().all(|finding| finding.rule.id == rules[0] || finding.severity == Severity::Info));
}

#[test]
fn a_guarded_node_that_is_lost() {
    let mut traffic = master(100);
    traffic.at(500, "000#0109");
    guarded(&mut traffic, 1_000, 31_000, 5);
    traffic.every(31_000, 55_000, 2_000, |_| "709#R1".to_owned()).at(55_000, "709#00");
    guarded(&mut traffic, 57_000, 63_000, 0x7F);
    let rules = ["nodes/lost", "nodes/boot-up-without-command", "nodes/guarding-unanswered"];
    let found = traffic.only(&rules);
    let lost = one(&found, "nodes/lost");
    says(lost, &["guarded every 2 s", "restarted by itself", "silent for 25.99"]);
    // No node is lost because the master stops guarding.
    let mut stopped = master(100);
    guarded(&mut stopped, 1_000, 31_000, 5);
    stopped.only(&["nodes/guarding-ended"]);
}

#[test]
fn malformed_frames_are_a_finding_each_kind() {
    let mut traffic = master(6);
    traffic.at(2_500, "000#00").at(3_500, "000#8101000000000000").at(3_600, "701#0500").at(4_500, "601#4000");
    let found = traffic.only(&["bus/malformed"]);
    let texts: Vec<&str> = found.iter().map(|finding| finding.message.as_str()).collect();
    assert_eq!(
        texts,
        [
            "nmt of 1 byte, 2 bytes are right",
            "nmt of 8 bytes, 2 bytes are right",
            "heartbeat of 2 bytes, 1 byte is right",
            "sdo of 2 bytes, 8 bytes are right",
        ]
    );
}

/// A device shows COB-ID 0 for SDO servers that it does not use. 000h stays NMT.
#[test]
fn a_cob_id_of_zero_is_none() {
    let mut traffic = Traffic::default();
    traffic.sdo(900, 1, "4001120100000000", "4301120100000000").sdo(920, 1, "4001120200000000", "4301120200000000");
    traffic.at(1_000, "000#8101").at(1_100, "701#00").at(1_200, "000#0101");
    traffic.sdo(1_300, 1, "4000100000000000", "4300100091010700");
    let results = traffic.results();
    assert_eq!(results.buses[0].1.frames[Service::Nmt as usize], 2);
    let all: Vec<_> = results.findings.iter().map(|finding| (finding.rule.id, finding.severity)).collect();
    assert_eq!(all, [("bus/restricted-cob-id", Severity::Info)]);
}

#[test]
fn the_first_server_has_its_default_cob_ids() {
    let mut traffic = Traffic::default();
    traffic.at(1_000, "704#00").sdo(1_010, 4, "4000120100000000", "4300120100000080");
    traffic.sdo(1_020, 4, "4000100000000000", "4300100000000000");
    let results = traffic.results();
    assert_eq!(results.buses[0].1.frames[Service::Sdo as usize], 4);
    let finding = one(&results.findings, "bus/restricted-cob-id");
    assert_eq!(finding.severity, Severity::Warning);
    says(finding, &["1200h:01 reads 80000000h", "00000604h"]);
    assert_eq!(results.findings.len(), 1);
}

/// A learned use of a CAN-ID is dropped if all following frames contradict it.
#[test]
fn a_learned_use_that_nothing_fits_is_lost() {
    let mut traffic = Traffic::default();
    // The second server reads as 301h and 381h, but these CAN-IDs belong to PDOs of other nodes.
    traffic.sdo(1_000, 4, "4001120100000000", "4301120181030000");
    traffic.every(2_000, 22_000, 20, |_| "381#FF01".to_owned());
    let results = traffic.results();
    let frames = &results.buses[0].1.frames;
    assert!(frames[Service::Pdo as usize] > 850, "{frames:?}");
}

/// Devices from the time between the versions of CiA 301 sent both kinds of boot-up message.
#[test]
fn a_boot_up_that_is_said_twice_is_one() {
    for second in [3_103, 3_110] {
        let mut traffic = Traffic::default();
        traffic.every(1_000, 3_100, 1_000, |_| "703#7F".to_owned()).at(3_100, "000#8200");
        traffic.at(if second == 3_103 { 3_110 } else { 3_103 }, "083#").at(second, "703#00");
        traffic.every(3_500, 9_000, 1_000, |_| "703#7F".to_owned()).only(&[]);
        assert_eq!(traffic.results().buses[0].1.nodes[0].1.boot_ups, 1);
    }
}

#[test]
fn an_emcy_without_bytes_is_a_boot_up() {
    let mut traffic = master(25);
    traffic.at(500, "000#0109");
    guarded(&mut traffic, 1_000, 21_000, 5);
    traffic.at(21_500, "089#");
    guarded(&mut traffic, 22_000, 25_000, 0x7F);
    traffic.finds("nodes/boot-up-without-command", Some(9), 21_500);
}

/// A master does not wait for answers: its requests lie in a queue until the device has started, and so do the answers.
#[test]
fn answers_from_a_queue_are_no_second_device() {
    let mut traffic = Traffic::default();
    for ms in [663, 692, 709, 767, 878, 927, 973, 1_002] {
        traffic.at(ms, "604#4000100000000000");
    }
    traffic.at(1_004, "704#00").at(1_124, "000#8104").at(1_168, "184#443322110600");
    for ms in [1_183, 1_194, 1_195, 1_196, 1_211] {
        traffic.at(ms, "584#4300100000000000");
    }
    let found = traffic.results().findings;
    let early = one(&found, "sdo/too-early");
    assert_eq!((early.count, found.len()), (8, 1), "{found:#?}");
}

#[test]
fn a_server_that_aborts_what_it_has_begun_is_one_device() {
    let mut traffic = Traffic::default();
    traffic.at(1_000, "702#00").at(2_000, "602#C617100002000000").at(2_002, "582#A41710007F000000");
    traffic.at(2_012, "582#8017100021000008");
    traffic.finds("sdo/aborted", Some(2), 2_012);
}

/// Two different answers to one request still prove two devices.
#[test]
fn two_answers_to_one_request_are_two_devices() {
    let mut traffic = Traffic::default();
    traffic.at(1_000, "702#00").at(2_000, "602#4000100000000000").at(2_003, "582#4300100091010000");
    traffic.at(2_004, "582#4300100096010000");
    let found = traffic.results().findings;
    assert!(found.iter().any(|finding| finding.rule.id == "bus/duplicate-node-id"), "{found:#?}");
}

#[test]
fn a_client_that_gives_up_at_once() {
    let mut traffic = Traffic::default();
    traffic.at(1_000, "702#00").at(2_000, "602#4055550000000000").micros(2_000_600, "602#8055550000000008");
    traffic.at(2_030, "582#8055550000000206");
    let found = traffic.only(&["sdo/impatient-client", "sdo/aborted"]);
    let finding = one(&found, "sdo/impatient-client");
    says(finding, &["gave up the request for 5555h:00 after", "the answer came after 29.99"]);
    assert_eq!(finding.count, 1);
    // The server only reports that it has no such object.
    let server = found.iter().filter(|finding| finding.message.contains("by the server"));
    assert!(server.clone().all(|finding| finding.severity == Severity::Info), "{found:#?}");
}

/// A client that waits for 600 ms is not impatient: the server is late.
#[test]
fn a_client_that_gives_up_late() {
    let mut traffic = Traffic::default();
    traffic.at(1_000, "702#00").at(2_000, "602#4055550000000000").at(2_600, "602#8055550000000405");
    let mut late = traffic.clone();
    late.at(2_800, "582#4355550001000000");
    let found = late.only(&["sdo/late", "sdo/aborted", "sdo/protocol-violation"]);
    says(one(&found, "sdo/late"), &["took 799.99", "the client had given up after 599.99"]);
    let found = traffic.only(&["sdo/unanswered", "sdo/aborted"]);
    says(one(&found, "sdo/unanswered"), &["gave up after 599.99"]);
}

#[test]
fn a_counter_of_milliseconds_that_wraps() {
    let mut traffic = Traffic::default();
    // 2^32 ms are 49 days and 61 367 296 ms.
    traffic.at(1_000, "100#00000000 5A10").at(2_000, "100#E8FB7D01 2810");
    let finding = traffic.finds("pdo/time-jump", None, 2_000);
    says(&finding, &["2^32 ms", "wrapped"]);
}

#[test]
fn who_was_only_commanded_is_no_node() {
    let mut traffic = Traffic::default();
    traffic.every(0, 3_000, 500, |_| "701#05".to_owned());
    for node in 2..128 {
        traffic.at(1_000 + node, &format!("000#82{node:02X}"));
    }
    traffic.at(2_000, "605#4000100000000000");
    let results = traffic.results();
    let nodes = &results.buses[0].1.nodes;
    assert_eq!(nodes.iter().map(|(id, _)| id.raw()).collect::<Vec<_>>(), [1, 5]);
    assert!(nodes[1].1.states.is_empty(), "it has never sent anything");
}

/// A recorder with several processors records frames out of order by milliseconds.
#[test]
fn records_out_of_order_are_sorted() {
    let mut traffic = Traffic::default();
    traffic.at(1_000, "702#00").sdo(2_003, 2, "4017100000000000", "4B17100000000000");
    traffic.at(2_009, "602#2B17100032000000").at(2_016, "582#6017100000000000");
    let mut records = traffic.records();
    records.swap(2, 3);
    let results = diagnose(&records, |_| {});
    let found: Vec<_> = results.findings.iter().map(|finding| finding.rule.id).collect();
    assert_eq!(found, ["capture/out-of-order"]);
    says(&results.findings[0], &["1 frame", "3"]);
    assert!(findings::find("capture/out-of-order").is_some());
}

/// A master has stopped guarding, and resets the node much later. Another master resets communication and then the
/// node, which takes long to restart.
#[test]
fn who_is_not_waited_for_is_not_lost() {
    let mut guarded_once = master(100);
    guarded(&mut guarded_once, 1_000, 31_000, 5);
    guarded_once.at(80_000, "000#8109").at(80_300, "709#00").only(&[]);
    let mut slow = master(100);
    beats(&mut slow, 200, 40_000, "05");
    slow.at(40_100, "000#820F").at(40_200, "000#810F").at(65_000, "70F#00");
    beats(&mut slow, 66_400, 100_000, "7F");
    slow.only(&[]);
}
