//! The encoding of ROS 1: little-endian, packed, a text is its length and its bytes, without a closing zero.

use super::plan::Layout;
use super::run::{Extent, Run};

/// The rest of a message.
pub(crate) struct Ros1<'a>(pub(crate) &'a [u8]);

impl<'a> Layout<'a> for Ros1<'a> {
    #[inline]
    fn number(&mut self, size: usize) -> Option<u64> {
        let bytes = self.bytes(size)?;
        self.placed(bytes, size)
    }

    #[inline]
    fn placed(&self, bytes: &[u8], size: usize) -> Option<u64> {
        Some(bytes.get(..size)?.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte)))
    }

    #[inline]
    fn run<'r>(&mut self, run: &'r Run) -> Option<(&'a [u8], &'r Extent)> {
        Some((self.bytes(run.packed.len)?, &run.packed))
    }

    fn skip_numbers(&mut self, size: usize, count: usize) -> Option<()> {
        self.bytes(size.checked_mul(count)?).map(|_| ())
    }

    #[inline]
    fn skip_text(&mut self, _wide: bool) -> Option<()> {
        let length = usize::try_from(self.number(4)?).ok()?;
        self.bytes(length).map(|_| ())
    }

    #[inline]
    fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(bytes)
    }
}
