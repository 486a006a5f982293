//! Position value (6004h), preset (6003h) and offset (6509h); and the high-precision position and preset (6008h,
//! 6009h), which are equal to 6004h and 6003h for a sensor of at most 32 bits.
//!
//! ```text
//! physical --code sequence, scaling--> position in measuring units --+ 6509h--> 6004h
//! ```

use super::Encoder;
use super::operating::{CODE_SEQUENCE, SCALING, physical_range, steps, steps_per_unit};
use crate::Fault;
use crate::device::Parameters;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Timestamp};

/// Time for which a faulty firmware shows a wrong position after a preset.
const GLITCH: Duration = Duration::from_millis(30);
/// Time for which the position stands still after a preset, in a faulty firmware.
const STANDSTILL: Duration = Duration::from_millis(400);

impl Encoder {
    pub(super) fn position_value(&self, now: Timestamp, at: Multiplexer, parameters: &Parameters) -> Option<u64> {
        match (at.index.0, at.sub.0) {
            (encoder::POSITION_VALUE, 0) if self.is_glitching(now) => {
                Some(self.position_without_preset(now, parameters))
            }
            (encoder::POSITION_VALUE, 0) => Some(self.position(self.counted_until(now), parameters)),
            (encoder::HIGH_PRECISION_POSITION, 0) if self.firmware.has(Fault::HighPrecisionWithoutPreset) => {
                Some(self.position_without_preset(now, parameters))
            }
            (encoder::HIGH_PRECISION_POSITION, 0) => Some(self.position(now, parameters)),
            (encoder::OFFSET_VALUE, 0) if self.firmware.has(Fault::OffsetNotReported) => Some(0),
            (encoder::OFFSET_VALUE, 0) if self.firmware.has(Fault::OffsetSignWrong) => {
                Some(self.offset.wrapping_neg() as u64)
            }
            (encoder::OFFSET_VALUE, 0) => Some(self.offset as u64),
            _ => None,
        }
    }

    /// Time up to which a faulty firmware has updated the position; `now` without the fault.
    fn counted_until(&self, now: Timestamp) -> Timestamp {
        let stands = self.preset_at.filter(|_| self.firmware.has(Fault::PresetStopsCounting));
        stands.filter(|&at| now.since(at) < STANDSTILL).unwrap_or(now)
    }

    fn is_glitching(&self, now: Timestamp) -> bool {
        self.firmware.has(Fault::PresetGlitch) && self.preset_at.is_some_and(|at| now.since(at) < GLITCH)
    }

    /// Checks that a preset is a position that the encoder can show.
    pub(super) fn check_preset(&self, value: u64, parameters: &Parameters) -> Result<(), AbortCode> {
        let fits = i128::from(value) < self.range(parameters) || self.firmware.has(Fault::PresetOutOfRangeAccepted);
        if fits { Ok(()) } else { Err(AbortCode::INVALID_VALUE) }
    }

    /// Handles a write to 6003h: the position becomes this value now.
    pub(super) fn preset(&mut self, now: Timestamp, value: u64, parameters: &Parameters) {
        if !self.firmware.has(Fault::PresetIgnored) {
            self.offset = (i128::from(value) - self.scaled(now, parameters)) as i64;
            self.preset_at = Some(now);
        }
    }

    /// The value of 6004h.
    pub(super) fn position(&self, now: Timestamp, parameters: &Parameters) -> u64 {
        if self.firmware.has(Fault::RangeZeroStops) && self.has_full_range(parameters) {
            return 0;
        }
        let operating = self.operating(parameters);
        let position = self.scaled_by(operating, now, parameters) + i128::from(self.offset);
        wrapped(position, self.range_by(operating, parameters)) as u64
    }

    fn has_full_range(&self, parameters: &Parameters) -> bool {
        self.is_scaled(parameters) && parameters.number(encoder::TOTAL_MEASURING_RANGE, 0) == Some(0)
    }

    /// The value that 6004h would have without any preset.
    pub(super) fn position_without_preset(&self, now: Timestamp, parameters: &Parameters) -> u64 {
        self.scaled(now, parameters) as u64
    }

    /// The position in measuring units, before the offset.
    fn scaled(&self, now: Timestamp, parameters: &Parameters) -> i128 {
        self.scaled_by(self.operating(parameters), now, parameters)
    }

    /// As [`Encoder::scaled`], for a value of 6000h that the caller has already read.
    fn scaled_by(&self, operating: u64, now: Timestamp, parameters: &Parameters) -> i128 {
        let mut physical = self.motion.position(now, steps_per_unit(&self.sheet));
        if operating & CODE_SEQUENCE != 0 {
            physical = -physical;
        }
        if !self.goes_on(operating) {
            physical = wrapped(physical, physical_range(&self.sheet));
        }
        let range = self.range_by(operating, parameters);
        if operating & SCALING == 0 {
            return wrapped(physical, range);
        }
        let mut product = physical * i128::from(parameters.number_or_zero(encoder::UNITS_PER_REVOLUTION, 0));
        if self.firmware.has(Fault::ScalingOverflow) {
            product = i128::from(product as u32);
        }
        if self.firmware.has(Fault::ScaledPositionStands) {
            return 0;
        }
        // The number of steps per revolution is a power of two, so the shift divides by it, rounding down.
        wrapped(product >> steps(&self.sheet).trailing_zeros(), range)
    }
}

/// The remainder of `position` by `range`, never negative. Nearly all positions fit into 64 bits, where a division is
/// much faster.
fn wrapped(position: i128, range: i128) -> i128 {
    match (i64::try_from(position), i64::try_from(range)) {
        (Ok(position), Ok(range)) => position.rem_euclid(range).into(),
        _ => position.rem_euclid(range),
    }
}
