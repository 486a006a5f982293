//! The measurement of a rotary encoder (CiA 406): from the shaft to 6004h.
//!
//! ```text
//! physical --code sequence, scaling--> position in measuring units --+ 6509h--> 6004h
//! ```

use super::motion::Motion;
use super::parameters::Parameters;
use crate::models::{self, Model};
use crate::{Fault, Faults};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::Timestamp;

/// The bits of 6000h.
mod operating {
    /// Counts upwards for counter-clockwise rotation.
    pub const CODE_SEQUENCE: u64 = 1 << 0;
    pub const SCALING: u64 = 1 << 2;
    /// Universal scaling function: the position goes on over the end of the physical range.
    pub const UNIVERSAL_SCALING: u64 = 1 << 12;
    /// Speed in units per second instead of revolutions per minute.
    pub const SPEED_FORMAT: u64 = 1 << 13;
    pub const START_IN_OPERATIONAL: u64 = 1 << 14;
}

/// 6505h bit 0.
const OVERSPEED: u64 = 1 << 0;

/// A rotary encoder.
#[derive(Clone, Debug)]
pub(super) struct Encoder {
    sheet: models::Encoder,
    motion: Motion,
    /// 6509h: what the preset adds to the position.
    offset: i64,
    /// The bits of 6000h that the measurement knows.
    operating_bits: u64,
    faults: Faults,
}

impl Encoder {
    /// The encoder of that model, if it is one.
    pub fn new(model: &Model, motion: Motion, faults: Faults) -> Option<Self> {
        let sheet = model.sheet().encoder?;
        // Of a model that names its own bits, those of the manufacturer are not part of the measurement.
        let own_bits = model.sheet().quirks.operating_bits.is_some();
        let operating_bits = if own_bits { operating::CODE_SEQUENCE | operating::SCALING } else { OPERATING_BITS };
        Some(Self { sheet, motion, offset: 0, operating_bits, faults })
    }

    /// How the shaft moves from now on.
    pub fn set_motion(&mut self, motion: Motion) {
        self.motion = motion;
    }

    /// How the shaft moves.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// What is to be stored beside the parameters.
    pub fn offset(&self) -> i64 {
        self.offset
    }

    /// Takes a stored offset over.
    pub fn set_offset(&mut self, offset: i64) {
        self.offset = offset;
    }

    /// The live value of an object, `None` if it is not one of the measurement.
    pub fn value(&self, now: Timestamp, at: Multiplexer, parameters: &Parameters) -> Option<u64> {
        Some(match (at.index.0, at.sub.0) {
            (0x6004, 0) => self.position(now, parameters),
            (0x6030, 1) => self.speed(now, parameters) as u64,
            (0x6040 | 0x6050, 1) => 0,
            (0x6400, sub @ 1..) => self.work_area(now, sub, parameters)?,
            (0x6500, 0) if self.faults.has(Fault::OperatingStatusStuck) => return None,
            (0x6500, 0) => parameters.number_or_zero(0x6000, 0),
            (0x6505, 0) => self.warnings(now),
            (0x6509, 0) => self.offset as u64,
            // In tenths of an hour (CiA 406).
            (0x6508, 0) => now.nanos() / 360_000_000_000,
            _ => return None,
        })
    }

    /// Whether the device goes to operational by itself.
    pub fn starts_in_operational(parameters: &Parameters) -> bool {
        parameters.number_or_zero(0x6000, 0) & operating::START_IN_OPERATIONAL != 0
    }

    /// The conditions of a write beyond the limits of the device description.
    ///
    /// # Errors
    /// The abort code for a value that does not go with the others.
    pub fn check(at: Multiplexer, value: u64, parameters: &Parameters) -> Result<(), AbortCode> {
        let range = |total: u64| if total == 0 { 1 << 32 } else { total };
        let fits = match at.index.0 {
            0x6000 => value & !OPERATING_BITS == 0,
            0x6001 => value <= range(parameters.number_or_zero(0x6002, 0)),
            0x6002 => range(value) >= parameters.number_or_zero(0x6001, 0),
            _ => true,
        };
        if fits { Ok(()) } else { Err(AbortCode::INVALID_VALUE) }
    }

    /// As [`Encoder::check`], for 6003h, whose range follows from scaling.
    ///
    /// # Errors
    /// The abort code for a preset outside the active range.
    pub fn check_preset(&self, value: u64, parameters: &Parameters) -> Result<(), AbortCode> {
        let fits = i128::from(value) < self.range(parameters) || self.faults.has(Fault::PresetOutOfRangeAccepted);
        if fits { Ok(()) } else { Err(AbortCode::INVALID_VALUE) }
    }

