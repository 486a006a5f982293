//! Cases that could not be judged because of an answer for which another case failed.

use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::{Kind, Reason};

/// Adds a note to each case that could not be judged: the case that failed for the same answer to the same request.
pub fn name_judges(cases: &mut [CaseReport]) {
    let failed = cases.iter().filter(|report| report.verdict.kind() == Kind::Fail);
    let judged: Vec<(Reason, &'static str)> = failed
        .flat_map(|report| report.verdict.breaches().iter().map(|ruled| (Reason::from(&ruled.breach), report.case.id)))
        .collect();
    for report in cases.iter_mut().filter(|report| report.verdict.kind() == Kind::Inconclusive) {
        let reason = report.verdict.reason();
        let judge = judged.iter().find(|(known, _)| reason.as_ref() == Some(known));
        report.notes.extend(judge.map(|(_, judge)| format!("{judge} judges this answer")));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_bus::observation::{Observation, Subject};
    use canvass_suite::bench::Evidence;
    use canvass_suite::catalogue;
    use canvass_suite::verdict::{Breach, End, Ruled, Verdict};
    use canvass_traces::Duration;

    fn report(case: usize, verdict: Verdict) -> CaseReport {
        CaseReport {
            case: catalogue::cases()[case],
            verdict,
            evidence: Evidence::default(),
            notes: Vec::new(),
            measurements: Vec::new(),
            uses: Vec::new(),
            foreign: Vec::new(),
            outcomes: Vec::new(),
            quarantine: None,
            duration: Duration::ZERO,
        }
    }

    #[test]
    fn a_case_that_could_not_be_judged_names_the_case_that_failed_for_the_same_answer() {
        let breach = Breach::new(Subject::Device, "a write is confirmed").found(Observation::Silence);
        let undecided = |reason| Verdict::new(Vec::new(), Some(End::Inconclusive(reason)));
        let failed = Verdict::new(vec![Ruled { breach: breach.clone(), excuse: None }], None);
        let other = Reason::new("another duty", "an answer", "none");
        let mut cases = [report(0, undecided(Reason::from(&breach))), report(1, undecided(other)), report(2, failed)];
        name_judges(&mut cases);
        let judge = catalogue::cases()[2].id;
        assert_eq!(cases[0].notes, [format!("{judge} judges this answer")]);
        assert!(cases[1].notes.is_empty() && cases[2].notes.is_empty());
    }
}
