use crate::traffic::{Traffic, machine};

#[test]
fn nothing_is_found_in_healthy_traffic() {
    machine().only(&[]);
}

/// A capture may begin anywhere: nothing is known of what was before.
#[test]
fn nothing_is_found_wherever_a_capture_begins() {
    for begin in (0..6_000).step_by(37).chain(9_900..10_100) {
        machine().remove(|ms, _| ms < begin).only(&[]);
    }
}

#[test]
fn nothing_is_found_wherever_a_capture_ends() {
    for end in (100..2_500).step_by(23).chain((9_900..11_500).step_by(41)).chain((19_900..21_500).step_by(41)) {
        machine().remove(|ms, _| ms >= end).only(&[]);
    }
}

#[test]
fn an_empty_capture_has_no_findings() {
    Traffic::default().only(&[]);
}
