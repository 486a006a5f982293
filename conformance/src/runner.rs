//! Runs cases one after the other and says what happens: every report is made from its events.

use crate::bench::{Bench, Deviation, Evidence, Measurement, Remains, objects};
use crate::bus::Health;
use crate::case::{Case, Touch};
use crate::verdict::{Kind, Reason, Verdict};
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::Duration;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What happens in a run, in this order: one [`RunEvent::RunStarted`], for each case a [`RunEvent::CaseStarted`] and a
/// [`RunEvent::CaseFinished`], any number of [`RunEvent::Noticed`], one [`RunEvent::RunFinished`].
#[derive(Debug)]
pub enum RunEvent<'a> {
    /// The device was reached; cases follow.
    RunStarted(&'a RunInfo),
    /// A case begins.
    CaseStarted {
        /// The case.
        case: &'static Case,
        /// Its number, from 1.
        number: usize,
        /// How many cases there are.
        of: usize,
    },
    /// A case has ended.
    CaseFinished(&'a CaseReport),
    /// Something about the run as a whole that a person should know.
    Noticed(&'a str),
    /// All cases have ended, or the user has cancelled.
    RunFinished(&'a Summary),
}

/// What is tested.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RunInfo {
    /// The bus, as the user addressed it.
    pub bus: String,
    /// The bit rate in bit/s, where it is known.
    pub bit_rate: Option<u32>,
    /// The node-ID.
    pub node: NodeId,
    /// The model id or path of the description; empty if none was given.
    pub model: String,
    /// What the device says about itself.
    pub device: DeviceIdentity,
    /// The seed of everything random in the run.
    pub seed: u64,
    /// How many cases were selected.
    pub cases: usize,
    /// The object dictionary before the first case, as far as it could be read: what the bench reads.
    pub dictionary: Vec<(Multiplexer, Vec<u8>)>,
}

/// What a device says about itself. The texts come from the device: they may hold anything.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct DeviceIdentity {
    /// 1000h.
    pub device_type: Option<u32>,
    /// 1018h:01 to 04: vendor-ID, product code, revision number, serial number.
    pub identity: [Option<u32>; 4],
    /// 1008h, 1009h, 100Ah: name, hardware version, software version.
    pub names: [Option<String>; 3],
}

/// The outcome of one case.
#[derive(Clone, Debug)]
pub struct CaseReport {
    /// The case.
    pub case: &'static Case,
    /// How it ended.
    pub verdict: Verdict,
    /// The frames that were on the bus.
    pub evidence: Evidence,
    /// What else was noticed.
    pub notes: Vec<String>,
    /// What was measured, whatever the verdict.
    pub measurements: Vec<Measurement>,
    /// How each repetition ended; one where the case ran once.
    pub outcomes: Vec<Kind>,
    /// How long it took on the clock of the bus, with the way to the precondition and back.
    pub duration: Duration,
}

impl CaseReport {
    /// Whether repetitions ended differently.
    pub fn is_flaky(&self) -> bool {
        self.outcomes.windows(2).any(|pair| pair.first() != pair.last())
    }
}

/// The outcome of a run.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Summary {
    counts: [usize; 7],
    /// How long the run took on the clock of the bus.
    pub duration: Duration,
    /// The user ended the run before all cases had run.
    pub cancelled: bool,
    /// How well the tester's own machine kept up, on a live bus.
    pub host: Option<HostTiming>,
    /// How often the device was told to write its non-volatile memory: it wears out.
    pub stores: u32,
    /// How many cases ended differently when they were repeated.
    pub flaky: usize,
}

/// How well the tester's own machine kept up. Each bound is at most twice the longest span that it holds for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct HostTiming {
    /// From a frame's time on the bus to the tester's seeing it, while it waited: 99 of 100 within this.
    pub receive_usually: Duration,
    /// All within this.
    pub receive_always: Duration,
    /// From the tester's handing over a frame to its time on the bus: 99 of 100 within this.
    pub transmit_usually: Duration,
    /// All within this.
    pub transmit_always: Duration,
    /// Frames that did not reach the tester.
    pub lost: u64,
    /// How often the way to the bus was interrupted.
    pub interruptions: u64,
}

