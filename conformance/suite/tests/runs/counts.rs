//! The counts of a run, its events, and their order.

use crate::scripted::{
    Row, ScriptedBus, described, dictionary, frame, test_case, with_bench, with_options, with_target,
};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::observation::{Observation, Subject};
use canvass_bus::{Bus, BusError, Health};
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::case::Case;
use canvass_suite::clause::Level;
use canvass_suite::journal::Interrupted;
use canvass_suite::needs;
use canvass_suite::quarantine::Quarantine;
use canvass_suite::runner::{HostTiming, Plan, RunError, RunEvent, Summary, put_back, run, run_case};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::{Breach, Kind, Lack, Reason, Stop};
use canvass_traces::{Direction, Duration, Frame, Record, Timestamp, parse_frame};
use std::cell::Cell;
use std::rc::Rc;
use std::sync::atomic::{AtomicU32, Ordering};

const MS: fn(u64) -> Duration = Duration::from_millis;

fn breach() -> Stop {
    Stop::Breach(Box::new(Breach::new(Subject::Device, "it works").found(Observation::Confirmation)))
}

static PASSES: Case = test_case("test/passes", |_| Ok(()));
static FAILS: Case = test_case("test/fails", |_| Err(breach()));
static GIVES_UP: Case =
    test_case("test/gives-up", |_| Err(Stop::Inconclusive(Reason::new("it is reached", "yes", "no"))));
static OPEN: Case = Case { level: Level::Open, ..test_case("test/open", |_| Err(breach())) };
static STORES: Case = test_case("test/stores", |bench| {
    bench.download(Multiplexer::new(0x1010, 1), b"save")?;
    Ok(())
});
static UNDESCRIBED: Case = test_case("test/undescribed", |_| {
    let reason = Reason::new("it is described", "a description", "none").for_lack_of(Lack::Description);
    Err(Stop::NotApplicable(reason))
});
static WAITS: Case = test_case("test/waits", |bench| bench.listen(MS(3_000)).map(|_| ()));
static ASKS_NOBODY: Case = test_case("306/file/test", |_| Ok(()));

/// A device with these values and a device type, which starts when it is reset.
fn device(rows: &[Row]) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> + use<> {
    let mut rows = rows.to_vec();
    rows.push(((0x1000, 0), vec![0x96, 1, 2, 0], false));
    let mut answers = dictionary(rows);
    move |request| match request.data() {
        [0x81, 63] => vec![(MS(1), frame("73F#00"))],
        _ => answers(request),
    }
}

fn store() -> Row {
    ((0x1010, 1), vec![1, 0, 0, 0], true)
}

fn plan<'a>(cases: &'a [&'static Case]) -> Plan<'a> {
    Plan { cases, bus: "can0", bit_rate: Some(125_000), seed: 9, shuffle: None }
}

/// The result of a run, and its events, each in a few words.
fn told(bench: &mut Bench<'_>, cases: &[&'static Case]) -> (Result<Summary, RunError>, Vec<String>) {
    let mut events = Vec::new();
    let summary = run(bench, &plan(cases), &mut |event| {
        events.push(match event {
            RunEvent::RunStarted(info) => format!("started: {} cases on {}, seed {}", info.cases, info.bus, info.seed),
            RunEvent::CaseStarted { case, number, of } => format!("{number} of {of}: {}", case.id),
            RunEvent::CaseFinished(report) => report.verdict.kind().to_string(),
            RunEvent::DictionaryCompared(comparison) => format!("compared: {}", comparison.objects),
            RunEvent::OtherClients(others) => format!("others: {}", others.len()),
            RunEvent::Noticed(text) => format!("noticed: {text}"),
            RunEvent::RunFinished(summary) => format!("finished: {}", summary.total()),
        });
    });
    (summary, events)
}

