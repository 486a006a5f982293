use crate::traffic::{END, Traffic, hex, machine};

#[test]
fn a_pdo_shorter_than_its_mapping() {
    let mut traffic = machine();
    traffic.remove(|ms, frame| ms == 15_000 && frame.cob_id() == Some(0x183)).micros(15_000_400, "183#0102");
    traffic.finds_among(&["pdo/length"], "pdo/length", Some(3), 15_000);
}

#[test]
fn a_cyclic_pdo_that_is_late() {
    let mut traffic = machine();
    traffic.silence(0x283, 15_000, 15_150);
    traffic.finds("pdo/period", Some(3), 14_957);
}

#[test]
fn a_pdo_within_its_inhibit_time() {
    let mut traffic = machine();
    // 283h comes at 1007 + 50 n ms; its inhibit time is 5 ms.
    traffic.at(15_008, "283#0000").at(15_009, "283#0001");
    traffic.finds("pdo/inhibit-time", Some(3), 15_008);
}

#[test]
fn sync_is_missing() {
    let mut traffic = machine();
    traffic.remove(|ms, frame| (15_000..15_020).contains(&ms) && matches!(frame.cob_id(), Some(0x080 | 0x183)));
    let found = traffic.only(&["pdo/sync-missing", "pdo/sync-counter"]);
    assert_eq!(found.len(), 2, "{found:?}");
}

#[test]
fn sync_is_irregular() {
    let mut traffic = machine();
    traffic.remove(|_, frame| matches!(frame.cob_id(), Some(0x080 | 0x183)));
    for n in 0..1000_u64 {
        traffic.micros(2_000_000 + n * 20_000 + n * 37 % 11 * 900, "080#");
    }
    let found = traffic.only(&["pdo/sync-jitter"]);
    assert_eq!(found.len(), 1, "{found:?}");
}

#[test]
fn a_sync_counter_that_jumps() {
    let mut traffic = machine();
    traffic.remove(|ms, frame| ms == 15_000 && frame.cob_id() == Some(0x080)).at(15_000, "080#05");
    traffic.finds("pdo/sync-counter", None, 15_000);
}

#[test]
fn a_synchronous_pdo_is_missing() {
    let mut traffic = machine();
    traffic.remove(|ms, frame| (15_000..15_001).contains(&ms) && frame.cob_id() == Some(0x183));
    traffic.finds("pdo/sync-pdo-missing", Some(3), 15_020);
}

#[test]
fn time_jumps_by_an_hour() {
    let mut traffic = machine();
    traffic.silence(0x100, 15_000, END);
    traffic.every(15_500, END, 1_000, |n| format!("100#{} 0010", hex(3_600_000 + 3_600_000 + (n + 14) * 1000)));
    let finding = traffic.finds("pdo/time-jump", None, 15_500);
    assert!(finding.message.contains("ahead by 3600"), "{}", finding.message);
}

#[test]
fn a_cyclic_pdo_that_is_irregular() {
    let mut traffic = machine();
    traffic.silence(0x283, 5_000, END);
    // Every third PDO waits for 20 ms.
    for n in 0..499_u64 {
        traffic.at(5_007 + n * 50 + if n % 3 == 0 { 20 } else { 0 }, "283#0000");
    }
    let finding = traffic.finds("pdo/jitter", Some(3), 5_477);
    assert!(finding.message.contains("its event timer is 50 ms"), "{}", finding.message);
    assert_eq!(finding.evidence.len(), 2);
}

/// An event may send the PDO sooner than its timer.
#[test]
fn events_between_the_beats_of_the_timer() {
    let mut traffic = machine();
    traffic.silence(0x283, 5_000, END);
    let mut at = 5_007;
    for n in 0..400_u64 {
        at += if n % 4 == 3 { 50 } else { 11 + n * 37 % 29 };
        traffic.at(at, "283#0000");
    }
    traffic.remove(|ms, _| ms > at).only(&[]);
}

#[test]
fn a_synchronous_pdo_outside_its_window() {
    let window = |us: u64| {
        let mut traffic = machine();
        traffic.sdo(600, 3, &format!("23071000{}", hex(us)), "6007100000000000");
        traffic
    };
    window(5_000).only(&[]);
    let mut late = window(5_000);
    late.remove(|ms, frame| ms == 15_000 && frame.cob_id() == Some(0x183));
    late.micros(15_009_000, &format!("183#{}", hex(4096 + 699 * 3)));
    let finding = late.finds("pdo/sync-window", Some(3), 15_009);
    assert!(finding.message.contains("(1007h) is 5 ms"), "{}", finding.message);
}

