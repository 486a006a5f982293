//! Channels: the place of a value in a record, and its conversion.

use super::block::{Block, chain};
use super::conversion::Conversion;
use crate::damage::Flaw;
use nom::number::complete::{le_u32, u8};
use nom::{IResult, Parser};

/// Number of levels of members in members; frames have one.
const DEEPEST: u32 = 4;
/// Limit of the number of channels in a group.
const MOST: usize = 4096;

/// A channel of a group.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    /// The name, such as `CAN_DataFrame.ID`.
    pub name: String,
    kind: u8,
    encoding: u8,
    bit_offset: u8,
    byte_offset: u32,
    bit_count: u32,
    conversion: Conversion,
    /// The block with the values, if these have variable lengths.
    pub values: Option<u64>,
}

const VARIABLE_LENGTH: u8 = 1;
const MASTER: u8 = 2;
/// Kinds of channels without a place in the record: their value is all in the conversion.
const VIRTUAL_MASTER: u8 = 3;
const VIRTUAL: u8 = 6;
const FLOATS: [u8; 2] = [4, 5];
const BIG_ENDIAN: [u8; 3] = [1, 3, 5];
/// The last bit of a byte.
const LAST_BIT: u8 = 7;
/// Widest number, in bits.
const WIDEST: u32 = 64;

struct ValuePlace {
    kind: u8,
    encoding: u8,
    bit_offset: u8,
    byte_offset: u32,
    bit_count: u32,
}

/// Parses type, kind of synchronisation, encoding, bit offset, byte offset, number of bits.
fn place(i: &[u8]) -> IResult<&[u8], ValuePlace> {
    (u8, u8, u8, u8, le_u32, le_u32)
        .map(|(kind, _, encoding, bit_offset, byte_offset, bit_count)| ValuePlace {
            kind,
            encoding,
            bit_offset,
            byte_offset,
            bit_count,
        })
        .parse(i)
}

/// All channels of a group, and their members.
pub(super) fn channels(file: &[u8], first: Option<u64>) -> Result<Vec<Channel>, Flaw> {
    let mut all = Vec::new();
    collect(file, first, DEEPEST, &mut all)?;
    Ok(all)
}

fn collect(file: &[u8], first: Option<u64>, depth: u32, all: &mut Vec<Channel>) -> Result<(), Flaw> {
    for block in chain(file, first, b"CN") {
        let block = block?;
        if all.len() >= MOST {
            return Err(Flaw::unsupported(format!("at most {MOST} channels in a group"), "more"));
        }
        all.push(Channel::read(file, &block)?);
        // An array has no channels as members.
        let members = block.link(1).filter(|at| Block::read(file, *at).is_ok_and(|block| block.id == *b"CN"));
        if depth > 0 && members.is_some() {
            collect(file, members, depth - 1, all)?;
        }
    }
    Ok(())
}

/// The text of a block TX; empty without a link.
fn text(file: &[u8], link: Option<u64>) -> Result<String, Flaw> {
    let Some(offset) = link else { return Ok(String::new()) };
    let bytes = Block::expect(file, offset, b"TX")?.data;
    Ok(String::from_utf8_lossy(bytes.split(|byte| *byte == 0).next().unwrap_or_default()).into_owned())
}

impl Channel {
    fn read(file: &[u8], block: &Block<'_>) -> Result<Self, Flaw> {
        let Ok((_, ValuePlace { kind, encoding, bit_offset, byte_offset, bit_count })) = place(block.data) else {
            return Err(Flaw::malformed("a whole channel", format!("{} bytes", block.data.len())));
        };
        if bit_offset > LAST_BIT {
            return Err(Flaw::malformed("a bit of a byte, 0 to 7", bit_offset.to_string()));
        }
        let conversion = block.link(4).map(|offset| Block::expect(file, offset, b"CC")).transpose()?;
        let conversion = conversion.map_or(Ok(Conversion::None), |block| Conversion::read(block.data))?;
        Ok(Self {
            name: text(file, block.link(2))?,
            kind,
            encoding,
            bit_offset,
            byte_offset,
            bit_count,
            conversion,
            values: block.link(5),
        })
    }

    /// Whether the value lies within a record of `length` bytes.
    pub const fn fits(&self, length: usize) -> bool {
        let bits = self.bit_offset as u64 + self.bit_count as u64;
        matches!(self.kind, VIRTUAL_MASTER | VIRTUAL) || self.byte_offset as u64 + bits.div_ceil(8) <= length as u64
    }

