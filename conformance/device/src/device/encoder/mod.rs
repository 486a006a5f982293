//! The application of an encoder (CiA 406), one file for each family of its objects.
//!
//! ```text
//! shaft --> raw (2160h, 600Bh, 600Ch)
//!       --> position (6000h to 6004h, 6008h, 6009h, 6509h) --> work area (6400h), cams (6300h)
//!       --> speed (6030h) --> acceleration (6040h) --> jerk (6050h)
//! wire, tilt --> draw_wire (6020h, 5000h)
//! ```

mod cams;
mod diagnosis;
mod draw_wire;
mod operating;
mod position;
mod raw;
mod speed;
mod work_area;

pub(super) use diagnosis::TEMPERATURE;

use super::motion::Motion;
use super::parameters::Parameters;
use crate::models::{self, EncoderKind, Model};
use crate::{Fault, Firmware};
use cams::Cams;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object::encoder;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::Timestamp;

/// The vendor-ID of Kübler.
const KUEBLER: u32 = 0x13;

#[derive(Clone, Debug)]
pub(super) struct Encoder {
    sheet: models::Encoder,
    motion: Motion,
    /// The offset that the preset adds to the position (6509h); for an inclinometer the zero point, in hundredths of
    /// a degree.
    offset: i64,
    /// Time of the last write to 6003h.
    preset_at: Option<Timestamp>,
    cams: Cams,
    firmware: Firmware,
    /// Whether manufacturer-specific objects are those of Kübler.
    is_of_kuebler: bool,
}

impl Encoder {
    /// The encoder of a model, if it is one.
    pub fn new(model: &Model, motion: Motion, firmware: &Firmware) -> Option<Self> {
        let sheet = model.sheet().encoder?;
        let is_of_kuebler = model.vendor() == Some(KUEBLER);
        let cams = Cams::default();
        Some(Self { sheet, motion, offset: 0, preset_at: None, cams, firmware: *firmware, is_of_kuebler })
    }

    /// Sets the motion of the shaft from now on.
    pub fn set_motion(&mut self, motion: Motion) {
        self.motion = motion;
    }

    /// The motion of the shaft.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// The offset, which is stored besides the parameters.
    pub fn offset(&self) -> i64 {
        if self.firmware.has(Fault::PresetLostAfterSave) { 0 } else { self.offset }
    }

    /// Takes a stored offset over.
    pub fn set_offset(&mut self, offset: i64) {
        if !self.firmware.has(Fault::PresetPersists) {
            self.offset = offset;
        }
    }

    /// The live value of an object; `None` for an object that is not measured.
    pub fn value(&self, now: Timestamp, at: Multiplexer, parameters: &Parameters) -> Option<u64> {
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

    /// The value of an object in a PDO, if it differs from [`Encoder::value`]: `again` if the PDO has the object a
    /// second time.
    pub fn process_value(&self, now: Timestamp, at: Multiplexer, again: bool, parameters: &Parameters) -> Option<u64> {
        if again && self.sheet.kind == EncoderKind::DrawWire {
            return self.redundant_value(now, at, parameters);
        }
        let without_preset =
            at.index.0 == encoder::POSITION_VALUE && self.firmware.has(Fault::TpdoPositionWithoutPreset);
        without_preset.then(|| self.position_without_preset(now, parameters))
    }

    /// Checks a write beyond the limits of the device description.
    ///
    /// # Errors
    /// The abort code for a value that is inconsistent with others.
    pub fn check(&self, at: Multiplexer, value: u64, parameters: &Parameters) -> Result<(), AbortCode> {
        match at.index.0 {
            0x6000..=0x6002 => self.check_operating(at, value, parameters),
            encoder::PRESET_VALUE | encoder::HIGH_PRECISION_PRESET => self.check_preset(value, parameters),
            _ => Ok(()),
        }
    }

    /// Handles the effects of a write besides the new value.
    pub fn on_written(&mut self, now: Timestamp, at: Multiplexer, value: u64, parameters: &Parameters) {
        match (at.index.0, at.sub.0) {
            (encoder::PRESET_VALUE | encoder::HIGH_PRECISION_PRESET, 0) => self.preset(now, value, parameters),
            (0x3010, 0) if self.sheet.kind == EncoderKind::DrawWire => self.set_zero_point(value),
            _ => {}
        }
    }

    /// Whether writing the object makes the firmware hang.
    pub fn wedges(&self, at: Multiplexer, value: u64) -> bool {
        at == Multiplexer::new(encoder::UNITS_PER_REVOLUTION, 0)
            && value == 0
            && self.firmware.has(Fault::UnitsZeroWedges)
    }
}
