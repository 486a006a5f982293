//! Failures that the device did not cause, but the bus, others on it, or the tester's own machine.

use super::Trial;
use crate::bench::{Bench, HOST_LATE, KEEPS_UP};
use crate::verdict::{Breach, End, Reason};
use canvass_bus::Health;
use canvass_traces::Duration;

/// Bus load of others, in percent, above which their traffic may delay the device's frames.
const OVERLOAD: u64 = 50;

/// The others that load the bus so much that the device's frames may not get through.
pub(super) fn overload(bench: &Bench<'_>, span: Duration) -> Option<String> {
    let foreign = bench.traffic.clients.foreign();
    let load = foreign.load(span, bench.bit_rate());
    let (id, count) = foreign.loudest()?;
    (load >= OVERLOAD)
        .then(|| format!("others took {load} % of the bus, most of them {count} frames with identifier {id}"))
}

pub(super) fn judge(trial: Trial, bench: &mut Bench<'_>) -> Trial {
    let health = bench.health().since(&trial.health);
    blameless(trial, &health)
}

/// Removes the breaches that the bus, others on it or the tester's own machine may have caused.
///
/// A late machine or a full bus can delay or hide an answer, but can't change a code or a value. Breaches that do not
/// depend on time stay.
fn blameless(mut trial: Trial, health: &Health) -> Trial {
    if trial.is_void() {
        return trial;
    }
    let meanwhile = trial.meanwhile();
    if health.interruptions > 0 {
        let trouble = health.trouble.clone().unwrap_or_else(|| "the connection to the bus was interrupted".to_owned());
        let end = Some(End::Error(Reason::new("the bus works", "no interruption", trouble)));
        return Trial { breaches: Vec::new(), end, ..trial };
    }
    if health.lost > 0 {
        let actual = format!("{} frames were lost on the tester's machine{meanwhile}", health.lost);
        let end = Some(End::Inconclusive(Reason::new("all frames reach the tester", "none lost", actual)));
        return Trial { breaches: Vec::new(), end, ..trial };
    }
    let overload = trial.overload.take();
    trial.excuse(|breach| {
        let reason = excuse(breach, health, overload.as_deref())?;
        Some(Reason { actual: format!("{}{meanwhile}", reason.actual), ..reason })
    });
    trial
}

/// The reason why the bus or the tester's own machine may have caused the breach.
fn excuse(breach: &Breach, health: &Health, overload: Option<&str>) -> Option<Reason> {
    if let Some(overload) = overload {
        let reason = || Reason::new("the bus has room for the device", "a load below half", overload);
        return breach.depends_on_time().then(reason);
    }
    let late = health.latest().unwrap_or_default();
    if is_made_by_lateness(breach, health, late) {
        let actual = format!("up to {late} between the tester and the bus");
        return Some(Reason::new(KEEPS_UP, "a delay of a few milliseconds", actual));
    }
    let trouble = health.stamps.filter(|_| breach.is_of_a_time())?;
    Some(Reason::new(
        "the adapter's time stamps say when a frame was on the bus",
        "correct time stamps",
        format!("they {trouble}"),
    ))
}