#[test]
fn a_run_is_told_from_its_start_to_its_end() {
    let (summary, events) = with_bench(device(&[store()]), |bench| told(bench, &[&PASSES, &OPEN]));
    assert_eq!(
        events,
        [
            "started: 2 cases on can0, seed 9",
            "1 of 2: test/passes",
            "pass",
            "2 of 2: test/open",
            "pass",
            "compared: 1",
            "finished: 2",
        ]
    );
    let summary = summary.unwrap();
    assert!(summary.is_good() && summary.is_as_found && !summary.cancelled && summary.host.is_none());
    assert_eq!((summary.count(Kind::Pass), summary.stores, summary.flaky, summary.quarantined), (2, 0, 0, 0));
}

/// The first event reports the device, its description and its values before the first case.
#[test]
fn what_is_tested_is_told_first() {
    let rows = [
        ((0x1018, 0), vec![1], false),
        ((0x1018, 1), vec![0x13, 0, 0, 0], false),
        ((0x1008, 0), b"CANV".to_vec(), false),
    ];
    let target = Target { model: "my.eds".to_owned(), ..Target::unknown(NodeId::new(63).unwrap()) };
    let found = with_target(device(&rows), &target, &Options::default(), |bench| {
        let mut found = None;
        run(bench, &plan(&[&PASSES]), &mut |event| {
            if let RunEvent::RunStarted(info) = event {
                found = Some((*info).clone());
            }
        })
        .unwrap();
        found.unwrap()
    });
    assert_eq!((found.bit_rate, found.node.raw(), found.model.as_str()), (Some(125_000), 63, "my.eds"));
    assert_eq!((found.device.device_type, found.device.identity[0]), (Some(0x0002_0196), Some(0x13)));
    let dictionary: Vec<String> = found.dictionary.iter().map(|(at, _)| at.to_string()).collect();
    assert_eq!(dictionary, ["1000h:00", "1008h:00", "1018h:00", "1018h:01"]);
}

/// The summary counts the store commands, the duration, and the cases that lacked a description.
#[test]
fn stores_time_and_what_is_not_described_are_counted() {
    let counted = |target: &Target, cases: &[&'static Case]| {
        with_target(device(&[store()]), target, &Options::default(), |bench| {
            let begun = bench.now();
            let (summary, events) = told(bench, cases);
            let summary = summary.unwrap();
            assert_eq!(summary.duration, bench.now().since(begun));
            let notices: Vec<String> = events.into_iter().filter(|event| event.starts_with("noticed")).collect();
            (summary.stores, notices, summary.duration)
        })
    };
    let unknown = Target::unknown(NodeId::new(63).unwrap());
    let (stores, notices, took) = counted(&unknown, &[&STORES, &PASSES, &STORES]);
    assert_eq!((stores, notices), (2, Vec::new()));
    let (_, _, longer) = counted(&unknown, &[&STORES, &WAITS, &STORES]);
    assert_eq!(longer.nanos() - took.nanos(), MS(3_000).nanos());
    let (_, notices, _) = counted(&unknown, &[&UNDESCRIBED, &PASSES]);
    assert_eq!(
        notices,
        ["noticed: no description of the device was given: its communication objects were looked for, 1 values were \
             found, and 1 case could not be judged"]
    );
    let (_, notices, _) = counted(&unknown, &[&UNDESCRIBED, &PASSES, &UNDESCRIBED]);
    assert!(notices[0].contains("and 2 cases could not be judged"), "{notices:?}");
    let described = described(&[("1000", "DataType=0x0007\nAccessType=ro")]);
    let (_, notices, _) = counted(&described, &[&UNDESCRIBED, &PASSES]);
    assert_eq!(notices, Vec::<String>::new(), "another description would be needed");
}

static TURN: AtomicU32 = AtomicU32::new(0);
/// A case that passes and fails in turn.
static BY_TURNS: Case = test_case("test/by-turns", |_| {
    if TURN.fetch_add(1, Ordering::SeqCst).is_multiple_of(2) { Ok(()) } else { Err(breach()) }
});

