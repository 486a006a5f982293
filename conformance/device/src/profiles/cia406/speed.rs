//! Speed (6030h, 6031h, 2130h), acceleration (6040h, 6041h) and jerk (6050h): the changes of position, speed and
//! acceleration within an integration time.
//!
//! The unit of speed is revolutions per minute or measuring units per second, as 6000h says. Acceleration is the change
//! of this speed per second, jerk per square second. 6031h:03 and :04 (6041h) are a multiplier and a divisor, for
//! example for a gear. In devices with 2130h, 2130h:01 and 2130h:02 take the place of multiplier and divisor, but only
//! while the unit is measuring units per second.

use super::Encoder;
use super::operating::steps_per_unit;
use crate::Fault;
use crate::device::Parameters;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_traces::{Duration, Timestamp};

/// Parts of a revolution in which changes of position are calculated: far finer than the resolution of the position.
const PARTS: u64 = 1 << 32;
/// Parts of a unit in which speeds are calculated, so that their differences are exact enough.
const FINE: i128 = 1_000_000;
/// The integration time, if no object sets one.
const INTEGRATION_TIME: Duration = Duration::from_millis(100);
const NANOSECONDS: i128 = 1_000_000_000;
/// 6031h:01: the speed follows the raw position, in physical steps. Otherwise it follows 6004h, in measuring units.
const RAW_POSITION: u64 = 2;

impl Encoder {
    pub(super) fn speed_value(&self, now: Timestamp, at: Multiplexer, parameters: &Parameters) -> Option<u64> {
        let fine = match (at.index.0, at.sub.0) {
            (encoder::SPEED_VALUE, 1) => self.shown_speed(now, parameters),
            (encoder::ACCELERATION_VALUE, 1) if self.firmware.has(Fault::AccelerationShowsSpeed) => {
                self.shown_speed(now, parameters)
            }
            (encoder::ACCELERATION_VALUE, 1) => self.acceleration(now, parameters),
            (encoder::JERK_VALUE, 1) if self.firmware.has(Fault::JerkShowsSpeed) => self.shown_speed(now, parameters),
            (encoder::JERK_VALUE, 1) => self.jerk(now, parameters),
            _ => return None,
        };
        let wide = parameters.entry(at).is_ok_and(|entry| entry.size() == Some(4));
        let (low, high) = if wide { (i32::MIN.into(), i32::MAX.into()) } else { (i16::MIN.into(), i16::MAX.into()) };
        Some(rounded(fine, FINE).clamp(low, high) as i64 as u64)
    }

    /// The speed that 6030h shows, in parts of its unit.
    fn shown_speed(&self, now: Timestamp, parameters: &Parameters) -> i128 {
        let mut speed = self.speed(now, parameters);
        if self.firmware.has(Fault::SpeedSignIgnoresCodeSequence) && self.is_turned(parameters) {
            speed = -speed;
        }
        if self.firmware.has(Fault::SpeedTenfold) {
            speed *= 10;
        }
        if self.firmware.has(Fault::SpeedNotZeroAtRest) { speed + 50 * FINE } else { speed }
    }

    /// The speed in parts of its unit; its sign is the direction of counting.
    fn speed(&self, now: Timestamp, parameters: &Parameters) -> i128 {
        let (time, multiplier, divisor) = self.averaging(encoder::SPEED_PARAMETER, parameters);
        let (parts, nanoseconds) = self.turned(now, time);
        let units = self.speed_in_units(parameters);
        // 2130h affects only the speed in units per second.
        let (multiplier, divisor) = match parameters.number(0x2130, 1) {
            Some(factor) if units => (i128::from(factor), nonzero(parameters.number(0x2130, 2))),
            _ => (multiplier, divisor),
        };
        let per_revolution = match units {
            true => i128::from(self.units_per_revolution(parameters)),
            // One minute in seconds.
            false => 60,
        };
        let sign = if self.is_turned(parameters) { -1 } else { 1 };
        let sign = if sign < 0 && self.firmware.has(Fault::SpeedDoubledBackwards) { sign * 2 } else { sign };
        let numerator = sign * parts * per_revolution * multiplier;
        // `parts / PARTS` revolutions were made in `nanoseconds`.
        let exact = numerator.saturating_mul(FINE) / (i128::from(PARTS) * divisor);
        exact.saturating_mul(NANOSECONDS) / nanoseconds
    }

