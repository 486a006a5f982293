//! The measurement of an encoder: the table `[application]` of a sheet.

use super::description::describe;
use crate::models::{ApplicationSheet, ProfileSheet, RegisteredSheet};
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::profiles::cia406::NUMBER;
use serde::Deserialize;
use serde::de::IgnoredAny as ForPeople;
use toml::Table;

/// Reads sheets of encoders.
struct Sheets;

inventory::submit! { RegisteredSheet(&Sheets) }

impl ProfileSheet for Sheets {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn read(&self, sheet: &str) -> Result<ApplicationSheet, toml::de::Error> {
        /// The other tables are read elsewhere.
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

/// The measurement.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Measurement {
    /// What is measured.
    pub kind: EncoderKind,
    /// The resolution of one revolution, in bits.
    pub single_turn_bits: u8,
    /// The revolutions that can be distinguished.
    pub revolutions: u32,
    /// Neither 6001h nor 6002h is smaller, but for the 0 of 6002h, which stands for 2^32.
    pub units_per_revolution_least: u32,
    /// Above it, 6505h bit 0 warns.
    pub speed_warning_rpm: Option<u32>,
    /// Whether the position goes on over the end of the physical range.
    pub universal_scaling: UniversalScaling,
    /// The bit of 6000h that makes the speed units per second instead of revolutions per minute.
    pub speed_format_bit: u8,
    /// The bits of 6000h that have a meaning in the profile or in the manual; a write of others is refused.
    pub operating_bits: u16,
    /// Of a draw-wire encoder: the sum of its two channels, in 0.1 mm.
    pub full_scale_tenth_mm: u32,
    /// Of a draw-wire encoder: how far one turn of its drum moves the wire, in 0.1 mm.
    pub tenth_mm_per_revolution: u32,
    /// Of an inclinometer: how the housing hangs, in hundredths of a degree, clockwise.
    pub tilt_hundredths: i32,
    /// Which of these values the manual does not say: for readers of the file.
    pub assumed: ForPeople,
    /// For people: over which times the speed is measured.
    pub integration_times_ms: ForPeople,
    /// For people: the finest resolution of the family.
    pub single_turn_bits_most: ForPeople,
    /// For people: what the speed is measured in.
    pub speed_unit: ForPeople,
    /// For people: the step of a linear scale.
    pub step_nm: ForPeople,
    /// For people: whether revolutions are counted.
    pub turns: ForPeople,
    /// For people: what 0 in 6002h means.
    pub zero_range_means_2_pow_32: ForPeople,
}

impl Default for Measurement {
    /// As version 3.2 of the profile has it.
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
            full_scale_tenth_mm: 0,
            tenth_mm_per_revolution: 1,
            tilt_hundredths: 0,
            assumed: ForPeople,
            integration_times_ms: ForPeople,
            single_turn_bits_most: ForPeople,
            speed_unit: ForPeople,
            step_nm: ForPeople,
            turns: ForPeople,
            zero_range_means_2_pow_32: ForPeople,
        }
    }
}

/// What an encoder measures.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EncoderKind {
    /// The angle of a shaft, and its revolutions.
    Rotary,
    /// A place on a straight scale; its period counts as a revolution.
    Linear,
    /// The length of a wire, by two redundant channels, and the tilt of the housing.
    DrawWire,
}

/// When the universal scaling function works: any scaling, without a jump where the physical range ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UniversalScaling {
    /// As bit 12 of 6000h says.
    #[serde(rename = "by-bit-12")]
    ByBit12,
    /// Wherever scaling is on.
    Always,
    /// Not at all.
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