/// A case whose repetitions end differently is flaky, and counts with its worst outcome; cases in quarantine do not
/// count.
#[test]
fn repeated_cases_and_those_in_quarantine_are_counted() {
    let options = Options { repeat: 3, ..Options::default() };
    TURN.store(0, Ordering::SeqCst);
    let (summary, _) = with_options(device(&[]), &options, |bench| told(bench, &[&BY_TURNS, &PASSES, &FAILS]));
    let summary = summary.unwrap();
    assert_eq!((summary.flaky, summary.count(Kind::Fail), summary.count(Kind::Pass)), (1, 2, 1));
    let quarantine = Quarantine {
        line: 1,
        case: "test/fails".to_owned(),
        owner: "Ann".to_owned(),
        reason: "ticket 12".to_owned(),
        until: "2027-06-30".to_owned(),
    };
    let target = Target { quarantines: vec![quarantine.clone()], ..Target::unknown(NodeId::new(63).unwrap()) };
    with_target(device(&[]), &target, &Options { fail_fast: true, ..Options::default() }, |bench| {
        let mut held = Vec::new();
        let summary = run(bench, &plan(&[&FAILS, &PASSES]), &mut |event| {
            if let RunEvent::CaseFinished(report) = event {
                held.push(report.quarantine.clone());
            }
        });
        let summary = summary.unwrap();
        assert_eq!((summary.quarantined, summary.total(), summary.is_good()), (1, 2, true), "it does not end the run");
        assert_eq!(held, [Some(quarantine), None]);
    });
}

/// A case that needs a description lacks it, even if it also has other needs.
#[test]
fn a_case_that_needs_a_description_is_counted() {
    static NEEDS_IT: Case = Case { needs: &[&needs::DESCRIPTION], ..test_case("test/needs-description", |_| Ok(())) };
    static NEEDS_MORE: Case = Case { needs: &[&needs::SYNC], ..test_case("test/needs-sync", |_| Ok(())) };
    let noticed = |case: &'static Case| {
        let (_, events) = with_bench(device(&[]), |bench| told(bench, &[case, &PASSES]));
        events.iter().any(|event| event.contains("1 case could not be judged"))
    };
    assert_eq!((noticed(&NEEDS_IT), noticed(&NEEDS_MORE)), (true, false));
}

/// If no device was asked, there is nothing to put back, and no journal is left.
#[test]
fn a_run_about_the_file_leaves_no_journal() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal");
    let options = Options { journal: Some(path.clone()), ..Options::default() };
    let (summary, events) = with_options(|_: &Frame| Vec::new(), &options, |bench| told(bench, &[&ASKS_NOBODY]));
    assert!(summary.is_ok() && !path.exists() && !events.iter().any(|event| event.contains("journal")), "{events:?}");
}

/// A run that ended early reports the number of its cases, and the reason.
#[test]
fn a_run_that_ended_early_says_so() {
    let options = Options { fail_fast: true, ..Options::default() };
    let (_, events) = with_options(device(&[]), &options, |bench| told(bench, &[&PASSES, &FAILS, &PASSES]));
    let notice = "noticed: the run ended after 2 of 3 cases: a case failed, and the run ends with the first failure";
    assert!(events.contains(&notice.to_owned()), "{events:?}");
    let options = Options { limit: Some(MS(7_000)), ..Options::default() };
    let (summary, events) = with_options(device(&[]), &options, |bench| told(bench, &[&WAITS, &WAITS, &WAITS]));
    assert!(summary.unwrap().cancelled);
    assert!(events.iter().any(|event| event.contains("its time limit was reached")), "{events:?}");
    assert!(events.iter().any(|event| event.starts_with("compared")), "it is put back all the same");
    let (summary, events) = with_bench(device(&[]), |bench| told(bench, &[&GIVES_UP, &PASSES]));
    assert!(!summary.unwrap().is_good() && !events.iter().any(|event| event.contains("the run ended")), "{events:?}");
    let none = with_bench(device(&[]), |bench| told(bench, &[&GIVES_UP]).0);
    assert_eq!(none.unwrap_err().to_string(), "no case was executed: none of 1 cases could be judged");
}

