//! Verdicts from breaches, their reports, and the numbers of a run.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::sdo::{Abort, AbortCode, Response};
use canvass_bus::client::sdo::{Outcome, Violation};
use canvass_bus::observation::{Observation, Subject};
use canvass_suite::comparison::{Change, Comparison, Nature};
use canvass_suite::runner::Summary;
use canvass_suite::situation::{Judgement, Situation};
use canvass_suite::verdict::{
    Allowed, Authority, Breach, Deviation, End, Excuse, Grade, Kind, Lack, Precondition, Reason, Ruled, Stop, Verdict,
    demand, observed, observed_response,
};
use canvass_traces::Duration;

fn breach(duty: &'static str) -> Breach {
    Breach::new(Subject::Device, duty).expected("an answer").found(Observation::Silence)
}

fn ruled(breach: Breach, excuse: Option<Authority>) -> Ruled {
    let excuse = excuse.map(|by| Excuse { documented: "manual, 5.1".to_owned(), by });
    Ruled { breach, excuse }
}

#[test]
fn kinds_have_names_titles_and_an_order() {
    let told: Vec<_> = Kind::ALL.iter().map(|kind| (kind.name(), kind.title(), kind.badness())).collect();
    assert_eq!(
        told,
        [
            ("pass", "pass", 0),
            ("tolerated", "tolerated", 1),
            ("deviation", "deviation", 2),
            ("fail", "fail", 6),
            ("inconclusive", "inconclusive", 4),
            ("not_applicable", "not applicable", 3),
            ("error", "error", 5),
        ]
    );
    for kind in Kind::ALL {
        assert_eq!((Kind::by_name(kind.name()), kind.to_string()), (Some(kind), kind.title().to_owned()));
    }
    assert_eq!(Kind::by_name("passed"), None);
    assert_eq!(format!("{:>6}|{:<6}|", Kind::Pass, Kind::Fail), "  pass|fail  |");
}

/// The reason of a verdict comes from the worst outcome: from the end if the end is the worst, otherwise from the first
/// breach of that kind.
#[test]
fn the_reason_is_that_of_the_worst() {
    let told = |breaches: &[Ruled], end: Option<End>| {
        let verdict = Verdict::new(breaches.to_vec(), end);
        (verdict.kind(), verdict.reason().map(|reason| reason.duty), verdict.worst().map(|worst| worst.breach.duty()))
    };
    let (open, tolerated) = (ruled(breach("open").open(), None), ruled(breach("tolerated").tolerated(), None));
    let (wrong, other) = (ruled(breach("wrong"), None), ruled(breach("other"), None));
    let duty = |text: &str| Some(text.to_owned());
    assert_eq!(told(&[], None), (Kind::Pass, None, None));
    assert_eq!(told(std::slice::from_ref(&open), None), (Kind::Pass, None, duty("open")));
    assert_eq!(told(&[open, tolerated.clone()], None), (Kind::Tolerated, duty("tolerated"), duty("tolerated")));
    assert_eq!(told(&[tolerated.clone(), wrong.clone(), other], None), (Kind::Fail, duty("wrong"), duty("wrong")));
    let end = |make: fn(Reason) -> End| Some(make(Reason::new("ended", "its end", "no end")));
    assert_eq!(told(&[tolerated], end(End::Inconclusive)), (Kind::Inconclusive, duty("ended"), None));
    assert_eq!(told(std::slice::from_ref(&wrong), end(End::Error)), (Kind::Fail, duty("wrong"), duty("wrong")));
    assert_eq!(told(&[], end(End::NotApplicable)), (Kind::NotApplicable, duty("ended"), None));
    assert_eq!(told(&[], end(End::Error)), (Kind::Error, duty("ended"), None));
}

