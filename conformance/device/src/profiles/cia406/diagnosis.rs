//! The encoder's own data: operating status (6500h), resolutions (6501h, 6502h), alarms (6503h, 6504h), warnings
//! (6505h, 6506h), versions (6507h), operating time (6508h), serial number (650Bh).

use super::Encoder;
use crate::Fault;
use crate::device::{ApplicationError, ApplicationErrors, Parameters};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::{makers, objects as encoder};
use canvass_analyzer::wire::emcy::{EmcyCode, ErrorRegister};
use canvass_traces::Timestamp;

/// The simulated temperature of the sensor in the unit of 2120h: degrees Celsius plus 64.
const TEMPERATURE: u8 = 0x56;

/// Position error: 6503h bit 0.
const POSITION_ERROR: u64 = 1 << 0;
/// Overspeed: 6505h bit 0.
const OVERSPEED: u64 = 1 << 0;
/// Temperature outside its limits: 6505h bit 14.
const TEMPERATURE_ERROR: u64 = 1 << 14;
/// A bit of 6503h and 6505h that no model supports.
const UNSUPPORTED: u64 = 1 << 3;
/// Unit of the operating time in nanoseconds: a tenth of an hour.
const OPERATING_TIME_UNIT: u64 = 360_000_000_000;

impl Encoder {
    pub(super) fn diagnosis_value(&self, now: Timestamp, at: Multiplexer, parameters: &Parameters) -> Option<u64> {
        match (at.index.0, at.sub.0) {
            (encoder::OPERATING_STATUS, 0) if self.firmware.has(Fault::OperatingStatusStuck) => None,
            (encoder::OPERATING_STATUS, 0) => parameters.number(encoder::OPERATING_PARAMETERS, 0),
            (encoder::SINGLE_TURN_RESOLUTION, 0) if self.firmware.has(Fault::SingleTurnResolutionFollowsScaling) => {
                parameters.number(encoder::UNITS_PER_REVOLUTION, 0)
            }
            (encoder::ALARMS, 0) => Some(self.alarms()),
            (encoder::WARNINGS, 0) => Some(self.warnings(now, parameters)),
            (encoder::OPERATING_TIME, 0) => Some(self.operating_time(now)),
            _ => None,
        }
    }

    /// The operating time in tenths of an hour.
    fn operating_time(&self, now: Timestamp) -> u64 {
        let seconds = now.nanos() / 1_000_000_000;
        match () {
            () if self.firmware.has(Fault::OperatingTimeBackwards) => 1_000_000_u64.saturating_sub(seconds),
            () if self.firmware.has(Fault::OperatingTimeInSeconds) => seconds,
            () => now.nanos() / OPERATING_TIME_UNIT,
        }
    }

    /// The alarms in 6503h.
    fn alarms(&self) -> u64 {
        let mut alarms = 0;
        if self.firmware.has(Fault::AlarmWithoutEmcy) {
            alarms |= POSITION_ERROR;
        }
        if self.firmware.has(Fault::UnsupportedAlarmSet) || self.firmware.has(Fault::ReservedAlarmBitSet) {
            alarms |= UNSUPPORTED;
        }
        alarms
    }

    /// The warnings in 6505h, limited to the warnings that 6506h supports.
    fn warnings(&self, now: Timestamp, parameters: &Parameters) -> u64 {
        let mut warnings = 0;
        if self.is_too_fast(now) {
            warnings |= OVERSPEED;
        }
        if self.firmware.has(Fault::WarningNotCleared) || self.is_too_hot(parameters) {
            warnings |= TEMPERATURE_ERROR;
        }
        if self.firmware.has(Fault::WarningNotSet) {
            warnings = 0;
        }
        warnings &= parameters.number_or_zero(encoder::SUPPORTED_WARNINGS, 0);
        if self.firmware.has(Fault::UnsupportedWarningSet) {
            warnings |= UNSUPPORTED;
        }
        warnings
    }

    /// The lowest and the highest temperature; `None` if the manufacturer has no objects for them.
    fn temperature_limits(&self, parameters: &Parameters) -> Option<(u8, u8)> {
        let [low, high] = makers::of(self.model.vendor()?)?.temperature_limits?;
        let limit = |at: Multiplexer| parameters.number(at.index.0, at.sub.0).map(|limit| limit as u8);
        limit(low).zip(limit(high))
    }

    /// Whether the temperature is outside its limits.
    fn is_too_hot(&self, parameters: &Parameters) -> bool {
        self.temperature_limits(parameters).is_some_and(|(low, high)| !(low..=high).contains(&TEMPERATURE))
    }

    /// The errors that an EMCY reports: a temperature outside its limits, overspeed (6505h bit 0), a position error
    /// (6503h bit 0).
    pub(super) fn find_errors(&self, now: Timestamp, parameters: &Parameters) -> ApplicationErrors {
        let temperature = self.temperature_limits(parameters).map(|(low, high)| {
            let outside = !(low..=high).contains(&TEMPERATURE) && !self.firmware.has(Fault::WarningWithoutEmcy);
            // Sensor error register, temperature, low and high threshold, sensor version.
            let manufacturer = [0x80, TEMPERATURE, low, high, 0x2E];
            (ApplicationError { number: 0, manufacturer, ..WARNING }, outside)
        });
        let supported = parameters.number_or_zero(encoder::SUPPORTED_WARNINGS, 0) & OVERSPEED != 0;
        let too_fast = (ApplicationError { number: 1, ..WARNING }, supported && self.is_too_fast(now));
        let wrong_position = (POSITION_WRONG, self.firmware.has(Fault::EmcyWithoutAlarm));
        [temperature, Some(too_fast), Some(wrong_position), None]
    }
}

/// EMCY 4200h: temperature outside its limits. The encoder goes on working.
const WARNING: ApplicationError =
    ApplicationError { number: 0, code: EmcyCode(0x4200), register: 0, manufacturer: [0; 5], behaviour: Some(2) };

/// EMCY 1000h with the profile's bit in the error register: position error.
const POSITION_WRONG: ApplicationError = ApplicationError {
    number: 2,
    code: EmcyCode::GENERIC,
    register: ErrorRegister::PROFILE.0,
    manufacturer: [0; 5],
    behaviour: None,
};
