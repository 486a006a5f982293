//! A part of a source, for a decompressor on top of it.

use crate::Source;
use std::io::{self, BufRead, Read};

/// The next bytes of a source, up to a given length.
pub(crate) struct Limited<'a> {
    source: &'a mut Source,
    left: u64,
    cut: bool,
}

/// The reason why unpacking a part of a source ended.
#[derive(Debug)]
pub(crate) enum Unpacked {
    Whole,
    /// The source ended before the part; the bytes before its end are unpacked.
    Cut,
    /// Everything is unpacked, but the part is longer by this number of bytes, which may belong to other records.
    Overlong(u64),
    /// The unpacked bytes can't be trusted.
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

    /// Whether the source ended or failed before the end of the part.
    pub(crate) fn is_cut(&self) -> bool {
        self.cut
    }

    /// The number of bytes of the part that are not read yet.
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
