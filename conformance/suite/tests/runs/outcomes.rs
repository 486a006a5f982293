//! Runs on devices of a few lines: the verdicts of the cases and their reports.

use crate::scripted::{dictionary, frame, table, test_case, with_bench, with_options};
use canvass_bus::observation::{Observation, Subject};
use canvass_suite::bench::Options;
use canvass_suite::case::Case;
use canvass_suite::runner::{Plan, RunError, RunEvent, Summary, run, run_case};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::{Breach, Kind, Reason, Stop};
use canvass_traces::{Duration, Frame};

/// A device that answers only reads of its device type, and starts when it is reset.
const ROWS: &[(&str, &str)] = &[("63F#4000100000000000", "5BF#4300100096010200"), ("000#813F", "73F#00")];

static PASSES: Case = test_case("test/passes", |_| Ok(()));
static PANICS: Case = test_case("test/panics", |_| panic!("out of luck"));
static TOUCHES: Case = Case { touches: &[Touch::Nvm], ..test_case("test/touches", |_| Ok(())) };
static RESETS: Case = test_case("test/resets", |bench| {
    // The start that the bench commanded is over after this time.
    bench.listen(Duration::from_secs(1))?;
    // The script obeys the raw frame, but the bench does not know it as its command.
    let node = bench.node().raw();
    bench.send_bytes(0, &[0x81, node])?;
    bench.wait_for_boot_up()?;
    Ok(())
});

fn run_cases(rows: &'static [(&str, &str)], cases: &[&'static Case]) -> (Result<Summary, RunError>, Vec<String>) {
    let mut events = Vec::new();
    let result = with_bench(table(rows), |bench| {
        let plan = Plan { cases, bus: "sim:test", bit_rate: None, seed: 0, shuffle: None };
        run(bench, &plan, &mut |event| match event {
            RunEvent::RunStarted(info) => events.push(format!("{:?}", info.device.device_type)),
            RunEvent::CaseFinished(report) => {
                let reason = report.verdict.reason().map(|reason| reason.actual).unwrap_or_default();
                events.push(format!("{}: {} {reason}", report.case.id, report.verdict.kind()));
            }
            _ => {}
        })
    });
    (result, events)
}

#[test]
fn a_panic_is_an_error_and_the_run_goes_on() {
    let (summary, events) = run_cases(ROWS, &[&PANICS, &PASSES]);
    assert_eq!(events, ["Some(131478)", "test/panics: error out of luck", "test/passes: pass "]);
    let summary = summary.unwrap();
    assert_eq!((summary.count(Kind::Error), summary.count(Kind::Pass), summary.is_good()), (1, 1, false));
}

#[test]
fn what_was_not_allowed_is_not_done_and_nothing_executed_is_an_error() {
    let (result, events) = run_cases(ROWS, &[&TOUCHES]);
    assert_eq!(events[1], "test/touches: not applicable not allowed: it writes non-volatile memory");
    assert!(matches!(result, Err(RunError::NothingToRun { .. })));
    assert!(matches!(run_cases(ROWS, &[]).0, Err(RunError::NothingToRun { .. })));
}

#[test]
fn a_restart_fails_a_case_that_passed() {
    let (_, events) = run_cases(ROWS, &[&RESETS]);
    assert!(events[1].starts_with("test/resets: fail a boot-up message"), "{events:?}");
}

#[test]
fn a_device_that_is_not_there_is_no_failure_of_a_device() {
    let (result, events) = run_cases(&[], &[&PASSES]);
    assert!(matches!(result, Err(RunError::Unreachable { .. })) && events.is_empty());
}

static UNREACHED: Case =
    test_case("test/unreached", |_| Err(Stop::Inconclusive(Reason::new("it is reached", "yes", "no"))));
static GIVES_UP: Case = test_case("test/gives-up", |bench| {
    (RESETS.run)(bench)?;
    (UNREACHED.run)(bench)
});
static BREAKS: Case = test_case("test/breaks", |bench| {
    (RESETS.run)(bench)?;
    Err(Stop::from(Box::new(Breach::new(Subject::Device, "it works").found(Observation::Silence))))
});