    /// Whether the channel is the time of the group.
    pub const fn is_master(&self) -> bool {
        matches!(self.kind, MASTER | VIRTUAL_MASTER)
    }

    /// Whether the record has the place of the value among values of variable length.
    pub const fn has_variable_length(&self) -> bool {
        self.kind == VARIABLE_LENGTH
    }

    /// The converted number in a record; `None` if the record is too short.
    pub fn number(&self, record: &[u8]) -> Option<u64> {
        self.raw(record).map(|raw| self.conversion.whole(raw))
    }

    /// The number in a record, without conversion.
    fn raw(&self, record: &[u8]) -> Option<u64> {
        if self.kind == VIRTUAL {
            return Some(0);
        }
        if self.bit_count == 0 || self.bit_count > WIDEST {
            return None;
        }
        let length = (u32::from(self.bit_offset) + self.bit_count).div_ceil(8) as usize;
        let bytes = record.get(self.byte_offset as usize..)?.get(..length)?;
        let join = |all: u128, byte: &u8| all << 8 | u128::from(*byte);
        let all = if BIG_ENDIAN.contains(&self.encoding) {
            bytes.iter().fold(0, join)
        } else {
            bytes.iter().rev().fold(0, join)
        };
        Some((all >> self.bit_offset) as u64 & (u64::MAX >> (WIDEST - self.bit_count)))
    }

    /// The bytes in a record.
    pub fn bytes<'a>(&self, record: &'a [u8]) -> Option<&'a [u8]> {
        record.get(self.byte_offset as usize..)?.get(..self.bit_count as usize / 8)
    }

    /// A time in seconds as nanoseconds. A recording that was made of an older one has times before its start.
    pub fn nanoseconds(&self, record: &[u8]) -> Option<i64> {
        const SECOND: f64 = 1e9;
        let raw = self.raw(record)?;
        let [offset, factor] = self.conversion.linear();
        let unit = (factor * SECOND).round();
        if !FLOATS.contains(&self.encoding) && offset == 0.0 && unit >= 1.0 && (factor * SECOND - unit).abs() < 1e-3 {
            return raw.checked_mul(unit as u64).and_then(|time| i64::try_from(time).ok());
        }
        let value = match (FLOATS.contains(&self.encoding), self.bit_count) {
            (true, 32) => f64::from(f32::from_bits(raw as u32)),
            (true, _) => f64::from_bits(raw),
            (false, _) => raw as f64,
        };
        let nanoseconds = ((offset + factor * value) * SECOND).round();
        (nanoseconds.abs() < i64::MAX as f64).then_some(nanoseconds as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(encoding: u8, bit_offset: u8, byte_offset: u32, bit_count: u32) -> Channel {
        Channel {
            name: String::new(),
            kind: 0,
            encoding,
            bit_offset,
            byte_offset,
            bit_count,
            conversion: Conversion::None,
            values: None,
        }
    }

    #[test]
    fn numbers_of_any_width_and_place() {
        let record = [0x12, 0x34, 0x56, 0x78, 0x9A];
        assert_eq!(channel(0, 0, 1, 16).number(&record), Some(0x5634));
        assert_eq!(channel(1, 0, 1, 16).number(&record), Some(0x3456));
        assert_eq!(channel(0, 4, 0, 12).number(&record), Some(0x341));
        assert_eq!(channel(0, 7, 4, 1).number(&record), Some(1));
        assert_eq!(channel(0, 0, 4, 16).number(&record), None, "beyond the record");
        assert_eq!(channel(0, 0, 0, 65).number(&record), None);
    }

    #[test]
    fn times_in_seconds() {
        let seconds = channel(4, 0, 0, 64);
        assert_eq!(seconds.nanoseconds(&1.5f64.to_le_bytes()), Some(1_500_000_000));
        assert_eq!(seconds.nanoseconds(&(-1.0f64).to_le_bytes()), Some(-1_000_000_000));
        assert_eq!(seconds.nanoseconds(&1e300f64.to_le_bytes()), None);
        assert_eq!(seconds.nanoseconds(&f64::NAN.to_le_bytes()), None);
        let ticks = Channel { conversion: Conversion::Linear([0.0, 1e-9]), ..channel(0, 0, 0, 64) };
        let exact = 9_007_199_254_740_993_i64;
        assert_eq!(ticks.nanoseconds(&exact.to_le_bytes()), Some(exact), "more digits than a float has");
        let coarse = Channel { conversion: Conversion::Linear([0.5, 1e-6]), ..channel(0, 0, 0, 32) };
        assert_eq!(coarse.nanoseconds(&[1, 0, 0, 0]), Some(500_001_000));
    }
}
