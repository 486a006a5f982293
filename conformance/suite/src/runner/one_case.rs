//! One case from its precondition to its verdict.

use super::blame::{blameless, not_kept_out, overload};
use super::event::CaseReport;
use super::lateness::not_of_a_late_device;
use super::others::not_of_others;
use super::restart::with_restart;
use crate::bench::{Bench, Boots, Evidence, Remains, Target};
use crate::case::Case;
use crate::clause::Level;
use crate::needs;
use crate::touch::Touch;
use crate::verdict::{Breach, Deviation, End, Excuse, Grade, Judged, Kind, Lack, Reason, Ruled, Stop, Verdict};
use canvass_bus::observation::{Observation, Subject};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs one case: precondition, stimulus, restoration, and what must be true after every case.
pub fn run_case(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let started = bench.now();
    let health = bench.health();
    bench.begin();
    let judged = catch_unwind(AssertUnwindSafe(|| judge(bench, case)));
    let judged = judged.unwrap_or_else(|panic| Err(Stop::Error(panicked(&*panic))));
    let (last, end) = ended(judged);
    let breaches = bench.take_breaches(last);
    let (breaches, end) = not_left_behind(bench, breaches, end);
    let took = bench.now().since(started);
    let overload = (!breaches.is_empty()).then(|| overload(bench, took)).flatten();
    // A device that has gone is looked for while its frames are still evidence; a case that passed may have stopped it, too.
    let was_interrupted = bench.health().since(&health).interruptions > 0;
    let ran = case.asks_the_device() && !was_interrupted && !matches!(end, Some(End::NotApplicable(_) | End::Error(_)));
    let has_left = ran && bench.has_left(case.id, regain);
    // Also what puts the device back could panic; the run goes on.
    let ended_early = matches!(end, Some(End::Inconclusive(_) | End::Error(_)));
    let clean_up = || {
        if ended_early {
            case.rescue(bench);
        }
        bench.finish()
    };
    let remains = catch_unwind(AssertUnwindSafe(clean_up)).ok();
    let Remains { evidence, notes, boots, measurements, uses } = remains.unwrap_or_else(|| Remains {
        evidence: Evidence::default(),
        notes: vec!["the tester failed while it restored the device".to_owned()],
        boots: Boots::default(),
        measurements: Vec::new(),
        uses: Vec::new(),
    });
    let breaches = with_restart(bench, breaches, end.as_ref(), &boots);
    let (breaches, end) = blameless(breaches, end, &bench.health().since(&health), overload.as_deref());
    let (mut breaches, end) = if ran && !has_left { not_kept_out(bench, case, breaches, end) } else { (breaches, end) };
    settle(bench, case, ran);
    breaches.extend(has_left.then(stopped_answering));
    let foreign = bench.foreign_messages();
    let (breaches, end) = not_of_others(case.id, breaches, end, &foreign);
    // What an open case finds fails nobody; a device that has left is not late.
    let may_be_late = ran && !has_left && case.level != Level::Open;
    let (breaches, end) = if may_be_late { not_of_a_late_device(bench, breaches, end) } else { (breaches, end) };
    let graded = breaches.into_iter().map(|breach| graded(breach, case));
    let ruled = graded.map(|breach| rule(breach, case, &bench.target().deviations)).collect();
    let verdict = Verdict::new(ruled, end);
    let others = foreign.iter().map(ToString::to_string);
    let notes = notes.into_iter().chain(others).chain(described_so(bench, case, &verdict)).collect();
    let outcomes = vec![verdict.kind()];
    let duration = bench.now().since(started);
    CaseReport { case, verdict, evidence, notes, measurements, uses, foreign, outcomes, quarantine: None, duration }
}

/// What the case may have stored is put back, and the journal knows.
fn settle(bench: &mut Bench<'_>, case: &Case, ran: bool) {
    let settled = catch_unwind(AssertUnwindSafe(|| {
        if ran {
            bench.settle_memory(case.touches);
        }
    }));
    // If the tester fails here, the journal goes on telling of the case.
    if settled.is_ok() {
        bench.settle_journal();
    }
}

/// What fails on a device that is simulated from its description alone is not its simulation.
fn described_so(bench: &Bench<'_>, case: &Case, verdict: &Verdict) -> Option<String> {
    let Target { described_alone, model, .. } = bench.target();
    let is_it = *described_alone && case.asks_the_device() && verdict.kind() == Kind::Fail;
    is_it.then(|| format!("the device is simulated as {model} describes it: what is wrong is wrong there"))
}

/// Gives a device its node-ID again that has lost it, where the user allows that.
fn regain(bench: &mut Bench<'_>) {
    let may_regain = bench.options().allow.contains(&Touch::NodeId);
    if let Some(rescue) = needs::LSS.rescue().filter(|_| may_regain) {
        // What fails here shows in whether the device answers then.
        let _ = rescue(bench, true);
    }
}

