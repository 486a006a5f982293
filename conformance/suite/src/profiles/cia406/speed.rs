//! Speed (6030h) and acceleration (6040h). The actual speed is calculated from the position.

use super::position::{
    CODE_SEQUENCE, OPERATING_PARAMETERS, POSITION, RANGE, SCALING, UNITS_PER_REVOLUTION, at_rest, operate,
    position_at_rest, shorter,
};
use super::preset::range_now;
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Check, Judged, Lack, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;
use std::cell::Cell;

const SPEED: Multiplexer = Multiplexer::new(encoder::SPEED_VALUE, 1);
/// The parameter that selects the position from which the device calculates the speed.
const SOURCE: Multiplexer = Multiplexer::new(encoder::SPEED_PARAMETER, 1);
const RAW_POSITION: u32 = 2;
const DIVISOR: Multiplexer = Multiplexer::new(encoder::SPEED_PARAMETER, 4);
const ACCELERATION: Multiplexer = Multiplexer::new(encoder::ACCELERATION_VALUE, 1);
const SINGLE_TURN: Multiplexer = Multiplexer::new(encoder::SINGLE_TURN_RESOLUTION, 0);
/// The unit of the speed: bit 13 of 6000h, since version 4.1 of the profile bit 12.
const SPEED_FORMATS: [u32; 2] = [1 << 13, 1 << 12];

/// A signed value of two or four bytes.
fn signed(bench: &mut Bench<'_>, at: Multiplexer) -> Result<i64, Stop> {
    let value = bench.read(at)?;
    Ok(match *value.as_slice() {
        [a, b] => i16::from_le_bytes([a, b]).into(),
        [a, b, c, d] => i32::from_le_bytes([a, b, c, d]).into(),
        _ => 0,
    })
}

/// A signed number as an observation: its bytes, INTEGER32.
fn shown(number: i64) -> Observation {
    Observation::Value((number as i32).to_le_bytes().to_vec())
}

/// The requirement on the motion, for reports.
const CONSTANT: &str = "the shaft turns at constant speed";

/// The change of 6004h, measured over half a second.
#[derive(Clone, Copy)]
pub(super) struct Course {
    /// The change in units per second.
    pub speed: f64,
    /// Maximum error of `speed`, as a position is a whole number of units.
    pub error: f64,
}

impl Course {
    /// Measures the course of a shaft that turns at constant speed.
    pub fn measure(bench: &mut Bench<'_>) -> Result<Self, Stop> {
        /// Parts of the measurement: the speed of each must be that of the whole. Two are not enough: around a turning
        /// point of the speed they are equal.
        const PARTS: usize = 4;
        let mut parts = [Self { speed: 0.0, error: 0.0 }; PARTS];
        for part in &mut parts {
            *part = Self::part(bench)?;
        }
        let speed = parts.iter().map(|part| part.speed).sum::<f64>() / PARTS as f64;
        let differs = |part: &&Self| (part.speed - speed).abs() > part.error.max(speed.abs() * 0.1);
        if let Some(part) = parts.iter().find(differs) {
            return Err(unmeasured(CONSTANT, format!("{speed:.0} and {:.0} units per second", part.speed)));
        }
        let error = parts.iter().map(|part| part.error).fold(0.0, f64::max) / PARTS as f64;
        Ok(Self { speed, error })
    }

    /// Measures for an eighth of a second.
    fn part(bench: &mut Bench<'_>) -> Result<Self, Stop> {
        /// Times between the readings, in milliseconds: unequal, so that a vibration does not look like a slow motion.
        const PAUSES: [u64; 6] = [19, 7, 31, 23, 11, 29];
        let range = range_now(bench)?;
        let (began, mut last) = (bench.now(), bench.read_number(POSITION)?);
        let mut change = 0_i64;
        let mut readings = [(0.0, 0.0); PAUSES.len()];
        for (pause, reading) in PAUSES.into_iter().zip(&mut readings) {
            bench.listen(Duration::from_millis(pause))?;
            let seconds = bench.now().since(began).as_millis() / 1_000.0;
            let position = bench.read_number(POSITION)?;
            let step = shorter(last, position, range);
            if step.unsigned_abs() > u64::from(range / 3) {
                return Err(unmeasured(
                    "the position passes less than a third of its range between two readings",
                    step.to_string(),
                ));
            }
            change += step;
            last = position;
            *reading = (seconds, change as f64);
        }
        let (seconds, change) = readings.last().copied().unwrap_or((1.0, 0.0));
        let speed = change / seconds;
        let strays = |(at, moved): &&(f64, f64)| (moved - speed * at).abs() > 2.0 + change.abs() * 0.1;
        if let Some((at, moved)) = readings.iter().find(strays) {
            return Err(unmeasured(CONSTANT, format!("{moved} units in {at:.3} s, {change} in {seconds:.3} s")));
        }
        Ok(Self { speed, error: 2.0 / seconds })
    }

