//! NMT error control: boot-up, heartbeat and node guarding (CAN-ID 700h + node-ID).
//!
//! ```text
//! byte 0: tsssssss    t toggle bit (node guarding; 0 in heartbeats), s NMT state
//! ```
//!
//! Boot-up is state 0 without toggle. A heartbeat and a guarding answer can't be distinguished by one frame alone:
//! guarding answers follow remote frames.

use super::{Field, Fields, Layout, Malformed, Wire, named};
use nom::{IResult, Parser, number::complete::u8};
use std::fmt;

/// The CAN-ID of node 0; the node-ID is added.
pub const CAN_ID_BASE: u16 = 0x700;

/// The message of a node about its state.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct ErrorControl {
    /// The toggle bit of node guarding.
    pub toggle: bool,
    /// The NMT state.
    pub state: State,
}

/// An NMT state, as it is sent in error control messages: seven bits.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct State(pub u8);

impl State {
    /// Initialisation is over (boot-up).
    pub const BOOT_UP: Self = Self(0x00);
    /// Stopped: only NMT and error control work.
    pub const STOPPED: Self = Self(0x04);
    /// Operational: everything works.
    pub const OPERATIONAL: Self = Self(0x05);
    /// Pre-operational: everything but PDOs works.
    pub const PRE_OPERATIONAL: Self = Self(0x7F);

    /// The standard's name, `None` for a reserved value.
    pub const fn name(self) -> Option<&'static str> {
        Some(match self {
            Self::BOOT_UP => "boot-up",
            Self::STOPPED => "stopped",
            Self::OPERATIONAL => "operational",
            Self::PRE_OPERATIONAL => "pre-operational",
            _ => return None,
        })
    }
}

impl ErrorControl {
    /// The message of a node that has finished its initialisation.
    pub const BOOT_UP: Self = Self::heartbeat(State::BOOT_UP);

    /// A heartbeat with this state.
    pub const fn heartbeat(state: State) -> Self {
        Self { toggle: false, state }
    }

    /// Whether the message is a boot-up: state 0 without toggle bit.
    pub fn is_boot_up(self) -> bool {
        self == Self::BOOT_UP
    }
}

impl Wire for ErrorControl {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        named("an NMT state", u8)
            .map(|byte: u8| Self { toggle: byte & 0x80 != 0, state: State(byte & 0x7F) })
            .parse(input)
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        buffer[0] = u8::from(self.toggle) << 7 | self.state.0 & 0x7F;
        1
    }
}

const FIELDS: &[Field] = &[Field::new("state", 0, 0, 7), Field::new("toggle bit", 0, 7, 1)];
static BOOT_UP: Layout = Layout { name: "boot-up", fields: FIELDS };
static HEARTBEAT: Layout = Layout { name: "heartbeat", fields: FIELDS };
/// The layout of an answer to node guarding. Only the remote frame before the answer distinguishes it from a heartbeat.
pub static GUARDING: Layout = Layout { name: "guarding", fields: FIELDS };

impl Fields for ErrorControl {
    const LAYOUTS: &'static [&'static Layout] = &[&BOOT_UP, &HEARTBEAT, &GUARDING];

    fn layout(&self) -> &'static Layout {
        if self.is_boot_up() { &BOOT_UP } else { &HEARTBEAT }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "reserved state {:02X}h", self.0),
        }
    }
}

impl fmt::Debug for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "State({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::{both_ways, stable};
    use super::*;

    #[test]
    fn states_of_the_standard() {
        both_ways(&[0x00], ErrorControl::BOOT_UP);
        both_ways(&[0x7F], ErrorControl::heartbeat(State::PRE_OPERATIONAL));
        both_ways(&[0x85], ErrorControl { toggle: true, state: State::OPERATIONAL });
        assert!(!ErrorControl::read(&[0x80]).unwrap().is_boot_up());
        assert!(ErrorControl::read(&[]).is_err());
        assert_eq!(State(0x33).to_string(), "reserved state 33h");
    }

    #[test]
    fn any_byte() {
        (0..=255).for_each(|byte| stable::<ErrorControl>(&[byte]));
    }
}
