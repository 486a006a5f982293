use crate::traffic::{END, Traffic, machine};

#[test]
fn a_node_that_restarts_by_itself() {
    let mut traffic = machine();
    traffic.silence(0x704, 15_000, 20_000).silence(0x184, 15_000, 20_000);
    traffic.at(15_100, "704#00").every(15_300, 20_000, 200, |_| "704#7F".to_owned());
    traffic.finds("nodes/boot-up-without-command", Some(4), 15_100);
}

#[test]
fn a_second_boot_up_after_one_command() {
    let mut traffic = machine();
    traffic.at(20_200, "704#00");
    traffic.finds("nodes/boot-up-without-command", Some(4), 20_200);
}

#[test]
fn a_node_that_restarts_again_and_again() {
    let mut traffic = machine();
    traffic.silence(0x704, 15_000, 20_000).silence(0x184, 15_000, 20_000);
    traffic.every(15_100, 20_000, 700, |_| "704#00".to_owned());
    traffic.finds_among(
        &["nodes/repeated-resets", "nodes/boot-up-without-command"],
        "nodes/repeated-resets",
        Some(4),
        16_500,
    );
}

/// A power cycle makes stored parameters take effect, as in the manual of an encoder.
#[test]
fn a_power_cycle_after_a_store() {
    let mut traffic = machine();
    traffic.sdo(15_000, 4, "2305210073617665", "6005210000000000");
    traffic.silence(0x704, 15_050, 20_000).silence(0x184, 15_050, 20_000);
    traffic.at(17_100, "704#00").every(17_300, 20_000, 200, |_| "704#7F".to_owned());
    traffic.only(&[]);
}

#[test]
fn heartbeats_late_missing_and_ended() {
    let mut late = machine();
    late.silence(0x703, 15_060, 15_061).at(15_130, "703#05");
    late.finds("nodes/heartbeat-late", Some(3), 15_130);
    let mut missing = machine();
    missing.silence(0x703, 15_000, 15_250);
    let finding = missing.finds("nodes/heartbeat-missing", Some(3), 14_960);
    assert!(finding.message.contains("2 missing") || finding.message.contains("3 missing"), "{}", finding.message);
    assert_eq!(finding.evidence.len(), 2);
    let mut ended = machine();
    ended.silence(0x703, 25_000, END);
    ended.finds("nodes/heartbeat-ended", Some(3), 24_960);
}

/// The period is not in the capture, so it is learned.
#[test]
fn a_heartbeat_of_unknown_period() {
    let mut missing = machine();
    missing.silence(0x701, 15_000, 15_150);
    missing.finds("nodes/heartbeat-missing", Some(1), 14_910);
    let mut lost = machine();
    lost.silence(0x701, 15_000, 15_550);
    lost.finds("nodes/lost", Some(1), 14_910);
}

#[test]
fn an_irregular_heartbeat() {
    let mut traffic = machine();
    traffic.silence(0x703, 5_000, END);
    for n in 0..249_u64 {
        traffic.at(5_060 + n * 100 + n * 37 % 7 * 9, "703#05");
    }
    let found = traffic.only(&["nodes/heartbeat-jitter", "nodes/heartbeat-late"]);
    assert!(found.iter().any(|finding| finding.rule.id == "nodes/heartbeat-jitter"), "{found:?}");
}

#[test]
fn a_consumer_time_that_is_too_short() {
    let mut traffic = machine();
    traffic.sdo(600, 3, "2316100178000100", "6016100100000000");
    traffic.silence(0x701, 15_005, 15_015);
    traffic.finds_among(&["nodes/consumer-time", "nodes/heartbeat-missing"], "nodes/consumer-time", Some(3), 14_910);
}

#[test]
fn a_node_that_never_comes_back() {
    let mut traffic = machine();
    traffic.silence(0x704, 20_100, END).silence(0x184, 20_100, END);
    traffic.finds("nodes/no-boot-up", Some(4), 20_000);
}

#[test]
fn a_command_that_is_not_obeyed() {
    let mut traffic = machine();
    traffic.silence(0x704, 10_031, 11_045).every(10_066, 11_045, 200, |_| "704#05".to_owned());
    traffic.finds("nodes/command-not-obeyed", Some(4), 10_031);
}

#[test]
fn a_node_that_leaves_operational() {
    let mut traffic = machine();
    traffic.silence(0x704, 15_000, 20_000).silence(0x184, 15_000, 20_000);
    traffic.every(15_066, 20_000, 200, |_| "704#7F".to_owned());
    traffic.finds("nodes/state-lost", Some(4), 15_066);
}