impl HostTiming {
    fn of(health: &Health) -> Self {
        let (receive, transmit) = (&health.receive, &health.transmit);
        Self {
            receive_usually: receive.quantile(990).unwrap_or_default(),
            receive_always: receive.longest().unwrap_or_default(),
            transmit_usually: transmit.quantile(990).unwrap_or_default(),
            transmit_always: transmit.longest().unwrap_or_default(),
            lost: health.lost,
            interruptions: health.interruptions,
        }
    }
}

impl Summary {
    /// How many cases ended that way.
    pub const fn count(&self, kind: Kind) -> usize {
        self.counts[kind as usize]
    }

    /// How many cases there are reports of.
    pub fn total(&self) -> usize {
        self.counts.iter().sum()
    }

    /// How many cases ran to an end.
    pub fn executed(&self) -> usize {
        Kind::ALL.into_iter().filter(|kind| kind.is_executed()).map(|kind| self.count(kind)).sum()
    }

    /// Whether all that could be judged is good: no case failed, the tester did not fail, and no precondition was out
    /// of reach. A device about which nothing could be found out must not look like a good one.
    pub const fn is_good(&self) -> bool {
        self.count(Kind::Fail) == 0 && self.count(Kind::Error) == 0 && self.count(Kind::Inconclusive) == 0
    }

