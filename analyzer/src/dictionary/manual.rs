//! What the manual of a device says and its description does not.

use super::annotation::Annotations;
use super::description::DeviceDescription;
use super::names;
use crate::identity::Multiplexer;
use crate::object::Acting;
use crate::wire::emcy::{Emcy, EmcyCode};

/// What is known of a device before it has sent anything.
#[derive(Clone, Debug, Default)]
pub struct KnownDevice {
    /// What its file says.
    pub description: DeviceDescription,
    /// What no file of that kind holds, and its manual says; empty where nobody gave it.
    pub manual: Manual,
}

impl KnownDevice {
    /// A device of which nobody has read the manual.
    pub fn described(description: DeviceDescription) -> Self {
        Self { description, manual: Manual::default() }
    }
}

/// What a manual adds to a device description.
#[derive(Clone, Debug, Default)]
pub struct Manual {
    /// Units and names of values.
    pub annotations: Annotations,
    /// How node-ID and bit rate are set.
    pub settings: Settings,
    /// The EMCY messages that it lists.
    pub emergencies: Vec<KnownEmergency>,
    /// Objects of the manufacturer that act when they are written.
    pub acting: Vec<(Multiplexer, Acting)>,
}

impl Manual {
    /// What an object does when it is written, by this manual, by the standard, by the device profile, or by a description
    /// that refuses to have it downloaded (CiA 306, ObjFlags bit 0). `None`: it is a setting, or only read.
    pub fn acting(&self, at: Multiplexer, description: Option<&DeviceDescription>) -> Option<Acting> {
        let of_maker = || self.acting.iter().find(|known| known.0 == at).map(|known| known.1);
        let profile = description.and_then(DeviceDescription::device_profile);
        let of_profile = || names::acting(at, profile);
        let is_refused = || {
            let entry = description.and_then(|description| description.dictionary.entry(at).ok());
            entry.is_some_and(|entry| entry.flags.refuses_write_on_download()).then_some(Acting::Commands)
        };
        of_maker().or_else(|| Acting::of_communication(at)).or_else(of_profile).or_else(is_refused)
    }

    /// What the manual says of an EMCY message: of those with its code the one whose fixed bytes it has, else the first.
    pub fn emergency(&self, emcy: &Emcy) -> Option<&KnownEmergency> {
        let code = emcy.code()?;
        let same_code = || self.emergencies.iter().filter(|known| known.code == code);
        let same = same_code().find(|known| !known.bytes.is_empty() && emcy.manufacturer().starts_with(&known.bytes));
        same.or_else(|| same_code().next())
    }
}

/// An EMCY message that the manual of a device lists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KnownEmergency {
    /// The error code.
    pub code: EmcyCode,
    /// The first manufacturer-specific bytes, where they are fixed.
    pub bytes: Vec<u8>,
    /// What it means.
    pub text: String,
}

/// How the node-ID and the bit rate of a device are set, apart from LSS.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Settings {
    /// The object that holds the node-ID to use from the next start on.
    pub node_id: Option<Multiplexer>,
    /// The object that holds the code of the bit rate to use from the next start on.
    pub bit_rate: Option<Multiplexer>,
    /// The codes, each with its bit rate in bit/s.
    pub bit_rates: Vec<(u32, u32)>,
    /// Whether the device knows LMT (CiA DS-205), the forerunner of LSS.
    pub layer_management: bool,
    /// The TPDOs, from 1, whose frames the device fills up with zeros to 8 bytes.
    pub padded_tpdos: Vec<u8>,
}

impl Settings {
    /// Whether a frame of that TPDO, from 1, always has 8 bytes.
    pub fn pads(&self, tpdo: u16) -> bool {
        u8::try_from(tpdo).is_ok_and(|tpdo| self.padded_tpdos.contains(&tpdo))
    }

    /// The bit rate of a code, in bit/s.
    pub fn bit_rate_of(&self, code: u32) -> Option<u32> {
        self.bit_rates.iter().find(|rate| rate.0 == code).map(|rate| rate.1)
    }
}
