//! A measured quantity that moves is no fault: no case fails on a correct device, however it moves. And a fault is found
//! although the measured quantity trembles, as that of every real sensor does.

use super::{REST, in_parallel, judge_machine, node_of, records};
use crate::bench::{Knowledge, Target};
use crate::case::Case;
use crate::verdict::{Kind, Reason, Verdict};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Firmware, Motion};
use canvass_traces::Duration;

/// A motion with its name; the argument is the start in steps.
struct Course {
    name: &'static str,
    from: fn(i64) -> Motion,
}

/// Twelve ways to move. Amplitudes and speeds are in units of a revolution.
const COURSES: [Course; 12] = [
    Course { name: "at rest", from: Motion::still },
    Course { name: "trembling by a step", from: trembling },
    Course { name: "trembling by several steps", from: |start| Motion::sine(start, 2e-5, Duration::from_millis(50)) },
    Course { name: "swaying slowly", from: |start| Motion::sine(start, 1e-4, Duration::from_millis(700)) },
    Course { name: "turning by 0.02 a minute", from: |start| Motion::constant(start, 20) },
    Course { name: "turning by 0.4 a minute, backwards", from: |start| Motion::constant(start, -400) },
    Course { name: "turning once a minute", from: |start| Motion::constant(start, 1_000) },
    Course { name: "turning once a second, backwards", from: |start| Motion::constant(start, -60_000) },
    Course { name: "turning ten times a second", from: |start| Motion::constant(start, 600_000) },
    Course { name: "turning fifty times a second", from: |start| Motion::constant(start, 3_000_000) },
    Course { name: "reversing every second", from: |start| Motion::sine(start, 3.0, Duration::from_secs(2)) },
    Course { name: "starting", from: |start| Motion::ramp(start, 300.0, Duration::from_secs(5)) },
];

/// The motion of a sensor at rest, of which the last bit changes.
fn trembling(start: i64) -> Motion {
    Motion::sine(start, 5e-6, Duration::from_millis(30))
}

/// The positions from which a device moves: the first step, a step in the middle, and the step before the first one,
/// which is the last one of the range.
const STARTS: [i64; 3] = [0, REST, -1];

/// Faults that can't show on a trembling device, with the reason.
const NEED_REST: &[(Fault, &str)] =
    &[(Fault::LimitSwitchInclusive, "whether the limit itself counts shows only at a position that stays there")];

/// The results of the cases on moving devices.
#[derive(Clone, Debug, Default)]
pub struct Moving {
    /// One row for each model and motion.
    pub rows: Vec<MotionRow>,
    /// Number of faults that were looked for on trembling devices.
    pub tried: usize,
    /// The faults that no case finds on a trembling device.
    pub missed: Vec<Fault>,
}

/// The results of the cases on a model that moves.
#[derive(Clone, Debug)]
pub struct MotionRow {
    /// The model.
    pub model: &'static str,
    /// The motion.
    pub motion: &'static str,
    /// The position from which it moves, in steps of the physical resolution.
    pub start: i64,
    /// Number of cases that ran to an end.
    pub executed: usize,
    /// The cases that failed, or in which the tester failed.
    pub alarms: Vec<(&'static Case, Kind, Reason)>,
}

impl Moving {
    /// Number of models and motions on which no case failed.
    pub fn spared(&self) -> usize {
        self.rows.iter().filter(|row| row.alarms.is_empty()).count()
    }

    /// Whether no motion failed a case, and no fault was missed.
    pub fn is_good(&self) -> bool {
        self.missed.is_empty() && self.spared() == self.rows.len()
    }
}

/// Runs the cases on all models in all motions, each from this number of positions, and looks for the faults on devices
/// that tremble. Without positions nothing runs.
pub(super) fn run(cases: &[&'static Case], faults: &[Fault], models: &[&'static Model], starts: usize) -> Moving {
    let mut moving: Vec<(&'static Model, &'static Course, i64)> = Vec::new();
    for (n, model) in models.iter().enumerate() {
        for (m, course) in COURSES.iter().enumerate() {
            // With fewer positions each model and motion has another one.
            let chosen = (0..starts.min(STARTS.len())).filter_map(|k| STARTS.get((n + m + k) % STARTS.len()));
            moving.extend(chosen.map(|start| (*model, course, *start)));
        }
    }
    let faults = if starts == 0 { &[] } else { faults };
    let found = in_parallel(faults, |fault| is_found(*fault, cases));
    let missed = faults.iter().zip(&found).filter(|(_, found)| **found == Some(false)).map(|(fault, _)| *fault);
    Moving {
        rows: in_parallel(&moving, |(model, course, start)| row(model, course, *start, cases)),
        tried: found.iter().flatten().count(),
        missed: missed.collect(),
    }
}

fn row(model: &'static Model, course: &Course, start: i64, cases: &[&'static Case]) -> MotionRow {
    let mut row = MotionRow { model: model.id(), motion: course.name, start, executed: 0, alarms: Vec::new() };
    let target = Target::of(model, node_of(model));
    let mut knowledge = Knowledge::default();
    for &case in cases {
        let motion = (course.from)(start);
        let verdict = judge(case, model, Firmware::PLAIN, &target, &motion, &mut knowledge);
        let kind = verdict.kind();
        row.executed += usize::from(kind.is_executed());
        if matches!(kind, Kind::Fail | Kind::Error) {
            row.alarms.push((case, kind, verdict.reason().unwrap_or_default()));
        }
    }
    row
}

/// Whether a case that names the fault finds it on a trembling device; `None` if the fault or these cases need another
/// motion, or there are none.
fn is_found(fault: Fault, cases: &[&'static Case]) -> Option<bool> {
    if NEED_REST.iter().any(|row| row.0 == fault) {
        return None;
    }
    let model = Model::by_id(fault.model())?;
    let firmware = Firmware::from(fault);
    let target = Target::with_firmware(model, node_of(model), firmware);
    let mut naming = cases.iter().filter(|case| case.catches.contains(&fault) && !case.needs_motion()).peekable();
    naming.peek()?;
    Some(naming.any(|case| {
        let verdict = judge(case, model, firmware, &target, &trembling(REST), &mut Knowledge::default());
        verdict.kind() == Kind::Fail || records(case, &verdict)
    }))
}

fn judge(
    case: &'static Case,
    model: &'static Model,
    firmware: Firmware,
    target: &Target,
    motion: &Motion,
    knowledge: &mut Knowledge,
) -> Verdict {
    let new = |_| -> Box<dyn canvass_bus::Machine> {
        Box::new(Device::with_motion(model, Some(target.node), firmware, 0, motion))
    };
    judge_machine(case, new, model.default_bit_rate(), target, knowledge, &mut |_| ()).verdict
}
