//! The motion of the quantity that a simulated device measures. Position, speed, acceleration and jerk are computed
//! from one course, so that they agree at every instant.
//!
//! The unit of length is a revolution of a rotary sensor or of a drum with a wire, and a millimetre of a linear sensor.
//! A motion in millimetres moves the wire by millimetres.
//! Time counts from the power-on of the bus.

use canvass_traces::{Duration, Timestamp};
use std::sync::Arc;

/// The course of the measured quantity.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Motion {
    /// The position at time 0, in steps of the physical resolution.
    pub start: i64,
    course: Course,
    in_millimetres: bool,
}

/// The course of a motion from its start. Lengths are in units, times in seconds.
#[derive(Clone, PartialEq, Debug)]
enum Course {
    /// Constant speed in thousandths of a unit per minute; negative is backwards.
    Steady(i64),
    /// `amplitude * sin(2 pi t / period)`.
    Sine { amplitude: f64, period: f64 },
    /// From rest to `speed` in units per second within `rise` seconds, then steady.
    Ramp { speed: f64, rise: f64 },
    /// Through these points; at rest before the first point and after the last one.
    Points(Arc<[Knot]>),
}

impl Default for Course {
    fn default() -> Self {
        Self::Steady(0)
    }
}

/// Limit of positions. It keeps calculations from overflowing.
const FARTHEST: i128 = 1 << 80;

/// A point of the course, with its speed.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Knot {
    seconds: f64,
    units: f64,
    /// Speed in units per second.
    speed: f64,
}

/// Position, speed, acceleration and jerk: in units, units per second, per square second and per cubic second.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
struct Kinematics {
    position: f64,
    speed: f64,
    acceleration: f64,
    jerk: f64,
}

impl Motion {
    /// A motion that stays at that position.
    pub const fn still(position: i64) -> Self {
        Self { start: position, course: Course::Steady(0), in_millimetres: false }
    }

    /// Constant speed in thousandths of a revolution (of a millimetre) per minute; negative is backwards.
    pub const fn constant(start: i64, milli_rpm: i64) -> Self {
        Self { start, course: Course::Steady(milli_rpm), in_millimetres: false }
    }

    /// A motion to and fro: `amplitude` revolutions or millimetres to both sides within `period` (at least 1 µs).
    pub fn sine(start: i64, amplitude: f64, period: Duration) -> Self {
        let period = seconds(period).max(1e-6);
        Self { start, course: Course::Sine { amplitude: finite(amplitude), period }, in_millimetres: false }
    }

    /// A motion from rest to `per_minute` revolutions or millimetres per minute within `rise`, then at constant speed.
    pub fn ramp(start: i64, per_minute: f64, rise: Duration) -> Self {
        let rise = seconds(rise).max(1e-6);
        Self { start, course: Course::Ramp { speed: finite(per_minute) / 60.0, rise }, in_millimetres: false }
    }

    /// A motion through points: seconds, and revolutions or millimetres from the start. Between the points the speed
    /// does not jump; before the first and after the last point it is zero. Points out of time order are left out.
    pub fn through(start: i64, points: &[(f64, f64)]) -> Self {
        let mut rising: Vec<(f64, f64)> = Vec::with_capacity(points.len());
        for &(time, units) in points {
            let later = rising.last().is_none_or(|&(before, _)| time > before);
            if later && time.is_finite() && units.is_finite() {
                rising.push((time, units));
            }
        }
        let knot = |n: usize| {
            let (seconds, units) = *rising.get(n)?;
            let neighbours = n.checked_sub(1).and_then(|before| rising.get(before)).zip(rising.get(n + 1));
            let speed = neighbours.map_or(0.0, |(before, after)| (after.1 - before.1) / (after.0 - before.0));
            Some(Knot { seconds, units, speed })
        };
        Self { start, course: Course::Points((0..rising.len()).filter_map(knot).collect()), in_millimetres: false }
    }

    /// The same numbers as millimetres, if the sensor measures a length.
    #[must_use]
    pub fn millimetres(self) -> Self {
        Self { in_millimetres: true, ..self }
    }

    /// Whether the motion is in millimetres, if the sensor measures a length.
    pub(crate) const fn is_in_millimetres(&self) -> bool {
        self.in_millimetres
    }

