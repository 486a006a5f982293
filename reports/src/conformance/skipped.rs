//! The cases that did not apply, grouped by reason, as many cases share a reason.

use super::Run;
use canvass_suite::verdict::{Kind, Lack, Reason};

/// Cases that did not apply.
#[derive(Debug, Default)]
pub struct Skipped {
    reasons: Vec<(Reason, Vec<&'static str>)>,
}

impl Skipped {
    /// Adds a case with its reason.
    fn add(&mut self, case: &'static str, reason: &Reason) {
        match self.reasons.iter_mut().find(|(known, _)| known == reason) {
            Some((_, cases)) => cases.push(case),
            None => self.reasons.push((reason.clone(), vec![case])),
        }
    }

    /// The cases of a run that did not apply.
    pub fn of(run: &Run) -> Self {
        let mut skipped = Self::default();
        for report in run.cases.iter().filter(|report| report.verdict.kind() == Kind::NotApplicable) {
            skipped.add(report.case.id, &report.verdict.reason().unwrap_or_default());
        }
        skipped
    }

    /// The missing features, each with the cases that did not apply for this reason. The reason of most cases comes
    /// first. `allow` is the text that a user types before the name of a permission.
    pub fn groups(&self, allow: &str) -> Vec<(String, Vec<String>)> {
        let names = |cases: &[&str]| cases.iter().map(|&case| case.to_owned()).collect::<Vec<_>>();
        let mut groups: Vec<_> =
            self.reasons.iter().map(|(reason, cases)| (sentence(reason, allow), names(cases))).collect();
        groups.sort_by_key(|(_, cases)| std::cmp::Reverse(cases.len()));
        groups
    }
}

/// The needed and the actual feature; only the actual feature if its text contains the needed one.
fn sentence(reason: &Reason, allow: &str) -> String {
    let Reason { expected, actual, lack, .. } = reason;
    if *lack == Lack::Permission {
        return format!("{actual} ({allow}{expected})");
    }
    if actual.contains(expected.as_str()) { actual.clone() } else { format!("{expected}: {actual}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_of_one_reason_share_its_line() {
        let blocks =
            Reason::new("the device has the feature that the case needs", "SDO block uploads", "answered by an abort");
        let nvm = Reason::new("the user allows it", "nvm", "not allowed: it writes").for_lack_of(Lack::Permission);
        let mut skipped = Skipped::default();
        for (case, reason) in [("301/a", &blocks), ("301/store", &nvm), ("301/b", &blocks), ("301/longer", &blocks)] {
            skipped.add(case, reason);
        }
        let blocks = ("SDO block uploads: answered by an abort", vec!["301/a", "301/b", "301/longer"]);
        let nvm = ("not allowed: it writes (--allow nvm)", vec!["301/store"]);
        let groups = skipped.groups("--allow ");
        let shown = groups.iter().map(|(reason, cases)| (&**reason, cases.iter().map(|case| &**case).collect()));
        assert_eq!(shown.collect::<Vec<(&str, Vec<&str>)>>(), [blocks, nvm]);
    }
}
