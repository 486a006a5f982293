//! Runs a case several times: to find out whether it always ends the same way, or to repeat a failed case.

use crate::bench::Bench;
use crate::case::Case;
use crate::touch::Touch;
use crate::trial::{CaseReport, doubt, run_case};
use crate::verdict::{End, Kind, Lack, Reason, Verdict};
use canvass_traces::Duration;

/// Maximum number of repetitions of a case that others disturbed.
const REPETITIONS: usize = 3;

/// Number of repetitions of a failed case if the failure may come from a late device, or from a motion.
const CONFIRMATIONS: u32 = 3;

/// Runs a case as often as the options require.
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

/// Runs a case `times` times. The report is the first one with the worst outcome.
fn repeated(bench: &mut Bench<'_>, case: &'static Case, times: u32) -> CaseReport {
    let mut worst = run_undisturbed(bench, case);
    for _ in 1..times {
        if bench.is_cancelled() {
            break;
        }
        let next = run_undisturbed(bench, case);
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

/// Repeats a failing case. The report is that of the last attempt; its notes contain the earlier failures.
fn retried(bench: &mut Bench<'_>, case: &'static Case, retries: u32) -> CaseReport {
    let mut last = run_undisturbed(bench, case);
    for retry in 1..=retries {
        if !has_failed(last.verdict.kind()) || bench.is_cancelled() {
            break;
        }
        let mut notes = std::mem::take(&mut last.notes);
        notes.push(told(&last.verdict, retry, last.duration));
        let outcomes = std::mem::take(&mut last.outcomes);
        last = run_undisturbed(bench, case);
        notes.append(&mut last.notes);
        last.notes = notes;
        last.outcomes.splice(0..0, outcomes);
    }
    last
}

/// Runs a case, and repeats it if others disturbed it, if the device was or may have been late as a whole, or if a
/// motion would explain the failure.
pub(crate) fn run_undisturbed(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let first = run_quietly(bench, case);
    match doubt(&first, bench) {
        Some(doubt) if !bench.is_cancelled() => confirmed(bench, case, first, doubt),
        _ => first,
    }
}

/// Repeats a failed case if the failure may have another cause than the device. If a repetition passes, or is
/// inconclusive because of such a cause, the case becomes inconclusive for the reason `doubt`. The frames of the failure
/// stay its evidence. Otherwise the failure counts.
fn confirmed(bench: &mut Bench<'_>, case: &'static Case, mut failed: CaseReport, doubt: Reason) -> CaseReport {
    for number in 1..=CONFIRMATIONS {
        if bench.is_cancelled() {
            break;
        }
        let next = run_quietly(bench, case);
        failed.notes.push(told(&next.verdict, number + 1, next.duration));
        if has_not_come_again(&next.verdict) {
            failed.verdict = Verdict::inconclusive(doubt);
            failed.outcomes = vec![Kind::Inconclusive];
            break;
        }
    }
    failed
}

/// Whether a repetition passed, or is inconclusive only because the device was late or moved. A repetition that could
/// not begin is no reason to doubt the failure: the failure itself may prevent it.
fn has_not_come_again(verdict: &Verdict) -> bool {
    match verdict.kind() {
        Kind::Pass | Kind::Tolerated | Kind::Deviation => true,
        Kind::Inconclusive => {
            verdict.reason().is_some_and(|reason| matches!(reason.lack, Lack::Promptness | Lack::Steadiness))
        }
        Kind::Fail | Kind::NotApplicable | Kind::Error => false,
    }
}

/// Runs a case, and repeats it if a temporary disturbance prevented a verdict. A case that wears out memory is not
/// repeated.
fn run_quietly(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let mut report = run_case(bench, case);
    for _ in 0..REPETITIONS {
        if !may_end_otherwise(&report) || may_wear_out(case) || bench.is_cancelled() {
            break;
        }
        let reason = report.verdict.reason().map(|reason| reason.actual).unwrap_or_default();
        let notes = std::mem::take(&mut report.notes);
        report = run_case(bench, case);
        let tried = format!("tried again: {reason}");
        report.notes.splice(0..0, notes.into_iter().chain([tried]));
    }
    report
}

/// Whether the case may write the memory. Some devices store a preset as soon as it is written.
fn may_wear_out(case: &Case) -> bool {
    case.touches.iter().any(|touch| matches!(touch, Touch::Nvm | Touch::FactoryDefaults | Touch::Preset))
}

/// Whether a repetition may meet a quieter moment: others that send to the device all the time leave no quiet moment.
fn may_end_otherwise(report: &CaseReport) -> bool {
    let Some(End::Inconclusive(reason)) = report.verdict.end() else { return false };
    let come_and_go = report.foreign.iter().any(|sent| sent.kind.may_keep_out());
    let is_by_chance = reason.lack == Lack::Quiet && come_and_go || reason.lack == Lack::Promptness;
    report.verdict.kind() == Kind::Inconclusive && is_by_chance
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
    use crate::scripted::{table, test_case, with_options};
    use crate::verdict::{Breach, Judged, Stop};
    use canvass_bus::observation::{Observation, Subject};
    use std::sync::atomic::{AtomicU32, Ordering};

    const ROWS: &[(&str, &str)] = &[("63F#4000100000000000", "5BF#4300100096010200"), ("000#813F", "73F#00")];

    static TRIES: AtomicU32 = AtomicU32::new(0);

    /// A case that fails twice, then passes.
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

    /// A case with the outcomes of the script in turn: `p` passes, `f` fails, `i` is inconclusive, `n` is not
    /// applicable, `e` is an error.
    fn ending(script: &'static str, options: &Options) -> CaseReport {
        static SCRIPT: std::sync::Mutex<Vec<char>> = std::sync::Mutex::new(Vec::new());
        static SERIAL: std::sync::Mutex<()> = std::sync::Mutex::new(());
        static SCRIPTED: Case = test_case("test/scripted", |bench| {
            let end = SCRIPT.lock().unwrap().pop().unwrap();
            bench.note(format!("note {end}"));
            let reason = || crate::verdict::Reason::new("it ends", "so", end.to_string());
            match end {
                'p' => Ok(()),
                'f' => Err(Stop::Breach(Box::new(Breach::new(Subject::Device, "it works")))),
                'i' => Err(Stop::Inconclusive(reason())),
                'n' => Err(Stop::NotApplicable(reason())),
                _ => Err(Stop::Error(reason())),
            }
        });
        let serial = SERIAL.lock().unwrap();
        *SCRIPT.lock().unwrap() = script.chars().rev().collect();
        let report = with_options(table(ROWS), options, |bench| {
            let begun = bench.now();
            let report = run_repeatedly(bench, &SCRIPTED);
            assert_eq!(report.duration, bench.now().since(begun), "of all repetitions");
            report
        });
        drop(serial);
        report
    }

    fn outcomes(report: &CaseReport) -> String {
        let letter = |kind: &Kind| match kind {
            Kind::Pass => 'p',
            Kind::Fail => 'f',
            Kind::Inconclusive => 'i',
            Kind::NotApplicable => 'n',
            _ => 'e',
        };
        report.outcomes.iter().map(letter).collect()
    }

    /// Of several repetitions the first one with the worst outcome is reported, and all are counted.
    #[test]
    fn of_repetitions_the_worst_is_reported() {
        let repeated = |script: &'static str, repeat: u32| {
            let report = ending(script, &Options { repeat, ..Options::default() });
            (outcomes(&report), report.notes.first().cloned().unwrap_or_default())
        };
        let told = |outcomes: &str, note: &str| (outcomes.to_owned(), format!("note {note}"));
        assert_eq!(repeated("pfffff", 1), told("p", "p"));
        assert_eq!(repeated("pfffff", 0), told("p", "p"), "0 is once");
        assert_eq!(repeated("pipf", 3), told("pip", "i"));
        assert_eq!(repeated("pipf", 4), told("pipf", "f"));
        assert_eq!(repeated("fpie", 4), told("fpie", "f"));
        assert_eq!(repeated("nieip", 5), told("nieip", "e"));
    }

    /// A case is repeated if it failed, could not be judged, or the tester failed; the others are not repeated.
    #[test]
    fn what_has_not_failed_is_not_tried_again() {
        let retried = |script: &'static str, retries: u32| {
            let report = ending(script, &Options { retries, repeat: 9, ..Options::default() });
            (outcomes(&report), report.notes)
        };
        assert_eq!(retried("pf", 5), ("p".to_owned(), vec!["note p".to_owned()]));
        assert_eq!(retried("nf", 5).0, "n");
        assert_eq!(
            (retried("fn", 5).0, retried("ipf", 5).0, retried("epf", 5).0),
            ("fn".into(), "ip".into(), "ep".into())
        );
        assert_eq!((retried("ffff", 1).0, retried("fffp", 2).0), ("ff".into(), "fff".into()));
        let (_, notes) = retried("iep", 3);
        let begins: Vec<&str> = notes.iter().map(|note| note.split(" after ").next().unwrap()).collect();
        let expected = ["note i", "try 1 ended with inconclusive", "note e", "try 2 ended with error", "note p"];
        assert_eq!(begins, expected);
        assert!(notes[1].ends_with(": it ends: expected so, found i"), "{notes:?}");
    }

    /// If the user ends a run, its repetitions end, too.
    #[test]
    fn a_cancelled_run_is_not_repeated() {
        static WAITS: Case = test_case("test/waits", |bench| bench.listen(Duration::from_secs(2)).map(|_| ()));
        for (repeat, retries) in [(9, 0), (0, 9)] {
            let options = Options { repeat, retries, limit: Some(Duration::from_secs(5)), ..Options::default() };
            let report = with_options(table(ROWS), &options, |bench| {
                bench.listen(Duration::from_secs(4)).unwrap();
                run_repeatedly(bench, &WAITS)
            });
            assert_eq!(outcomes(&report), "i", "{repeat} {retries}");
        }
    }
}
