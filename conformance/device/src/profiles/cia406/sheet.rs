//! The measurement of an encoder: the table `[application]` of its sheet.

use super::description::describe;
use crate::models::{ApplicationSheet, ProfileSheet, RegisteredSheet};
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::profiles::cia406::NUMBER;
use serde::Deserialize;
use serde::de::IgnoredAny as ForPeople;
use toml::Table;

/// Reads the sheets of encoders.
struct Sheets;

inventory::submit! { RegisteredSheet(&Sheets) }

impl ProfileSheet for Sheets {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn read(&self, sheet: &str) -> Result<ApplicationSheet, toml::de::Error> {
        /// The sheet without its other tables, which other code reads.
        #[derive(Deserialize)]
        struct Whole {
            application: Option<Measurement>,
        }
        let whole: Whole = toml::from_str(sheet)?;
        Ok(whole.application.map_or_else(ApplicationSheet::default, ApplicationSheet::new))
    }

    fn describe(&self, description: &DeviceDescription, sheet: &mut Table) -> ApplicationSheet {
        describe(description, sheet).map_or_else(ApplicationSheet::default, ApplicationSheet::new)
    }
}

/// The number of nanometres in a millimetre, the step of a linear encoder whose step is not known.
pub(super) const NANOMETRES_PER_MILLIMETRE: u32 = 1_000_000;

/// The measurement of an encoder.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Measurement {
    /// The measured quantity.
    pub kind: EncoderKind,
    /// The resolution of one revolution, in bits.
    pub single_turn_bits: u8,
    /// The number of revolutions that the encoder can distinguish.
    pub revolutions: u32,
    /// The lowest value of 6001h and 6002h. A 0 in 6002h is allowed: it stands for 2^32.
    pub units_per_revolution_least: u32,
    /// The speed above which 6505h bit 0 warns; `None`: no warning.
    pub speed_warning_rpm: Option<u32>,
    /// The condition under which the position continues beyond the end of the physical range.
    pub universal_scaling: UniversalScaling,
    /// The bit of 6000h that makes the speed units per second instead of revolutions per minute.
    pub speed_format_bit: u8,
    /// The bits of 6000h that the profile or the manual defines. The device refuses a write that sets other bits.
    pub operating_bits: u16,
    /// For a linear encoder: the length of a step, in nanometres.
    pub step_nm: u32,
    /// For a draw-wire encoder: the sum of both channels, in 0.1 mm.
    pub full_scale_tenth_mm: u32,
    /// For a draw-wire encoder: the movement of the wire in one turn of the drum, in 0.1 mm.
    pub tenth_mm_per_revolution: u32,
    /// For an inclinometer: the tilt of the housing, in hundredths of a degree, clockwise.
    pub tilt_hundredths: i32,
    /// For people: the values of this table that the manual does not give.
    pub assumed: ForPeople,
    /// For people: the times over which the speed is measured.
    pub integration_times_ms: ForPeople,
    /// For people: the finest resolution of the family.
    pub single_turn_bits_most: ForPeople,
    /// For people: the unit of the measured speed.
    pub speed_unit: ForPeople,
    /// For people: whether revolutions are counted.
    pub turns: ForPeople,
    /// For people: the meaning of 0 in 6002h.
    pub zero_range_means_2_pow_32: ForPeople,
}

impl Default for Measurement {
    /// The values of version 3.2 of the profile.
    fn default() -> Self {
        Self {
            kind: EncoderKind::Rotary,
            single_turn_bits: 0,
            revolutions: 1,
            units_per_revolution_least: 1,
            speed_warning_rpm: None,
            universal_scaling: UniversalScaling::ByBit12,
            speed_format_bit: 13,
            operating_bits: 0xF00F,
            step_nm: NANOMETRES_PER_MILLIMETRE,
            full_scale_tenth_mm: 0,
            tenth_mm_per_revolution: 1,
            tilt_hundredths: 0,
            assumed: ForPeople,
            integration_times_ms: ForPeople,
            single_turn_bits_most: ForPeople,
            speed_unit: ForPeople,
            turns: ForPeople,
            zero_range_means_2_pow_32: ForPeople,
        }
    }
}

/// The quantity that an encoder measures.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EncoderKind {
    /// The angle of a shaft, and its revolutions.
    Rotary,
    /// A position on a straight scale. The period of the scale counts as a revolution.
    Linear,
    /// The length of a wire, by two redundant channels, and the tilt of the housing.
    DrawWire,
}

/// The condition under which the universal scaling function works. The function allows any scaling without a jump of
/// the position at the end of the physical range.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum UniversalScaling {
    /// While bit 12 of 6000h is set.
    #[serde(rename = "by-bit-12")]
    ByBit12,
    /// Whenever scaling is on.
    Always,
    /// Never: the device does not have the function.
    Never,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::documentation::{fields_of, is_documented};

    #[test]
    fn every_key_that_is_read_is_documented() {
        let missing: Vec<&str> = fields_of::<Measurement>().into_iter().filter(|field| !is_documented(field)).collect();
        assert!(missing.is_empty(), "docs/models.md does not explain {missing:?}");
    }
}