/// Resets the device. What a case has ordered may act only now: that the device has no node-ID any more, for example.
fn prepare(bench: &mut Bench<'_>) -> Judged {
    match bench.prepare() {
        Err(Stop::Inconclusive(_)) if bench.options().allow.contains(&Touch::NodeId) && !bench.is_cancelled() => {
            regain(bench);
            bench.prepare()
        }
        prepared => prepared,
    }
}

/// A case that judges an object that an earlier case has left behind says nothing of the device's own value.
fn not_left_behind(bench: &Bench<'_>, breaches: Vec<Breach>, end: Option<End>) -> (Vec<Breach>, Option<End>) {
    let (ours, its): (Vec<Breach>, Vec<Breach>) =
        breaches.into_iter().partition(|breach| bench.is_left_behind(breach.subject));
    let end = ours.first().map_or(end, |breach| {
        let duty = format!("{} has the device's own value", breach.subject);
        let reason =
            Reason::new(duty, "the value before the run", "one that an earlier case left, which could not be put back");
        Some(End::Inconclusive(reason))
    });
    (its, end)
}

/// The breach that ended a case, or why else it did not come to its own end.
fn ended(judged: Judged) -> (Option<Box<Breach>>, Option<End>) {
    match judged {
        Ok(()) => (None, None),
        Err(Stop::Breach(breach)) => (Some(breach), None),
        Err(Stop::Inconclusive(reason)) => (None, Some(End::Inconclusive(reason))),
        Err(Stop::NotApplicable(reason)) => (None, Some(End::NotApplicable(reason))),
        Err(Stop::Error(reason)) => (None, Some(End::Error(reason))),
    }
}

fn stopped_answering() -> Breach {
    Breach::new(Subject::Device, "the device stays on the bus")
        .expected("an answer, or a start after a reset")
        .found(Observation::named("the device stopped answering"))
}

fn judge(bench: &mut Bench<'_>, case: &'static Case) -> Judged {
    if let Some(touch) = case.touches.iter().find(|touch| !bench.options().allow.contains(touch)) {
        return Err(Stop::NotApplicable(not_allowed(*touch)));
    }
    if case.touches.contains(&Touch::FactoryDefaults) && bench.would_lose_zero_point() {
        return Err(Stop::NotApplicable(not_allowed(Touch::Preset)));
    }
    if case.asks_the_device() {
        bench.end_when_frames_are_lost();
        bench.look_for_it()?;
        prepare(bench)?;
    }
    bench.journal_case(case.id, case.touches)?;
    case.require(bench)?;
    (case.run)(bench)
}

fn not_allowed(touch: Touch) -> Reason {
    let duty = format!("the user allows what the case does: it {}", touch.text());
    Reason::new(duty, touch.name(), format!("not allowed: it {}", touch.text())).for_lack_of(Lack::Permission)
}

fn panicked(panic: &(dyn Any + Send)) -> Reason {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    Reason::new("the tester works", "a verdict", text.unwrap_or_else(|| "a panic".to_owned()))
}

/// What the standard leaves open is recorded and never fails.
fn graded(breach: Breach, case: &Case) -> Breach {
    if case.level == Level::Open { breach.open() } else { breach }
}

/// What the device's documentation or its user announces is excused: that case, that subject, that behaviour, and
/// nothing else.
pub(super) fn rule(breach: Breach, case: &Case, deviations: &[Deviation]) -> Ruled {
    let announced = deviations.iter().filter(|_| breach.grade == Grade::Wrong);
    let announced = announced.into_iter().find(|deviation| deviation.explains(case.id, &breach));
    let excuse = announced.map(|Deviation { documented, by, .. }| Excuse { documented: documented.clone(), by: *by });
    Ruled { breach, excuse }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::Options;
    use crate::scripted::{table, with_options};
    use canvass_traces::Duration;

    /// Without the user's leave a device that does not start is reset, and once more after it was woken; with it, its node-ID is
    /// looked for, and it is reset anew. After the end of the run nothing more is tried.
    #[test]
    fn a_node_id_is_looked_for_with_leave_only() {
        let resets = |allow: &[Touch], limit: Option<Duration>| {
            let options = Options { allow: allow.iter().copied().collect(), limit, ..Options::default() };
            with_options(table(&[]), &options, |bench| {
                assert!(prepare(bench).is_err());
                bench.evidence().frames().filter(|exhibit| exhibit.text == "000#813F").count()
            })
        };
        assert_eq!(resets(&[], None), 2);
        assert_eq!(resets(&[Touch::Nvm], None), 2);
        assert_eq!(resets(&[Touch::NodeId], None), 4);
        assert_eq!(resets(&[Touch::NodeId], Some(Duration::from_secs(15))), 2, "its time was over");
    }
}
