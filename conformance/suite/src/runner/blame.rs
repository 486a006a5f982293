//! Whose fault a failure is: the device's, or that of the bus, of others on it, or of the tester's own machine.

use crate::bench::Bench;
use crate::verdict::{Reason, Verdict};
use canvass_bus::Health;
use canvass_traces::Duration;

/// A failure that comes while a frame takes longer than this to or from the tester may be the tester's own: it is as long
/// as the shortest wait that a case judges by.
const HOST_LATE: Duration = Duration::from_millis(50);

/// From that share of the bus on, in percent, others may be why a device does not get through.
const OVERLOAD: u64 = 50;

/// Who takes so much of the bus that the device may not get through.
pub(super) fn overload(bench: &Bench<'_>, span: Duration) -> Option<String> {
    let load = bench.foreign().load(span, bench.bit_rate());
    let (id, count) = bench.foreign().loudest()?;
    (load >= OVERLOAD)
        .then(|| format!("others took {load} % of the bus, most of them {count} frames with identifier {id}"))
}

/// The verdict, if neither the bus nor the tester's own machine may be to blame.
pub(super) fn blameless(verdict: Verdict, health: &Health, overload: Option<String>, has_left: bool) -> Verdict {
    let says_something = !matches!(verdict, Verdict::NotApplicable(_) | Verdict::Error(_));
    let found = |verdict: &Verdict| match verdict.reason() {
        Some(reason) => format!("; meanwhile: {} ({})", reason.duty, reason.actual),
        None => String::new(),
    };
    if health.interruptions > 0 && says_something {
        let trouble = health.trouble.clone().unwrap_or_else(|| "the way to the bus was interrupted".to_owned());
        return Verdict::Error(Reason::new("the bus works", "no interruption", trouble));
    }
    if health.lost > 0 && says_something {
        let actual = format!("{} frames were lost on the tester's machine{}", health.lost, found(&verdict));
        return Verdict::Inconclusive(Reason::new("all frames reach the tester", "none lost", actual));
    }
    if !matches!(verdict, Verdict::Fail(_)) {
        return verdict;
    }
    let late = health.receive.longest().max(health.transmit.longest()).filter(|&longest| longest > HOST_LATE);
    let (duty, expected, actual) = match (has_left, overload, late) {
        (true, ..) => ("the device stays on the bus", "an answer, or a start after a reset", "neither".to_owned()),
        (_, Some(overload), _) => ("the bus has room for the device", "a load below half", overload),
        (_, _, Some(late)) => {
            let actual = format!("up to {late} between the tester and the bus");
            ("the tester's machine keeps up", "a few milliseconds", actual)
        }
        _ => return verdict,
    };
    Verdict::Inconclusive(Reason::new(duty, expected, format!("{actual}{}", found(&verdict))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::Kind;

    #[test]
    fn the_host_and_the_bus_are_not_the_device() {
        let fail = || Verdict::Fail(Reason::new("the read is answered", "the value", "no answer"));
        let judged = |health: &Health| blameless(fail(), health, None, false).kind();
        assert_eq!(judged(&Health::default()), Kind::Fail);
        assert_eq!(judged(&Health { lost: 1, ..Health::default() }), Kind::Inconclusive);
        assert_eq!(judged(&Health { interruptions: 1, ..Health::default() }), Kind::Error);
        let mut late = Health::default();
        late.receive.add(Duration::from_millis(20));
        assert_eq!(judged(&late), Kind::Fail);
        late.receive.add(Duration::from_millis(200));
        assert_eq!(judged(&late), Kind::Inconclusive);
        assert_eq!(blameless(Verdict::Pass, &late, None, false), Verdict::Pass);
        let lost = Health { lost: 1, ..Health::default() };
        assert_eq!(blameless(Verdict::Pass, &lost, None, false).kind(), Kind::Inconclusive);
        assert_eq!(blameless(fail(), &Health::default(), Some("123".to_owned()), false).kind(), Kind::Inconclusive);
        let Verdict::Inconclusive(reason) = blameless(fail(), &Health::default(), None, true) else { panic!() };
        assert_eq!(reason.actual, "neither; meanwhile: the read is answered (no answer)");
    }
}