#[test]
fn guarding_without_an_answer() {
    let mut traffic = machine();
    // Requests come at 700 + 300 n ms; this one is at 15 100 ms. The toggle bit continues with the next answer.
    traffic.remove(|ms, frame| ms == 15_100 && frame.cob_id() == Some(0x706));
    traffic.finds_among(
        &["nodes/guarding-unanswered", "nodes/guarding-toggle"],
        "nodes/guarding-unanswered",
        Some(6),
        15_100,
    );
}

#[test]
fn a_toggle_bit_that_stays() {
    let mut traffic = machine();
    traffic.remove(|ms, frame| ms == 15_100 && frame.cob_id() == Some(0x706)).micros(15_100_700, "706#85");
    let found = traffic.only(&["nodes/guarding-toggle"]);
    let mut other = machine();
    other.remove(|ms, frame| ms == 15_100 && frame.cob_id() == Some(0x706)).micros(15_100_700, "706#05");
    // One of the two answers repeats the toggle bit of its neighbours.
    assert_eq!(found.len() + other.only(&["nodes/guarding-toggle"]).len(), 1);
}

#[test]
fn pdos_of_a_stopped_node() {
    let mut traffic = machine();
    traffic.every(10_300, 10_800, 100, |_| "184#01".to_owned());
    let finding = traffic.finds("nodes/pdo-outside-operational", Some(4), 10_300);
    assert!(finding.message.contains("stopped"), "{}", finding.message);
}

#[test]
fn an_answer_of_a_stopped_node() {
    let mut traffic = machine();
    traffic.sdo(10_400, 4, "4000100000000000", "4300100091010000");
    traffic.finds("nodes/sdo-in-stopped", Some(4), 10_403);
}

/// The guard time of node 6 is 300 ms, its life time factor 2.
fn guarded() -> Traffic {
    let mut traffic = machine();
    traffic.sdo(560, 6, "2B0C10002C010000", "600C100000000000").sdo(570, 6, "2F0D100002000000", "600D100000000000");
    traffic
}

#[test]
fn life_guarding_is_lost() {
    guarded().only(&[]);
    let mut late = guarded();
    late.silence(0x706, 15_000, 16_700);
    let finding = late.finds("nodes/life-guarding", Some(6), 15_400);
    assert!(finding.message.contains("its life time is 600 ms"), "{}", finding.message);
    let mut ended = guarded();
    ended.silence(0x706, 15_000, END);
    let finding = ended.finds("nodes/life-guarding", Some(6), 15_400);
    assert!(finding.message.contains("no longer asked for its state"), "{}", finding.message);
}

#[test]
fn a_heartbeat_that_a_consumer_waits_for_in_vain() {
    let mut traffic = machine();
    traffic.sdo(600, 3, "2316100196000100", "6016100100000000");
    traffic.silence(0x701, 25_000, END);
    let finding = traffic.finds_among(&["nodes/consumer-time", "nodes/lost"], "nodes/consumer-time", Some(3), 24_910);
    assert!(finding.message.contains("waits 150 ms for the heartbeat of node 1"), "{}", finding.message);
}

/// A master repeats the start command every 700 ms, which changes nothing and hides nothing.
#[test]
fn a_command_that_is_repeated_hides_nothing() {
    let repeated = || {
        let mut traffic = machine();
        traffic.silence(0x704, 10_031, 11_045).remove(|ms, frame| ms == 10_031 && frame.cob_id() == Some(0));
        traffic.every(2_000, 19_900, 70, |_| "000#0100".to_owned());
        traffic.every(10_066, 11_045, 200, |_| "704#05".to_owned());
        traffic
    };
    repeated().only(&[]);
    let mut missing = repeated();
    missing.silence(0x703, 15_000, 15_250);
    missing.finds("nodes/heartbeat-missing", Some(3), 14_960);
    let mut lost = repeated();
    lost.silence(0x704, 15_000, 20_000).silence(0x184, 15_000, 20_000);
    lost.every(15_066, 20_000, 200, |_| "704#7F".to_owned());
    let found = lost.only(&["nodes/state-lost", "nodes/command-not-obeyed"]);
    assert!(found.iter().any(|finding| finding.rule.id == "nodes/state-lost"), "{found:?}");
}

#[test]
fn what_a_node_still_sends_when_its_heartbeat_has_ended() {
    let pdos_until = |end: u64| {
        let mut traffic = Traffic::default();
        traffic.every(100, 10_000, 500, |_| "70A#05".to_owned()).every(200, END, 500, |_| "709#05".to_owned());
        traffic.every(0, end, 10, |_| "18A#00000000".to_owned());
        traffic
    };
    let message = pdos_until(END).finds("nodes/heartbeat-ended", Some(10), 9_600).message;
    assert!(message.ends_with("it still sends other messages"), "{message}");
    let message = pdos_until(9_800).finds("nodes/lost", Some(10), 9_790).message;
    assert!(message.ends_with("not back when the capture ends"), "{message}");
}