/// Cases about the file alone ask no device: none need be present, and nothing is compared.
#[test]
fn cases_about_the_description_need_no_device() {
    let (summary, events) = with_bench(
        |_: &Frame| Vec::new(),
        |bench| {
            let told = told(bench, &[&ASKS_NOBODY]);
            assert_eq!(bench.evidence().frames().count(), 0);
            told
        },
    );
    let summary = summary.unwrap();
    assert!(summary.is_as_found && summary.is_good() && summary.executed() == 1);
    assert_eq!(events, ["started: 1 cases on can0, seed 9", "1 of 1: 306/file/test", "pass", "finished: 1"]);
}

/// A device that was operational is operational again after the run; any other device is left as after power-on.
#[test]
fn a_device_that_was_operational_is_so_again() {
    let started = |state: &'static str| {
        let mut announced = false;
        let mut inner = device(&[]);
        let last: Rc<Cell<u8>> = Rc::default();
        let command = Rc::clone(&last);
        let script = move |request: &Frame| {
            if let [number, 63] = request.data() {
                command.set(*number);
            }
            let mut answers = inner(request);
            if !std::mem::replace(&mut announced, true) {
                answers.push((MS(500), frame(state)));
            }
            answers
        };
        with_bench(script, |bench| {
            // The script answers only after a frame was sent.
            bench.send_bytes(0x123, &[]).unwrap();
            told(bench, &[&PASSES]).0.unwrap();
        });
        last.get()
    };
    // The last commands: start, reset node, reset node.
    assert_eq!((started("73F#05"), started("73F#7F"), started("73E#05")), (0x01, 0x81, 0x81));
}

/// A device that does not answer may be in the NMT state stopped: a reset makes it answer again. If it does not start
/// after the reset, it is absent.
#[test]
fn a_device_that_is_stopped_is_reached_by_a_reset() {
    let reached = |starts: bool| {
        let (mut silent, mut inner) = (true, device(&[]));
        let script = move |request: &Frame| {
            silent &= !(starts && request.data() == [0x81, 63]);
            if silent { Vec::new() } else { inner(request) }
        };
        with_bench(script, |bench| told(bench, &[&PASSES]).0.map(|summary| summary.total()))
    };
    assert_eq!(reached(true), Ok(1));
    let error = reached(false).unwrap_err().to_string();
    assert_eq!(error, "node 63 does not answer: expected an SDO response or a boot-up message within 10 s");
}

/// If the bus fails before the first case, the device does not count as absent.
#[test]
fn a_bus_that_fails_is_told_as_such() {
    struct Broken(Timestamp);
    impl Bus for Broken {
        fn now(&self) -> Timestamp {
            self.0
        }
        fn send(&mut self, _: &Frame) -> Result<(), BusError> {
            Err(std::io::Error::other("unplugged").into())
        }
        fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
            self.0 = deadline;
            Ok(None)
        }
        fn bit_rate(&self) -> Option<u32> {
            None
        }
    }
    let (target, cancel) = (Target::unknown(NodeId::MIN), std::sync::atomic::AtomicBool::new(false));
    let (options, mut annotate) = (Options::default(), |_: &Record| String::new());
    let mut bus = Broken(Timestamp::ZERO);
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    assert_eq!(told(&mut bench, &[&PASSES]).0, Err(RunError::Bus("the bus failed: unplugged".to_owned())));
}

