//! EMCY messages as text: the meaning of the code in the device's profile, otherwise in CiA 301; then the meaning in
//! the device's manual.

use super::escaped::Escaped;
use crate::NodeId;
use crate::dictionary::names::error_name;
use crate::dictionary::{EmergencyField, KnownEmergency};
use crate::network::Bus;
use crate::wire::emcy::Emcy;
use std::fmt;

/// An EMCY message, as text: `FF00h device specific, register 80h (manufacturer), data 13 05 00 00 00: Sensor
/// synchronisation failure`.
pub struct EmcyText<'a> {
    emcy: &'a Emcy,
    /// The device's profile, if known.
    profile: Option<u16>,
    /// The message in the device's manual.
    known: Option<&'a KnownEmergency>,
}

impl<'a> EmcyText<'a> {
    /// The text of a node's message.
    pub fn of(emcy: &'a Emcy, node: NodeId, bus: &'a Bus) -> Self {
        let known = bus.node(node);
        let device = known.and_then(|node| node.device.as_deref());
        let by_manual = device.and_then(|device| device.manual.emergency(emcy));
        Self { emcy, profile: known.and_then(|known| known.profile(node)), known: by_manual }
    }

    /// The meaning of the code in the device's profile.
    fn by_profile(&self) -> Option<&'static str> {
        error_name(self.emcy.code()?, self.profile?)
    }
}

impl fmt::Display for EmcyText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let by_profile = self.by_profile();
        match by_profile {
            Some(name) => self.emcy.write_named(name, f)?,
            None => self.emcy.fmt(f)?,
        }
        let standard = || self.emcy.code().and_then(|code| code.name());
        let name = by_profile.or_else(standard).unwrap_or_default();
        // Many manuals repeat the standard's text.
        let Some(known) = self.known else { return Ok(()) };
        if !name.to_lowercase().starts_with(&known.text.to_lowercase()) {
            write!(f, ": {}", Escaped(&known.text))?;
        }
        self.fields(&known.fields, f)
    }
}

impl EmcyText<'_> {
    /// Writes the contents of the manufacturer-specific bytes: `; sensor error register 80h, temperature 22 °C`.
    fn fields(&self, fields: &[EmergencyField], f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, (field, &byte)) in fields.iter().zip(self.emcy.manufacturer()).enumerate() {
            write!(f, "{} {}", if n == 0 { ";" } else { "," }, Escaped(&field.name))?;
            match &field.unit {
                Some(unit) => write!(f, " {} {}", unit.physical(f64::from(byte)), Escaped(&unit.symbol))?,
                None => write!(f, " {byte:02X}h")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dictionary::{KnownDevice, Manual, Unit};
    use crate::network::Network;
    use crate::wire::emcy::{EmcyCode, ErrorRegister};
    use canvass_traces::{ChannelId, Record, Timestamp, parse_frame};

    fn known(code: u16, bytes: &[u8], text: &str) -> KnownEmergency {
        KnownEmergency { code: EmcyCode(code), bytes: bytes.to_vec(), text: text.to_owned(), fields: Vec::new() }
    }

    /// The message of the Kübler manual, 5.8.2: 22 °C, limits -32 °C and 16 °C.
    #[test]
    fn the_bytes_have_names_and_units() {
        let field = |name: &str, unit| EmergencyField { name: name.to_owned(), unit };
        let degrees = Some(Unit { offset: -64.0, ..Unit::new(1.0, "°C") });
        let fields = vec![
            field("sensor error register", None),
            field("temperature", degrees.clone()),
            field("low threshold", degrees.clone()),
            field("high threshold", degrees),
            field("sensor version", None),
        ];
        let known = KnownEmergency { fields, ..known(0x4200, &[], "Temperature limit") };
        let emcy = Emcy::new(EmcyCode(0x4200), ErrorRegister(0x09), [0x80, 0x56, 0x20, 0x50, 0x2E]);
        let text = EmcyText { emcy: &emcy, profile: None, known: Some(&known) }.to_string();
        let fields = "sensor error register 80h, temperature 22 °C, low threshold -32 °C, high threshold 16 °C, sensor \
                      version 2Eh";
        assert!(text.ends_with(&format!("80 56 20 50 2E: Temperature limit; {fields}")), "{text}");
    }

    #[test]
    fn the_manual_says_more_than_the_standard() {
        let emergencies = vec![
            known(0xFF00, &[], "something"),
            known(0xFF00, &[0x13, 0x05], "Sensor synchronisation failure"),
            known(0x8110, &[], "CAN overrun"),
        ];
        let mut network = Network::new();
        let node = NodeId::new(63).unwrap();
        let manual = Manual { emergencies, ..Manual::default() };
        network.describe(node, KnownDevice { manual, ..KnownDevice::default() });
        let frame = parse_frame("73F#00").unwrap().frame;
        network.handle(&Record::new(Timestamp::ZERO, ChannelId(0), frame));
        let bus = network.bus(ChannelId(0)).unwrap();
        let text = |code, bytes| {
            let emcy = Emcy::new(EmcyCode(code), ErrorRegister(0x80), bytes);
            EmcyText::of(&emcy, node, bus).to_string()
        };
        assert!(text(0xFF00, [0x13, 0x05, 0, 0, 0]).ends_with("data 13 05 00 00 00: Sensor synchronisation failure"));
        assert!(text(0xFF00, [0x13, 0x06, 0, 0, 0]).ends_with("data 13 06 00 00 00: something"));
        assert!(text(0x8110, [0; 5]).ends_with("data 00 00 00 00 00"));
        assert!(text(0x5000, [0; 5]).ends_with("data 00 00 00 00 00"));
        let other = Emcy::new(EmcyCode(0xFF00), ErrorRegister(0), [0; 5]);
        assert!(!EmcyText::of(&other, NodeId::MIN, bus).to_string().contains("something"));
    }
}
