//! Texts in UTF-16, as some editors write them, and texts whose lines end in a carriage return alone, as SLCAN adapters
//! send them.
//!
//! Offsets are those in the text in UTF-8 with line feeds.

use crate::{Source, SourceError};
use std::io::{self, Read};

/// Number of bytes that are converted at once.
const CHUNK: usize = 16 * 1024;
/// Number of bytes in which the first line end is searched for.
const LONGEST_LINE: usize = 256;

/// The source itself, or its text in UTF-8 with line feeds.
///
/// # Errors
/// [`SourceError`] if the first bytes can't be read.
pub(crate) fn readable(mut source: Source) -> Result<Source, SourceError> {
    while matches!(source.window(), [] | [0xFE | 0xFF]) {
        if !source.fill()? {
            break;
        }
    }
    Ok(match source.window() {
        [0xFF, 0xFE, ..] => Source::new(Utf16::new(source, u16::from_le_bytes)),
        [0xFE, 0xFF, ..] => Source::new(Utf16::new(source, u16::from_be_bytes)),
        head if has_bare_returns(head) => Source::new(Returns(source)),
        _ => source,
    })
}

/// Whether the first line is a text that ends in a carriage return, and more follows it than a line feed.
fn has_bare_returns(head: &[u8]) -> bool {
    let head = head.get(..head.len().min(LONGEST_LINE)).unwrap_or_default();
    let line = head.iter().position(|byte| *byte == b'\r').unwrap_or(head.len());
    let is_text = |byte: &u8| matches!(byte, b' '..=b'~' | b'\t');
    let is_first = line > 0 && head.iter().take(line).all(is_text) && !head.contains(&b'\n');
    is_first && matches!(head.get(line..), Some([b'\r', next, ..]) if is_text(next) || *next == b'\r')
}

/// Text in UTF-16 as UTF-8.
struct Utf16 {
    source: Source,
    unit: fn([u8; 2]) -> u16,
    converted: Vec<u8>,
    given: usize,
    /// The first half of a character beyond U+FFFF.
    high: Option<u16>,
    is_first: bool,
}

impl Utf16 {
    fn new(source: Source, unit: fn([u8; 2]) -> u16) -> Self {
        Self { source, unit, converted: Vec::new(), given: 0, high: None, is_first: true }
    }

    /// Converts the next units; nothing is left to convert if nothing is converted.
    fn convert(&mut self) -> io::Result<()> {
        self.converted.clear();
        self.given = 0;
        while self.source.window().len() < 2 {
            if !self.source.fill().map_err(io::Error::other)? {
                break;
            }
        }
        let window = self.source.window();
        let len = (window.len() & !1).min(CHUNK);
        let (unit, high) = (self.unit, self.high.take());
        let pairs = window.get(..len).unwrap_or_default().chunks_exact(2);
        let units = high.into_iter().chain(pairs.map(|pair| unit([pair[0], pair[1]])));
        let mut units: Vec<u16> = units.skip(usize::from(std::mem::take(&mut self.is_first))).collect();
        if let Some(last @ 0xD800..=0xDBFF) = units.last().copied()
            && len > 0
        {
            units.pop();
            self.high = Some(last);
        }
        for char in char::decode_utf16(units) {
            let char = char.unwrap_or(char::REPLACEMENT_CHARACTER);
            self.converted.extend_from_slice(char.encode_utf8(&mut [0; 4]).as_bytes());
        }
        self.source.consume(len);
        Ok(())
    }
}

impl Read for Utf16 {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.given == self.converted.len() {
            self.convert()?;
            if self.converted.is_empty() && self.source.window().len() < 2 && self.high.is_none() && self.source.ended()
            {
                return Ok(0);
            }
        }
        let rest = self.converted.get(self.given..).unwrap_or_default();
        let len = rest.len().min(buffer.len());
        buffer.iter_mut().zip(rest).for_each(|(place, byte)| *place = *byte);
        self.given += len;
        Ok(len)
    }
}

/// Text whose carriage returns are line ends.
struct Returns(Source);

impl Read for Returns {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let len = self.0.read(buffer)?;
        let read = buffer.iter_mut().take(len);
        read.filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
        Ok(len)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn text(bytes: Vec<u8>) -> String {
        let mut text = Vec::new();
        readable(Source::from_bytes(bytes)).unwrap().read_to_end(&mut text).unwrap();
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn only_bare_returns_are_line_ends() {
        assert_eq!(text(b"one\rtwo\rthree\r".to_vec()), "one\ntwo\nthree\n");
        for same in ["one\r\ntwo\rthree\r\n", "one\ntwo\r", "one\r", "\rone\rtwo", "", "one"] {
            assert_eq!(text(same.into()), same);
        }
    }

    #[test]
    fn halves_become_the_mark_of_what_is_unreadable() {
        assert_eq!(
            text([&[0xFF, 0xFE, b'a', 0, 0x00, 0xD8, b'b', 0, 0x00, 0xD8][..], &[1]].concat()),
            "a\u{FFFD}b\u{FFFD}"
        );
        assert_eq!(text(vec![0xFF, 0xFE]), "");
        assert_eq!(readable(Source::from_bytes([0xFF])).unwrap().window(), [0xFF]);
    }

    proptest! {
        #[test]
        fn both_orders_come_back(words in prop::collection::vec("\\PC{0,9}", 0..50), times in 1..900_usize) {
            let original = words.join(" ").repeat(times);
            let units: Vec<u16> = std::iter::once(0xFEFF).chain(original.encode_utf16()).collect();
            let little = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
            let big = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
            prop_assert!(text(little) == original && text(big) == original);
        }
    }
}
