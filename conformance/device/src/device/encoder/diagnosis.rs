//! The encoder's own data: operating status (6500h), resolutions (6501h, 6502h), alarms (6503h, 6504h), warnings
//! (6505h, 6506h), versions (6507h), operating time (6508h), serial number (650Bh).

use super::Encoder;
use crate::Fault;
use crate::device::parameters::Parameters;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object::encoder;
use canvass_traces::Timestamp;

/// The temperature of the sensor in the unit of 2120h: degrees Celsius plus 64.
pub(in crate::device) const TEMPERATURE: u8 = 0x56;

/// 6503h bit 0.
const POSITION_ERROR: u64 = 1 << 0;
/// 6505h bit 0.
const OVERSPEED: u64 = 1 << 0;
/// 6505h bit 14.
const TEMPERATURE_ERROR: u64 = 1 << 14;
/// A bit of 6503h and 6505h that no Sendix supports.
const UNSUPPORTED: u64 = 1 << 3;
/// A tenth of an hour.
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

    /// 6503h.
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

    /// 6505h, limited to the warnings that 6506h supports.
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

    /// The temperature limits in 2120h, which is an object of Kübler's encoders; other manufacturers use it
    /// differently.
    pub fn temperature_limits(&self, parameters: &Parameters) -> Option<(u8, u8)> {
        let limit = |sub| parameters.number(0x2120, sub).map(|limit| limit as u8);
        limit(2).zip(limit(3)).filter(|_| self.is_of_kuebler)
    }

    /// Whether the temperature is outside its limits.
    fn is_too_hot(&self, parameters: &Parameters) -> bool {
        self.temperature_limits(parameters).is_some_and(|(low, high)| !(low..=high).contains(&TEMPERATURE))
    }

    /// Whether 6505h bit 0 is set, which an EMCY reports.
    pub fn is_overspeed(&self, now: Timestamp, parameters: &Parameters) -> bool {
        self.is_too_fast(now) && parameters.number_or_zero(encoder::SUPPORTED_WARNINGS, 0) & OVERSPEED != 0
    }

    /// Whether a position error is reported by an EMCY.
    pub fn has_position_error(&self) -> bool {
        self.firmware.has(Fault::EmcyWithoutAlarm)
    }
}
