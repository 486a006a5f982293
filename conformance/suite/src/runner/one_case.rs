//! One case from its precondition to its verdict.

use super::blame::{blameless, overload};
use super::event::CaseReport;
use crate::bench::{Bench, Deviation, Evidence, Remains};
use crate::case::{Case, Touch};
use crate::verdict::{Reason, Verdict};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs one case: precondition, stimulus, restoration, and what must be true after every case.
pub fn run_case(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let started = bench.now();
    let health = bench.health();
    bench.begin();
    let judged = catch_unwind(AssertUnwindSafe(|| judge(bench, case)));
    let verdict = judged.unwrap_or_else(|panic| Verdict::Error(panicked(&*panic)));
    let took = bench.now().since(started);
    let overload = matches!(verdict, Verdict::Fail(_)).then(|| overload(bench, took)).flatten();
    // A device that has gone is looked for while its frames are still evidence.
    let suspicious = matches!(verdict, Verdict::Fail(_) | Verdict::Inconclusive(_));
    let has_left = suspicious && bench.is_live() && bench.has_left();
    // Also what puts the device back could panic; the run goes on.
    let ended_early = matches!(verdict, Verdict::Inconclusive(_) | Verdict::Error(_));
    let clean_up = || {
        if ended_early {
            bench.rescue(case);
        }
        bench.finish()
    };
    let remains = catch_unwind(AssertUnwindSafe(clean_up)).ok();
    let Remains { evidence, notes, restarted, measurements } = remains.unwrap_or_else(|| Remains {
        evidence: Evidence::default(),
        notes: vec!["the tester failed while it restored the device".to_owned()],
        restarted: None,
        measurements: Vec::new(),
    });
    let verdict = blameless(verdict, &bench.health().since(&health), overload, has_left);
    let verdict = match (verdict, restarted) {
        (Verdict::Pass | Verdict::Tolerated(_), Some(at)) => Verdict::Fail(Reason::new(
            "the device does not restart by itself",
            "no boot-up message after the case has begun",
            format!("a boot-up message at {at} s"),
        )),
        (verdict, _) => verdict,
    };
    let verdict = documented(verdict, case, &bench.target().deviations);
    let outcomes = vec![verdict.kind()];
    CaseReport { case, verdict, evidence, notes, measurements, outcomes, duration: bench.now().since(started) }
}

fn judge(bench: &mut Bench<'_>, case: &'static Case) -> Verdict {
    let judged = (|| {
        if let Some(touch) = case.touches.iter().find(|touch| !bench.options().allow.contains(touch)) {
            return Err(Verdict::NotApplicable(not_allowed(*touch)));
        }
        bench.end_when_frames_are_lost();
        bench.look_for_it()?;
        bench.prepare()?;
        for &need in case.needs {
            if let Err(why) = bench.meets(need)? {
                let expected = need.text();
                return Err(Verdict::NotApplicable(Reason::new("the case has what it needs", expected, why)));
            }
        }
        (case.run)(bench)
    })();
    judged.unwrap_or_else(|verdict| verdict)
}

fn not_allowed(touch: Touch) -> Reason {
    let duty = format!("the user allows what the case does: it {}", touch.text());
    Reason::new(duty, format!("--allow {touch}"), format!("not allowed: it {} (--allow {touch})", touch.text()))
}

fn panicked(panic: &(dyn Any + Send)) -> Reason {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    Reason::new("the tester works", "a verdict", text.unwrap_or_else(|| "a panic".to_owned()))
}

/// A failure that the device's documentation or its user announces is a deviation.
pub(super) fn documented(verdict: Verdict, case: &Case, deviations: &[Deviation]) -> Verdict {
    let Verdict::Fail(reason) = verdict else { return verdict };
    match deviations.iter().find(|deviation| deviation.explains(case, &reason)) {
        Some(Deviation { documented, by, .. }) => {
            Verdict::Deviation { reason, documented: documented.clone(), by: *by }
        }
        None => Verdict::Fail(reason),
    }
}