static BREAKS_FIRST: Case = test_case("test/breaks-first", |bench| {
    bench.listen(Duration::from_secs(1))?;
    bench.check(Err(Box::new(Breach::new(Subject::Device, "it works").found(Observation::Silence))))?;
    (BREAKS.run)(bench)
});

/// Findings after a restart are consequences of the restart; earlier findings are not.
#[test]
fn a_restart_is_named_before_what_it_leaves() {
    let (_, events) = run_cases(ROWS, &[&GIVES_UP, &BREAKS, &BREAKS_FIRST]);
    assert!(events[1].starts_with("test/gives-up: fail a boot-up message at"), "{events:?}");
    assert!(events[2].starts_with("test/breaks: fail a boot-up message at"), "{events:?}");
    assert_eq!(events[3], "test/breaks-first: fail no answer");
}

static RESTARTS_SOON: Case = test_case("test/restarts-soon", |bench| {
    bench.send_bytes(0x7E5, &[0x13, 0, 0, 0, 0, 0, 0, 0])?;
    bench.listen(Duration::from_millis(100))?;
    Err(Stop::from(Box::new(Breach::new(Subject::Device, "it works").found(Observation::Silence))))
});

/// A boot-up message soon after that of the start proves a restart, unless the device sends two at each start.
#[test]
fn a_restart_soon_after_the_start_is_told_from_a_second_boot_up_message() {
    let found = |starts: &'static [u64]| {
        let script = move |request: &Frame| match request.to_string().as_str() {
            "000#813F" => starts.iter().map(|&ms| (Duration::from_millis(ms), frame("73F#00"))).collect(),
            "7E5#1300000000000000" if starts.len() == 1 => vec![(Duration::from_millis(20), frame("73F#00"))],
            request => table(ROWS)(&frame(request)),
        };
        let report = with_bench(script, |bench| run_case(bench, &RESTARTS_SOON));
        assert_eq!(report.verdict.breaches().len(), 3 - starts.len());
        report.verdict.reason().unwrap().actual
    };
    assert!(found(&[10]).starts_with("a boot-up message at"), "{}", found(&[10]));
    assert_eq!(found(&[10, 100]), "no answer");
}

#[test]
fn a_run_ends_at_the_first_failure_where_it_shall() {
    let total = |fail_fast, cases: &[&'static Case]| {
        let options = Options { fail_fast, ..Default::default() };
        let plan = Plan { cases, bus: "sim:test", bit_rate: None, seed: 0, shuffle: None };
        let summary = with_options(table(ROWS), &options, |bench| run(bench, &plan, &mut |_| {}));
        summary.map(|summary| (summary.total(), summary.cancelled))
    };
    assert_eq!(total(false, &[&PASSES, &BREAKS, &PASSES]), Ok((3, false)));
    assert_eq!(total(true, &[&PASSES, &BREAKS, &PASSES]), Ok((2, true)));
    assert_eq!(total(true, &[&PASSES, &PANICS, &PASSES]), Ok((2, true)));
    assert_eq!(total(true, &[&PASSES, &UNREACHED, &TOUCHES]), Ok((3, false)), "nothing has failed");
}

#[test]
fn a_device_is_known_by_its_identity() {
    let row = |index, sub, value: &[u8]| ((index, sub), value.to_vec(), false);
    let rows = vec![
        row(0x1000, 0, &[0x96, 1, 2, 0]),
        row(0x1008, 0, b"CANV"),
        row(0x100A, 0, b"1.0"),
        row(0x1018, 0, &[4]),
        row(0x1018, 1, &[0x13, 0, 0, 0]),
        row(0x1018, 3, &[3, 0, 0, 0]),
        row(0x1018, 4, &[5, 0, 0, 0]),
    ];
    let mut device = None;
    let _ = with_bench(dictionary(rows), |bench| {
        let plan = Plan { cases: &[&PASSES], bus: "sim:test", bit_rate: None, seed: 0, shuffle: None };
        run(bench, &plan, &mut |event| {
            if let RunEvent::RunStarted(info) = event {
                device = Some(info.device.clone());
            }
        })
    });
    let found = device.unwrap();
    assert_eq!((found.device_type, found.identity), (Some(0x0002_0196), [Some(0x13), None, Some(3), Some(5)]));
    assert_eq!(found.names, [Some("CANV".to_owned()), None, Some("1.0".to_owned())]);
}
