//! A device that gets no processor, as a process on a busy machine, is late as a whole: that is no failure of its timers.

use crate::bench::{Bench, DEVICE_KEEPS_UP, HOST_LATE, Timing};
use crate::verdict::{Allowed, Breach, End, Lack, Reason};
use canvass_analyzer::Service;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Duration;

/// What remains of the breaches when those are left out that a device may have made that was as late with answers that cost it
/// nothing, and how the case ended then. A precondition that was not reached may be its lateness, too.
pub(super) fn not_of_a_late_device(
    bench: &mut Bench<'_>,
    breaches: Vec<Breach>,
    end: Option<End>,
) -> (Vec<Breach>, Option<End>) {
    let timing = bench.timing();
    let needed = |breach: &Breach| lateness_needed(breach, &timing);
    let unreached = match &end {
        Some(End::NotApplicable(_) | End::Error(_)) => return (breaches, end),
        Some(End::Inconclusive(reason)) => (reason.lack == Lack::Feature).then(|| reason.clone()),
        None => None,
    };
    let most = breaches.iter().filter_map(needed).chain(unreached.as_ref().map(|_| HOST_LATE)).max();
    let Some(most) = most else { return (breaches, end) };
    let lateness = bench.lateness(most);
    let (excused, certain): (Vec<Breach>, Vec<Breach>) =
        breaches.into_iter().partition(|breach| needed(breach).is_some_and(|needed| needed <= lateness));
    let unreached = unreached.filter(|_| lateness >= HOST_LATE);
    let Some(found) = excused.first().map(Reason::from).or(unreached) else { return (certain, end) };
    let actual = format!(
        "the device was late as a whole: a read beside the case was answered {lateness} later; meanwhile: {} ({})",
        found.duty, found.actual
    );
    let usual = bench.usual_answer();
    let reason = Reason::new(DEVICE_KEEPS_UP, format!("answers after {usual}, as usual"), actual);
    (certain, Some(End::Inconclusive(reason.for_lack_of(Lack::Promptness))))
}

/// How late the device would have had to be to make the breach; `None`: no lateness makes it.
fn lateness_needed(breach: &Breach, timing: &Timing) -> Option<Duration> {
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
        Observation::Value(_) | Observation::Number(_) if of_dictionary => None,
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
