//! MPDO: a PDO that names the object whose value it carries (CiA 301; mapping count FEh or FFh).
//!
//! ```text
//! byte 0: annnnnnn    a address type: 0 source, 1 destination; n node-ID
//! bytes 1..3: multiplexer    bytes 4..7: value, little-endian
//! ```
//!
//! With a source address, node and object belong to the sender, and receivers look them up in their dispatcher lists
//! (1FD0h..). With a destination address, node and object belong to the receiver; node-ID 0 addresses all nodes.

use super::{Malformed, Wire, named};
use crate::Multiplexer;
use nom::{IResult, Parser, bytes::complete::take, number::complete::u8};
use std::fmt;

/// The node whose node-ID and object an MPDO names.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Addressing {
    /// The sender (SAM).
    Source,
    /// The receiver (DAM).
    Destination,
}

/// A multiplexed PDO.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Mpdo {
    /// The node that owns the object.
    pub addressing: Addressing,
    /// The node-ID; 0 is all nodes in a destination address, and reserved in a source address.
    pub node: u8,
    /// The object.
    pub object: Multiplexer,
    /// The value of the object, which determines how many bytes count.
    pub data: [u8; 4],
}

impl Addressing {
    /// The addressing for the count of a mapping (sub-index 0 of 1600h.., 1A00h..); `None` for an ordinary PDO.
    pub(crate) const fn of_mapping_count(count: u32) -> Option<Self> {
        match count {
            0xFE => Some(Self::Source),
            0xFF => Some(Self::Destination),
            _ => None,
        }
    }
}

impl Wire for Mpdo {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, head) = named("an MPDO address", u8).parse(input)?;
        let (rest, object) = named("index and sub-index", take(3_usize)).parse(rest)?;
        let (rest, value) = named("a value in four bytes", take(4_usize)).parse(rest)?;
        let addressing = if head & 0x80 == 0 { Addressing::Source } else { Addressing::Destination };
        let mut data = [0; 4];
        data.copy_from_slice(value);
        let object = Multiplexer::from_bytes([object[0], object[1], object[2]]);
        Ok((rest, Self { addressing, node: head & 0x7F, object, data }))
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        let address_type = match self.addressing {
            Addressing::Source => 0x00,
            Addressing::Destination => 0x80,
        };
        buffer[0] = address_type | self.node & 0x7F;
        buffer[1..4].copy_from_slice(&self.object.to_bytes());
        buffer[4..].copy_from_slice(&self.data);
        8
    }
}

/// Writes `from node 5`, `to node 5`, `to all nodes`.
impl fmt::Display for Mpdo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.addressing, self.node) {
            (Addressing::Source, 0) => f.write_str("from reserved node 0"),
            (Addressing::Source, node) => write!(f, "from node {node}"),
            (Addressing::Destination, 0) => f.write_str("to all nodes"),
            (Addressing::Destination, node) => write!(f, "to node {node}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::{both_ways, stable};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn source_and_destination() {
        let object = Multiplexer::new(0x6004, 0);
        let source = Mpdo { addressing: Addressing::Source, node: 5, object, data: [0xBA, 0x4C, 0, 0] };
        both_ways(&[0x05, 0x04, 0x60, 0x00, 0xBA, 0x4C, 0x00, 0x00], source);
        let all = Mpdo { addressing: Addressing::Destination, node: 0, ..source };
        both_ways(&[0x80, 0x04, 0x60, 0x00, 0xBA, 0x4C, 0x00, 0x00], all);
        assert_eq!((source.to_string(), all.to_string()), ("from node 5".into(), "to all nodes".into()));
        assert_eq!(Mpdo::read(&[0x05, 0x04]), Err(Malformed { offset: 1, expected: "index and sub-index" }));
        assert_eq!(Addressing::of_mapping_count(0xFE), Some(Addressing::Source));
        assert_eq!(Addressing::of_mapping_count(2), None);
    }

    proptest! {
        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<Mpdo>(&bytes);
        }
    }
}
