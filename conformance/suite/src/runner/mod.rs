//! Runs cases one after the other and says what happens: every report is made from its events.

mod blame;
mod event;
#[cfg(test)]
mod left_behind;
mod nonsense;
mod one_case;
mod repetition;
mod summary;

pub use event::{CaseReport, DeviceIdentity, RunEvent, RunInfo};
pub use one_case::run_case;
pub use summary::{HostTiming, Summary};

use crate::bench::{Bench, objects};
use crate::case::Case;
use crate::catalogue;
use crate::comparison::Comparison;
use crate::journal::Interrupted;
use crate::verdict::{End, Kind, Lack, Stop};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::Duration;
use nonsense::Nonsense;
use repetition::run_repeatedly;

/// Why a run says nothing about the device.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum RunError {
    /// No case was executed: a test that tests nothing is no success.
    #[error("no case was executed: {reason}")]
    NothingToRun {
        /// Why not.
        reason: String,
    },
    /// The device does not answer.
    #[error("node {node} does not answer: expected an SDO response or a boot-up message within {waited}")]
    Unreachable {
        /// The node-ID that was asked.
        node: NodeId,
        /// How long.
        waited: Duration,
    },
    /// What is changed could not be written down beforehand.
    #[error("the journal of the run can't be written: {0}")]
    Journal(String),
    /// The bus failed before the first case.
    #[error("{0}")]
    Bus(String),
}

/// Everything that a run needs beside its bench.
#[derive(Debug)]
pub struct Plan<'a> {
    /// The cases, in the order in which they run: see [`crate::catalogue::select`].
    pub cases: &'a [&'static Case],
    /// The bus, as the user addressed it.
    pub bus: &'a str,
    /// The bit rate in bit/s, where it is known.
    pub bit_rate: Option<u32>,
    /// The seed of everything random in the run.
    pub seed: u64,
}