/// An encoder of TR-Electronic is silent for three seconds after a store.
#[test]
fn a_silent_store() {
    let mut traffic = machine();
    traffic.at(15_001, "603#2310100173617665").at(18_050, "583#6010100100000000");
    traffic.remove(|ms, frame| {
        (15_001..18_050).contains(&ms)
            && matches!(frame.cob_id(), Some(0x183 | 0x283 | 0x583 | 0x603 | 0x703))
            && frame.data() != b"\x23\x10\x10\x01save"
    });
    traffic.only(&[]);
    let mut guarded = machine();
    guarded.at(15_050, "606#2310100173617665").at(18_050, "586#6010100100000000");
    guarded.remove(|ms, frame| (15_051..18_050).contains(&ms) && frame.cob_id() == Some(0x706)).only(&[]);
}

/// A device fills its TPDOs up to 8 bytes with zeros; another device does so only once.
#[test]
fn a_pdo_that_is_filled_up() {
    let filled = |last: &'static str| {
        let mut traffic = Traffic::default();
        traffic.sdo(100, 4, "40001A0000000000", "4F001A0001000000").sdo(110, 4, "40001A0100000000", "43001A0120000460");
        traffic.at(200, "000#0104");
        traffic.every(300, 5_000, 20, |n| format!("184#{:02X}00000000000000", n & 0xFF)).at(5_007, last);
        traffic
    };
    filled("184#0100000000000000").only(&[]);
    filled("184#0100000000000001").finds("pdo/length", Some(4), 5_007);
    let mut once = machine();
    once.remove(|ms, frame| ms == 15_000 && frame.cob_id() == Some(0x183)).micros(15_000_400, "183#0000000000000000");
    let found = once.results().findings;
    assert!(found.iter().any(|finding| finding.rule.id == "pdo/length"), "{found:?}");
}

#[test]
fn a_sync_period_that_is_written() {
    let mut traffic = Traffic::default();
    traffic.every(0, 2_000, 20, |_| "080#".to_owned()).every(2_040, 5_000, 50, |_| "080#".to_owned());
    traffic.sdo(1_990, 10, "2306100050C30000", "6006100000000000").only(&[]);
    traffic.silence(0x080, 4_000, 4_100).finds("pdo/sync-missing", None, 3_990);
}

#[test]
fn a_sync_that_is_switched_off_and_on() {
    let mut traffic = Traffic::default();
    traffic.every(0, 2_000, 20, |_| "080#".to_owned()).every(2_920, 5_000, 20, |_| "080#".to_owned());
    traffic.sdo(1_990, 10, "2305100080000000", "6005100000000000");
    traffic.sdo(2_900, 10, "2305100080000040", "6005100000000000").only(&[]);
    traffic.silence(0x080, 4_000, 4_030).finds("pdo/sync-missing", None, 3_980);
}

/// Of the event timer and the cyclic timer of an encoder, the value shown last is in force.
#[test]
fn a_cyclic_timer_behind_an_event_timer() {
    let mut traffic = Traffic::default();
    traffic.at(0, "705#00").sdo(100, 5, "4000100000000000", "4300100096010200");
    traffic.sdo(150, 5, "2F001802FE000000", "6000180200000000");
    traffic.sdo(200, 5, "2B00180564000000", "6000180500000000").at(500, "000#0105");
    traffic.every(510, 5_500, 100, |n| format!("185#{}", hex(1000 + n)));
    traffic.sdo(5_450, 5, "2B006200F4010000", "6000620000000000");
    traffic.every(5_910, 16_000, 500, |n| format!("185#{}", hex(1100 + n)));
    traffic.only(&[]);
    let mut late = traffic.clone();
    let finding = late.silence(0x185, 8_900, 9_000).finds("pdo/period", Some(5), 8_410);
    assert!(finding.message.contains("its event timer is 500 ms"), "{}", finding.message);
    // The timer is changed back.
    traffic.silence(0x185, 12_000, 16_000).sdo(12_000, 5, "2B00180564000000", "6000180500000000");
    traffic.every(12_100, 16_000, 100, |n| format!("185#{}", hex(1200 + n))).only(&[]);
    let finding = traffic.silence(0x185, 14_050, 14_450).finds("pdo/period", Some(5), 14_000);
    assert!(finding.message.contains("its event timer is 100 ms"), "{}", finding.message);
}
