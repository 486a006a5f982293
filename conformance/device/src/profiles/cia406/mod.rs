//! The application of an encoder (CiA 406), one file for each family of its objects.
//!
//! ```text
//! shaft --> raw (2160h, 600Bh, 600Ch)
//!       --> position (6000h to 6004h, 6008h, 6009h, 6509h) --> work area (6400h), cams (6300h)
//!       --> speed (6030h) --> acceleration (6040h) --> jerk (6050h)
//! wire, tilt --> draw_wire (6020h, 5000h)
//! ```

mod cams;
mod checks;
mod description;
mod diagnosis;
mod draw_wire;
mod limit_switches;
mod operating;
mod overlay;
mod position;
mod raw;
mod sheet;
mod speed;
mod work_area;

pub use description::shows_limit_switches;

use crate::device::{Application, ApplicationErrors, Motion, Parameters, Profile, Registered, Surroundings};
use crate::models::Model;
use crate::{Fault, Firmware};
use cams::Cams;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::{NUMBER, objects as encoder};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Timestamp};
use operating::SCALING;
use sheet::{EncoderKind, Measurement};

/// Interval at which the speed of a turning shaft is compared with its limit.
const WATCH: Duration = Duration::from_millis(100);

/// The value of 6508h in a device that does not count its operating time.
const NOT_USED: u64 = 0xFFFF_FFFF;

/// The encoder profile.
struct Cia406;

inventory::submit! { Registered(&Cia406) }

impl Profile for Cia406 {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn application(&self, model: &Model, motion: &Motion, firmware: &Firmware) -> Option<Box<dyn Application>> {
        let sheet = *model.sheet().application.get::<Measurement>()?;
        let (model, motion, cams, firmware) = (model.clone(), motion.clone(), Cams::default(), *firmware);
        Some(Box::new(Encoder { sheet, model, motion, offset: 0, preset_at: None, cams, firmware }))
    }

    fn plant(&self, parameters: &mut Parameters, firmware: &Firmware) {
        overlay::plant(parameters, firmware);
    }
}

/// The application of an encoder.
#[derive(Clone, Debug)]
struct Encoder {
    sheet: Measurement,
    model: Model,
    motion: Motion,
    /// The offset that the preset adds to the position (6509h). For an inclinometer: the zero point, in hundredths of a
    /// degree.
    offset: i64,
    /// Time of the last write to 6003h.
    preset_at: Option<Timestamp>,
    cams: Cams,
    firmware: Firmware,
}

impl Application for Encoder {
    fn boxed_clone(&self) -> Box<dyn Application> {
        Box::new(self.clone())
    }

    fn value(&self, now: Timestamp, at: Multiplexer, device: &Surroundings<'_>) -> Option<u64> {
        let (quirks, parameters) = (&self.model.sheet().quirks, device.parameters);
        match (at.index.0, at.sub.0) {
            (encoder::OPERATING_STATUS, 0) if quirks.limit_switches => {
                let position = self.measured(now, POSITION, parameters)?;
                Some(limit_switches::operating_status(position, parameters, &self.firmware))
            }
            (encoder::SINGLE_TURN_RESOLUTION | encoder::NUMBER_OF_REVOLUTIONS, 0)
                if quirks.resolution_follows_scaling =>
            {
                scaled_resolution(at, parameters)
            }
            (encoder::ALARMS, 0) if quirks.limits_checked_at_store => {
                Some(if device.has_refused_parameter() { PARAMETER_ALARM } else { 0 })
            }
            (encoder::OPERATING_TIME, 0) if parameters.number(encoder::OPERATING_TIME, 0) == Some(NOT_USED) => None,
            _ => self.measured(now, at, parameters),
        }
    }

    fn process_value(&self, now: Timestamp, at: Multiplexer, again: bool, device: &Surroundings<'_>) -> Option<u64> {
        // In the PDO of a draw-wire encoder, the second occurrence of an object is the redundant channel.
        if again && self.sheet.kind == EncoderKind::DrawWire {
            return self.redundant_value(now, at, device.parameters);
        }
        let without_preset =
            at.index.0 == encoder::POSITION_VALUE && self.firmware.has(Fault::TpdoPositionWithoutPreset);
        without_preset.then(|| self.position_without_preset(now, device.parameters))
    }

    fn check(&self, at: Multiplexer, value: u64, device: &Surroundings<'_>) -> Result<(), AbortCode> {
        self.check_written(at, value, device.parameters)
    }

    fn overlooks_limits(&self, at: Multiplexer) -> bool {
        matches!(at.index.0, encoder::WORK_AREA_LOW_LIMIT | encoder::WORK_AREA_HIGH_LIMIT)
            && self.firmware.has(Fault::WorkAreaLimitsSwappedAccepted)
    }

    fn on_written(&mut self, now: Timestamp, at: Multiplexer, value: u64, device: &Surroundings<'_>) {
        match (at.index.0, at.sub.0) {
            (encoder::PRESET_VALUE | encoder::HIGH_PRECISION_PRESET, 0) => self.preset(now, value, device.parameters),
            (0x3010, 0) if self.sheet.kind == EncoderKind::DrawWire => self.set_zero_point(value),
            _ => {}
        }
    }