#[test]
fn only_a_deviation_is_documented() {
    let told = |breaches: &[Ruled]| {
        let verdict = Verdict::new(breaches.to_vec(), None);
        (verdict.kind(), verdict.documented().map(str::to_owned), verdict.authority())
    };
    let manual = ruled(breach("a"), Some(Authority::Manual));
    let waiver = ruled(breach("b"), Some(Authority::Waiver { line: 3 }));
    let text = Some("manual, 5.1".to_owned());
    assert_eq!(told(&[manual.clone(), waiver.clone()]), (Kind::Deviation, text.clone(), Some(Authority::Manual)));
    assert_eq!(told(&[waiver, manual.clone()]), (Kind::Deviation, text, Some(Authority::Waiver { line: 3 })));
    assert_eq!(told(&[manual, ruled(breach("c"), None)]), (Kind::Fail, None, None));
    assert_eq!(told(&[]), (Kind::Pass, None, None));
    // A tolerated or open breach needs no excuse.
    let excused = |breach: Breach| ruled(breach, Some(Authority::Manual)).kind();
    assert_eq!((excused(breach("d").tolerated()), excused(breach("e").open())), (Kind::Tolerated, Kind::Pass));
}

#[test]
fn verdicts_of_one_reason() {
    let reason = Reason::new("it works", "yes", "no").for_lack_of(Lack::Permission);
    assert_eq!((reason.lack, reason.to_string()), (Lack::Permission, "it works: expected yes, found no".to_owned()));
    assert_eq!(Reason::new("a", "b", "c").lack, Lack::Feature);
    for (verdict, kind) in [
        (Verdict::inconclusive(reason.clone()), Kind::Inconclusive),
        (Verdict::not_applicable(reason.clone()), Kind::NotApplicable),
        (Verdict::error(reason.clone()), Kind::Error),
    ] {
        assert_eq!((verdict.kind(), verdict.reason(), verdict.breaches().len()), (kind, Some(reason.clone()), 0));
        assert_eq!(verdict.end().map(End::reason), Some(&reason));
    }
    assert_eq!((Verdict::pass().kind(), Verdict::pass().end()), (Kind::Pass, None));
}

#[test]
fn a_breach_as_precondition_leaves_the_case_inconclusive() {
    let found = || Box::new(breach("it works"));
    let reason = Reason::from(&breach("it works"));
    let stop: Result<(), Stop> = Err::<(), _>(found()).or_inconclusive();
    assert_eq!(stop, Err(Stop::Inconclusive(reason.clone())));
    assert_eq!(Ok::<u8, Stop>(7).or_inconclusive(), Ok(7));
    let other = Stop::NotApplicable(Reason::new("a", "b", "c"));
    assert_eq!(Err::<(), _>(other.clone()).or_inconclusive(), Err(other.clone()));
    assert_eq!(other.reason(), Reason::new("a", "b", "c"));
    assert_eq!(Stop::from(found()).reason(), reason);
    assert_eq!(demand(true, || breach("a")), Ok(()));
    assert_eq!(demand(false, || breach("a")), Err(Box::new(breach("a"))));
}

/// A time just outside its limits may be the tester's fault; a time further outside is the device's.
#[test]
fn a_time_is_outside_by_so_much() {
    let ms = Duration::from_millis;
    let allowed = Allowed::Time { least: ms(90), most: ms(110) };
    let after =
        |nanos| Breach::new(Subject::Device, "x").expected(allowed.clone()).found(Observation::Time(Duration(nanos)));
    for (nanos, outside) in [
        (84_999_999, false),
        (85_000_000, true),
        (89_999_999, true),
        (90_000_000, false),
        (100_000_000, false),
        (110_000_000, false),
        (110_000_001, true),
        (115_000_000, true),
        (115_000_001, false),
    ] {
        assert_eq!(after(nanos).is_outside_by(ms(5)), outside, "{nanos}");
        assert!(!after(nanos).is_outside_by(Duration::ZERO));
    }
    assert!(!breach("x").is_outside_by(ms(5)) && !breach("x").expected(allowed.clone()).is_outside_by(ms(5)));
    assert!(breach("x").expected(allowed).depends_on_time());
    let abort = Observation::Abort(AbortCode::GENERAL);
    assert!(breach("x").depends_on_time() && !breach("x").found(abort).depends_on_time());
}