    /// Whether the position never changes.
    pub(crate) const fn is_still(&self) -> bool {
        matches!(self.course, Course::Steady(0))
    }

    /// The position in steps from position 0, counted over all revolutions.
    pub fn position(&self, now: Timestamp, steps_per_unit: u64) -> i128 {
        // Conversion from thousandths per minute to nanoseconds.
        const PER_NANOSECOND: i128 = 1_000 * 60 * 1_000_000_000;
        let moved = match &self.course {
            Course::Steady(0) => 0,
            Course::Steady(milli) => {
                let turned =
                    i128::from(*milli).saturating_mul(now.nanos().into()).saturating_mul(steps_per_unit.into());
                turned.div_euclid(PER_NANOSECOND)
            }
            _ => (self.kinematics(now).position * steps_per_unit as f64).floor() as i128,
        };
        moved.clamp(-FARTHEST, FARTHEST) + i128::from(self.start)
    }

    /// The speed in thousandths of a revolution (of a millimetre) per minute.
    pub fn milli_rpm(&self, now: Timestamp) -> i64 {
        match self.course {
            Course::Steady(milli) => milli,
            _ => (self.kinematics(now).speed * 60_000.0).round() as i64,
        }
    }

    /// The acceleration in thousandths of a revolution (of a millimetre) per square second.
    pub fn acceleration(&self, now: Timestamp) -> i64 {
        (self.kinematics(now).acceleration * 1_000.0).round() as i64
    }

    /// The jerk in thousandths of a revolution (of a millimetre) per cubic second.
    pub fn jerk(&self, now: Timestamp) -> i64 {
        (self.kinematics(now).jerk * 1_000.0).round() as i64
    }

    fn kinematics(&self, now: Timestamp) -> Kinematics {
        let t = now.nanos() as f64 / 1e9;
        match &self.course {
            Course::Steady(milli) => {
                let speed = *milli as f64 / 60_000.0;
                Kinematics { position: speed * t, speed, ..Kinematics::default() }
            }
            Course::Sine { amplitude, period } => swing(t, *amplitude, *period),
            Course::Ramp { speed, rise } if t < *rise => Kinematics {
                position: speed * t * t / (2.0 * rise),
                speed: speed * t / rise,
                acceleration: speed / rise,
                jerk: 0.0,
            },
            Course::Ramp { speed, rise } => {
                Kinematics { position: speed * (t - rise / 2.0), speed: *speed, ..Kinematics::default() }
            }
            Course::Points(knots) => between(t, knots),
        }
    }
}

fn swing(t: f64, amplitude: f64, period: f64) -> Kinematics {
    let omega = std::f64::consts::TAU / period;
    let (sin, cos) = (omega * t).sin_cos();
    Kinematics {
        position: amplitude * sin,
        speed: amplitude * omega * cos,
        acceleration: -amplitude * omega.powi(2) * sin,
        jerk: -amplitude * omega.powi(3) * cos,
    }
}

/// Cubic interpolation between two points, with the speeds of both (Hermite).
fn between(t: f64, knots: &[Knot]) -> Kinematics {
    let after = knots.partition_point(|knot| knot.seconds <= t);
    let (before, next) = (after.checked_sub(1).and_then(|n| knots.get(n)), knots.get(after));
    let (from, to) = match (before, next) {
        (Some(from), Some(to)) => (from, to),
        (Some(knot), None) | (None, Some(knot)) => return Kinematics { position: knot.units, ..Kinematics::default() },
        (None, None) => return Kinematics::default(),
    };
    let span = to.seconds - from.seconds;
    let t = t - from.seconds;
    let slope = (to.units - from.units) / span;
    let square = (3.0 * slope - 2.0 * from.speed - to.speed) / span;
    let cube = (from.speed + to.speed - 2.0 * slope) / (span * span);
    Kinematics {
        position: from.units + t * (from.speed + t * (square + t * cube)),
        speed: from.speed + t * (2.0 * square + 3.0 * t * cube),
        acceleration: 2.0 * square + 6.0 * t * cube,
        jerk: 6.0 * cube,
    }
}

fn seconds(duration: Duration) -> f64 {
    duration.nanos() as f64 / 1e9
}

fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn one_revolution_per_second() {
        let motion = Motion::constant(100, 60_000);
        assert_eq!(motion.position(Timestamp(SECOND), 8192), 100 + 8192);
        assert_eq!(motion.position(Timestamp(SECOND / 2), 8192), 100 + 4096);
        assert_eq!(Motion::constant(0, -60_000).position(Timestamp(SECOND), 8192), -8192);
        assert!(Motion::still(3).is_still() && !motion.is_still());
        assert_eq!((motion.milli_rpm(Timestamp(5)), motion.acceleration(Timestamp(5))), (60_000, 0));
    }

    #[test]
    fn to_and_fro() {
        let motion = Motion::sine(0, 2.0, Duration::from_secs(4));
        assert_eq!(motion.position(Timestamp(SECOND), 1000), 2000);
        assert_eq!(motion.position(Timestamp(3 * SECOND), 1000), -2000);
        assert_eq!(motion.milli_rpm(Timestamp(SECOND)), 0, "at the turning point");
        // The speed at the centre is 2 revolutions * (2 pi / 4 s).
        assert_eq!(motion.milli_rpm(Timestamp(0)), 188_496);
        assert_eq!(motion.acceleration(Timestamp(SECOND)), -4_935);
    }

    #[test]
    fn a_ramp_goes_on_at_its_speed() {
        let motion = Motion::ramp(0, 60.0, Duration::from_secs(2));
        assert_eq!((motion.milli_rpm(Timestamp(SECOND)), motion.acceleration(Timestamp(SECOND))), (30_000, 500));
        assert_eq!(motion.position(Timestamp(2 * SECOND), 1000), 1000);
        assert_eq!(motion.position(Timestamp(3 * SECOND), 1000), 2000);
        assert_eq!((motion.milli_rpm(Timestamp(3 * SECOND)), motion.acceleration(Timestamp(3 * SECOND))), (60_000, 0));
    }

    #[test]
    fn points_are_passed_and_stand_at_their_ends() {
        let motion = Motion::through(7, &[(1.0, 0.0), (2.0, 10.0), (1.5, 99.0), (4.0, 10.0), (f64::NAN, 1.0)]);
        let at = |tenths: u64| motion.position(Timestamp(tenths * SECOND / 10), 100) - 7;
        assert_eq!((at(0), at(10), at(20), at(40), at(90)), (0, 0, 1000, 1000, 1000));
        assert!(at(15) > 0 && at(15) < 1000);
        assert_eq!(motion.milli_rpm(Timestamp(9 * SECOND)), 0);
        assert_eq!(Motion::through(3, &[]).position(Timestamp(5), 100), 3);
    }

    /// Speed is the derivative of position, acceleration of speed, jerk of acceleration.
    #[test]
    fn derivatives_fit_together() {
        let through = Motion::through(0, &[(0.0, 0.0), (1.0, 3.0), (2.5, -2.0), (4.0, 5.0)]);
        let courses =
            [Motion::sine(0, 3.0, Duration::from_secs(7)), Motion::ramp(0, 90.0, Duration::from_secs(9)), through];
        for motion in courses {
            for tick in 1..39 {
                let (from, to) = (Timestamp(tick * SECOND / 10), Timestamp(tick * SECOND / 10 + 1_000_000));
                let (a, b) = (motion.kinematics(from), motion.kinematics(to));
                let crosses_a_point = tick == 10 || tick == 25;
                for (value, next, slope) in [
                    (a.position, b.position, a.speed),
                    (a.speed, b.speed, a.acceleration),
                    (a.acceleration, b.acceleration, a.jerk),
                ] {
                    let found = (next - value) / 1e-3;
                    assert!(crosses_a_point || (found - slope).abs() < 0.05, "{motion:?} {tick}: {found} {slope}");
                }
            }
        }
    }

    #[test]
    fn no_course_overflows() {
        for motion in [
            Motion::constant(i64::MAX, i64::MAX),
            Motion::sine(i64::MIN, f64::MAX, Duration::ZERO),
            Motion::ramp(0, f64::MAX, Duration::ZERO),
            Motion::through(0, &[(0.0, f64::MIN), (1e-300, f64::MAX)]),
        ] {
            for now in [Timestamp::ZERO, Timestamp(1), Timestamp::MAX] {
                motion.position(now, u64::MAX);
                motion.milli_rpm(now);
                motion.jerk(now);
            }
        }
    }
}