    /// 6003h was written: the position takes that value now.
    pub fn preset(&mut self, now: Timestamp, value: u64, parameters: &Parameters) {
        if !self.faults.has(Fault::PresetIgnored) {
            self.offset = (i128::from(value) - self.scaled(now, parameters)) as i64;
        }
    }

    fn position(&self, now: Timestamp, parameters: &Parameters) -> u64 {
        let position = self.scaled(now, parameters) + i128::from(self.offset);
        position.rem_euclid(self.range(parameters)) as u64
    }

    /// The position in measuring units, before the offset.
    fn scaled(&self, now: Timestamp, parameters: &Parameters) -> i128 {
        let operating = self.operating(parameters);
        let range = self.range(parameters);
        let mut physical = self.motion.position(now, self.steps());
        if operating & (operating::SCALING | operating::UNIVERSAL_SCALING)
            != operating::SCALING | operating::UNIVERSAL_SCALING
        {
            physical = physical.rem_euclid(self.physical_range());
        }
        let scaled = match operating & operating::SCALING {
            0 => physical,
            _ => (physical * i128::from(parameters.number_or_zero(0x6001, 0))).div_euclid(i128::from(self.steps())),
        };
        let counted = if operating & operating::CODE_SEQUENCE == 0 { scaled } else { -scaled };
        counted.rem_euclid(range)
    }

    /// How many positions there are: 6002h where scaling is on, else all physical ones.
    fn range(&self, parameters: &Parameters) -> i128 {
        match (self.operating(parameters) & operating::SCALING, parameters.number_or_zero(0x6002, 0)) {
            (0, _) => self.physical_range(),
            (_, 0) => 1 << 32,
            (_, range) => i128::from(range),
        }
    }

    /// 6000h, as the measurement uses it.
    fn operating(&self, parameters: &Parameters) -> u64 {
        let mut bits = parameters.number_or_zero(0x6000, 0) & self.operating_bits;
        if self.faults.has(Fault::CodeSequenceIgnored) {
            bits &= !operating::CODE_SEQUENCE;
        }
        if self.faults.has(Fault::ScalingIgnored) {
            bits &= !operating::SCALING;
        }
        if self.faults.has(Fault::ScalingAlwaysOn) {
            bits |= operating::SCALING;
        }
        bits
    }

    fn steps(&self) -> u64 {
        1 << self.sheet.single_turn_bits.min(32)
    }

    fn physical_range(&self) -> i128 {
        i128::from(self.steps()) * i128::from(self.sheet.revolutions.max(1))
    }

    /// 6030h, with the sign of the direction in which the position counts.
    fn speed(&self, now: Timestamp, parameters: &Parameters) -> i64 {
        let operating = self.operating(parameters);
        let milli_rpm = match operating & operating::CODE_SEQUENCE {
            0 => self.motion.milli_rpm(now),
            _ => -self.motion.milli_rpm(now),
        };
        let speed = if operating & operating::SPEED_FORMAT == 0 {
            i128::from(milli_rpm) / 1_000
        } else {
            let units = i128::from(parameters.number_or_zero(0x6001, 0));
            let factor = i128::from(parameters.number(0x2130, 1).unwrap_or(1));
            let divisor = i128::from(parameters.number(0x2130, 2).unwrap_or(1)).max(1);
            i128::from(milli_rpm) * units * factor / divisor / 60_000
        };
        let wide = parameters.entry(Multiplexer::new(0x6030, 1)).is_ok_and(|entry| entry.size() == Some(4));
        let (low, high) = if wide { (i32::MIN.into(), i32::MAX.into()) } else { (i16::MIN.into(), i16::MAX.into()) };
        speed.clamp(low, high) as i64
    }

    /// 6400h: bit 0 out of range, bit 1 overflow, bit 2 underflow.
    fn work_area(&self, now: Timestamp, sub: u8, parameters: &Parameters) -> Option<u64> {
        let (low, high) = (parameters.number(0x6401, sub)?, parameters.number(0x6402, sub)?);
        let position = self.position(now, parameters);
        let (over, under) = (position > high, position < low);
        Some(u64::from(over || under) | u64::from(over) << 1 | u64::from(under) << 2)
    }

    /// 6505h.
    pub fn warnings(&self, now: Timestamp) -> u64 {
        let limit = self.sheet.speed_warning_rpm.map(|rpm| u64::from(rpm) * 1_000);
        if limit.is_some_and(|limit| self.motion.milli_rpm(now).unsigned_abs() > limit) { OVERSPEED } else { 0 }
    }
}

/// All bits of 6000h that have a meaning in CiA 406 or in the manual; the others are reserved.
const OPERATING_BITS: u64 = 0xF00F;
