//! Segments of SDO block transfers, and their checksum.

use crate::wire::{Field, Fields, Layout, Malformed, Wire, named};
use nom::{IResult, Parser, bytes::complete::take, number::complete::u8};

/// A segment of a block transfer. Only the state of the transfer distinguishes it from a command.
///
/// ```text
/// byte 0: csssssss    c no more segments, s sequence number 1..127    bytes 1..7: data
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct BlockSegment {
    /// The sequence number, 1 to 127, counted anew in every sub-block; 0 is illegal.
    pub sequence: u8,
    /// Whether it is the last segment of the transfer.
    pub last: bool,
    /// Seven bytes; the end of the transfer tells how many of the last segment's bytes count.
    pub data: [u8; 7],
}

impl BlockSegment {
    /// The highest sequence number, and the largest block size.
    pub const MAX: u8 = 127;
}

impl Wire for BlockSegment {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (input, head) = named("a sequence number", u8).parse(input)?;
        let (input, bytes) = named("seven bytes of data", take(7_usize)).parse(input)?;
        let mut data = [0; 7];
        data.copy_from_slice(bytes);
        Ok((input, Self { sequence: head & 0x7F, last: head & 0x80 != 0, data }))
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        buffer[0] = u8::from(self.last) << 7 | self.sequence & 0x7F;
        buffer[1..].copy_from_slice(&self.data);
        8
    }
}

static SEGMENT: Layout = Layout {
    name: "block segment",
    fields: &[
        Field::new("sequence number", 0, 0, 7),
        Field::new("no more segments", 0, 7, 1),
        Field::new("data", 1, 0, 56),
    ],
};

impl Fields for BlockSegment {
    const LAYOUTS: &'static [&'static Layout] = &[&SEGMENT];

    fn layout(&self) -> &'static Layout {
        &SEGMENT
    }
}

/// The CRC-16 of block transfers: polynomial 1021h, start value 0, no reflection (CiA 301).
///
/// To continue a calculation, pass the earlier result as `start`; otherwise 0.
pub fn crc16(start: u16, data: &[u8]) -> u16 {
    data.iter().fold(start, |crc, &byte| crc << 8 ^ CRC_TABLE[usize::from((crc >> 8) as u8 ^ byte)])
}

const CRC_TABLE: [u16; 256] = {
    let mut table = [0; 256];
    let mut n = 0;
    while n < 256 {
        let mut crc = (n as u16) << 8;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 0x8000 != 0 { crc << 1 ^ 0x1021 } else { crc << 1 };
            bit += 1;
        }
        table[n] = crc;
        n += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::vectors::both_ways;
    use proptest::prelude::*;

    #[test]
    fn segments() {
        both_ways(
            &[0x21, 1, 2, 3, 4, 5, 6, 7],
            BlockSegment { sequence: 0x21, last: false, data: [1, 2, 3, 4, 5, 6, 7] },
        );
        both_ways(&[0xFF, 0, 0, 0, 0, 0, 0, 0], BlockSegment { sequence: 127, last: true, data: [0; 7] });
        assert!(BlockSegment::read(&[1, 2, 3]).is_err());
    }

    /// The check value of CRC-16/XMODEM, which CiA 301 uses.
    #[test]
    fn check_value() {
        assert_eq!(crc16(0, b"123456789"), 0x31C3);
    }

    proptest! {
        #[test]
        fn crc_in_pieces(data in proptest::collection::vec(any::<u8>(), 0..100), cut in 0usize..100) {
            let (head, tail) = data.split_at(cut.min(data.len()));
            prop_assert_eq!(crc16(crc16(0, head), tail), crc16(0, &data));
        }
    }
}
