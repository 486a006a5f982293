//! Runs cases one after the other and reports events, from which every report is made.

mod event;
mod nonsense;
mod repetition;
mod summary;

pub use crate::trial::{CaseReport, run_case};
pub use event::{DeviceIdentity, RunEvent, RunInfo};
pub(crate) use repetition::run_undisturbed;
pub use summary::{EndedEarly, HostTiming, Summary};

use crate::bench::{Bench, Harm, baseline, dictionary, interrupted, objects};
use crate::case::Case;
use crate::catalogue;
use crate::comparison::Comparison;
use crate::foreign::{ForeignKind, ForeignMessages, told};
use crate::journal::Interrupted;
use crate::touch::Touch;
use crate::verdict::{End, Kind, Lack, Stop};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::Duration;
use nonsense::Nonsense;
use repetition::run_repeatedly;

/// The reason why a run says nothing about the device.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum RunError {
    /// No case was executed: an empty test is no success.
    #[error("no case was executed: {reason}")]
    NothingToRun {
        /// The reason why none was executed.
        reason: String,
    },
    /// The device does not answer.
    #[error("node {node} does not answer: expected an SDO response or a boot-up message within {waited}")]
    Unreachable {
        /// The node-ID that was asked.
        node: NodeId,
        /// The time that the tester waited for an answer.
        waited: Duration,
    },
    /// The first reset would lose a value that no case puts back.
    #[error("node {node} is not tested, and the tester only read from it: {harm}")]
    WouldHarm {
        /// The node-ID.
        node: NodeId,
        /// The value that would be lost.
        harm: Harm,
    },
    /// Others use the device, and the user has not allowed testing it meanwhile.
    #[error("other clients use node {node}, and the cases would reset it and change its settings: {}", told(.messages))]
    OtherClients {
        /// The node-ID.
        node: NodeId,
        /// The messages of the others.
        messages: Vec<ForeignMessages>,
    },
    /// The journal could not be written. Without a journal the tester may change nothing.
    #[error("the journal of the run can't be written: {0}")]
    Journal(String),
    /// The bus failed before the first case.
    #[error("{0}")]
    Bus(String),
}

/// The case that judges a server which keeps transfers open.
const OPEN_TRANSFERS: &str = "301/boot-up/open-transfers";

/// The parameters of a run, besides its bench.
#[derive(Debug)]
pub struct Plan<'a> {
    /// The cases in the order in which they run: see [`crate::catalogue::select`].
    pub cases: &'a [&'static Case],
    /// The bus, as the user addressed it.
    pub bus: &'a str,
    /// The bit rate in bit/s, if it is known.
    pub bit_rate: Option<u32>,
    /// The seed of everything random in the run.
    pub seed: u64,
    /// The seed of the order of the cases; `None` if they have their usual order.
    pub shuffle: Option<u64>,
}

/// Runs the cases of a plan. `report` gets every event.
///
/// # Errors
/// [`RunError`] if nothing was learned about the device. If cases were selected and the device was reached, `report`
/// gets all events even then.
pub fn run(bench: &mut Bench<'_>, plan: &Plan<'_>, report: &mut dyn FnMut(&RunEvent<'_>)) -> Result<Summary, RunError> {
    if plan.cases.is_empty() {
        return Err(RunError::NothingToRun { reason: "none was selected".to_owned() });
    }
    let started = bench.now();
    let asks = plan.cases.iter().any(|case| case.asks_the_device());
    let was_operational = asks && reach_device(bench)?;
    let dictionary = if asks { dictionary::dump(bench) } else { Vec::new() };
    if asks {
        bench.traffic.clients.learn_addresses(&dictionary);
        is_left_alone(bench, |_| true)?;
    }
    let info = RunInfo {
        bus: plan.bus.to_owned(),
        bit_rate: plan.bit_rate,
        node: bench.node(),
        model: bench.target().model.clone(),
        device: if asks { identify(bench) } else { DeviceIdentity::default() },
        seed: plan.seed,
        shuffle: plan.shuffle,
        cases: plan.cases.len(),
        dictionary,
    };
    if asks {
        let starts = plan.cases.iter().any(|case| case.may_start_the_device());
        baseline::note_zero_point(bench, was_operational || starts);
        if let Some(harm) = baseline::harm_of_a_reset(bench, &info.dictionary) {
            return Err(RunError::WouldHarm { node: bench.node(), harm });
        }
    }
    interrupted::begin_journal(bench, plan.bus, was_operational, &info.dictionary)
        .map_err(|error| RunError::Journal(error.to_string()))?;
    report(&RunEvent::RunStarted(&info));
    // If the dictionary was not read completely, a reset would lose unknown values.
    let has_restarted = asks && !bench.is_cancelled() && has_learned_memory(bench, &info)?;
    let mut summary = Summary::default();
    let (undescribed, ended_by) = run_cases(bench, plan, &mut summary, report);
    summary.cancelled = bench.is_cancelled() || ended_by.is_some();
    (summary.undescribed, summary.ended_early) = (undescribed, ended_by);
    if let Some(why) = ended_by {
        let (run, of) = (summary.total(), plan.cases.len());
        report(&RunEvent::Noticed(&format!("the run ended after {run} of {of} cases: {why}")));
    }
    // Without a restart and without a case, nothing was changed.
    summary.is_as_found = !asks;
    if has_restarted || asks && summary.total() > 0 {
        let comparison = baseline::put_back_device(bench, plan.bus, was_operational, &info.dictionary);
        summary.is_as_found = comparison.is_as_found();
        report(&RunEvent::DictionaryCompared(&comparison));
        let notice = bench.changes.end_journal(comparison.is_as_found());
        notice.iter().for_each(|notice| report(&RunEvent::Noticed(notice)));
    }
    bench.changes.end_journal(true);
    if let Some(notice) = bench.traffic.fd_notice() {
        report(&RunEvent::Noticed(&notice));
    }
    if let Some(kept) = bench.kept_open() {
        report(&RunEvent::Noticed(&format!("{kept}: {OPEN_TRANSFERS} judges that")));
    }
    if undescribed > 0 {
        report(&RunEvent::Noticed(&without_description(undescribed, info.dictionary.len())));
    }
    let others = bench.traffic.clients.messages_of_run();
    if !others.is_empty() {
        report(&RunEvent::OtherClients(&others));
        report(&RunEvent::Noticed(&format!("other clients used the device during the run: {}", told(&others))));
    }
    summary.stores = bench.stores();
    summary.duration = bench.now().since(started);
    summary.host = bench.is_live().then(|| HostTiming::of(&bench.health(), bench.now()));
    report(&RunEvent::RunFinished(&summary));
    if summary.executed() == 0 {
        let reason = format!("none of {} cases could be judged", summary.total());
        return Err(RunError::NothingToRun { reason });
    }
    Ok(summary)
}

/// Restarts the device and reads the values that the start loads. Returns whether the device was restarted.
fn has_learned_memory(bench: &mut Bench<'_>, info: &RunInfo) -> Result<bool, RunError> {
    match baseline::learn_memory(bench, &info.dictionary) {
        Err(Stop::Error(reason)) => Err(RunError::Bus(reason.actual)),
        // If the device does not start, or the user cancels, the cases report it.
        _ => Ok(true),
    }
}

/// Runs one case after the other. Returns the number of cases that could not be judged without a description of the
/// device, and the reason if the run ended before its last case.
fn run_cases(
    bench: &mut Bench<'_>,
    plan: &Plan<'_>,
    summary: &mut Summary,
    report: &mut dyn FnMut(&RunEvent<'_>),
) -> (usize, Option<EndedEarly>) {
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
            return (undescribed, Some(EndedEarly::NoProtocol));
        }
        let counts = kind.badness() >= Kind::Error.badness() && finished.quarantine.is_none();
        if bench.options().fail_fast && counts {
            return (undescribed, Some(EndedEarly::FirstFailure));
        }
    }
    let late = bench.traffic.is_out_of_time().then_some(EndedEarly::TimeIsOver);
    (undescribed, late)
}

