//! SDO: reading and writing objects of another node (client to server 600h + node-ID, server to client 580h +
//! node-ID, unless 1200h and the following say otherwise).
//!
//! Byte 0 has the command specifier in its upper three bits; [`request`] and [`response`] show the layout of each
//! message. Segments of a block transfer have no command specifier: only the state of the transfer distinguishes them
//! from commands, see [`block::BlockSegment`].

pub mod abort;
pub mod block;
mod layouts;
pub mod request;
pub mod response;

pub use abort::{ABORT_CODES, Abort, AbortCode, CAL_ERRORS};
pub use block::{BlockSegment, crc16};
pub use request::Request;
pub use response::Response;

use super::{Malformed, named};
use crate::Multiplexer;
use nom::{IResult, Parser, bytes::complete::take, number::complete::le_u32};

/// The CAN-ID from client to server of node 0; the node-ID is added.
pub const REQUEST_BASE: u16 = 0x600;
/// The CAN-ID from server to client of node 0; the node-ID is added.
pub const RESPONSE_BASE: u16 = 0x580;

/// The content of an initiate message (`e` and `s` of its command byte).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Payload {
    /// e = 1, s = 1: the value itself, 1 to 4 bytes.
    Expedited(Expedited),
    /// e = 1, s = 0: four bytes with the value, whose length is not given.
    ExpeditedUnsized([u8; 4]),
    /// e = 0, s = 1: segments follow, with this total number of bytes.
    Segmented(u32),
    /// e = 0, s = 0: segments follow, without a total number. The four bytes are reserved.
    SegmentedUnsized,
}

/// A value of 1 to 4 bytes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Expedited {
    data: [u8; 4],
    len: u8,
}

impl Expedited {
    /// A value of 1 to 4 bytes, `None` for other lengths.
    pub fn new(value: &[u8]) -> Option<Self> {
        if !(1..=4).contains(&value.len()) {
            return None;
        }
        let mut data = [0; 4];
        data[..value.len()].copy_from_slice(value);
        Some(Self { data, len: value.len() as u8 })
    }

    /// The value's bytes.
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }
}

impl Payload {
    /// A value of 1 to 4 bytes in the message itself, or the announcement of segments for any other length.
    pub fn of(value: &[u8]) -> Self {
        match Expedited::new(value) {
            Some(expedited) => Self::Expedited(expedited),
            None => Self::Segmented(value.len() as u32),
        }
    }

    /// The value, if the message carries it; all four bytes if their number is not given.
    pub fn value(&self) -> Option<&[u8]> {
        match self {
            Self::Expedited(expedited) => Some(expedited.data()),
            Self::ExpeditedUnsized(data) => Some(data),
            Self::Segmented(_) | Self::SegmentedUnsized => None,
        }
    }

    /// The lower four bits of the command byte: `nnes`.
    const fn bits(&self) -> u8 {
        match self {
            Self::Expedited(value) => (4 - value.len) << 2 | 0b11,
            Self::ExpeditedUnsized(_) => 0b10,
            Self::Segmented(_) => 0b01,
            Self::SegmentedUnsized => 0b00,
        }
    }

    const fn bytes(&self) -> [u8; 4] {
        match self {
            Self::Expedited(value) => value.data,
            Self::ExpeditedUnsized(data) => *data,
            Self::Segmented(size) => size.to_le_bytes(),
            Self::SegmentedUnsized => [0; 4],
        }
    }

    /// Reads the bytes after the multiplexer; of an expedited value only the used bytes are required.
    fn parse(command: u8, input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        match command & 0b11 {
            0b11 => {
                let len = 4 - usize::from(command >> 2 & 0b11);
                let (input, data) = named("the value that the command byte announces", take(len)).parse(input)?;
                let value = Expedited::new(data).map_or(Self::SegmentedUnsized, Self::Expedited);
                Ok((&input[input.len().min(4 - len)..], value))
            }
            0b10 => named("four bytes of value", four).map(Self::ExpeditedUnsized).parse(input),
            0b01 => named("a size in four bytes", le_u32).map(Self::Segmented).parse(input),
            _ => Ok((&input[input.len().min(4)..], Self::SegmentedUnsized)),
        }
    }
}

/// A segment of a segmented transfer: up to seven bytes.
///
/// ```text
/// byte 0: ---tnnnc    t toggle, n bytes that don't count, c no more segments
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Segment {
    /// The toggle bit.
    pub toggle: bool,
    /// Whether it is the last segment.
    pub last: bool,
    data: [u8; 7],
    len: u8,
}

impl Segment {
    /// A segment of up to seven bytes; `None` if `data` is longer.
    pub fn new(toggle: bool, data: &[u8], last: bool) -> Option<Self> {
        if data.len() > 7 {
            return None;
        }
        let mut segment = Self { toggle, last, data: [0; 7], len: data.len() as u8 };
        segment.data[..data.len()].copy_from_slice(data);
        Some(segment)
    }

    /// The used bytes.
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }

    const fn bits(&self) -> u8 {
        (self.toggle as u8) << 4 | (7 - self.len) << 1 | self.last as u8
    }

    /// Reads the bytes after the command byte; only the used bytes are required.
    fn parse(command: u8, input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let len = 7 - usize::from(command >> 1 & 0b111);
        let (input, data) = named("the data that the command byte announces", take(len)).parse(input)?;
        let segment = Self::new(command & 0x10 != 0, data, command & 1 != 0);
        debug_assert!(segment.is_some(), "three bits can't announce more than seven bytes");
        let segment = segment.unwrap_or(Self { toggle: false, last: true, data: [0; 7], len: 0 });
        Ok((&input[input.len().min(7 - len)..], segment))
    }

    fn emit(&self, command_specifier: u8, buffer: &mut [u8; 8]) {
        buffer[0] = command_specifier << 5 | self.bits();
        buffer[1..].copy_from_slice(&self.data);
    }
}

fn multiplexer(input: &[u8]) -> IResult<&[u8], Multiplexer, Malformed> {
    named("index and sub-index", take(3_usize)).map(|b: &[u8]| Multiplexer::from_bytes([b[0], b[1], b[2]])).parse(input)
}

fn four(input: &[u8]) -> IResult<&[u8], [u8; 4], Malformed> {
    le_u32.map(u32::to_le_bytes).parse(input)
}

/// Drops the reserved bytes at the end of a message, as far as they exist.
fn skip_reserved(input: &[u8], n: usize) -> &[u8] {
    &input[input.len().min(n)..]
}

/// Fills an eight-byte message: command byte, multiplexer, four bytes.
fn emit_initiate(command: u8, multiplexer: Multiplexer, tail: [u8; 4], buffer: &mut [u8; 8]) {
    buffer[0] = command;
    buffer[1..4].copy_from_slice(&multiplexer.to_bytes());
    buffer[4..].copy_from_slice(&tail);
}

/// Fills an eight-byte message with the given bytes, then reserved bytes.
fn emit_short(head: &[u8], buffer: &mut [u8; 8]) {
    *buffer = [0; 8];
    buffer[..head.len()].copy_from_slice(head);
}
