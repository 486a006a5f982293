use crate::traffic::{Traffic, diagnose, machine};
use canvass_traces::Timestamp;

#[test]
fn nothing_is_found_in_healthy_traffic() {
    machine().only(&[]);
}

/// A capture may begin at any time, so that nothing is known of the time before.
#[test]
fn nothing_is_found_wherever_a_capture_begins() {
    for begin in (0..3_000).step_by(73).chain((9_900..11_100).step_by(37)) {
        machine().remove(|ms, _| ms < begin).only(&[]);
    }
}

#[test]
fn nothing_is_found_wherever_a_capture_ends() {
    for end in (100..2_500).step_by(71).chain((9_900..11_500).step_by(83)).chain((19_900..21_500).step_by(83)) {
        machine().remove(|ms, _| ms >= end).only(&[]);
    }
}

#[test]
fn an_empty_capture_has_no_findings() {
    Traffic::default().only(&[]);
}

/// All times are multiples of 100 ms, as written by a person or a script. Such times do not make the clock coarse.
#[test]
fn regular_times_hide_nothing() {
    let mut traffic = Traffic::default();
    traffic.every(0, 5_000, 100, |_| "703#05".to_owned()).silence(0x703, 2_400, 2_500);
    let mut records = traffic.records();
    for record in &mut records {
        record.timestamp = Timestamp(record.timestamp.nanos() / 100_000_000 * 100_000_000);
    }
    let findings = diagnose(&records, |_| {}).findings;
    let [finding] = findings.as_slice() else { panic!("{findings:?}") };
    assert_eq!(
        (finding.rule.id, finding.message.as_str()),
        ("nodes/heartbeat-missing", "no heartbeat for 200 ms, but its period is 100 ms: 1 missing",)
    );
}