    /// The same course in a unit of which there are `factor` for each unit of the position.
    fn times(self, factor: f64) -> Self {
        Self { speed: self.speed * factor, error: self.error * factor.abs() }
    }

    /// Requires that the speed is at least this, and large against its error.
    pub fn at_least(self, least: f64) -> Result<Self, Stop> {
        let is_certain = self.speed.abs() >= least && self.speed.abs() >= 3.0 * self.error;
        let duty = format!("the shaft turns fast enough to be measured: {:.0} units per second", least.ceil());
        if is_certain { Ok(self) } else { Err(unmeasured(duty, format!("{:.1}", self.speed))) }
    }

    /// Whether a value of the device shows the speed: it differs by at most a tenth, by 2, or by the error.
    fn is_shown_by(self, value: f64) -> bool {
        is_like(value, self.speed.abs()) || (value - self.speed.abs()).abs() <= self.error
    }
}

/// The end of a case whose motion can't be measured.
fn unmeasured(duty: impl Into<String>, found: impl Into<String>) -> Stop {
    let reason = Reason::new(duty, "a motion that can be measured", found);
    Stop::Inconclusive(reason.for_lack_of(Lack::Steadiness))
}

/// Judges a value that depends on the speed, which holds only for a constant speed. A failure counts only if it comes
/// three times, with the same speed and the same value: a shaft that starts, or vibrates while it turns, has another
/// speed in the moment of the reading than around it.
fn at_constant_speed(
    bench: &mut Bench<'_>,
    value: Multiplexer,
    course: impl Fn(&mut Bench<'_>) -> Result<Course, Stop>,
    judge: impl Fn(Course, i64) -> Check,
) -> Judged {
    let first = (course(bench)?, signed(bench, value)?);
    let check = judge(first.0, first.1);
    if check.is_err() {
        for pause in [37, 91] {
            bench.listen(Duration::from_millis(pause))?;
            let (again, found) = (course(bench)?, signed(bench, value)?);
            let is_same = again.is_shown_by(first.0.speed.abs()) && is_like(found as f64, first.1 as f64);
            if !is_same || judge(again, found).is_ok() {
                return Err(unmeasured(CONSTANT, format!("{} and then {found} in {value}", first.1)));
            }
        }
    }
    bench.check(check.map_err(|breach| Box::new(breach.explained_by_motion())))
}

fn units_per_revolution(bench: &mut Bench<'_>) -> Result<f64, Stop> {
    let scaled = bench.read_number(OPERATING_PARAMETERS)? & SCALING != 0;
    Ok(bench.read_number(if scaled { UNITS_PER_REVOLUTION } else { SINGLE_TURN })?.into())
}

/// Whether two speeds differ by at most a tenth, or by at most 2.
fn is_like(a: f64, b: f64) -> bool {
    (a - b).abs() <= (b.abs() * 0.1).max(2.0)
}

/// At rest the speed is 0.
#[case(id = "406/speed/rest", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Speed], catches = [SpeedNotZeroAtRest])]
fn rest(bench: &mut Bench<'_>) -> Judged {
    position_at_rest(bench)?;
    bench.listen(Duration::from_secs(2))?;
    let speed = signed(bench, SPEED)?;
    let check = demand(speed.abs() <= 2, || {
        Breach::new(SPEED, "6030h is 0 at rest").expected("0").found(shown(speed)).told(speed.to_string())
    });
    at_rest(bench, check)
}

/// In revolutions per minute, the speed equals the measured change of the position.
#[case(id = "406/speed/revolutions-per-minute", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Speed, TurningShaft], catches = [SpeedTenfold])]
fn revolutions_per_minute(bench: &mut Bench<'_>) -> Judged {
    let [v3, v4] = SPEED_FORMATS;
    let format = if in_units_bit(bench)? == v3 { v3 } else { v4 };
    operate(bench, 0, format)?;
    let minute = 60.0 / units_per_revolution(bench)?;
    let course = |bench: &mut Bench<'_>| Course::measure(bench)?.times(minute).at_least(1.0);
    at_constant_speed(bench, SPEED, course, |turned, speed| {
        demand(turned.is_shown_by((speed as f64).abs()), || {
            let breach = Breach::new(SPEED, "6030h is the speed in revolutions per minute");
            breach.expected(format!("{:.0}", turned.speed)).found(shown(speed)).told(speed.to_string())
        })
    })
}

/// The speed has the sign of the change of the position in both code sequences. The same change of the position gives
/// the same magnitude of the speed in both.
#[case(id = "406/speed/sign", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Speed, TurningShaft], catches = [SpeedSignIgnoresCodeSequence, SpeedDoubledBackwards])]
fn sign(bench: &mut Bench<'_>) -> Judged {
    /// A slower speed in revolutions per minute may be rounded to 0.
    const LEAST: f64 = 2.0;
    let mut seen = Vec::new();
    let minute = 60.0 / units_per_revolution(bench)?;
    bench.each([(0, CODE_SEQUENCE), (CODE_SEQUENCE, 0)], |bench, (with, without)| {
        operate(bench, with, without)?;
        bench.listen(Duration::from_millis(500))?;
        let last = Cell::new((0.0, 0.0));
        let course = |bench: &mut Bench<'_>| {
            let turned = Course::measure(bench)?;
            turned.times(minute).at_least(LEAST)?;
            Ok(turned)
        };
        at_constant_speed(bench, SPEED, course, |turned, speed| {
            last.set((speed as f64, turned.speed));
            demand(speed as f64 * turned.speed > 0.0, || {
                let duty = format!("6030h has the sign of the change of 6004h (code sequence {with})");
                let breach =
                    Breach::new(SPEED, duty).expected(if turned.speed > 0.0 { "positive" } else { "negative" });
                breach.found(shown(speed)).told(speed.to_string())
            })
        })?;
        seen.push(last.get());
        Ok(())
    })?;
    let [(one, one_turned), (other, other_turned)] = seen[..] else { return Ok(()) };
    // The other speed, scaled to the position change of the first.
    let alike = other.abs() * (one_turned / other_turned).abs();
    bench.check(demand(is_like(one.abs(), alike), || {
        let duty = "6030h has the same magnitude in both code sequences";
        Breach::new(SPEED, duty)
            .expected(format!("{one:.0}"))
            .found(Observation::named("another"))
            .told(format!("{alike:.0}"))
            .explained_by_motion()
    }))
}

