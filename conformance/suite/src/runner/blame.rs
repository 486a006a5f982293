//! Whose fault a failure is: the device's, or that of the bus, of others on it, or of the tester's own machine.

use crate::bench::{Bench, HOST_LATE, KEEPS_UP, KeptOut};
use crate::case::Case;
use crate::clause::Level;
use crate::verdict::{Breach, End, Reason};
use canvass_analyzer::Service;
use canvass_analyzer::wire::error_control::State;
use canvass_bus::Health;
use canvass_bus::observation::{Observation, Subject};
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
    overload: Option<&str>,
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
    let meanwhile = found(&end);
    let excuse = |breach: &Breach| excuse(breach, health, overload);
    let (excused, certain): (Vec<Breach>, Vec<Breach>) =
        breaches.into_iter().partition(|breach| excuse(breach).is_some());
    let Some(reason) = excused.first().and_then(excuse) else { return (certain, end) };
    let actual = format!("{}{meanwhile}", reason.actual);
    (certain, Some(End::Inconclusive(Reason { actual, ..reason })))
}

/// What of the bus or of the tester's own machine may have made the breach.
fn excuse(breach: &Breach, health: &Health, overload: Option<&str>) -> Option<Reason> {
    if let Some(overload) = overload {
        let reason = || Reason::new("the bus has room for the device", "a load below half", overload);
        return breach.depends_on_time().then(reason);
    }
    let late = health.latest().unwrap_or_default();
    if is_made_by_lateness(breach, health, late) {
        let actual = format!("up to {late} between the tester and the bus");
        return Some(Reason::new(KEEPS_UP, "a few milliseconds", actual));
    }
    let trouble = health.stamps.filter(|_| breach.is_of_a_time())?;
    Some(Reason::new(
        "the adapter's time stamps say when a frame was on the bus",
        "right ones",
        format!("they {trouble}"),
    ))
}

/// Whether the tester's own machine may have made the breach: it was late for longer than a case waits for a frame, or the
/// frames have no time of their own and what was measured is outside by less than that.
fn is_made_by_lateness(breach: &Breach, health: &Health, late: Duration) -> bool {
    let stamping = health.stamping.longest().unwrap_or_default();
    if late > HOST_LATE { breach.depends_on_time() } else { breach.is_outside_by(stamping.times(2)) }
}

/// A case that needs the device operational says nothing of a device that can't be: that is told by the cases of its state, or by
/// that after which it could no longer be.
pub(super) fn not_kept_out(
    bench: &mut Bench<'_>,
    case: &Case,
    breaches: Vec<Breach>,
    end: Option<End>,
) -> (Vec<Breach>, Option<End>) {
    let judges_states = matches!(case.family(), "301/nmt" | "301/heartbeat" | "301/guarding");
    let has_passed = breaches.is_empty() && end.is_none();
    let is_doubtful = breaches.iter().any(needs_operational) || has_passed && !bench.may_be_operational();
    if judges_states || !bench.has_started_it() || !is_doubtful {
        return (breaches, end);
    }
    match bench.kept_out_of_operational((case.level != Level::Open).then_some(case.id)) {
        None => (breaches, end),
        Some(KeptOut::Newly(breach)) => (breaches.into_iter().chain([breach]).collect(), end),
        Some(KeptOut::Known(reason)) => {
            let others = breaches.into_iter().filter(|breach| !needs_operational(breach)).collect();
            (others, Some(End::Inconclusive(reason)))
        }
    }
}