/// Runs the cases of a plan. `report` gets every event.
///
/// # Errors
/// [`RunError`] if nothing was learned about the device. Where cases had been selected and the device was reached,
/// the events are complete all the same.
pub fn run(bench: &mut Bench<'_>, plan: &Plan<'_>, report: &mut dyn FnMut(&RunEvent<'_>)) -> Result<Summary, RunError> {
    if plan.cases.is_empty() {
        return Err(RunError::NothingToRun { reason: "none was selected".to_owned() });
    }
    let started = bench.now();
    let asks = plan.cases.iter().any(|case| case.asks_the_device());
    let was_operational = asks && reach_device(bench)?;
    let info = RunInfo {
        bus: plan.bus.to_owned(),
        bit_rate: plan.bit_rate,
        node: bench.node(),
        model: bench.target().model.clone(),
        device: if asks { identify(bench) } else { DeviceIdentity::default() },
        seed: plan.seed,
        cases: plan.cases.len(),
        dictionary: if asks { bench.dump() } else { Vec::new() },
    };
    bench
        .begin_journal(plan.bus, was_operational, &info.dictionary)
        .map_err(|error| RunError::Journal(error.to_string()))?;
    report(&RunEvent::RunStarted(&info));
    let mut summary = Summary::default();
    let (undescribed, ended_by) = run_cases(bench, plan, &mut summary, report);
    summary.cancelled = bench.is_cancelled() || ended_by.is_some();
    if let Some(why) = ended_by {
        let (run, of) = (summary.total(), plan.cases.len());
        report(&RunEvent::Noticed(&format!("the run ended after {run} of {of} cases: {why}")));
    }
    // Where no case has run, nothing was changed, and the dictionary may not have been read to its end: a reset would lose
    // values that nobody knows.
    summary.is_as_found = !asks;
    if asks && summary.total() > 0 {
        bench.leave(was_operational);
        let comparison = bench.put_back_dictionary(plan.bus, &info.dictionary);
        summary.is_as_found = comparison.is_as_found();
        report(&RunEvent::DictionaryCompared(&comparison));
        let notice = bench.end_journal(comparison.is_as_found());
        notice.iter().for_each(|notice| report(&RunEvent::Noticed(notice)));
    }
    bench.end_journal(true);
    if let Some(notice) = bench.fd_notice() {
        report(&RunEvent::Noticed(&notice));
    }
    if undescribed > 0 {
        report(&RunEvent::Noticed(&without_description(undescribed, info.dictionary.len())));
    }
    summary.stores = bench.stores();
    summary.duration = bench.now().since(started);
    summary.host = bench.is_live().then(|| HostTiming::of(&bench.health()));
    report(&RunEvent::RunFinished(&summary));
    if summary.executed() == 0 {
        let reason = format!("of {} cases none could be judged", summary.total());
        return Err(RunError::NothingToRun { reason });
    }
    Ok(summary)
}

/// Runs one case after the other; gives how many could not be judged as nobody has described the device, and why the run
/// ended before its last case, if it did.
fn run_cases(
    bench: &mut Bench<'_>,
    plan: &Plan<'_>,
    summary: &mut Summary,
    report: &mut dyn FnMut(&RunEvent<'_>),
) -> (usize, Option<&'static str>) {
    let (mut undescribed, mut nonsense) = (0, Nonsense::default());
    for (at, &case) in plan.cases.iter().enumerate() {
        if bench.is_cancelled() {
            break;
        }
        report(&RunEvent::CaseStarted { case, number: at + 1, of: plan.cases.len() });
        let began = bench.now();
        let mut finished = run_repeatedly(bench, case);
        let makes_no_sense = nonsense.judge(bench, began, &mut finished);
        let kind = finished.verdict.kind();
        let mut quarantines = bench.target().quarantines.iter();
        finished.quarantine = quarantines.find(|quarantine| quarantine.holds(case.id, kind)).cloned();
        summary.add(kind);
        summary.quarantined += usize::from(finished.quarantine.is_some());
        summary.flaky += usize::from(finished.is_flaky());
        undescribed += usize::from(lacks_description(bench, &finished));
        report(&RunEvent::CaseFinished(&finished));
        if makes_no_sense {
            return (undescribed, Some("the device does not follow the protocol"));
        }
        let counts = kind.badness() >= Kind::Error.badness() && finished.quarantine.is_none();
        if bench.options().fail_fast && counts {
            return (undescribed, Some("a case failed (--fail-fast)"));
        }
    }
    let late = bench.is_out_of_time().then_some("its time was over (--for says how long it may take)");
    (undescribed, late)
}

/// Puts back what an interrupted run has left behind, and says what is not as it was.
///
/// # Errors
/// [`RunError::Unreachable`] if the device does not answer.
pub fn put_back(bench: &mut Bench<'_>, run: &Interrupted) -> Result<Comparison, RunError> {
    if !run.begun {
        return Ok(Comparison { is_complete: true, objects: run.values.len(), ..Comparison::default() });
    }
    let unreachable = RunError::Unreachable { node: bench.node(), waited: bench.timing().boot_up };
    let case = run.case.as_deref().and_then(catalogue::find);
    let rescue = case.and_then(|case| case.needs.iter().find_map(|need| need.rescue()));
    bench.put_back(run, rescue).ok_or(unreachable)
}

/// Whether a case could not be judged because nobody has described the device.
fn lacks_description(bench: &Bench<'_>, report: &CaseReport) -> bool {
    let Some(End::NotApplicable(reason)) = report.verdict.end() else { return false };
    let lacks = reason.lack == Lack::Description || report.case.requires(&crate::needs::DESCRIPTION);
    lacks && bench.target().description.is_none()
}

fn without_description(cases: usize, found: usize) -> String {
    let plural = if cases == 1 { "" } else { "s" };
    format!(
        "no description of the device was given: its communication objects were looked for, {found} values were found, \
         and {cases} case{plural} could not be judged; --device MODEL or --device FILE.eds describes it"
    )
}

/// Sees that the device is there; says whether it was operational.
fn reach_device(bench: &mut Bench<'_>) -> Result<bool, RunError> {
    let bus = |stop: Stop| RunError::Bus(stop.reason().actual);
    bench.begin();
    let was_operational = bench.is_operational().map_err(bus)?;
    if bench.answers().map_err(bus)? {
        return Ok(was_operational);
    }
    // Stopped, or with a server that does not work: a reset shows whether anyone is there.
    match bench.reset(Command::RESET_NODE) {
        Ok(()) => Ok(was_operational),
        Err(stop @ Stop::Error(_)) => Err(bus(stop)),
        Err(_) => Err(RunError::Unreachable { node: bench.node(), waited: bench.timing().boot_up }),
    }
}

fn identify(bench: &mut Bench<'_>) -> DeviceIdentity {
    let mut number = |index, sub| bench.read_number(Multiplexer::new(index, sub)).ok();
    let device_type = number(object::DEVICE_TYPE, 0);
    let identity = [1, 2, 3, 4].map(|sub| number(object::IDENTITY, sub));
    let names = objects::NAMES.map(|name| {
        let value = bench.read(name).ok()?;
        Some(String::from_utf8_lossy(&value).into_owned())
    });
    DeviceIdentity { device_type, identity, names }
}

#[cfg(test)]
mod tests {
    use super::one_case::rule;
    use super::*;
    use crate::clause::{Clause, Confidence, Level};
    use crate::scripted::{table, with_bench};
    use crate::touch::Touch;
    use crate::verdict::Deviation;
    use crate::verdict::{Authority, Breach, Judged};
    use canvass_bus::observation::{Observation, Subject};

    /// A device that answers only when its device type is read or it is reset.
    const ROWS: &[(&str, &str)] = &[("63F#4000100000000000", "5BF#4300100096010200"), ("000#813F", "73F#00")];

    pub(super) const fn test_case(id: &'static str, run: fn(&mut Bench<'_>) -> Judged) -> Case {
        let clause = Clause { standard: "CiA 301", section: None, confidence: Confidence::Unknown };
        let (needs, touches, catches) = (&[], &[], &[]);
        let answers = &[];
        Case {
            id,
            requirement: "A test.",
            clause,
            level: Level::Must,
            needs,
            touches,
            catches,
            answers,
            cct: None,
            run,
        }
    }

    static PASSES: Case = test_case("test/passes", |_| Ok(()));
    static PANICS: Case = test_case("test/panics", |_| panic!("out of luck"));
    static TOUCHES: Case = Case { touches: &[Touch::Nvm], ..test_case("test/touches", |_| Ok(())) };
    static RESETS: Case = test_case("test/resets", |bench| {
        // After the start that the bench commanded is over.
        bench.listen(Duration::from_secs(1))?;
        // The script takes the raw frame for a command; the bench did not give it.
        let node = bench.node().raw();
        bench.send_bytes(0, &[0x81, node])?;
        bench.wait_for_boot_up()?;
        Ok(())
    });

    fn run_cases(rows: &'static [(&str, &str)], cases: &[&'static Case]) -> (Result<Summary, RunError>, Vec<String>) {
        let mut events = Vec::new();
        let result = with_bench(table(rows), |bench| {
            let plan = Plan { cases, bus: "sim:test", bit_rate: None, seed: 0 };
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
        assert_eq!(events[1], "test/touches: not applicable not allowed: it writes non-volatile memory (--allow nvm)");
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

    #[test]
    fn a_documented_breach_is_a_deviation_and_hides_no_other() {
        let silent = Breach::new(Subject::Device, "it works").found(Observation::Silence);
        let deviations = [Deviation {
            case: "test/*".to_owned(),
            subject: Subject::Device,
            does: "silence".parse().unwrap(),
            documented: "manual, 5.1".to_owned(),
            by: Authority::Manual,
        }];
        let kind = |breach: &Breach| rule(breach.clone(), &PASSES, &deviations).kind();
        assert_eq!(kind(&silent), Kind::Deviation);
        assert_eq!(kind(&silent.clone().found(Observation::Confirmation)), Kind::Fail, "it does something else");
        let elsewhere = Breach { subject: Multiplexer::new(object::DEVICE_TYPE, 0).into(), ..silent.clone() };
        assert_eq!(kind(&elsewhere), Kind::Fail, "another object does it");
        let other_case = test_case("other/case", |_| Ok(()));
        assert_eq!(rule(silent, &other_case, &deviations).kind(), Kind::Fail);
    }

    static GIVES_UP: Case = test_case("test/gives-up", |bench| {
        (RESETS.run)(bench)?;
        Err(Stop::Inconclusive(crate::verdict::Reason::new("it is reached", "yes", "no")))
    });
    static BREAKS: Case = test_case("test/breaks", |bench| {
        (RESETS.run)(bench)?;
        Err(Stop::from(Box::new(Breach::new(Subject::Device, "it works").found(Observation::Silence))))
    });

    /// A restart is told where nothing else is: what broke or was not reached may be why.
    #[test]
    fn a_restart_is_no_second_failure() {
        let (_, events) = run_cases(ROWS, &[&GIVES_UP, &BREAKS]);
        assert_eq!(events[1..], ["test/gives-up: inconclusive no", "test/breaks: fail no answer"]);
    }

    #[test]
    fn a_run_ends_at_the_first_failure_where_it_shall() {
        let total = |fail_fast, cases: &[&'static Case]| {
            let options = crate::bench::Options { fail_fast, ..Default::default() };
            let plan = Plan { cases, bus: "sim:test", bit_rate: None, seed: 0 };
            let summary = crate::scripted::with_options(table(ROWS), &options, |bench| run(bench, &plan, &mut |_| {}));
            summary.map(|summary| (summary.total(), summary.cancelled))
        };
        assert_eq!(total(false, &[&PASSES, &BREAKS, &PASSES]), Ok((3, false)));
        assert_eq!(total(true, &[&PASSES, &BREAKS, &PASSES]), Ok((2, true)));
        assert_eq!(total(true, &[&PASSES, &PANICS, &PASSES]), Ok((2, true)));
        assert_eq!(total(true, &[&PASSES, &GIVES_UP, &TOUCHES]), Ok((3, false)), "nothing has failed");
    }

    #[test]
    fn a_device_is_known_by_its_identity() {
        let row = |index, sub, value: &[u8]| ((index, sub), value.to_vec(), false);
        let rows = vec![
            row(0x1000, 0, &[0x96, 1, 2, 0]),
            row(0x1008, 0, b"CANV"),
            row(0x100A, 0, b"1.0"),
            row(0x1018, 1, &[0x13, 0, 0, 0]),
            row(0x1018, 2, &[2, 0, 0, 0]),
            row(0x1018, 4, &[4, 0, 0, 0]),
        ];
        let found = with_bench(crate::scripted::dictionary(rows), identify);
        assert_eq!((found.device_type, found.identity), (Some(0x0002_0196), [Some(0x13), Some(2), None, Some(4)]));
        assert_eq!(found.names, [Some("CANV".to_owned()), None, Some("1.0".to_owned())]);
    }
}