#[test]
fn breaches_are_told_in_words() {
    let told = |observation: Observation| breach("x").found(observation).found_text();
    assert_eq!(told(Observation::Silence), "no answer");
    assert_eq!(
        told(Observation::Abort(AbortCode::NO_OBJECT)),
        "abort 0602 0000h object does not exist in the object dictionary"
    );
    assert_eq!(told(Observation::State(State::OPERATIONAL)), "operational");
    assert_eq!(told(Observation::Time(Duration::from_millis(20))), "20 ms");
    assert_eq!(told(Observation::Count(3)), "3");
    assert_eq!(told(Observation::Value(vec![1, 0xAB])), "01 AB");
    assert!(told(Observation::Emcy(EmcyCode(0x8130))).starts_with("EMCY 8130h"));
    assert_eq!(breach("x").told("in its own words").found_text(), "in its own words");
    assert_eq!(breach("x").to_string(), "x: expected an answer, found no answer");
    let listed = Breach::listed(Subject::Device, Situation::ReadOnly, "download of 1 byte to 1000h:00");
    assert_eq!(listed.duty(), format!("{}: download of 1 byte to 1000h:00", Situation::ReadOnly.requirement()));
    assert_eq!((listed.grade, listed.seen), (Grade::Wrong, None));

    let ms = Duration::from_millis;
    let both = Allowed::OneOf(vec![Observation::Silence, Observation::Count(2)]);
    assert_eq!(both.to_string(), "no answer or 2");
    assert_eq!(Allowed::from(Observation::Silence).to_string(), "no answer");
    assert_eq!(Allowed::Time { least: ms(1), most: ms(2) }.to_string(), "1 ms to 2 ms");
    let count = |least, most| Allowed::Count { least, most }.to_string();
    assert_eq!(
        (count(2, Some(2)), count(1, Some(2)), count(1, None)),
        ("2".into(), "1 to 2".into(), "at least 1".into())
    );
    assert_eq!((Allowed::from("a").to_string(), Allowed::from("b".to_owned()).to_string()), ("a".into(), "b".into()));
}

#[test]
fn what_a_transfer_led_to_is_an_observation() {
    let object = Multiplexer::new(0x1000, 0);
    let abort = Abort { multiplexer: object, code: AbortCode::READ_ONLY };
    let violation = Violation::Malformed("x".to_owned());
    for (outcome, observation) in [
        (Outcome::Uploaded(vec![1, 2]), Observation::Value(vec![1, 2])),
        (Outcome::Downloaded, Observation::Confirmation),
        (Outcome::Aborted(abort), Observation::Abort(AbortCode::READ_ONLY)),
        (Outcome::Silent, Observation::Silence),
        (Outcome::Violated(violation.clone()), Observation::Violation(violation)),
    ] {
        assert_eq!(observed(&outcome), observation);
    }
    assert_eq!(observed_response(&Response::Abort(abort)), Observation::Abort(AbortCode::READ_ONLY));
    assert!(matches!(observed_response(&Response::InitiateDownload { multiplexer: object }), Observation::Named(_)));
}

/// Situations allow aborts, any abort, silence or a confirmation (CiA 301, 7.2.4.3.17 and the clauses of the objects).
#[test]
fn a_situation_judges_every_kind_of_answer() {
    let abort = |code| Observation::Abort(code);
    for (situation, answer, judgement) in [
        (Situation::ReadOnly, abort(AbortCode::READ_ONLY), Judgement::Allowed),
        (Situation::ReadOnly, abort(AbortCode::GENERAL), Judgement::Tolerated),
        (Situation::ReadOnly, abort(AbortCode::NO_OBJECT), Judgement::Wrong),
        (Situation::ReadOnly, Observation::Confirmation, Judgement::Wrong),
        (Situation::ReadOnly, Observation::Silence, Judgement::Wrong),
        (Situation::StoreUnsupported, abort(AbortCode(0x1234)), Judgement::Allowed),
        (Situation::StoreInOperational, Observation::Confirmation, Judgement::Allowed),
        (Situation::StoreInOperational, abort(AbortCode::READ_ONLY), Judgement::Wrong),
        (Situation::Confirmed, Observation::Confirmation, Judgement::Allowed),
        (Situation::Confirmed, Observation::Silence, Judgement::Wrong),
        (Situation::Unanswered, Observation::Silence, Judgement::Allowed),
        (Situation::Unanswered, Observation::Confirmation, Judgement::Wrong),
        (Situation::Unanswered, Observation::Value(vec![1]), Judgement::Wrong),
    ] {
        assert_eq!(situation.judge(&answer), judgement, "{situation:?} {answer:?}");
    }
    assert_eq!(Situation::Unanswered.allowed(), [Observation::Silence]);
    assert_eq!(Situation::Confirmed.allowed(), [Observation::Confirmation]);
    assert_eq!(Situation::RepeatedToggle.allowed(), [abort(AbortCode::TOGGLE), Observation::Silence]);
    assert_eq!(Situation::StoreUnsupported.allowed(), [Observation::named("any abort")]);
    for situation in Situation::ALL {
        assert_eq!(Situation::by_id(situation.id()), Some(*situation));
        assert!(!situation.requirement().is_empty() && situation.requirement() == situation.requirement().trim());
    }
    assert_eq!(Situation::by_id("read"), None);
}