/// On a live bus the summary contains how well the tester's machine kept up.
#[test]
fn how_late_the_host_was_is_told_of_a_live_bus() {
    struct Live(ScriptedBus);
    impl Bus for Live {
        fn now(&self) -> Timestamp {
            self.0.now()
        }
        fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
            self.0.send(frame)
        }
        fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
            self.0.receive(deadline)
        }
        fn bit_rate(&self) -> Option<u32> {
            None
        }
        fn is_live(&self) -> bool {
            true
        }
        fn health(&self) -> Health {
            let interrupted_for = Duration::from_secs(4);
            let mut health = Health { lost: 3, interruptions: 2, interrupted_for, ..Health::default() };
            // The 99th percentile is the 990th of a thousand.
            for n in 1..=1_000 {
                health.receive.add(Duration(1 << [8, 10, 20][usize::from(n > 989) + usize::from(n > 990)]));
                health.transmit.add(Duration(1 << [9, 12, 22][usize::from(n > 989) + usize::from(n > 990)]));
            }
            health
        }
    }
    let (target, cancel) = (Target::unknown(NodeId::new(63).unwrap()), std::sync::atomic::AtomicBool::new(false));
    let (options, mut annotate) = (Options::default(), |_: &Record| String::new());
    let mut bus = Live(ScriptedBus::new(device(&[])));
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    let host = told(&mut bench, &[&PASSES]).0.unwrap().host.unwrap();
    let [receive_usually, receive_always, transmit_usually, transmit_always] =
        [11, 21, 13, 23].map(|bits| Duration((1 << bits) - 1));
    let right = HostTiming {
        receive_usually,
        receive_always,
        transmit_usually,
        transmit_always,
        lost: 3,
        interruptions: 2,
        interrupted_for: Duration::from_secs(4),
        stamps: None,
    };
    assert_eq!(host, right);
}

/// CAN FD frames that came are reported.
#[test]
fn can_fd_frames_are_told_of() {
    let mut inner = device(&[]);
    let script = move |request: &Frame| {
        let mut answers = inner(request);
        if request.data() == [0x81, 63] {
            answers.push((MS(2), parse_frame("123##00102").unwrap().frame));
        }
        answers
    };
    let (_, events) = with_bench(script, |bench| told(bench, &[&PASSES]));
    assert!(events.iter().any(|event| event.contains("CAN FD frames came, and none was taken")), "{events:?}");
}

/// A case whose touch the user has not allowed does not run; the verdict names the missing touch.
#[test]
fn the_leave_that_is_missing_is_named() {
    static TWO: Case = Case { touches: &[Touch::Nvm, Touch::NodeId], ..test_case("test/two", |_| Ok(())) };
    let actual = |allow: &[Touch]| {
        let options = Options { allow: allow.iter().copied().collect(), ..Options::default() };
        with_options(device(&[]), &options, |bench| {
            run_case(bench, &TWO).verdict.reason().map(|reason| reason.expected)
        })
    };
    assert_eq!(actual(&[]).as_deref(), Some("nvm"));
    assert_eq!(actual(&[Touch::Nvm]).as_deref(), Some("node-id"));
    assert_eq!(actual(&[Touch::Nvm, Touch::NodeId]), None);
}

/// An object that an earlier case left changed is not judged; another object is.
#[test]
fn what_an_earlier_case_left_is_not_blamed_on_the_device() {
    static JUDGES: Case =
        test_case("test/judges", |bench| bench.expect_value(Multiplexer::new(0x1017, 0), &[0, 0], "it is off"));
    let mut refuses = false;
    let mut inner = device(&[((0x1017, 0), vec![0, 0], true)]);
    let script = move |request: &Frame| {
        let text = request.to_string();
        refuses |= text.starts_with("63F#2B171000E8");
        match refuses && text == "63F#2B17100000000000" {
            true => vec![(MS(1), frame("5BF#8017100022000008"))],
            false => inner(request),
        }
    };
    static WRITES: Case = test_case("test/writes", |bench| bench.write(Multiplexer::new(0x1017, 0), &[0xE8, 3]));
    with_bench(script, |bench| {
        assert_eq!(run_case(bench, &JUDGES).verdict.kind(), Kind::Pass);
        let left = run_case(bench, &WRITES);
        assert_eq!(left.notes, ["1017h:00 could not be set back to 00 00"]);
        let judged = run_case(bench, &JUDGES).verdict;
        let reason = judged.reason().unwrap();
        assert_eq!((judged.kind(), reason.duty.as_str()), (Kind::Inconclusive, "1017h:00 has the device's own value"));
        assert_eq!(run_case(bench, &FAILS).verdict.kind(), Kind::Fail, "that is not about 1017h");
    });
}

