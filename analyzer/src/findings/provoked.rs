//! Adds to each finding the conformance case during which it first occurred. Markers in the capture show when each case
//! began and ended.

use super::finding::Finding;
use crate::statistics::{BusStatistics, TestCase};
use canvass_traces::{ChannelId, Timestamp};
use std::fmt::Write;

/// Adds to each finding, and to its text, the case during which it first occurred.
pub(super) fn tie(findings: &mut [Finding], buses: &[(ChannelId, BusStatistics)]) {
    for (channel, bus) in buses.iter().filter(|(_, bus)| !bus.test_run.cases.is_empty()) {
        let cases = &bus.test_run.cases;
        for finding in findings.iter_mut().filter(|finding| finding.channel == Some(*channel)) {
            if let Some(first) = case_at(cases, finding.first) {
                tell(finding, cases, first);
            }
        }
    }
}

fn tell(finding: &mut Finding, cases: &[TestCase], first: usize) {
    let mut all: Vec<usize> = finding.windows.iter().filter_map(|window| case_at(cases, window.0)).collect();
    all.sort_unstable();
    all.dedup();
    let others = all.iter().filter(|case| **case != first).count();
    let name = &cases[first].name;
    finding.case = Some(name.clone());
    let begin = if others > 0 { "first in" } else { "in" };
    // Writing to a string can't fail.
    let _ = write!(finding.message, "; {begin} {name} of the test run");
    if others > 0 {
        let _ = write!(finding.message, ", then in {others} other{}", if others == 1 { "" } else { "s" });
    }
}

/// The index of the case that was under way at `time`.
fn case_at(cases: &[TestCase], time: Timestamp) -> Option<usize> {
    let begun = cases.partition_point(|case| case.begin <= time);
    let last = begun.checked_sub(1)?;
    (time <= cases[last].end).then_some(last)
}
