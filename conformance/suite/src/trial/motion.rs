//! A measured quantity that changes during a case: that is no failure of what the device makes of it.

use super::{CaseReport, meanwhile};
use crate::verdict::{Kind, Lack, Reason, Ruled};

/// The reason to doubt a failure until it comes again: a motion between two readings would explain each of its
/// breaches. The quantity may stay the same before and after a reset, and change during it.
pub(super) fn doubt(report: &CaseReport) -> Option<Reason> {
    let mut failures = report.verdict.breaches().iter().filter(|ruled| ruled.kind() == Kind::Fail);
    let by_motion = |Ruled { breach, .. }: &Ruled| breach.compares_measurements;
    if report.verdict.kind() != Kind::Fail || !failures.all(by_motion) {
        return None;
    }
    let found = report.verdict.reason().map(|reason| meanwhile(&reason)).unwrap_or_default();
    let reason = Reason::new(
        "the measured quantity does not change during the case",
        "the same failure in another try",
        format!("another try did not find it{found}"),
    );
    Some(reason.for_lack_of(Lack::Steadiness))
}