    fn wedges(&self, at: Multiplexer, value: u64) -> bool {
        at == Multiplexer::new(encoder::UNITS_PER_REVOLUTION, 0)
            && value == 0
            && self.firmware.has(Fault::UnitsZeroWedges)
    }

    fn resets(&self, at: Multiplexer, value: u64) -> &'static [u16] {
        let switches_off = at == OPERATING_PARAMETERS && value & SCALING == 0;
        match switches_off && self.model.sheet().quirks.scaling_bit_guards {
            true => &[encoder::UNITS_PER_REVOLUTION, encoder::TOTAL_MEASURING_RANGE],
            false => &[],
        }
    }

    fn breaks_link(&self, at: Multiplexer, value: Option<u64>) -> bool {
        let firmware = &self.firmware;
        match (at.index.0, value) {
            (encoder::CYCLIC_TIMER, Some(0)) if firmware.has(Fault::CyclicTimerNotStopped) => true,
            (encoder::CYCLIC_TIMER, Some(_)) => firmware.has(Fault::CyclicTimerNotLinked),
            (object::TPDO_COMMUNICATION_PARAMETER, Some(_)) => firmware.has(Fault::EventTimerNotInCyclicTimer),
            (encoder::SERIAL_NUMBER, None) => firmware.has(Fault::SerialNumberDiffers),
            (encoder::OPERATING_STATUS, None) => firmware.has(Fault::OperatingStatusStuck),
            _ => false,
        }
    }

    fn cyclic_timer(&self) -> Option<u16> {
        Some(encoder::CYCLIC_TIMER)
    }

    fn changes_tpdos(&self, at: Multiplexer) -> bool {
        at.index.0 == encoder::CYCLIC_TIMER && !self.firmware.has(Fault::CyclicTimerIdle)
    }

    fn set_motion(&mut self, motion: Motion) {
        self.motion = motion;
    }

    fn is_moving(&self) -> bool {
        !self.motion.is_still()
    }

    fn retained(&self) -> i64 {
        if self.firmware.has(Fault::PresetLostAfterSave) { 0 } else { self.offset }
    }

    fn restore(&mut self, retained: i64) {
        if !self.firmware.has(Fault::PresetPersists) {
            self.offset = retained;
        }
    }

    fn starts_in_operational(&self, device: &Surroundings<'_>) -> bool {
        operating::starts_in_operational(device.parameters)
    }

    fn watch(&self) -> Option<Duration> {
        (self.sheet.speed_warning_rpm.is_some() && self.is_moving()).then_some(WATCH)
    }

    fn errors(&self, now: Timestamp, device: &Surroundings<'_>) -> ApplicationErrors {
        self.find_errors(now, device.parameters)
    }
}

impl Encoder {
    /// The live value of an object of the profile; `None` for an object that is not measured.
    fn measured(&self, now: Timestamp, at: Multiplexer, parameters: &Parameters) -> Option<u64> {
        if self.sheet.kind == EncoderKind::DrawWire {
            return self.wire_value(now, at, parameters);
        }
        match at.index.0 {
            0x2160..=0x2162 | encoder::HIGH_RESOLUTION_RAW_VALUE | encoder::POSITION_RAW_VALUE => {
                self.raw_value(now, at)
            }
            encoder::POSITION_VALUE | encoder::HIGH_PRECISION_POSITION | encoder::OFFSET_VALUE => {
                self.position_value(now, at, parameters)
            }
            0x6030..=0x605F => self.speed_value(now, at, parameters),
            encoder::CAM_STATE => self.cam_state(now, at.sub.0, parameters),
            encoder::WORK_AREA_STATE => self.work_area(now, at.sub.0, parameters),
            0x6500..=0x650B => self.diagnosis_value(now, at, parameters),
            _ => None,
        }
    }
}

/// 6501h or 6502h while scaling is on: units per revolution, or the number of revolutions in the range.
fn scaled_resolution(at: Multiplexer, parameters: &Parameters) -> Option<u64> {
    let number = |index| parameters.number_or_zero(index, 0);
    if number(encoder::OPERATING_PARAMETERS) & SCALING == 0 {
        return None;
    }
    match at.index.0 {
        encoder::SINGLE_TURN_RESOLUTION => Some(number(encoder::UNITS_PER_REVOLUTION)),
        _ => number(encoder::TOTAL_MEASURING_RANGE).checked_div(number(encoder::UNITS_PER_REVOLUTION)),
    }
}

const POSITION: Multiplexer = Multiplexer::new(encoder::POSITION_VALUE, 0);
const OPERATING_PARAMETERS: Multiplexer = Multiplexer::new(encoder::OPERATING_PARAMETERS, 0);

/// 6503h bit 13: a parameter that was to be stored is outside its limits.
const PARAMETER_ALARM: u64 = 1 << 13;
