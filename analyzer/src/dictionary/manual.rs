//! Facts from a device's manual that its description lacks.

use super::annotation::Annotations;
use super::description::DeviceDescription;
use super::names::{self, Unit};
use crate::identity::Multiplexer;
use crate::object::Acting;
use crate::wire::emcy::{Emcy, EmcyCode};

/// The knowledge of a device before it has sent anything.
#[derive(Clone, Debug, Default)]
pub struct KnownDevice {
    /// The device's description.
    pub description: DeviceDescription,
    /// Facts from the device's manual; empty if they are unknown.
    pub manual: Manual,
}

impl KnownDevice {
    /// A device without facts from its manual.
    pub fn described(description: DeviceDescription) -> Self {
        Self { description, manual: Manual::default() }
    }
}

/// Facts that a manual adds to a device description.
#[derive(Clone, Debug, Default)]
pub struct Manual {
    /// Units and names of values.
    pub annotations: Annotations,
    /// The ways to set node-ID and bit rate.
    pub settings: Settings,
    /// The EMCY messages in the manual.
    pub emergencies: Vec<KnownEmergency>,
    /// Objects that repeat another object for comparison.
    pub checked: Vec<Checked>,
    /// Manufacturer-specific objects that act when they are written.
    pub acting: Vec<(Multiplexer, Acting)>,
}

impl Manual {
    /// The action of writing an object, by this manual, the standard, the device profile, or a description that
    /// excludes the object from downloads (CiA 306, ObjFlags bit 0). `None` for a setting or a read-only object.
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

    /// The manual's entry for an EMCY message: among the entries with the message's error code, the entry with matching
    /// bytes, else the first.
    pub fn emergency(&self, emcy: &Emcy) -> Option<&KnownEmergency> {
        let code = emcy.code()?;
        let same_code = || self.emergencies.iter().filter(|known| known.code == code);
        let same = same_code().find(|known| !known.bytes.is_empty() && emcy.manufacturer().starts_with(&known.bytes));
        same.or_else(|| same_code().next())
    }
}

/// An EMCY message in a device's manual.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownEmergency {
    /// The error code.
    pub code: EmcyCode,
    /// The first manufacturer-specific bytes, if they are fixed.
    pub bytes: Vec<u8>,
    /// The meaning of the message.
    pub text: String,
    /// The contents of the manufacturer-specific bytes, one byte each; empty if the manual does not give them.
    pub fields: Vec<EmergencyField>,
}

/// An object with its inverse and its checksum in further objects of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checked {
    /// The object.
    pub value: Multiplexer,
    /// The object whose value has all bits of `value` inverted.
    pub inverse: Option<Multiplexer>,
    /// The object with the CRC-CCITT over the four bytes of the value.
    pub crc: Option<Multiplexer>,
    /// The start value of the CRC.
    pub crc_start: u16,
}

/// The content of one manufacturer-specific byte of an EMCY message.
#[derive(Clone, Debug, PartialEq)]
pub struct EmergencyField {
    /// The name of the content.
    pub name: String,
    /// The unit of the content; `None` for a register.
    pub unit: Option<Unit>,
}

/// The ways to set node-ID and bit rate of a device, apart from LSS.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Settings {
    /// The object with the node-ID for the next start.
    pub node_id: Option<Multiplexer>,
    /// The object with the code of the bit rate for the next start.
    pub bit_rate: Option<Multiplexer>,
    /// The codes, each with its bit rate in bit/s.
    pub bit_rates: Vec<(u32, u32)>,
    /// The shortest event timers of TPDOs in ms that the manual allows, each with its bit rate in bit/s.
    pub shortest_cycles: Vec<(u32, u32)>,
    /// Whether the device supports LMT (CiA DS-205), the predecessor of LSS.
    pub layer_management: bool,
    /// The TPDOs, from 1, whose frames the device fills up with zeros to 8 bytes.
    pub padded_tpdos: Vec<u8>,
}

impl Settings {
    /// Whether the device always sends this TPDO, numbered from 1, with 8 bytes.
    pub fn pads(&self, tpdo: u16) -> bool {
        u8::try_from(tpdo).is_ok_and(|tpdo| self.padded_tpdos.contains(&tpdo))
    }

    /// The shortest event timer of a TPDO in ms at a bit rate, if the manual limits it.
    pub fn shortest_cycle(&self, bit_rate: u32) -> Option<u32> {
        self.shortest_cycles.iter().find(|cycle| cycle.0 == bit_rate).map(|cycle| cycle.1)
    }

    /// The bit rate of a code, in bit/s.
    pub fn bit_rate_of(&self, code: u32) -> Option<u32> {
        self.bit_rates.iter().find(|rate| rate.0 == code).map(|rate| rate.1)
    }
}
