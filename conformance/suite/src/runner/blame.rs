//! Whose fault a failure is: the device's, or that of the bus, of others on it, or of the tester's own machine.

use crate::bench::{Bench, HOST_LATE};
use crate::verdict::{Breach, End, Reason};
use canvass_bus::Health;
use canvass_traces::Duration;

/// From that share of the bus on, in percent, others may be why a device does not get through.
const OVERLOAD: u64 = 50;

/// Who takes so much of the bus that the device may not get through.
pub(super) fn overload(bench: &Bench<'_>, span: Duration) -> Option<String> {
    let load = bench.foreign().load(span, bench.bit_rate());
    let (id, count) = bench.foreign().loudest()?;
    (load >= OVERLOAD)
        .then(|| format!("others took {load} % of the bus, most of them {count} frames with identifier {id}"))
}

/// What remains of the breaches when what the bus, others on it or the tester's own machine may have made is left out; and
/// how the case ended then.
///
/// A machine that was late, or a bus that had no room, can make an answer late or seem missing; it can't change a code or a
/// value. What does not rest on time stays.
pub(super) fn blameless(
    breaches: Vec<Breach>,
    end: Option<End>,
    health: &Health,
    overload: Option<String>,
) -> (Vec<Breach>, Option<End>) {
    if matches!(end, Some(End::NotApplicable(_) | End::Error(_))) {
        return (breaches, end);
    }
    let found = |end: &Option<End>| {
        let reason = breaches.first().map(Reason::from).or_else(|| end.as_ref().map(|end| end.reason().clone()));
        reason.map(|reason| format!("; meanwhile: {} ({})", reason.duty, reason.actual)).unwrap_or_default()
    };
    if health.interruptions > 0 {
        let trouble = health.trouble.clone().unwrap_or_else(|| "the way to the bus was interrupted".to_owned());
        return (Vec::new(), Some(End::Error(Reason::new("the bus works", "no interruption", trouble))));
    }
    if health.lost > 0 {
        let actual = format!("{} frames were lost on the tester's machine{}", health.lost, found(&end));
        let reason = Reason::new("all frames reach the tester", "none lost", actual);
        return (Vec::new(), Some(End::Inconclusive(reason)));
    }
    let late = health.receive.longest().max(health.transmit.longest()).filter(|&longest| longest > HOST_LATE);
    let (duty, expected, actual) = match (overload, late) {
        (Some(overload), _) => ("the bus has room for the device", "a load below half", overload),
        (_, Some(late)) => {
            let actual = format!("up to {late} between the tester and the bus");
            ("the tester's machine keeps up", "a few milliseconds", actual)
        }
        _ => return (breaches, end),
    };
    let excused = breaches.iter().any(Breach::depends_on_time);
    let reason = Reason::new(duty, expected, format!("{actual}{}", found(&end)));
    let certain: Vec<Breach> = breaches.into_iter().filter(|breach| !breach.depends_on_time()).collect();
    let end = if excused { Some(End::Inconclusive(reason)) } else { end };
    (certain, end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::{Kind, Ruled, Verdict};
    use canvass_analyzer::wire::sdo::AbortCode;
    use canvass_bus::observation::{Observation, Subject};

    fn breach(actual: Observation) -> Breach {
        Breach::new(Subject::Device, "the read is answered").expected("the value").found(actual)
    }

    fn judged(breaches: Vec<Breach>, health: &Health, overload: Option<String>) -> Verdict {
        let (breaches, end) = blameless(breaches, None, health, overload);
        Verdict::new(breaches.into_iter().map(|breach| Ruled { breach, excuse: None }).collect(), end)
    }

    #[test]
    fn the_host_and_the_bus_are_not_the_device() {
        let silent = |health: &Health| judged(vec![breach(Observation::Silence)], health, None).kind();
        assert_eq!(silent(&Health::default()), Kind::Fail);
        assert_eq!(silent(&Health { lost: 1, ..Health::default() }), Kind::Inconclusive);
        assert_eq!(silent(&Health { interruptions: 1, ..Health::default() }), Kind::Error);
        let mut late = Health::default();
        late.receive.add(Duration::from_millis(20));
        assert_eq!(silent(&late), Kind::Fail);
        late.receive.add(Duration::from_millis(200));
        assert_eq!(silent(&late), Kind::Inconclusive);
        assert_eq!(judged(Vec::new(), &late, None).kind(), Kind::Pass);
        let lost = Health { lost: 1, ..Health::default() };
        assert_eq!(judged(Vec::new(), &lost, None).kind(), Kind::Inconclusive);
        let overload = judged(vec![breach(Observation::Silence)], &Health::default(), Some("123".to_owned()));
        assert_eq!(overload.kind(), Kind::Inconclusive);
        assert_eq!(overload.reason().unwrap().actual, "123; meanwhile: the read is answered (no answer)");
    }

    #[test]
    fn a_late_host_changes_no_code_and_no_value() {
        let mut late = Health::default();
        late.receive.add(Duration::from_millis(200));
        for certain in [Observation::Abort(AbortCode::GENERAL), Observation::Value(vec![1]), Observation::Confirmation]
        {
            assert_eq!(judged(vec![breach(certain)], &late, None).kind(), Kind::Fail);
        }
        let both = vec![breach(Observation::Silence), breach(Observation::Abort(AbortCode::GENERAL))];
        assert_eq!(judged(both, &late, None).kind(), Kind::Fail);
    }
}
