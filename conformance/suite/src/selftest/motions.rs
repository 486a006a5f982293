//! A measured quantity that moves is no fault: no case fails on a correct device, however it moves. And a fault is found
//! although the measured quantity trembles, as that of every real sensor does.

use super::{Chance, REST, in_parallel, judge_machine, node_of, records};
use crate::bench::{Knowledge, Target};
use crate::case::Case;
use crate::dice::Dice;
use crate::verdict::{Kind, Reason, Verdict};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Firmware, Motion};
use canvass_traces::Duration;

/// A motion with its name; the argument is the start in steps.
struct Course {
    name: &'static str,
    from: fn(i64) -> Motion,
}

/// A model that moves from a position.
struct Moved {
    model: &'static Model,
    /// The motion as a user types it, or in words.
    name: String,
    start: i64,
    motion: Motion,
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
    /// The motion, in words or as typed after `sim:MODEL~`.
    pub motion: String,
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

/// Runs the cases on all models in all motions, each from [`Chance::starts`] positions, and in
/// [`Chance::motions`] random motions, and looks for the faults on devices that tremble. Without positions nothing runs.
pub(super) fn run(cases: &[&'static Case], faults: &[Fault], models: &[&'static Model], chance: Chance) -> Moving {
    let mut moved = Vec::new();
    let mut dice = Dice::new(chance.seed);
    for (n, model) in models.iter().enumerate() {
        for (m, course) in COURSES.iter().enumerate() {
            // With fewer positions each model and motion has another one.
            let chosen = (0..chance.starts.min(STARTS.len())).filter_map(|k| STARTS.get((n + m + k) % STARTS.len()));
            moved.extend(chosen.map(|&start| Moved {
                model,
                name: course.name.to_owned(),
                start,
                motion: (course.from)(start),
            }));
        }
        moved.extend((0..chance.motions).map(|_| drawn(model, &mut dice)));
    }
    let faults = if chance.starts == 0 { &[] } else { faults };
    let found = in_parallel(faults, |fault| is_found(*fault, cases));
    let missed = faults.iter().zip(&found).filter(|(_, found)| **found == Some(false)).map(|(fault, _)| *fault);
    Moving {
        rows: in_parallel(&moved, |moved| row(moved, cases)),
        tried: found.iter().flatten().count(),
        missed: missed.collect(),
    }
}

/// A random motion from a random position. Each quantity is drawn by its order of magnitude: from a trembling sensor to
/// the fastest machine.
fn drawn(model: &'static Model, dice: &mut Dice) -> Moved {
    // No model has more steps.
    let start = (dice.next() >> 20) as i64;
    let sign = if dice.below(2) == 0 { 1.0 } else { -1.0 };
    let (name, motion) = match dice.below(5) {
        0 => ("still".to_owned(), Motion::still(start)),
        1 => {
            let (amplitude, period) = (magnitude(dice, -7.0, 1.0), magnitude(dice, -2.0, 1.5));
            let period = Duration((period * 1e9) as u64);
            (format!("sine={amplitude},{}", period.as_millis() / 1e3), Motion::sine(start, amplitude, period))
        }
        2 => {
            let milli = (sign * magnitude(dice, 0.0, 6.5)).round();
            (format!("rpm={}", milli / 1e3), Motion::constant(start, milli as i64))
        }
        3 => {
            let (speed, rise) = (sign * magnitude(dice, -2.0, 3.5), magnitude(dice, -1.0, 2.0));
            let rise = Duration((rise * 1e9) as u64);
            (format!("ramp={speed},{}", rise.as_millis() / 1e3), Motion::ramp(start, speed, rise))
        }
        _ => {
            let points = wandering(dice);
            let last = points.last().map_or(0.0, |point| point.0);
            (format!("csv={} random points in {last:.1} s", points.len()), Motion::through(start, &points))
        }
    };
    Moved { model, name, start, motion }
}

/// A number whose decimal logarithm is drawn between these.
fn magnitude(dice: &mut Dice, least: f64, most: f64) -> f64 {
    10_f64.powf(least + (most - least) * dice.fraction())
}

/// The points of a quantity that rests, moves and moves back at random.
fn wandering(dice: &mut Dice) -> Vec<(f64, f64)> {
    let (mut time, mut place) = (0.0, 0.0);
    let mut points = Vec::new();
    for _ in 0..3 + dice.below(400) {
        points.push((time, place));
        time += magnitude(dice, -2.0, 1.2);
        let way = [0.0, 0.0, 1.0, -1.0][dice.below(4) as usize % 4];
        place += way * magnitude(dice, -7.0, 0.5);
    }
    points
}

fn row(moved: &Moved, cases: &[&'static Case]) -> MotionRow {
    let Moved { model, name, start, motion } = moved;
    let mut row = MotionRow { model: model.id(), motion: name.clone(), start: *start, executed: 0, alarms: Vec::new() };
    let target = Target::of(model, node_of(model));
    let mut knowledge = Knowledge::default();
    for &case in cases {
        let verdict = judge(case, model, Firmware::PLAIN, &target, motion, &mut knowledge);
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