/// The bit that the device uses for the unit of the speed.
fn in_units_bit(bench: &mut Bench<'_>) -> Result<u32, Stop> {
    let before = bench.read_number(OPERATING_PARAMETERS)?;
    let [v3, v4] = SPEED_FORMATS;
    let attempt = bench.download(OPERATING_PARAMETERS, &((before | v3) as u16).to_le_bytes())?;
    let taken = attempt.outcome == Outcome::Downloaded;
    bench.write(OPERATING_PARAMETERS, &(before as u16).to_le_bytes())?;
    Ok(if taken { v3 } else { v4 })
}

/// The speed format in 6000h changes the unit of the speed from revolutions per minute to units per second.
#[case(id = "406/speed/format", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Speed, TurningShaft], catches = [SpeedFormatIgnored])]
fn format(bench: &mut Bench<'_>) -> Judged {
    let bit = in_units_bit(bench)?;
    // Few units, so that the speed fits into 16 bits, and a number that differs from the revolutions per minute.
    operate(bench, SCALING, bit)?;
    bench.write(UNITS_PER_REVOLUTION, &256_u32.to_le_bytes())?;
    bench.write(RANGE, &4_096_u32.to_le_bytes())?;
    bench.listen(Duration::from_millis(500))?;
    let slow = signed(bench, SPEED)?;
    operate(bench, bit, 0)?;
    bench.listen(Duration::from_millis(500))?;
    // Slower, both formats show nearly the same number.
    Course::measure(bench)?.at_least(8.0)?;
    let fast = signed(bench, SPEED)?;
    bench.check(demand(fast.abs() > slow.abs() + 2, || {
        let duty = "6030h in units per second is 256/60 of 6030h in revolutions per minute, or more";
        let breach = Breach::new(SPEED, duty).expected(format!("{}", slow * 256 / 60));
        breach.found(shown(fast)).told(fast.to_string()).explained_by_motion()
    }))
}

