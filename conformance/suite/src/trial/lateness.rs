//! A device without processor time, such as a process on a busy machine, is late as a whole: that is no failure of its
//! timers.

use super::{CaseReport, Trial, meanwhile};
use crate::bench::{Bench, DEVICE_KEEPS_UP, HOST_LATE, Timing, promptness};
use crate::clause::Level;
use crate::verdict::{Allowed, Breach, End, Kind, Lack, Reason, Ruled};
use canvass_analyzer::Service;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Duration;

/// Removes the breaches that the lateness of the device may have caused, if its cheap answers were as late. The
/// lateness may also be why a precondition was not reached.
pub(super) fn judge(mut trial: Trial, bench: &mut Bench<'_>) -> Trial {
    // An open case never fails; a device that has left is not late.
    let is_open = trial.case.level == Level::Open;
    if !trial.has_asked || trial.has_left || bench.knowledge.has_gone() || is_open || trial.is_void() {
        return trial;
    }
    // The run must end: nothing more is asked.
    if bench.is_cancelled() {
        return trial;
    }
    let timing = bench.timing();
    let needed = |breach: &Breach| lateness_needed(breach, &timing);
    // If an earlier judge ended the case, its reason is better than this one.
    let unreached = match &trial.end {
        Some(End::Inconclusive(reason)) => trial.unreached.clone().filter(|unreached| unreached == reason),
        _ => None,
    };
    let most = trial.breaches.iter().filter_map(needed).chain(unreached.as_ref().map(|_| HOST_LATE)).max();
    let Some(most) = most else { return trial };
    let lateness = promptness::lateness(bench, most);
    let usual = bench.knowledge.usual_answer();
    let late = |found: &Reason| {
        let actual = format!(
            "the device was late as a whole: a read outside the case was answered {lateness} later{}",
            meanwhile(found)
        );
        let reason = Reason::new(DEVICE_KEEPS_UP, format!("answers after {usual}, as usual"), actual);
        reason.for_lack_of(Lack::Promptness)
    };
    let of_run = promptness::lateness_of_run(bench);
    // A device that is late now may have met its longest stall in the case, and a shorter one in the reads beside it.
    let stall = if lateness >= HOST_LATE { lateness.max(of_run) } else { lateness };
    let is_excused = |breach: &Breach| needed(breach).is_some_and(|needed| needed <= stall);
    if !trial.excuse(|breach| is_excused(breach).then(|| late(&Reason::from(breach))))
        && let Some(unreached) = unreached.filter(|_| lateness >= HOST_LATE)
    {
        trial.end = Some(End::Inconclusive(late(&unreached)));
    }
    trial
}

/// Lateness in a run from which on the device may also have met a longer stall that no read has seen. Stalls of a process
/// without processor time differ much, and a case lasts much longer than the reads.
const SIGN_OF_STALLS: Duration = Duration::from_millis(5);

/// The reason to doubt a failure until it comes again: lateness can cause each of its breaches, and the device was late
/// as a whole at some time in the run. A device that sometimes gets no processor time may be prompt again when the
/// bench measures it.
pub(super) fn doubt(report: &CaseReport, bench: &Bench<'_>) -> Option<Reason> {
    if report.verdict.kind() != Kind::Fail {
        return None;
    }
    let (timing, lateness) = (bench.timing(), promptness::lateness_of_run(bench));
    // An LSS answer does not name its request: the bench takes a late one for the answer to the next request.
    let is_mistaken = |breach: &Breach| matches!(breach.subject, Subject::Service(Service::Lss | Service::Lmt));
    let by_lateness = |Ruled { breach, .. }: &Ruled| match lateness_needed(breach, &timing) {
        Some(needed) => lateness >= needed.min(SIGN_OF_STALLS),
        None => lateness >= HOST_LATE && is_mistaken(breach),
    };
    let mut failures = report.verdict.breaches().iter().filter(|ruled| ruled.kind() == Kind::Fail);
    if lateness == Duration::ZERO || !failures.all(by_lateness) {
        return None;
    }
    let usual = bench.knowledge.usual_answer();
    let found = report.verdict.reason().map(|reason| meanwhile(&reason)).unwrap_or_default();
    let actual = format!(
        "another try did not find it, and the device was late as a whole in this run, by up to {lateness}{found}"
    );
    let reason = Reason::new(DEVICE_KEEPS_UP, format!("answers after {usual}, as usual"), actual);
    Some(reason.for_lack_of(Lack::Promptness))
}

/// The lateness that could cause the breach; `None` if none could.
fn lateness_needed(breach: &Breach, timing: &Timing) -> Option<Duration> {
    if breach.lateness.is_some() {
        return breach.lateness;
    }
    if let (Allowed::Time { .. }, Observation::Time(_)) = (&breach.allowed, &breach.actual) {
        return breach.outside();
    }
    let of_dictionary = matches!(breach.subject, Subject::Entry(_) | Subject::Object(_));
    let of_sdo = of_dictionary || breach.subject == Subject::Service(Service::Sdo);
    let of_layers = matches!(breach.subject, Subject::Service(Service::Lss | Service::Lmt));
    match breach.actual {
        // A request waits this long for its answer.
        Observation::Silence if of_sdo => Some(timing.sdo_response),
        Observation::Silence if of_layers => Some(timing.silence),
        Observation::Silence if breach.subject == Subject::Service(Service::BootUp) => Some(timing.boot_up),
        Observation::Value(_) | Observation::Number(_) if of_dictionary => None,
        // The form of an answer is wrong at any time.
        Observation::Named(_) | Observation::Frame(_) if of_sdo || of_layers => None,
        // Cases give the device at least this long to act.
        Observation::Silence
        | Observation::Value(_)
        | Observation::Number(_)
        | Observation::State(_)
        | Observation::Time(_)
        | Observation::Count(_)
        | Observation::Emcy(_)
        | Observation::Frame(_)
        | Observation::Named(_) => Some(HOST_LATE),
        _ => None,
    }
}
