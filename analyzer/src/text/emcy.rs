//! EMCY messages as text: the meaning of the code in the device's profile, otherwise in CiA 301; then the meaning in
//! the device's manual.

use super::escaped::Escaped;
use crate::NodeId;
use crate::dictionary::names::error_name;
use crate::network::Bus;
use crate::wire::emcy::Emcy;
use std::fmt;

/// An EMCY message, as text: `FF00h device specific, register 80h (manufacturer), data 13 05 00 00 00: Sensor
/// synchronisation failure`.
pub struct EmcyText<'a> {
    emcy: &'a Emcy,
    /// The device's profile, if known.
    profile: Option<u16>,
    /// The meaning in the device's manual.
    known: Option<&'a str>,
}

impl<'a> EmcyText<'a> {
    /// The text of a node's message.
    pub fn of(emcy: &'a Emcy, node: NodeId, bus: &'a Bus) -> Self {
        let known = bus.node(node);
        let device = known.and_then(|node| node.device.as_deref());
        let by_manual = device.and_then(|device| device.manual.emergency(emcy)).map(|known| &*known.text);
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
        match self.known.filter(|known| !name.to_lowercase().starts_with(&known.to_lowercase())) {
            Some(known) => write!(f, ": {}", Escaped(known)),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dictionary::{KnownDevice, KnownEmergency, Manual};
    use crate::network::Network;
    use crate::wire::emcy::{EmcyCode, ErrorRegister};
    use canvass_traces::{ChannelId, Record, Timestamp, parse_frame};

    fn known(code: u16, bytes: &[u8], text: &str) -> KnownEmergency {
        KnownEmergency { code: EmcyCode(code), bytes: bytes.to_vec(), text: text.to_owned() }
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
