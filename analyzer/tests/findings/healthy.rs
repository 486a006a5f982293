use crate::traffic::{Traffic, machine};

#[test]
fn nothing_is_found_in_healthy_traffic() {
    machine().only(&[]);
}

/// A capture may begin anywhere: nothing is known of what was before.
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