/// Whether a device that is not operational may show that: its state, PDOs that don't come or have no effect, and what follows
/// from them. It serves SDO as one that is.
fn needs_operational(breach: &Breach) -> bool {
    let is_application = |subject| matches!(subject, Subject::Entry(at) if at.index.0 >= 0x2000);
    let is_of_sdo = match breach.subject {
        Subject::Service(service) => service == Service::Sdo,
        subject => matches!(subject, Subject::Entry(_) | Subject::Object(_)) && !is_application(subject),
    };
    match breach.actual {
        Observation::State(state) => state != State::OPERATIONAL,
        Observation::Count(_) | Observation::Time(_) => true,
        Observation::Silence | Observation::Named(_) => !is_of_sdo,
        Observation::Value(_) => is_application(breach.subject),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::{Allowed, Kind, Ruled, Verdict};
    use canvass_analyzer::wire::sdo::AbortCode;
    use canvass_bus::StampTrouble;

    fn breach(actual: Observation) -> Breach {
        Breach::new(Subject::Device, "the read is answered").expected("the value").found(actual)
    }

    fn judged(breaches: Vec<Breach>, health: &Health, overload: Option<&str>) -> Verdict {
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
        let overload = judged(vec![breach(Observation::Silence)], &Health::default(), Some("123"));
        assert_eq!(overload.kind(), Kind::Inconclusive);
        assert_eq!(overload.reason().unwrap().actual, "123; meanwhile: the read is answered (no answer)");
    }

    /// Frames without a time of their own: a small lateness excuses what is outside by little, and nothing else.
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

    /// What an adapter measured whose clock can't be trusted is no time; all else stays.
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

    /// From half of the bus on others are named; the device's own frames, and the tester's, are not theirs.
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
        // At the highest bit rate, as that of the bus is not known.
        let bits = u64::from(bit_length(&frame("123#0102030405060708")).unwrap()) * 100;
        let half = bits * 1_000 * 2;
        let named = "others took 50 % of the bus, most of them 100 frames with identifier 123";
        assert_eq!(told("123#0102030405060708", half).as_deref(), Some(named));
        assert_eq!(told("123#0102030405060708", half + half / 20), None);
        assert_eq!(told("1BF#0102030405060708", 1), None, "that is the device itself");
    }

    /// What did not come to a verdict on the device is left as it is, and what others made hides no other reason.
    #[test]
    fn what_was_found_meanwhile_is_told() {
        let reason = || Reason::new("it is reached", "yes", "no");
        let lost = Health { lost: 2, ..Health::default() };
        for end in [End::NotApplicable(reason()), End::Error(reason())] {
            let kept = blameless(vec![breach(Observation::Silence)], Some(end.clone()), &lost, None);
            assert_eq!(kept, (vec![breach(Observation::Silence)], Some(end)));
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
        assert_eq!(told(None, &unnamed), "the way to the bus was interrupted");
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
        let (_, end) = blameless(breaches, end, health, None);
        end.unwrap().reason().actual.clone()
    }

    /// What a device shows that is not operational, and what none shows for that reason.
    #[test]
    fn what_the_state_explains() {
        let tpdo = Subject::Pdo { transmit: true, number: 1 };
        let entry = |index| Subject::Entry(canvass_analyzer::Multiplexer::new(index, 0));
        let found = |subject, actual| needs_operational(&Breach { subject, ..breach(actual) });
        for (subject, actual) in [
            (tpdo, Observation::Silence),
            (tpdo, Observation::Count(0)),
            (Subject::Device, Observation::State(State::PRE_OPERATIONAL)),
            (Subject::Device, Observation::named("no EMCY, but the state")),
            (entry(0x2000), Observation::Value(vec![0])),
        ] {
            assert!(found(subject, actual.clone()), "{subject:?} {actual:?}");
        }
        for (subject, actual) in [
            (Subject::Device, Observation::State(State::OPERATIONAL)),
            (entry(0x1017), Observation::Silence),
            (entry(0x1017), Observation::Value(vec![0])),
            (Subject::Service(Service::Sdo), Observation::named("seven bytes")),
            (tpdo, Observation::Abort(AbortCode::GENERAL)),
            (Subject::Device, Observation::BootUp),
        ] {
            assert!(!found(subject, actual.clone()), "{subject:?} {actual:?}");
        }
    }
}
