//! Tests of the tester: every case on every fault, and on every model without fault.
//!
//! Each fault is put into the firmware of its model, and every case runs against a device of its own. A fault is
//! detected if a case that names it fails. A case that fails without naming the fault must belong to the chapter of a
//! case that names it; otherwise the failing case judges something outside its subject.

pub mod alone;
mod liberties;
mod masking;
mod motions;
pub mod null;
pub mod wire;

pub use liberties::{Chance, LibertyRow, Sparing, random_liberties};
pub use masking::{Masked, Masking};
pub use motions::{MotionRow, Moving};

use crate::bench::{Bench, Knowledge, Options, Target};
use crate::case::Case;
use crate::catalogue;
use crate::clause::Level;
use crate::runner::{CaseReport, run_undisturbed};
use crate::touch::Touch;
use crate::trial::is_gone;
use crate::verdict::{Grade, Kind, Reason, Ruled, Verdict};
use canvass_analyzer::NodeId;
use canvass_bus::client::Violation;
use canvass_bus::observation::Observation;
use canvass_bus::{Machine, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_device::{Fault, Firmware};
use canvass_traces::Record;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// The share of the matrix that is run.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Extent {
    /// All cells.
    Whole,
    /// All cells of a fault with the cases that name it, and one in this number of the other cells, evenly spread.
    OneIn(usize),
}

impl Extent {
    fn contains(self, fault: Fault, number: usize, case: &Case) -> bool {
        match self {
            Self::Whole => true,
            Self::OneIn(n) => case.catches.contains(&fault) || (number + fault as usize).is_multiple_of(n.max(1)),
        }
    }
}

/// The outcome of the selftest.
#[derive(Clone, Debug, Default)]
pub struct Matrix {
    /// One row for each fault, in the order of their definition.
    pub faults: Vec<FaultRow>,
    /// One row for each model without fault.
    pub models: Vec<ModelRow>,
    /// The documented deviations that hide a fault.
    pub masking: Masking,
    /// The liberties of the standard that fail a case.
    pub sparing: Sparing,
    /// The motions that fail a case.
    pub moving: Moving,
    /// The cases that ran.
    pub cases: Vec<&'static Case>,
}

/// The results of the cases on a fault.
#[derive(Clone, Debug)]
pub struct FaultRow {
    /// The fault.
    pub fault: Fault,
    /// The model whose firmware had it.
    pub model: &'static str,
    /// The cases that failed.
    pub failed: Vec<&'static Case>,
    /// Cases that name the fault and did not fail, each with its verdict.
    pub missed: Vec<(&'static Case, Kind)>,
    /// Cases that failed but do not belong to the chapter of a case that names the fault.
    pub unrelated: Vec<&'static Case>,
}

/// The results of the cases on a model without fault.
#[derive(Clone, Debug)]
pub struct ModelRow {
    /// The model.
    pub model: &'static str,
    /// Number of cases that ran to an end.
    pub executed: usize,
    /// The cases that failed, or could not be judged, or in which the tester failed.
    pub alarms: Vec<(&'static Case, Kind, Reason)>,
}

impl FaultRow {
    /// Whether a case that names the fault failed.
    pub fn is_detected(&self) -> bool {
        self.failed.iter().any(|case| case.catches.contains(&self.fault))
    }
}

impl Matrix {
    /// Number of detected faults.
    pub fn detected(&self) -> usize {
        self.faults.iter().filter(|row| row.is_detected()).count()
    }

    /// Number of failures on a model without fault, or on a fault outside the chapter of the case.
    pub fn false_alarms(&self) -> usize {
        let unrelated: usize = self.faults.iter().map(|row| row.unrelated.len()).sum();
        let alarms: usize = self.models.iter().map(|row| row.alarms.len()).sum();
        unrelated + alarms
    }

    /// The cases that failed on no fault.
    pub fn vacuous_cases(&self) -> Vec<&'static Case> {
        let failed: BTreeSet<&str> = self.faults.iter().flat_map(|row| &row.failed).map(|case| case.id).collect();
        self.cases.iter().copied().filter(|case| !failed.contains(case.id)).collect()
    }

