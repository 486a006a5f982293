//! Operating parameters (6000h), measuring units per revolution (6001h) and total measuring range (6002h).

use super::Encoder;
use super::sheet::{EncoderKind, Measurement, NANOMETRES_PER_MILLIMETRE, UniversalScaling};
use crate::Fault;
use crate::device::Parameters;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::sdo::AbortCode;

/// Bit 0: counter-clockwise rotation counts up.
pub(super) const CODE_SEQUENCE: u64 = 1 << 0;
/// Bit 2: 6001h and 6002h are in use.
pub(super) const SCALING: u64 = 1 << 2;
/// Bit 12: the universal scaling function (V3.2) lets the position continue beyond the end of the physical range.
const UNIVERSAL_SCALING: u64 = 1 << 12;
/// Bit 14: the device enters operational by itself.
const START_IN_OPERATIONAL: u64 = 1 << 14;

/// Whether the device enters operational by itself.
pub(super) fn starts_in_operational(parameters: &Parameters) -> bool {
    parameters.number_or_zero(encoder::OPERATING_PARAMETERS, 0) & START_IN_OPERATIONAL != 0
}

impl Encoder {
    /// Checks a write to 6000h, 6001h or 6002h: no reserved bits, and a range of at least one revolution.
    pub(super) fn check_operating(
        &self,
        at: Multiplexer,
        value: u64,
        parameters: &Parameters,
    ) -> Result<(), AbortCode> {
        let refuses = !self.firmware.has(Fault::UnitsAboveRangeAccepted);
        let fits = match at.index.0 {
            encoder::OPERATING_PARAMETERS => {
                let reserved = value & !u64::from(self.sheet.operating_bits);
                (reserved == 0 || self.firmware.has(Fault::ReservedOperatingBitsAccepted))
                    && !self.firmware.has(Fault::OperatingParametersRefused)
            }
            encoder::UNITS_PER_REVOLUTION
                if value < parameters.number_or_zero(encoder::UNITS_PER_REVOLUTION, 0)
                    && self.firmware.has(Fault::UnitsFewerRefused) =>
            {
                false
            }
            encoder::UNITS_PER_REVOLUTION => {
                value <= units_of(parameters.number_or_zero(encoder::TOTAL_MEASURING_RANGE, 0)) || !refuses
            }
            encoder::TOTAL_MEASURING_RANGE
                if value < parameters.number_or_zero(encoder::TOTAL_MEASURING_RANGE, 0)
                    && self.firmware.has(Fault::RangeSmallerRefused) =>
            {
                false
            }
            _ => {
                let range = units_of(value);
                range >= self.sheet.units_per_revolution_least.into()
                    && (range >= parameters.number_or_zero(encoder::UNITS_PER_REVOLUTION, 0) || !refuses)
            }
        };
        if at.index.0 != encoder::OPERATING_PARAMETERS && self.firmware.has(Fault::ScalingRefused) {
            return Err(AbortCode::INVALID_VALUE);
        }
        if fits { Ok(()) } else { Err(AbortCode::INVALID_VALUE) }
    }

    /// The bits of 6000h that this firmware uses for the measurement.
    pub(super) fn operating(&self, parameters: &Parameters) -> u64 {
        let mut bits =
            parameters.number_or_zero(encoder::OPERATING_PARAMETERS, 0) & u64::from(self.sheet.operating_bits);
        if self.firmware.has(Fault::CodeSequenceIgnored) {
            bits &= !CODE_SEQUENCE;
        }
        if self.firmware.has(Fault::ScalingIgnored) {
            bits &= !SCALING;
        }
        if self.firmware.has(Fault::ScalingAlwaysOn) {
            bits |= SCALING;
        }
        bits
    }

    /// Whether 6000h reverses the direction of counting.
    pub(super) fn is_turned(&self, parameters: &Parameters) -> bool {
        self.operating(parameters) & CODE_SEQUENCE != 0
    }

    /// Whether 6001h and 6002h are in use.
    pub(super) fn is_scaled(&self, parameters: &Parameters) -> bool {
        self.operating(parameters) & SCALING != 0
    }

    /// Whether the position continues beyond the end of the physical range.
    pub(super) const fn goes_on(&self, operating: u64) -> bool {
        operating & SCALING != 0
            && match self.sheet.universal_scaling {
                UniversalScaling::ByBit12 => operating & UNIVERSAL_SCALING != 0,
                UniversalScaling::Always => true,
                UniversalScaling::Never => false,
            }
    }

    /// Whether the speed is in units per second instead of revolutions per minute.
    pub(super) fn speed_in_units(&self, parameters: &Parameters) -> bool {
        let bit = u32::from(self.sheet.speed_format_bit);
        let set = self.operating(parameters).checked_shr(bit).is_some_and(|bits| bits & 1 != 0);
        set && !self.firmware.has(Fault::SpeedFormatIgnored)
    }

    /// The number of positions: 6002h if scaling is on, else all physical positions that fit into 6004h.
    pub(super) fn range(&self, parameters: &Parameters) -> i128 {
        self.range_by(self.operating(parameters), parameters)
    }

    /// As [`Encoder::range`], for a value of 6000h that the caller has already read.
    pub(super) fn range_by(&self, operating: u64, parameters: &Parameters) -> i128 {
        if operating & SCALING == 0 {
            return physical_range(&self.sheet).min(FULL_RANGE);
        }
        let range = i128::from(units_of(parameters.number_or_zero(encoder::TOTAL_MEASURING_RANGE, 0)));
        if self.firmware.has(Fault::WrapAtPowerOfTwo) {
            return (range as u128).next_power_of_two() as i128;
        }
        range
    }
}

/// The number of positions that 32 bits can show.
const FULL_RANGE: i128 = 1 << 32;

/// The number of units in 6002h, where 0 means 2^32.
fn units_of(range: u64) -> u64 {
    if range == 0 { 1 << 32 } else { range }
}

/// The number of steps in one revolution.
pub(super) fn steps(sheet: &Measurement) -> u64 {
    1 << sheet.single_turn_bits.min(32)
}

/// The number of steps in the unit of motions: a revolution, or a millimetre of a linear encoder.
pub(super) fn steps_per_unit(sheet: &Measurement) -> u64 {
    match sheet.kind {
        EncoderKind::Linear => u64::from(NANOMETRES_PER_MILLIMETRE / sheet.step_nm.max(1)).max(1),
        _ => steps(sheet),
    }
}

/// The number of steps in all revolutions.
pub(super) fn physical_range(sheet: &Measurement) -> i128 {
    i128::from(steps(sheet)) * i128::from(sheet.revolutions.max(1))
}
