//! A case run several times: to find out whether it always ends the same way, or to give a failure another chance.

use super::{CaseReport, run_case};
use crate::bench::Bench;
use crate::case::Case;
use crate::verdict::{Kind, Verdict};
use canvass_traces::Duration;

/// Runs a case as often as the options say.
pub(super) fn run_repeatedly(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let started = bench.now();
    let (repeat, retries) = (bench.options().repeat, bench.options().retries);
    let mut report = match retries {
        0 => repeated(bench, case, repeat),
        _ => retried(bench, case, retries),
    };
    report.duration = bench.now().since(started);
    report
}

/// The report is that of the worst outcome, the first of them.
fn repeated(bench: &mut Bench<'_>, case: &'static Case, times: u32) -> CaseReport {
    let mut worst = run_case(bench, case);
    for _ in 1..times.max(1) {
        if bench.is_cancelled() {
            break;
        }
        let next = run_case(bench, case);
        let kind = next.verdict.kind();
        let outcomes = std::mem::take(&mut worst.outcomes);
        if kind.badness() > worst.verdict.kind().badness() {
            worst = next;
        }
        worst.outcomes = outcomes;
        worst.outcomes.push(kind);
    }
    worst
}

/// The report is that of the last try; what failed before stands in its notes, so that nothing is passed over.
fn retried(bench: &mut Bench<'_>, case: &'static Case, retries: u32) -> CaseReport {
    let mut last = run_case(bench, case);
    for retry in 1..=retries {
        if !has_failed(last.verdict.kind()) || bench.is_cancelled() {
            break;
        }
        let mut notes = std::mem::take(&mut last.notes);
        notes.push(told(&last.verdict, retry, last.duration));
        let outcomes = std::mem::take(&mut last.outcomes);
        last = run_case(bench, case);
        notes.append(&mut last.notes);
        last.notes = notes;
        last.outcomes.splice(0..0, outcomes);
    }
    last
}

const fn has_failed(kind: Kind) -> bool {
    matches!(kind, Kind::Fail | Kind::Inconclusive | Kind::Error)
}

fn told(verdict: &Verdict, attempt: u32, took: Duration) -> String {
    let reason = verdict.reason().map(|reason| format!(": {reason}")).unwrap_or_default();
    format!("try {attempt} ended with {} after {took}{reason}", verdict.kind())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::Options;
    use crate::clause::{Clause, Confidence, Level};
    use crate::scripted::{table, with_options};
    use crate::verdict::{Breach, Judged, Stop};
    use canvass_bus::observation::{Observation, Subject};
    use std::sync::atomic::{AtomicU32, Ordering};

    const ROWS: &[(&str, &str)] = &[("63F#4000100000000000", "5BF#4300100096010200"), ("000#813F", "73F#00")];

    static TRIES: AtomicU32 = AtomicU32::new(0);

    /// Fails twice, then passes.
    fn fails_twice(_: &mut Bench<'_>) -> Judged {
        if TRIES.fetch_add(1, Ordering::SeqCst) < 2 {
            let breach = Breach::new(Subject::Device, "it works").found(Observation::Silence);
            return Err(Stop::Breach(Box::new(breach)));
        }
        Ok(())
    }

    static FLAKY: Case = Case {
        id: "test/flaky",
        requirement: "A test.",
        clause: Clause { standard: "CiA 301", section: None, confidence: Confidence::Unknown },
        level: Level::Must,
        needs: &[],
        touches: &[],
        catches: &[],
        answers: &[],
        cct: None,
        run: fails_twice,
    };

    #[test]
    fn a_retry_passes_and_hides_nothing() {
        let outcome = |retries| {
            TRIES.store(0, Ordering::SeqCst);
            let options = Options { retries, ..Options::default() };
            with_options(table(ROWS), &options, |bench| run_repeatedly(bench, &FLAKY))
        };
        let once = outcome(1);
        assert_eq!((once.verdict.kind(), once.outcomes.len(), once.is_flaky()), (Kind::Fail, 2, false));
        let passed = outcome(5);
        assert_eq!((passed.verdict.kind(), passed.is_flaky()), (Kind::Pass, true));
        assert_eq!(passed.outcomes, [Kind::Fail, Kind::Fail, Kind::Pass]);
        assert_eq!(passed.notes.len(), 2, "{:?}", passed.notes);
        assert!(passed.notes[0].starts_with("try 1 ended with fail after"), "{:?}", passed.notes);
        assert!(passed.notes[1].contains("no answer"), "{:?}", passed.notes);
    }
}
