use crate::traffic::{END, hex, machine};

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