#[test]
fn a_deviation_explains_its_case_its_object_and_its_behaviour() {
    let deviation = Deviation {
        cases: vec!["301/sdo/*".to_owned()],
        subject: Some("1000".parse().unwrap()),
        situation: None,
        does: "silence".parse().unwrap(),
        documented: String::new(),
        by: Authority::Manual,
    };
    let of = |index| Breach::new(Multiplexer::new(index, 0), "x").found(Observation::Silence);
    assert!(deviation.explains("301/sdo/a", &of(0x1000)));
    assert!(!deviation.explains("301/nmt/a", &of(0x1000)), "another case");
    assert!(!deviation.explains("301/sdo/a", &of(0x1001)), "another object");
    assert!(!deviation.explains("301/sdo/a", &of(0x1000).found(Observation::Confirmation)), "another behaviour");
}

#[test]
fn a_run_in_numbers() {
    let mut summary = Summary::default();
    assert!(summary.is_good() && summary.total() == 0 && summary.executed() == 0);
    for (kind, times) in Kind::ALL.into_iter().zip([7, 1, 2, 0, 0, 3, 0]) {
        (0..times).for_each(|_| summary.add(kind));
        assert_eq!(summary.count(kind), times);
    }
    assert!(summary.is_good());
    assert_eq!((summary.total(), summary.executed()), (13, 10));
    for kind in [Kind::Fail, Kind::Error, Kind::Inconclusive] {
        let mut summary = summary;
        summary.add(kind);
        assert!(!summary.is_good(), "{kind}");
        summary.quarantined = 1;
        assert!(summary.is_good(), "{kind} in quarantine");
        summary.add(kind);
        assert!(!summary.is_good(), "{kind} twice, once in quarantine");
    }
    summary.add(Kind::Fail);
    assert_eq!((summary.total(), summary.executed()), (14, 11));
    summary.add(Kind::Error);
    assert_eq!((summary.total(), summary.executed()), (15, 11));
}

#[test]
fn a_device_is_as_found_when_no_setting_and_no_constant_differs() {
    let change = |nature| Change {
        multiplexer: Multiplexer::new(0x1017, 0),
        name: None,
        data_type: None,
        nature,
        before: Some(vec![0]),
        after: Some(vec![1]),
    };
    let compared = |is_complete, natures: &[Nature]| {
        let changes = natures.iter().copied().map(change).collect();
        let comparison = Comparison { is_complete, changes, ..Comparison::default() };
        (comparison.is_as_found(), comparison.left().count(), comparison.own().count())
    };
    assert_eq!(compared(true, &[]), (true, 0, 0));
    assert_eq!(compared(false, &[]), (false, 0, 0));
    assert_eq!(compared(true, &[Nature::Own]), (true, 0, 1));
    assert_eq!(compared(true, &[Nature::Setting, Nature::Own]), (false, 1, 1));
    assert_eq!(compared(true, &[Nature::Acting, Nature::Own]), (true, 0, 1));
    assert_eq!(compared(true, &[Nature::Constant, Nature::Setting]), (false, 2, 0));
    let names = [Nature::Setting, Nature::Constant, Nature::Own, Nature::Acting].map(Nature::name);
    assert_eq!(names, ["setting", "constant", "own", "acting"]);
}