/// Whether the tester's own machine may have caused the breach: its delay exceeds the wait of a case for a frame, or
/// frames have no time stamp of their own and the measured time is outside its limits by less than the delay.
fn is_made_by_lateness(breach: &Breach, health: &Health, late: Duration) -> bool {
    let stamping = health.stamping.longest().unwrap_or_default();
    if late > HOST_LATE { breach.depends_on_time() } else { breach.is_outside_by(stamping.times(2)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::tests::{trial, verdict};
    use crate::verdict::{Allowed, Kind, Verdict};
    use canvass_analyzer::wire::sdo::AbortCode;
    use canvass_bus::StampTrouble;
    use canvass_bus::observation::{Observation, Subject};

    fn breach(actual: Observation) -> Breach {
        Breach::new(Subject::Device, "the read is answered").expected("the value").found(actual)
    }

    fn judged(breaches: Vec<Breach>, health: &Health, overload: Option<&str>) -> Verdict {
        let overload = overload.map(str::to_owned);
        verdict(blameless(Trial { overload, ..trial(breaches, None) }, health))
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
        let overload = judged(vec![breach(Observation::Silence)], &Health::default(), Some("123"));
        assert_eq!(overload.kind(), Kind::Inconclusive);
        assert_eq!(overload.reason().unwrap().actual, "123; meanwhile: the read is answered (no answer)");
    }

    /// Without time stamps of frames, a small delay of the machine excuses only a time that is outside by less.
    #[test]
    fn a_time_is_excused_by_what_was_late() {
        let allowed = Allowed::Time { least: Duration::from_millis(90), most: Duration::from_millis(110) };
        let after = |ms| Breach::new(Subject::Device, "in time").expected(allowed.clone()).found(time(ms));
        let mut late = Health::default();
        assert_eq!(judged(vec![after(111)], &late, None).kind(), Kind::Fail);
        late.receive.add(Duration::from_millis(3));
        assert_eq!(
            judged(vec![after(111)], &late, None).kind(),
            Kind::Fail,
            "the frames' times are right all the same"
        );
        late.stamping.add(Duration::from_millis(3));
        for (found, kind) in [(111, Kind::Inconclusive), (85, Kind::Inconclusive), (130, Kind::Fail), (70, Kind::Fail)]
        {
            assert_eq!(judged(vec![after(found)], &late, None).kind(), kind, "{found} ms");
        }
        assert_eq!(judged(vec![breach(Observation::Silence)], &late, None).kind(), Kind::Fail);
    }

    /// Times from an adapter with a faulty clock are not judged; other breaches stay.
    #[test]
    fn wrong_time_stamps_judge_no_time() {
        let allowed = Allowed::Time { least: Duration::from_millis(90), most: Duration::from_millis(110) };
        let late = Breach::new(Subject::Device, "in time").expected(allowed).found(time(900));
        let wrong = Health { stamps: Some(StampTrouble::Still), ..Health::default() };
        let verdict = judged(vec![late.clone()], &wrong, None);
        assert_eq!(verdict.kind(), Kind::Inconclusive);
        assert_eq!(verdict.reason().unwrap().actual, "they stand still; meanwhile: in time (900 ms)");
        assert_eq!(judged(vec![late], &Health::default(), None).kind(), Kind::Fail);
        assert_eq!(judged(vec![breach(Observation::Silence)], &wrong, None).kind(), Kind::Fail);
        assert_eq!(judged(Vec::new(), &wrong, None).kind(), Kind::Pass);
    }

    fn time(ms: u64) -> Observation {
        Observation::Time(Duration::from_millis(ms))
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

    /// Others are named from half of the bus load on; frames of the device and the tester do not count.
    #[test]
    fn others_that_take_half_of_the_bus_are_named() {
        use crate::scripted::{frame, with_bench};
        use canvass_traces::{Frame, bit_length};
        let told = |text: &'static str, span: u64| {
            let script = move |_: &Frame| vec![(Duration::from_millis(1), frame(text)); 100];
            with_bench(script, |bench| {
                bench.send_bytes(0x7FF, &[0; 8]).unwrap();
                bench.listen(Duration::from_millis(5)).unwrap();
                overload(bench, Duration(span))
            })
        };
        // The load refers to the highest bit rate, since the bit rate of the bus is unknown.
        let bits = u64::from(bit_length(&frame("123#0102030405060708")).unwrap()) * 100;
        let half = bits * 1_000 * 2;
        let named = "others took 50 % of the bus, most of them 100 frames with identifier 123";
        assert_eq!(told("123#0102030405060708", half).as_deref(), Some(named));
        assert_eq!(told("123#0102030405060708", half + half / 20), None);
        assert_eq!(told("1BF#0102030405060708", 1), None, "that is the device itself");
    }

    /// A case without verdict on the device is left unchanged, and an excuse by others hides no other reason.
    #[test]
    fn what_was_found_meanwhile_is_told() {
        let reason = || Reason::new("it is reached", "yes", "no");
        let lost = Health { lost: 2, ..Health::default() };
        for end in [End::NotApplicable(reason()), End::Error(reason())] {
            let kept = blameless(trial(vec![breach(Observation::Silence)], Some(end.clone())), &lost);
            assert_eq!((kept.breaches, kept.end), (vec![breach(Observation::Silence)], Some(end)));
        }
        let told = |end: Option<End>, health: &Health| judged_so(Vec::new(), end, health);
        let unreached = || Some(End::Inconclusive(reason()));
        assert_eq!(
            told(unreached(), &lost),
            "2 frames were lost on the tester's machine; meanwhile: it is reached (no)"
        );
        assert_eq!(told(None, &lost), "2 frames were lost on the tester's machine");
        let interrupted = Health { interruptions: 1, trouble: Some("bus-off".to_owned()), ..Health::default() };
        assert_eq!(told(None, &interrupted), "bus-off");
        let unnamed = Health { interruptions: 1, ..Health::default() };
        assert_eq!(told(None, &unnamed), "the connection to the bus was interrupted");
        let mut late = Health::default();
        late.receive.add(Duration::from_millis(200));
        let told = judged_so(vec![breach(Observation::Silence)], None, &late);
        assert!(
            told.starts_with("up to 2") && told.contains(" ms between the tester and the bus; meanwhile: "),
            "{told}"
        );
        assert_eq!(judged_so(Vec::new(), unreached(), &late), "no", "nothing of that rests on time");
    }

    fn judged_so(breaches: Vec<Breach>, end: Option<End>, health: &Health) -> String {
        blameless(trial(breaches, end), health).end.unwrap().reason().actual.clone()
    }
}
