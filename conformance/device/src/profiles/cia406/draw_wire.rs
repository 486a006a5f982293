//! Draw-wire encoder with inclinometer: two redundant channels of the position (6020h, in 0.1 mm), two angles (5000h,
//! in 0.01 degrees), and the settings of the angles (3003h, 3004h, 3005h, 3010h).
//!
//! Channel B is the full scale less channel A, so that the sum of both is constant. Angle Z2 is the opposite of Z1, or
//! equal to it.

use super::Encoder;
use crate::Fault;
use crate::device::Parameters;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_traces::Timestamp;

/// Units of the position in a millimetre of wire.
const TENTHS_PER_MILLIMETRE: u64 = 10;
/// 360 degrees, in 0.01 degrees.
const FULL_TURN: i64 = 36_000;
/// 3003h: clockwise rotation counts up.
const CLOCKWISE: u64 = 1;
/// 3004h: the range is -180 to 180 degrees instead of 0 to 360.
const SIGNED: u64 = 1;
/// 3005h: Z2 runs opposite to Z1.
const OPPOSITE: u64 = 1;
/// Nanoseconds in which the faulty channel B gains 0.1 mm.
const DRIFT: u64 = 20_000_000;

impl Encoder {
    pub(super) fn wire_value(&self, now: Timestamp, at: Multiplexer, parameters: &Parameters) -> Option<u64> {
        match (at.index.0, at.sub.0) {
            (encoder::CHANNEL_POSITION_VALUES, 0) => Some(self.length(now)),
            (0x5000, 0) => Some(self.angle(parameters)),
            _ => None,
        }
    }

    /// The value of the redundant channel: channel B or angle Z2.
    pub(super) fn redundant_value(&self, now: Timestamp, at: Multiplexer, parameters: &Parameters) -> Option<u64> {
        match (at.index.0, at.sub.0) {
            (encoder::CHANNEL_POSITION_VALUES, 0) => Some(self.redundant_length(now)),
            (0x5000, 0) => Some(self.redundant_angle(parameters)),
            _ => None,
        }
    }

    /// The length of the extended wire in 0.1 mm, limited to the wire's range.
    fn length(&self, now: Timestamp) -> u64 {
        let full_scale = i128::from(self.sheet.full_scale_tenth_mm);
        let per_revolution = u64::from(self.sheet.tenth_mm_per_revolution);
        let per_unit = if self.motion.is_in_millimetres() { TENTHS_PER_MILLIMETRE } else { per_revolution };
        self.motion.position(now, per_unit).clamp(0, full_scale) as u64
    }

    fn redundant_length(&self, now: Timestamp) -> u64 {
        let length = self.length(now);
        if self.firmware.has(Fault::RedundantChannelNotNegated) {
            return length;
        }
        let drift = if self.firmware.has(Fault::RedundantChannelDrift) { now.nanos() / DRIFT } else { 0 };
        u64::from(self.sheet.full_scale_tenth_mm) - length + drift
    }

    /// The angle of the first inclinometer channel (Z1).
    fn angle(&self, parameters: &Parameters) -> u64 {
        self.shown(self.tilt(parameters), parameters)
    }

    /// The angle of the redundant inclinometer channel (Z2).
    fn redundant_angle(&self, parameters: &Parameters) -> u64 {
        let tilt = self.tilt(parameters);
        let opposite =
            parameters.number_or_zero(0x3005, 0) == OPPOSITE && !self.firmware.has(Fault::RedundantAngleSame);
        self.shown(if opposite { -tilt } else { tilt }, parameters)
    }

    /// The angle from the zero point, in the direction of 3003h.
    fn tilt(&self, parameters: &Parameters) -> i64 {
        let tilt = i64::from(self.sheet.tilt_hundredths) - self.offset;
        let clockwise = parameters.number_or_zero(0x3003, 0) == CLOCKWISE;
        if clockwise || self.firmware.has(Fault::AngleDirectionIgnored) { tilt } else { -tilt }
    }

    /// Converts an angle to the range of 3004h.
    fn shown(&self, angle: i64, parameters: &Parameters) -> u64 {
        let signed = parameters.number_or_zero(0x3004, 0) == SIGNED && !self.firmware.has(Fault::AngleRangeIgnored);
        let turn = angle.rem_euclid(FULL_TURN);
        let angle = if signed && turn >= FULL_TURN / 2 { turn - FULL_TURN } else { turn };
        u64::from(angle as u16)
    }

    /// Handles a write to 3010h: 1 makes the current angle zero, 0 removes this zero point.
    pub(super) fn set_zero_point(&mut self, value: u64) {
        if !self.firmware.has(Fault::ZeroPointIgnored) {
            self.offset = if value == 0 { 0 } else { i64::from(self.sheet.tilt_hundredths) };
        }
    }
}
