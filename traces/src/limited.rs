//! A part of a source, for a decompressor on top of it.

use crate::Source;
use std::io::{self, BufRead, Read};

/// A source's next bytes, up to an end.
pub(crate) struct Limited<'a> {
    source: &'a mut Source,
    left: u64,
    cut: bool,
}

/// How unpacking such a part ended.
#[derive(Debug)]
pub(crate) enum Unpacked {
    Whole,
    /// The source ended before the part: what was there is unpacked.
    Cut,
    /// All is unpacked, but the part is said to have so many more bytes: they may be others'.
    Overlong(u64),
    /// Nothing of what was unpacked can be trusted.
    Damaged {
        expected: String,
        found: String,
    },
}

impl<'a> Limited<'a> {
    /// The next `length` bytes of a source.
    pub(crate) fn new(source: &'a mut Source, length: u64) -> Self {
        Self { source, left: length, cut: false }
    }

    /// Whether the source ended or failed before the end.
    pub(crate) fn is_cut(&self) -> bool {
        self.cut
    }

    /// How many bytes were not read yet.
    pub(crate) fn left(&self) -> u64 {
        self.left
    }
}

impl BufRead for Limited<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.left == 0 {
            return Ok(&[]);
        }
        let left = usize::try_from(self.left).unwrap_or(usize::MAX);
        self.cut = !matches!(BufRead::fill_buf(self.source), Ok(bytes) if !bytes.is_empty());
        let window = self.source.window();
        Ok(&window[..window.len().min(left)])
    }

    fn consume(&mut self, n: usize) {
        self.source.consume(n);
        self.left -= (n as u64).min(self.left);
    }
}

impl Read for Limited<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let bytes = self.fill_buf()?;
        let n = bytes.len().min(buffer.len());
        buffer[..n].copy_from_slice(&bytes[..n]);
        self.consume(n);
        Ok(n)
    }
}