/// In units per second, the speed equals the measured change of the position, for any number of units per revolution:
/// of the position 6004h, or of the raw position in physical steps if 6031h:01 selects it.
#[case(id = "406/speed/units-per-second", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, Speed, TurningShaft], catches = [SpeedInPhysicalSteps])]
fn units(bench: &mut Bench<'_>) -> Judged {
    let bit = in_units_bit(bench)?;
    operate(bench, SCALING | bit, 0)?;
    let raw = bench.has(SOURCE)? && bench.read_number(SOURCE)? == RAW_POSITION;
    bench.each([(256_u32, 4_096_u32), (1_000, 16_000)], |bench, (units, range)| {
        bench.write(UNITS_PER_REVOLUTION, &256_u32.to_le_bytes())?;
        bench.write(RANGE, &range.to_le_bytes())?;
        bench.write(UNITS_PER_REVOLUTION, &units.to_le_bytes())?;
        bench.listen(Duration::from_millis(500))?;
        let steps = if raw { f64::from(bench.read_number(SINGLE_TURN)?) / f64::from(units) } else { 1.0 };
        let course = |bench: &mut Bench<'_>| {
            let turned = Course::measure(bench)?.times(steps).at_least(1.0)?;
            Ok(Course { speed: turned.speed.abs().min(most(bench)?), ..turned })
        };
        at_constant_speed(bench, SPEED, course, |turned, speed| {
            demand(turned.is_shown_by((speed as f64).abs()), || {
                let of = if raw { "the raw position" } else { "6004h" };
                let duty = format!("with {units} units per revolution 6030h is the change of {of} per second");
                let breach = Breach::new(SPEED, duty).expected(format!("{:.0}", turned.speed));
                breach.found(shown(speed)).told(speed.to_string())
            })
        })
    })
}

/// The maximum speed that 6030h can show.
fn most(bench: &mut Bench<'_>) -> Result<f64, Stop> {
    Ok(if bench.read(SPEED)?.len() == 2 { i16::MAX.into() } else { i32::MAX.into() })
}

/// 6031h:04 divides the speed.
#[case(id = "406/speed/divisor", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, SpeedParameters, TurningShaft], catches = [SpeedDivisorIgnored])]
fn divisor(bench: &mut Bench<'_>) -> Judged {
    let before = Course::measure(bench)?;
    let whole = signed(bench, SPEED)? as f64;
    bench.write(DIVISOR, &5_u16.to_le_bytes())?;
    bench.listen(Duration::from_millis(500))?;
    let course = |bench: &mut Bench<'_>| {
        let now = Course::measure(bench)?;
        let found = || format!("{:.0} and then {:.0} units per second", before.speed, now.speed);
        if now.is_shown_by(before.speed.abs()) { Ok(now) } else { Err(unmeasured(CONSTANT, found())) }
    };
    at_constant_speed(bench, SPEED, course, |_, part| {
        demand(is_like(part as f64 * 5.0, whole) || (part as f64 - whole / 5.0).abs() <= 1.0, || {
            let breach = Breach::new(SPEED, "6031h:04 = 5 divides the speed by 5");
            breach.expected(format!("{:.0}", whole / 5.0)).found(shown(part)).told(part.to_string())
        })
    })
}

/// The acceleration is 0 at constant speed.
#[case(id = "406/acceleration/constant-speed", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Acceleration, TurningShaft], catches = [AccelerationShowsSpeed])]
fn acceleration(bench: &mut Bench<'_>) -> Judged {
    zero_at_constant_speed(bench, ACCELERATION, "6040h is 0 at constant speed")
}

/// Judges that a derivative of the speed is zero at constant speed.
fn zero_at_constant_speed(bench: &mut Bench<'_>, value: Multiplexer, duty: &'static str) -> Judged {
    at_constant_speed(bench, value, Course::measure, |_, found| {
        demand(found.abs() <= 2, || Breach::new(value, duty).expected("0").found(shown(found)).told(found.to_string()))
    })
}

/// The jerk 6050h is 0 at constant speed, like the acceleration.
#[case(id = "406/jerk/constant-speed", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Jerk, TurningShaft], catches = [JerkShowsSpeed])]
fn jerk(bench: &mut Bench<'_>) -> Judged {
    const JERK: Multiplexer = Multiplexer::new(encoder::JERK_VALUE, 1);
    zero_at_constant_speed(bench, JERK, "6050h is 0 at constant speed")
}