    /// Whether every fault was detected, every case detects a fault, no case misses a fault that it names, there was no
    /// false alarm, no manual hides a fault, and no liberty and no motion fails a case.
    pub fn is_good(&self) -> bool {
        self.detected() == self.faults.len()
            && self.false_alarms() == 0
            && self.vacuous_cases().is_empty()
            && self.masking.masked.is_empty()
            && self.sparing.is_good()
            && self.moving.is_good()
            && self.faults.iter().all(|row| row.missed.is_empty())
    }
}

/// Runs the cases on the faults, and on the models without fault. Uses as many threads as the computer has cores.
///
/// The order of the rows does not depend on the threads.
pub fn run(
    cases: &[&'static Case],
    faults: &[Fault],
    models: &[&'static Model],
    extent: Extent,
    chance: Chance,
) -> Matrix {
    let mut order: Vec<Fault> = faults.to_vec();
    order.sort_unstable();
    let fault_rows = in_parallel(&order, |fault| fault_row(*fault, cases, extent));
    let model_rows = in_parallel(models, |model| model_row(model, cases));
    let mut masking = Masking::default();
    // The models whose manuals announce deviations.
    let deviating: Vec<_> = models.iter().copied().filter(|model| !model.deviations().is_empty()).collect();
    in_parallel(&deviating, |model| masking::of_model(model, cases, &order))
        .into_iter()
        .for_each(|one| masking.add(one));
    let faults = fault_rows.into_iter().flatten().collect();
    let sparing = liberties::run(cases, &order, chance);
    let moving = motions::run(cases, &order, models, chance);
    Matrix { faults, models: model_rows, masking, sparing, moving, cases: cases.to_vec() }
}

/// The faults that the cases name.
pub fn named_by(cases: &[&'static Case]) -> Vec<Fault> {
    let named: BTreeSet<Fault> = cases.iter().flat_map(|case| case.catches).copied().collect();
    named.into_iter().collect()
}

/// Whether all breaches of a case can show in any case: an abort that names another object than the request, or a
/// device that leaves the bus.
fn shows_anywhere(verdict: &Verdict) -> bool {
    let is_everywhere = |ruled: &Ruled| {
        is_gone(&ruled.breach) || matches!(ruled.breach.actual, Observation::Violation(Violation::Multiplexer(_)))
    };
    verdict.breaches().iter().filter(|ruled| ruled.kind() == Kind::Fail).all(is_everywhere)
}

/// Whether a case of level [`Level::Open`] has recorded a difference. Such a case never fails: it detects a fault by
/// its record.
pub fn records(case: &Case, verdict: &Verdict) -> bool {
    case.level == Level::Open && verdict.breaches().iter().any(|ruled| ruled.breach.grade == Grade::Open)
}

/// The row of this fault; `None` if its model does not exist.
fn fault_row(fault: Fault, cases: &[&'static Case], extent: Extent) -> Option<FaultRow> {
    let model = Model::by_id(fault.model())?;
    let named = catalogue::cases().into_iter().filter(|case| case.catches.contains(&fault));
    let relatives: BTreeSet<&str> = named.map(chapter).collect();
    let mut row = FaultRow { fault, model: model.id(), failed: Vec::new(), missed: Vec::new(), unrelated: Vec::new() };
    let target = Target::with_faults(model, node_of(model), fault.into());
    let mut knowledge = Knowledge::default();
    for (n, &case) in cases.iter().enumerate() {
        if !extent.contains(fault, n, case) {
            continue;
        }
        let verdict = judge_knowing(case, model, fault.into(), &target, &mut knowledge).verdict;
        let kind = verdict.kind();
        if kind == Kind::Fail || records(case, &verdict) {
            row.failed.push(case);
            if kind == Kind::Fail && !relatives.contains(chapter(case)) && !shows_anywhere(&verdict) {
                row.unrelated.push(case);
            }
        } else if case.catches.contains(&fault) {
            row.missed.push((case, kind));
        }
    }
    Some(row)
}

fn model_row(model: &'static Model, cases: &[&'static Case]) -> ModelRow {
    let mut row = ModelRow { model: model.id(), executed: 0, alarms: Vec::new() };
    let target = Target::of(model, node_of(model));
    let mut knowledge = Knowledge::default();
    for &case in cases {
        let verdict = judge_knowing(case, model, Firmware::PLAIN, &target, &mut knowledge).verdict;
        let kind = verdict.kind();
        row.executed += usize::from(kind.is_executed());
        if matches!(kind, Kind::Fail | Kind::Error | Kind::Inconclusive) {
            row.alarms.push((case, kind, verdict.reason().unwrap_or_default()));
        }
    }
    row
}

/// Runs one case, with everything allowed, on a new device of this model with this firmware.
pub fn judge(case: &'static Case, model: &'static Model, firmware: impl Into<Firmware>) -> CaseReport {
    let firmware = firmware.into();
    let target = Target::with_firmware(model, node_of(model), firmware);
    judge_target(case, model, firmware, &target)
}

/// The node-ID as delivered. A device without one gets 127.
pub fn node_of(model: &Model) -> NodeId {
    model.default_node().unwrap_or(GIVEN_NODE)
}

const GIVEN_NODE: NodeId = NodeId::MAX;

/// The rest position of the measured quantity, in steps of the physical resolution.
const REST: i64 = 0x4CBA;

/// The speed of the measured quantity if a case needs motion, in thousandths of a revolution per minute.
const TURNING: i64 = 30_000;

/// Runs one case as [`judge`] does, with this target as the tester's knowledge of the device.
pub fn judge_target(
    case: &'static Case,
    model: &'static Model,
    firmware: impl Into<Firmware>,
    target: &Target,
) -> CaseReport {
    judge_knowing(case, model, firmware.into(), target, &mut Knowledge::default())
}

/// Runs one case as [`judge_target`] does, with the knowledge of earlier cases about the device, and adds to it.
fn judge_knowing(
    case: &'static Case,
    model: &'static Model,
    firmware: Firmware,
    target: &Target,
    knowledge: &mut Knowledge,
) -> CaseReport {
    judge_hearing(case, model, firmware, target, knowledge, &mut |_| ())
}

/// Runs one case as [`judge_knowing`] does; `hear` gets each frame of the case.
fn judge_hearing(
    case: &'static Case,
    model: &'static Model,
    firmware: Firmware,
    target: &Target,
    knowledge: &mut Knowledge,
    hear: &mut dyn FnMut(&Record),
) -> CaseReport {
    let new =
        |motion| -> Box<dyn Machine> { Box::new(Device::with_motion(model, Some(target.node), firmware, 0, &motion)) };
    judge_machine(case, new, model.default_bit_rate(), target, knowledge, hear)
}

/// Runs one case as [`judge_hearing`] does, on a machine with this motion, which `new` makes.
fn judge_machine(
    case: &'static Case,
    new: impl FnOnce(Motion) -> Box<dyn Machine>,
    bit_rate: u32,
    target: &Target,
    knowledge: &mut Knowledge,
    hear: &mut dyn FnMut(&Record),
) -> CaseReport {
    let mut bus = SimulatedBus::new(bit_rate);
    bus.attach(new(Motion::constant(REST, if case.needs_motion() { TURNING } else { 0 })));
    let options = Options { allow: Touch::ALL.into_iter().collect(), ..Options::default() };
    let cancel = AtomicBool::new(false);
    let mut annotate = |record: &Record| {
        hear(record);
        String::new()
    };
    let mut bench = Bench::new(&mut bus, target, &options, &mut annotate, &cancel);
    bench.learn(std::mem::take(knowledge));
    let report = run_undisturbed(&mut bench, case);
    *knowledge = bench.into_knowledge();
    report
}

/// A firmware of a model that several cases judge in turn. Each case uses the knowledge of the earlier cases about the
/// device.
pub struct Tried {
    model: &'static Model,
    firmware: Firmware,
    target: Target,
    knowledge: Knowledge,
}

impl Tried {
    /// The firmware before the first case.
    pub fn new(model: &'static Model, firmware: impl Into<Firmware>) -> Self {
        let firmware = firmware.into();
        let target = Target::with_firmware(model, node_of(model), firmware);
        Self { model, firmware, target, knowledge: Knowledge::default() }
    }

    /// Runs a case, with everything allowed, on a new device; `hear` gets each frame.
    pub fn judge(&mut self, case: &'static Case, hear: &mut dyn FnMut(&Record)) -> CaseReport {
        judge_hearing(case, self.model, self.firmware, &self.target, &mut self.knowledge, hear)
    }
}

/// The chapter of a case. Services that can't be distinguished from outside share a chapter: a device shows its NMT
/// state by its heartbeats, and its objects by its SDO server, so a fault of one service shows in the cases of all
/// these services.
fn chapter(case: &'static Case) -> &'static str {
    match case.family() {
        "301/nmt"
        | "301/boot-up"
        | "301/state"
        | "301/heartbeat"
        | "301/heartbeat-consumer"
        | "301/guarding"
        | "301/life-guarding"
        | "301/error-behaviour" => "network management",
        "301/sdo" | "301/dictionary" | "301/identity" | "301/description" => "object dictionary",
        "301/pdo" | "301/tpdo" | "301/rpdo" | "301/sync" => "process data",
        "301/emcy" | "301/error-history" | "301/error-register" => "emergencies",
        "301/store" | "301/restore" => "non-volatile memory",
        family => family.split('/').next().filter(|standard| *standard != "301").unwrap_or(family),
    }
}

/// Works on all items, on as many threads as the computer has cores. The results are in the order of the items.
pub fn in_parallel<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(items.len().max(1));
    let (next, results) = (AtomicUsize::new(0), Mutex::new(Vec::with_capacity(items.len())));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((at, item)) = take(&next, items) {
                    let result = work(item);
                    results.lock().unwrap_or_else(PoisonError::into_inner).push((at, result));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_unstable_by_key(|(at, _)| *at);
    results.into_iter().map(|(_, result)| result).collect()
}

fn take<'a, T>(next: &AtomicUsize, items: &'a [T]) -> Option<(usize, &'a T)> {
    let at = next.fetch_add(1, Ordering::Relaxed);
    items.get(at).map(|item| (at, item))
}
