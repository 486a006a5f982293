//! The EMCY messages that the manual of a model lists.

use canvass_analyzer::dictionary::{EmergencyField, KnownEmergency, Unit};
use canvass_analyzer::wire::emcy::EmcyCode;
use serde::Deserialize;
use serde::de::IgnoredAny as ForPeople;

/// A row `[[emergency]]` of a sheet.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Emergency {
    /// The error code.
    pub code: u16,
    /// The values of the error register with this code: first the value in the manual's table of codes, then values
    /// elsewhere in the manual. Empty if the manual gives none: the register then follows from the class of the code
    /// (CiA 301).
    #[serde(default)]
    pub registers: Vec<u8>,
    /// The first manufacturer-specific bytes, if they are fixed.
    #[serde(default)]
    pub bytes: Vec<u8>,
    /// The meaning of the code.
    pub text: String,
    /// For people: the values of this row that the manual does not give.
    #[serde(default)]
    pub assumed: ForPeople,
    /// The contents of the manufacturer-specific bytes.
    #[serde(default)]
    pub fields: Vec<Field>,
}

/// The content of one manufacturer-specific byte: a register or, with a unit, byte + offset.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Field {
    name: String,
    unit: Option<String>,
    #[serde(default)]
    offset: f64,
}

impl Emergency {
    /// The message in the form that the analyzer uses.
    pub(super) fn known(&self) -> KnownEmergency {
        let fields = self.fields.iter().map(Field::known).collect();
        KnownEmergency { code: self.code(), bytes: self.bytes.clone(), text: self.text.clone(), fields }
    }

    /// The error code.
    pub const fn code(&self) -> EmcyCode {
        EmcyCode(self.code)
    }

    /// The error register; 0 if the manual does not give it.
    pub fn register(&self) -> u8 {
        self.registers.first().copied().unwrap_or(0)
    }

    /// Bytes 3 to 7 of the EMCY message.
    pub fn manufacturer(&self) -> [u8; 5] {
        let mut bytes = [0; 5];
        bytes.iter_mut().zip(&self.bytes).for_each(|(to, from)| *to = *from);
        bytes
    }
}

impl Field {
    fn known(&self) -> EmergencyField {
        let unit = |symbol: &String| Unit { factor: 1.0, offset: self.offset, symbol: symbol.clone().into() };
        EmergencyField { name: self.name.clone(), unit: self.unit.as_ref().map(unit) }
    }
}
