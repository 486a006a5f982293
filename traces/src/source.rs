//! A source of bytes, seen through a window that moves forward.

use std::io::{self, BufRead, Read};

/// Bytes from a file, a pipe or a decompressor.
///
/// A reader looks at the [`window`](Source::window), [consumes](Source::consume) the parsed bytes, and calls
/// [`fill`](Source::fill) if a line or packet is incomplete. Memory is bounded: the window never exceeds its limit,
/// for a source of any length.
pub struct Source {
    reader: Box<dyn Read + Send>,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    /// The offset of `start` in the source.
    offset: u64,
    limit: usize,
    ended: bool,
}

/// Why a source can't give more bytes.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// The operating system or the decompressor reports an error.
    #[error("can't continue reading: {0}")]
    Io(#[from] io::Error),
    /// A single line or packet fills the whole window.
    #[error("a single line or packet is longer than {0} bytes")]
    Full(usize),
}

impl Source {
    /// Number of bytes requested from the system at once.
    const CHUNK: usize = 256 * 1024;
    /// The default limit of the window.
    pub const LIMIT: usize = 1024 * 1024;

    /// A source with the usual limit.
    pub fn new(reader: impl Read + Send + 'static) -> Self {
        Self::with_limit(reader, Self::LIMIT)
    }

    /// A source whose window holds at most `limit` bytes (at least one chunk).
    pub fn with_limit(reader: impl Read + Send + 'static, limit: usize) -> Self {
        Self {
            reader: Box::new(reader),
            buffer: vec![0; Self::CHUNK],
            start: 0,
            end: 0,
            offset: 0,
            limit: limit.max(Self::CHUNK),
            ended: false,
        }
    }

    /// A source of bytes in memory.
    pub fn from_bytes(bytes: impl Into<Vec<u8>>) -> Self {
        Self::new(io::Cursor::new(bytes.into()))
    }

    /// The buffered bytes; more may follow.
    #[inline]
    pub fn window(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// The offset of the window's first byte in the source.
    #[inline]
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// Whether the source has ended, so that no bytes follow the window.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// Moves the window forward by `n` bytes, at most to its end.
    #[inline]
    pub fn consume(&mut self, n: usize) {
        let n = n.min(self.end - self.start);
        self.start += n;
        self.offset += n as u64;
        self.check_window();
    }

    /// Checks the invariant that the window lies inside the buffer: all slices of the window rely on it.
    #[inline]
    fn check_window(&self) {
        debug_assert!(self.start <= self.end && self.end <= self.buffer.len());
    }

    /// Reads more bytes, at least one unless the source has ended; returns whether it read any.
    ///
    /// The call returns as soon as bytes arrive, so that a line from a pipe can be shown before the next one is
    /// complete.
    ///
    /// # Errors
    /// [`SourceError::Full`] if the window is at its limit, [`SourceError::Io`] if reading fails.
    pub fn fill(&mut self) -> Result<bool, SourceError> {
        if self.ended {
            return Ok(false);
        }
        self.make_room()?;
        loop {
            match self.reader.read(&mut self.buffer[self.end..]) {
                Ok(0) => {
                    self.ended = true;
                    return Ok(false);
                }
                Ok(n) => {
                    self.end += n;
                    self.check_window();
                    return Ok(true);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => {
                    self.ended = true;
                    return Err(error.into());
                }
            }
        }
    }

    /// Reads until the window holds at least `n` bytes; returns whether it does.
    ///
    /// # Errors
    /// See [`Source::fill`].
    #[inline]
    pub fn fill_to(&mut self, n: usize) -> Result<bool, SourceError> {
        while self.end - self.start < n {
            if !self.fill()? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Skips the next `n` bytes without buffering them; returns the number of bytes skipped.
    ///
    /// # Errors
    /// [`SourceError::Io`] if reading fails.
    pub fn skip(&mut self, n: u64) -> Result<u64, SourceError> {
        let mut left = n;
        loop {
            let now = self.window().len().min(usize::try_from(left).unwrap_or(usize::MAX));
            self.consume(now);
            left -= now as u64;
            if left == 0 || !self.fill()? {
                return Ok(n - left);
            }
        }
    }

    fn make_room(&mut self) -> Result<(), SourceError> {
        if self.start > 0 {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
        }
        if self.end == self.buffer.len() {
            if self.end >= self.limit {
                return Err(SourceError::Full(self.limit));
            }
            let larger = (2 * self.buffer.len()).min(self.limit);
            self.buffer.resize(larger, 0);
        }
        Ok(())
    }
}

/// Reads the window's bytes, then the bytes after it: for a decompressor on top of a source.
impl Read for Source {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let held = self.fill_buf()?;
        let n = held.len().min(buffer.len());
        buffer[..n].copy_from_slice(&held[..n]);
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Source {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.start == self.end {
            self.fill().map_err(|error| match error {
                SourceError::Io(error) => error,
                full @ SourceError::Full(_) => io::Error::other(full),
            })?;
        }
        Ok(self.window())
    }

    fn consume(&mut self, n: usize) {
        Self::consume(self, n);
    }
}

impl std::fmt::Debug for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Source(offset {}, {} bytes at hand)", self.offset, self.end - self.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_moves_and_tells_where_it_is() {
        let mut source = Source::from_bytes(*b"abcdef");
        assert!(source.fill().unwrap());
        source.consume(2);
        assert_eq!((source.window(), source.offset()), (&b"cdef"[..], 2));
        assert!(!source.fill().unwrap());
        assert!(source.ended());
    }

    #[test]
    fn the_window_does_not_grow_beyond_its_limit() {
        let mut source = Source::with_limit(io::repeat(b'x'), 2 * Source::CHUNK);
        let error = source.fill_to(usize::MAX).unwrap_err();
        assert!(matches!(error, SourceError::Full(n) if n == 2 * Source::CHUNK));
    }

    #[test]
    fn skipping_takes_no_memory_and_tells_where_the_source_ends() {
        let mut source = Source::new(io::repeat(0).take(5_000_000));
        assert_eq!(source.skip(4_999_999).unwrap(), 4_999_999);
        assert_eq!(source.offset(), 4_999_999);
        assert_eq!(source.skip(u64::MAX).unwrap(), 1);
    }

    #[test]
    fn what_a_pipe_gives_is_there_at_once() {
        struct Trickle(u8);
        impl Read for Trickle {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                buffer[0] = self.0;
                self.0 += 1;
                Ok(1)
            }
        }
        let mut source = Source::new(Trickle(b'a'));
        source.fill().unwrap();
        assert_eq!(source.window(), b"a");
        source.fill().unwrap();
        assert_eq!(source.window(), b"ab");
    }
}
