//! CDR, the encoding of ROS 2 (OMG CORBA 3.3 part 2, 9.3; DDS-XTypes 1.3, 7.4).
//!
//! A header of 4 bytes gives the byte order: `00 00` big-endian, `00 01` little-endian (CDR); `00 06`, `00 07` are the
//! same in version 2, which aligns numbers of 8 bytes to 4. **Alignment counts from the end of this header.** A text is
//! its length, including its closing zero, and its bytes.

use super::plan::Layout;
use super::run::{Extent, Run};
use crate::damage::Flaw;

/// A message: the bytes after its header.
pub(crate) struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    little: bool,
    /// The maximum alignment of a number.
    widest: usize,
}

impl<'a> Cdr<'a> {
    /// Reads the header of a message.
    #[inline]
    pub(crate) fn new(message: &'a [u8]) -> Result<Self, Flaw> {
        let Some((&[high, low, _, _], bytes)) = message.split_first_chunk() else {
            return Err(Flaw::malformed("a CDR header of 4 bytes", format!("{} bytes", message.len())));
        };
        let (little, widest) = match (high, low) {
            (0, 0) => (false, 8),
            (0, 1) => (true, 8),
            (0, 6) => (false, 4),
            (0, 7) => (true, 4),
            _ => return Err(Flaw::unsupported("CDR representation 0, 1, 6 or 7", format!("{high:02X}{low:02X}h"))),
        };
        Ok(Self { bytes, at: 0, little, widest })
    }

    #[inline]
    fn align(&mut self, size: usize) {
        // Sizes are powers of two, so this number is a mask.
        let below = size.min(self.widest) - 1;
        self.at = (self.at + below) & !below;
    }
}

impl<'a> Layout<'a> for Cdr<'a> {
    #[inline]
    fn number(&mut self, size: usize) -> Option<u64> {
        self.align(size);
        let bytes = self.bytes(size)?;
        self.placed(bytes, size)
    }

    #[inline]
    fn placed(&self, bytes: &[u8], size: usize) -> Option<u64> {
        Some(match (size, self.little) {
            (1, _) => u64::from(*bytes.first()?),
            (4, true) => u64::from(u32::from_le_bytes(*bytes.first_chunk()?)),
            (_, true) => bytes.get(..size)?.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte)),
            (_, false) => bytes.get(..size)?.iter().fold(0, |number, &byte| number << 8 | u64::from(byte)),
        })
    }

    #[inline]
    fn run<'r>(&mut self, run: &'r Run) -> Option<(&'a [u8], &'r Extent)> {
        self.align(run.align);
        Some((self.bytes(run.aligned.len)?, &run.aligned))
    }

    fn skip_numbers(&mut self, size: usize, count: usize) -> Option<()> {
        if count > 0 {
            self.align(size);
        }
        self.bytes(size.checked_mul(count)?).map(|_| ())
    }

    #[inline]
    fn skip_text(&mut self, wide: bool) -> Option<()> {
        // A wide text has no closing zero; its length counts characters of two bytes.
        let length = usize::try_from(self.number(4)?).ok()?;
        self.bytes(length.checked_mul(if wide { 2 } else { 1 })?).map(|_| ())
    }

    #[inline]
    fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let bytes = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alignment_counts_from_behind_the_header() {
        let message =
            [0, 1, 0, 0, 0xAA, 0, 0, 0, 0x78, 0x56, 0x34, 0x12, 1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0];
        let mut cdr = Cdr::new(&message).unwrap();
        assert_eq!([cdr.number(1), cdr.number(4), cdr.number(1)], [Some(0xAA), Some(0x1234_5678), Some(1)]);
        assert_eq!((cdr.number(8), cdr.number(1)), (Some(2), None));
        let mut second = message;
        second[1] = 7;
        let mut cdr = Cdr::new(&second).unwrap();
        assert_eq!([cdr.number(1), cdr.number(4), cdr.number(1)], [Some(0xAA), Some(0x1234_5678), Some(1)]);
        assert_eq!(cdr.number(8), Some(2 << 32), "version 2 aligns eight bytes to four");
    }

    #[test]
    fn texts_and_the_other_byte_order() {
        let mut cdr = Cdr::new(b"\0\0\0\0\0\0\0\x05can0\0\0\0\0\x12\x34").unwrap();
        assert_eq!((cdr.skip_text(false), cdr.skip_numbers(1, 0), cdr.number(2)), (Some(()), Some(()), Some(0)));
        assert_eq!((cdr.number(2), cdr.number(2)), (Some(0x1234), None));
        assert!(Cdr::new(b"\0\x03\0\0").is_err());
        assert!(Cdr::new(b"\0\x01").is_err());
    }
}