/// A device that left the bus fails the case in which it left; the later cases say nothing about it.
#[test]
fn a_device_that_leaves_fails_one_case() {
    static LEAVES: Case = test_case("test/leaves", |bench| bench.send_bytes(0x123, &[1]).map(|_| ()));
    let (mut gone, mut inner) = (false, device(&[]));
    let script = move |request: &Frame| {
        gone = match request.to_string().as_str() {
            "123#01" => true,
            "124#01" => false,
            _ => gone,
        };
        if gone { Vec::new() } else { inner(request) }
    };
    with_bench(script, |bench| {
        let left = run_case(bench, &LEAVES);
        let reason = left.verdict.reason().unwrap();
        assert_eq!((left.verdict.kind(), reason.actual.as_str()), (Kind::Fail, "the device stopped answering"));
        assert_eq!(reason.expected, "an answer, or a start after a reset");
        let after = run_case(bench, &PASSES).verdict;
        assert_eq!(
            (after.kind(), after.reason().unwrap().actual.as_str()),
            (Kind::Inconclusive, "it stopped answering during test/leaves")
        );
        bench.send_bytes(0x124, &[1]).unwrap();
        assert_eq!(run_case(bench, &PASSES).verdict.kind(), Kind::Pass);
    });
}

/// A failure of a device that is simulated from its description alone is an error of the description; the reports say
/// so.
#[test]
fn a_device_that_is_simulated_from_its_description_is_named_as_such() {
    let notes = |described_alone: bool, case: &'static Case| {
        let target =
            Target { described_alone, model: "my.eds".to_owned(), ..Target::unknown(NodeId::new(63).unwrap()) };
        with_target(device(&[]), &target, &Options::default(), |bench| run_case(bench, case).notes)
    };
    assert_eq!(
        notes(true, &FAILS),
        ["the device is simulated as my.eds describes it: the fault is in that description"]
    );
    assert!(notes(false, &FAILS).is_empty() && notes(true, &PASSES).is_empty());
    static OF_THE_FILE: Case = test_case("306/file/wrong", |_| Err(breach()));
    assert!(notes(true, &OF_THE_FILE).is_empty(), "the file is not simulated");
}

/// A report of a case contains its frames, its duration, and its verdict.
#[test]
fn a_report_has_all_of_a_case() {
    with_bench(device(&[]), |bench| {
        let begun = bench.now();
        let report = run_case(bench, &WAITS);
        assert_eq!(report.duration, bench.now().since(begun));
        assert!(report.duration >= MS(3_000) && report.evidence.frames().count() > 2);
        assert_eq!((report.outcomes, report.quarantine), (vec![Kind::Pass], None));
        let restarts = bench.evidence().frames().filter(|exhibit| exhibit.record.direction == Direction::Rx);
        assert_eq!(restarts.count(), 0, "the next case begins without them");
    });
}

/// If no case had begun, nothing is put back; otherwise the tester asks the device, which must be present.
#[test]
fn an_interrupted_run_is_put_back_if_it_had_begun() {
    let read = |lines: &str| {
        Interrupted::read(&format!(
            "canvass journal 1\nbus can0\nnode 63\ndevice \noperational no\nvalue 1000:00 96010200\nvalue 1017:00 0000\n{lines}"
        ))
        .unwrap()
    };
    let unbegun = read("");
    let found = with_bench(|_: &Frame| panic!("nobody is asked"), |bench| put_back(bench, &unbegun)).unwrap();
    assert_eq!((found.is_complete, found.objects, found.changes.len()), (true, 2, 0));
    let rows = [((0x1017, 0), vec![0xE8, 3], true)];
    let found = with_bench(device(&rows), |bench| put_back(bench, &read("begun\n"))).unwrap();
    assert!(found.is_as_found());
    let gone = with_bench(|_: &Frame| Vec::new(), |bench| put_back(bench, &read("begun\n")));
    assert_eq!(gone, Err(RunError::Unreachable { node: NodeId::new(63).unwrap(), waited: MS(10_000) }));
}
