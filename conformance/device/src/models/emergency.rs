//! The EMCY messages that the manual of a model lists.

use canvass_analyzer::dictionary::KnownEmergency;
use canvass_analyzer::wire::emcy::EmcyCode;
use serde::Deserialize;
use serde::de::IgnoredAny as ForPeople;

/// A row `[[emergency]]` of a sheet.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Emergency {
    /// The error code.
    pub code: u16,
    /// What the error register is with it: the first is what the table of codes has, others occur elsewhere in the manual.
    /// Empty: the manual does not say it, so it is what CiA 301 has for the class of the code.
    #[serde(default)]
    pub registers: Vec<u8>,
    /// The first manufacturer-specific bytes, where they are fixed.
    #[serde(default)]
    pub bytes: Vec<u8>,
    /// What it means.
    pub text: String,
    /// For people: which of these values the manual does not say.
    #[serde(default)]
    pub assumed: ForPeople,
    /// For people: what the manufacturer-specific bytes hold.
    #[serde(default)]
    pub fields: ForPeople,
}

impl Emergency {
    /// As the analyzer knows it.
    pub(super) fn known(&self) -> KnownEmergency {
        KnownEmergency { code: self.code(), bytes: self.bytes.clone(), text: self.text.clone() }
    }

    /// The error code.
    pub const fn code(&self) -> EmcyCode {
        EmcyCode(self.code)
    }

    /// The error register; 0 where the manual does not say it.
    pub fn register(&self) -> u8 {
        self.registers.first().copied().unwrap_or(0)
    }

    /// Bytes 3 to 7 of the message.
    pub fn manufacturer(&self) -> [u8; 5] {
        let mut bytes = [0; 5];
        bytes.iter_mut().zip(&self.bytes).for_each(|(to, from)| *to = *from);
        bytes
    }
}