/// Puts back the changes of an interrupted run, and returns the remaining differences.
///
/// # Errors
/// [`RunError::Unreachable`] if the device does not answer.
pub fn put_back(bench: &mut Bench<'_>, run: &Interrupted) -> Result<Comparison, RunError> {
    if !run.begun {
        return Ok(Comparison { is_complete: true, objects: run.values.len(), ..Comparison::default() });
    }
    let unreachable = RunError::Unreachable { node: bench.node(), waited: bench.timing().boot_up };
    let case = run.case.as_deref().and_then(catalogue::find);
    if case.is_some_and(|case| case.touches.contains(&Touch::BitRate)) {
        bench.traffic.watch.assume_configured_bit_rate();
    }
    if case.is_some_and(|case| case.touches.contains(&Touch::FactoryDefaults)) {
        bench.traffic.watch.assume_loaded();
    }
    let rescue = case.and_then(|case| case.needs.iter().find_map(|need| need.rescue()));
    let mut comparison = interrupted::put_back(bench, run, rescue).ok_or(unreachable)?;
    if case.is_some_and(|case| case.touches.contains(&Touch::Preset)) {
        comparison.changes.extend(interrupted::unseen_presets(bench, run));
    }
    Ok(comparison)
}

/// Whether a case could not be judged because the device has no description.
fn lacks_description(bench: &Bench<'_>, report: &CaseReport) -> bool {
    let Some(End::NotApplicable(reason)) = report.verdict.end() else { return false };
    let lacks = reason.lack == Lack::Description || report.case.requires(&crate::needs::DESCRIPTION);
    lacks && bench.target().description.is_none()
}

fn without_description(cases: usize, found: usize) -> String {
    let plural = if cases == 1 { "" } else { "s" };
    format!(
        "no description of the device was given: its communication objects were looked for, {found} values were found, \
         and {cases} case{plural} could not be judged"
    )
}

/// Checks that the device is present; returns whether it was operational.
fn reach_device(bench: &mut Bench<'_>) -> Result<bool, RunError> {
    let bus = |stop: Stop| RunError::Bus(stop.reason().actual);
    bench.begin();
    let was_operational = bench.is_operational().map_err(bus)?;
    // These messages concern every device, whatever its dictionary holds.
    is_left_alone(bench, ForeignKind::concerns_all)?;
    if bench.answers().map_err(bus)? {
        return Ok(was_operational);
    }
    is_left_alone(bench, |_| true)?;
    // The device is stopped or its server is broken: a reset shows whether a device is present.
    match bench.reset(Command::RESET_NODE) {
        Ok(()) => Ok(was_operational),
        Err(stop @ Stop::Error(_)) => Err(bus(stop)),
        Err(_) => Err(RunError::Unreachable { node: bench.node(), waited: bench.timing().boot_up }),
    }
}

/// Fails if others use the device: a test would reset it. The user can allow it.
fn is_left_alone(bench: &Bench<'_>, counts: impl Fn(ForeignKind) -> bool) -> Result<(), RunError> {
    let mut messages = bench.traffic.clients.messages_of_run();
    messages.retain(|sent| counts(sent.kind));
    if messages.is_empty() || bench.options().allow.contains(&Touch::OtherClients) {
        return Ok(());
    }
    Err(RunError::OtherClients { node: bench.node(), messages })
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