    fn units_per_revolution(&self, parameters: &Parameters) -> u64 {
        let raw = parameters.number(encoder::SPEED_PARAMETER, 1) == Some(RAW_POSITION) || !self.is_scaled(parameters);
        if raw || self.firmware.has(Fault::SpeedInPhysicalSteps) {
            steps_per_unit(&self.sheet)
        } else {
            parameters.number_or_zero(encoder::UNITS_PER_REVOLUTION, 0)
        }
    }

    /// The acceleration: the change of speed, in parts of its unit per second.
    fn acceleration(&self, now: Timestamp, parameters: &Parameters) -> i128 {
        let (time, multiplier, divisor) = self.averaging(encoder::ACCELERATION_PARAMETER, parameters);
        let (before, nanoseconds) = window(now, time);
        let change = self.speed(now, parameters) - self.speed(before, parameters);
        change.saturating_mul(NANOSECONDS * multiplier) / (nanoseconds * divisor)
    }

    fn jerk(&self, now: Timestamp, parameters: &Parameters) -> i128 {
        let (before, nanoseconds) = window(now, INTEGRATION_TIME);
        let change = self.acceleration(now, parameters) - self.acceleration(before, parameters);
        change.saturating_mul(NANOSECONDS) / nanoseconds
    }

    /// Integration time, multiplier and divisor of 6031h or 6041h.
    fn averaging(&self, index: u16, parameters: &Parameters) -> (Duration, i128, i128) {
        let time = parameters.number(index, 2).map_or(INTEGRATION_TIME, Duration::from_millis);
        let multiplier = nonzero(parameters.number(index, 3));
        let divisor = match self.firmware.has(Fault::SpeedDivisorIgnored) {
            true => 1,
            false => nonzero(parameters.number(index, 4)),
        };
        (time.max(Duration::from_millis(1)), multiplier, divisor)
    }

    /// The rotation of the shaft in the last `time`, in parts of a revolution, and that time in nanoseconds.
    fn turned(&self, now: Timestamp, time: Duration) -> (i128, i128) {
        let (before, nanoseconds) = window(now, time);
        (self.motion.position(now, PARTS) - self.motion.position(before, PARTS), nanoseconds)
    }

    /// Whether the shaft turns faster than its limit (6505h bit 0).
    pub(crate) fn is_too_fast(&self, now: Timestamp) -> bool {
        let Some(limit) = self.sheet.speed_warning_rpm else { return false };
        let (parts, nanoseconds) = self.turned(now, INTEGRATION_TIME);
        // Both positions are rounded down, so a difference of one part may be no movement.
        let turned = (parts.abs() - 1).saturating_mul(60 * NANOSECONDS);
        turned > i128::from(limit) * i128::from(PARTS) * nanoseconds
    }
}

/// The begin of the window that ends now and lasts `time`, but not before power-on; and its length in nanoseconds.
fn window(now: Timestamp, time: Duration) -> (Timestamp, i128) {
    let before = Timestamp(now.nanos().saturating_sub(time.nanos()));
    (before, i128::from(now.since(before).nanos()).max(1))
}

/// A factor or divisor; 1 if the object does not exist or is 0.
fn nonzero(number: Option<u64>) -> i128 {
    i128::from(number.unwrap_or(1).max(1))
}

/// Divides and rounds to the nearest integer.
fn rounded(value: i128, by: i128) -> i128 {
    (value.saturating_mul(2).saturating_add(by)).div_euclid(2 * by)
}