    /// Counts a case.
    pub const fn add(&mut self, kind: Kind) {
        self.counts[kind as usize] += 1;
    }
}

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
    let was_operational = reach_device(bench)?;
    let info = RunInfo {
        bus: plan.bus.to_owned(),
        bit_rate: plan.bit_rate,
        node: bench.node(),
        model: bench.target().model.clone(),
        device: identify(bench),
        seed: plan.seed,
        cases: plan.cases.len(),
        dictionary: bench.dump(),
    };
    report(&RunEvent::RunStarted(&info));
    let mut summary = Summary::default();
    for (at, &case) in plan.cases.iter().enumerate() {
        if bench.is_cancelled() {
            break;
        }
        report(&RunEvent::CaseStarted { case, number: at + 1, of: plan.cases.len() });
        let finished = repeat_case(bench, case);
        summary.add(finished.verdict.kind());
        summary.flaky += usize::from(finished.is_flaky());
        report(&RunEvent::CaseFinished(&finished));
    }
    summary.cancelled = bench.is_cancelled();
    bench.leave(was_operational);
    for notice in bench.put_back_dictionary(&info.dictionary) {
        report(&RunEvent::Noticed(&notice));
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

/// Sees that the device is there; says whether it was operational.
fn reach_device(bench: &mut Bench<'_>) -> Result<bool, RunError> {
    let bus =
        |verdict: Verdict| RunError::Bus(verdict.reason().map(|reason| reason.actual.clone()).unwrap_or_default());
    bench.begin();
    let was_operational = bench.is_operational().map_err(bus)?;
    if bench.answers().map_err(bus)? {
        return Ok(was_operational);
    }
    // Stopped, or with a server that does not work: a reset shows whether anyone is there.
    match bench.reset(Command::RESET_NODE) {
        Ok(()) => Ok(was_operational),
        Err(verdict @ Verdict::Error(_)) => Err(bus(verdict)),
        Err(_) => Err(RunError::Unreachable { node: bench.node(), waited: bench.timing().boot_up }),
    }
}

fn identify(bench: &mut Bench<'_>) -> DeviceIdentity {
    let mut number = |index, sub| bench.read_number(Multiplexer::new(index, sub)).ok();
    let device_type = number(0x1000, 0);
    let identity = [1, 2, 3, 4].map(|sub| number(0x1018, sub));
    let names = objects::NAMES.map(|name| {
        let value = bench.read(name).ok()?;
        Some(String::from_utf8_lossy(&value).into_owned())
    });
    DeviceIdentity { device_type, identity, names }
}

/// Runs a case as often as the options say. The report is that of the worst outcome, the first of them.
fn repeat_case(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let started = bench.now();
    let mut worst = run_case(bench, case);
    for _ in 1..bench.options().repeat.max(1) {
        if bench.is_cancelled() {
            break;
        }
        let next = run_case(bench, case);
        let kind = next.verdict.kind();
        let outcomes = std::mem::take(&mut worst.outcomes);
        if kind.badness() > worst.verdict.kind().badness() {
            worst = next;
        }
        worst.outcomes = outcomes;
        worst.outcomes.push(kind);
    }
    worst.duration = bench.now().since(started);
    worst
}

/// Runs one case: precondition, stimulus, restoration, and what must be true after every case.
pub fn run_case(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let started = bench.now();
    let health = bench.health();
    bench.begin();
    let judged = catch_unwind(AssertUnwindSafe(|| judge(bench, case)));
    let verdict = judged.unwrap_or_else(|panic| Verdict::Error(panicked(&*panic)));
    let took = bench.now().since(started);
    let overload = matches!(verdict, Verdict::Fail(_)).then(|| overload(bench, took)).flatten();
    // A device that has gone is looked for while its frames are still evidence.
    let has_left = matches!(verdict, Verdict::Fail(_)) && bench.is_live() && bench.has_left();
    // Also what puts the device back could panic; the run goes on.
    let remains = catch_unwind(AssertUnwindSafe(|| bench.finish())).ok();
    let Remains { evidence, notes, restarted, measurements } = remains.unwrap_or_else(|| Remains {
        evidence: Evidence::default(),
        notes: vec!["the tester failed while it restored the device".to_owned()],
        restarted: None,
        measurements: Vec::new(),
    });
    let verdict = blameless(verdict, &bench.health().since(&health), overload, has_left);
    let verdict = match (verdict, restarted) {
        (Verdict::Pass | Verdict::Tolerated(_), Some(at)) => Verdict::Fail(Reason::new(
            "the device does not restart by itself",
            "no boot-up message after the case has begun",
            format!("a boot-up message at {at} s"),
        )),
        (verdict, _) => verdict,
    };
    let verdict = documented(verdict, case, &bench.target().deviations);
    let outcomes = vec![verdict.kind()];
    CaseReport { case, verdict, evidence, notes, measurements, outcomes, duration: bench.now().since(started) }
}

/// A failure that comes while a frame takes longer than this to or from the tester may be the tester's own: it is as long
/// as the shortest wait that a case judges by.
const HOST_LATE: Duration = Duration::from_millis(50);

/// From that share of the bus on, in percent, others may be why a device does not get through.
const OVERLOAD: u64 = 50;

/// Who takes so much of the bus that the device may not get through.
fn overload(bench: &Bench<'_>, span: Duration) -> Option<String> {
    let load = bench.foreign().load(span, bench.bit_rate());
    let (id, count) = bench.foreign().loudest()?;
    (load >= OVERLOAD)
        .then(|| format!("others took {load} % of the bus, most of them {count} frames with identifier {id}"))
}

/// The verdict, if neither the bus nor the tester's own machine may be to blame.
fn blameless(verdict: Verdict, health: &Health, overload: Option<String>, has_left: bool) -> Verdict {
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

fn judge(bench: &mut Bench<'_>, case: &'static Case) -> Verdict {
    let judged = (|| {
        if let Some(touch) = case.touches.iter().find(|touch| !bench.options().allow.contains(touch)) {
            return Err(Verdict::NotApplicable(not_allowed(*touch)));
        }
        bench.look_for_it()?;
        bench.prepare()?;
        for &need in case.needs {
            if let Err(why) = bench.meets(need)? {
                let expected = need.text();
                return Err(Verdict::NotApplicable(Reason::new("the case has what it needs", expected, why)));
            }
        }
        (case.run)(bench)
    })();
    judged.unwrap_or_else(|verdict| verdict)
}

fn not_allowed(touch: Touch) -> Reason {
    let duty = format!("the user allows what the case does: it {}", touch.text());
    Reason::new(duty, format!("--allow {touch}"), format!("not allowed: it {} (--allow {touch})", touch.text()))
}

fn panicked(panic: &(dyn Any + Send)) -> Reason {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    Reason::new("the tester works", "a verdict", text.unwrap_or_else(|| "a panic".to_owned()))
}

/// A failure that the device's documentation or its user announces is a deviation.
fn documented(verdict: Verdict, case: &Case, deviations: &[Deviation]) -> Verdict {
    let Verdict::Fail(reason) = verdict else { return verdict };
    match deviations.iter().find(|deviation| deviation.explains(case, &reason)) {
        Some(Deviation { documented, by, .. }) => {
            Verdict::Deviation { reason, documented: documented.clone(), by: *by }
        }
        None => Verdict::Fail(reason),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Clause, Confidence, Level};
    use crate::scripted::{table, with_bench};
    use crate::verdict::Judged;

    /// A device that answers only when its device type is read or it is reset.
    const ROWS: &[(&str, &str)] = &[("63F#4000100000000000", "5BF#4300100096010200"), ("000#813F", "73F#00")];

    const fn test_case(id: &'static str, run: fn(&mut Bench<'_>) -> Judged) -> Case {
        let clause = Clause { standard: "CiA 301", section: None, confidence: Confidence::Unknown };
        let (needs, touches, catches) = (&[], &[], &[]);
        Case { id, requirement: "A test.", clause, level: Level::Must, needs, touches, catches, cct: None, run }
    }

    static PASSES: Case = test_case("test/passes", |_| Ok(Verdict::Pass));
    static PANICS: Case = test_case("test/panics", |_| panic!("out of luck"));
    static TOUCHES: Case = Case { touches: &[Touch::Nvm], ..test_case("test/touches", |_| Ok(Verdict::Pass)) };
    static RESETS: Case = test_case("test/resets", |bench| {
        // After the start that the bench commanded is over.
        bench.listen(Duration::from_secs(1))?;
        // The script takes the raw frame for a command; the bench did not give it.
        let node = bench.node().raw();
        bench.send_bytes(0, &[0x81, node])?;
        bench.wait_for_boot_up()?;
        Ok(Verdict::Pass)
    });

    fn run_cases(rows: &'static [(&str, &str)], cases: &[&'static Case]) -> (Result<Summary, RunError>, Vec<String>) {
        let mut events = Vec::new();
        let result = with_bench(table(rows), |bench| {
            let plan = Plan { cases, bus: "sim:test", bit_rate: None, seed: 0 };
            run(bench, &plan, &mut |event| match event {
                RunEvent::RunStarted(info) => events.push(format!("{:?}", info.device.device_type)),
                RunEvent::CaseFinished(report) => {
                    let reason = report.verdict.reason().map(|reason| reason.actual.clone()).unwrap_or_default();
                    events.push(format!("{}: {} {reason}", report.case.id, report.verdict.kind()));
                }
                _ => {}
            })
        });
        (result, events)
    }

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
    fn a_documented_failure_is_a_deviation() {
        let deviations = [Deviation::of_manual("test/*", "manual, 5.1")];
        let verdict = documented(Verdict::Fail(Reason::default()), &PASSES, &deviations);
        assert_eq!(verdict.documented(), Some("manual, 5.1"));
        assert_eq!(documented(Verdict::Pass, &PASSES, &deviations), Verdict::Pass);
    }
}
