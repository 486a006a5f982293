//! NMT: the master commands the states of its slaves (CAN-ID 000h).
//!
//! ```text
//! byte 0: command specifier    byte 1: node-ID, 0 = all nodes
//! ```

use super::error_control::State;
use super::{Field, Fields, Layout, Malformed, Wire, named};
use nom::{IResult, Parser, number::complete::u8};
use std::fmt;

/// The CAN-ID of NMT commands.
pub const CAN_ID: u16 = 0x000;

/// An NMT command to one node or to all.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Nmt {
    /// The command.
    pub command: Command,
    /// The node-ID, 0 for all nodes; 128 to 255 address no node.
    pub node: u8,
}

/// An NMT command specifier.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Command(pub u8);

impl Command {
    /// Start remote node: go to operational.
    pub const START: Self = Self(0x01);
    /// Stop remote node: go to stopped.
    pub const STOP: Self = Self(0x02);
    /// Enter pre-operational.
    pub const ENTER_PRE_OPERATIONAL: Self = Self(0x80);
    /// Reset node: the whole device.
    pub const RESET_NODE: Self = Self(0x81);
    /// Reset communication: the communication parameters only.
    pub const RESET_COMMUNICATION: Self = Self(0x82);
    /// All commands of CiA 301.
    pub const ALL: [Self; 5] =
        [Self::START, Self::STOP, Self::ENTER_PRE_OPERATIONAL, Self::RESET_NODE, Self::RESET_COMMUNICATION];

    /// Whether the command restarts a node or its communication.
    pub const fn is_reset(self) -> bool {
        matches!(self, Self::RESET_NODE | Self::RESET_COMMUNICATION)
    }

    /// The state that a node shows after the command; `None` for a reserved specifier.
    pub const fn state(self) -> Option<State> {
        Some(match self {
            Self::START => State::OPERATIONAL,
            Self::STOP => State::STOPPED,
            Self::ENTER_PRE_OPERATIONAL => State::PRE_OPERATIONAL,
            Self::RESET_NODE | Self::RESET_COMMUNICATION => State::BOOT_UP,
            _ => return None,
        })
    }

    /// The standard's name, `None` for a reserved specifier.
    pub const fn name(self) -> Option<&'static str> {
        Some(match self {
            Self::START => "start remote node",
            Self::STOP => "stop remote node",
            Self::ENTER_PRE_OPERATIONAL => "enter pre-operational",
            Self::RESET_NODE => "reset node",
            Self::RESET_COMMUNICATION => "reset communication",
            _ => return None,
        })
    }
}

impl Wire for Nmt {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let command = named("an NMT command specifier", u8);
        let node = named("a node-ID", u8);
        (command, node).map(|(command, node)| Self { command: Command(command), node }).parse(input)
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        buffer[0] = self.command.0;
        buffer[1] = self.node;
        2
    }
}

static NMT: Layout =
    Layout { name: "NMT command", fields: &[Field::new("command specifier", 0, 0, 8), Field::new("node-ID", 1, 0, 8)] };

impl Fields for Nmt {
    const LAYOUTS: &'static [&'static Layout] = &[&NMT];

    fn layout(&self) -> &'static Layout {
        &NMT
    }
}

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "reserved command {:02X}h", self.0),
        }
    }
}

impl fmt::Debug for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Command({self})")
    }
}

/// Writes `start remote node, node 63`.
impl fmt::Display for Nmt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.node {
            0 => write!(f, "{}, all nodes", self.command),
            1..=127 => write!(f, "{}, node {}", self.command, self.node),
            _ => write!(f, "{}, no node ({} is not a node-ID)", self.command, self.node),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::{both_ways, stable};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn commands_of_the_standard() {
        both_ways(&[0x01, 0x3F], Nmt { command: Command::START, node: 63 });
        both_ways(&[0x81, 0x00], Nmt { command: Command::RESET_NODE, node: 0 });
        assert_eq!(Nmt::read(&[0x80, 0x3F]).unwrap().to_string(), "enter pre-operational, node 63");
        assert_eq!(
            Nmt::read(&[0x77, 0xFF]).unwrap().to_string(),
            "reserved command 77h, no node (255 is not a node-ID)"
        );
    }

    #[test]
    fn a_missing_byte_is_named() {
        assert_eq!(Nmt::read(&[0x01]), Err(Malformed { offset: 1, expected: "a node-ID" }));
        assert_eq!(Nmt::read(&[]), Err(Malformed { offset: 0, expected: "an NMT command specifier" }));
    }

    proptest! {
        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<Nmt>(&bytes);
        }
    }
}
