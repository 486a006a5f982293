//! Splits a text into lines, and classifies the bytes of each in one pass.

use super::MARK;
use crate::dictionary::place::Span;

/// A line without its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<'t> {
    pub text: &'t str,
    /// The offset of the line's beginning in the text.
    pub start: usize,
    /// Whether the line consists of printable ASCII characters and tabs only.
    pub is_plain: bool,
    /// The offset of the first equals sign from the line's beginning; only for a plain line.
    equals: Option<usize>,
}

impl<'t> Line<'t> {
    /// The line without blanks and zeros at both ends.
    pub(crate) fn trimmed(self) -> Self {
        let is_before = |character| is_blank(character) || character == MARK && self.start == 0;
        let text = if self.is_plain { self.text.trim_ascii_start() } else { self.text.trim_start_matches(is_before) };
        let cut = self.text.len() - text.len();
        let equals = self.equals.and_then(|equals| equals.checked_sub(cut));
        let text = if self.is_plain { text.trim_ascii_end() } else { text.trim_end_matches(is_blank) };
        Self { text, start: self.start + cut, equals, ..self }
    }

    /// The two sides of the equals sign, without blanks around them.
    pub fn sides(&self) -> Option<(&'t str, &'t str)> {
        if self.is_plain {
            let equals = self.equals?;
            let (name, value) = (self.text.get(..equals)?, self.text.get(equals + 1..)?);
            return Some((name.trim_ascii_end(), value.trim_ascii_start()));
        }
        let (name, value) = self.text.split_once('=')?;
        Some((name.trim_end(), value.trim_start()))
    }

    /// The range of the line.
    pub const fn span(&self) -> Span {
        Span::new(self.start, self.start + self.text.len())
    }
}

/// Whether a character around a line or a field is insignificant.
pub(super) fn is_blank(character: char) -> bool {
    character.is_whitespace() || character == '\0'
}

/// The meaning of a byte for its line.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Plain,
    Equals,
    /// A control character, or a part of a character beyond ASCII.
    Other,
    End,
}

const KINDS: [Kind; 256] = {
    let mut kinds = [Kind::Other; 256];
    let mut byte = b' ';
    while byte < 0x7F {
        kinds[byte as usize] = Kind::Plain;
        byte += 1;
    }
    kinds[b'\t' as usize] = Kind::Plain;
    kinds[b'=' as usize] = Kind::Equals;
    kinds[b'\n' as usize] = Kind::End;
    kinds[b'\r' as usize] = Kind::End;
    kinds
};

/// The lines of a text, which end in LF, CR LF or CR alone. After the last line end there is one more, empty line.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let mut next = Some(0);
    std::iter::from_fn(move || {
        let (line, after) = line_at(text, next?);
        next = after;
        Some(line)
    })
}

/// The line that begins at `start`, and the offset of the next one.
fn line_at(text: &str, start: usize) -> (Line<'_>, Option<usize>) {
    let (mut is_plain, mut equals) = (true, None);
    let rest = text.get(start..).unwrap_or_default();
    for (at, &byte) in rest.as_bytes().iter().enumerate() {
        match KINDS[byte as usize] {
            Kind::Plain => {}
            Kind::Equals => equals = equals.or(Some(at)),
            Kind::Other => is_plain = false,
            Kind::End => {
                let line = Line { text: rest.get(..at).unwrap_or_default(), start, is_plain, equals };
                let is_both = byte == b'\r' && rest.as_bytes().get(at + 1) == Some(&b'\n');
                return (line, Some(start + at + 1 + usize::from(is_both)));
            }
        }
    }
    (Line { text: rest, start, is_plain, equals }, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lines_end_in_three_ways() {
        let all: Vec<&str> = lines("a\nb\r\nc\rd\r\r\n\n").map(|line| line.text).collect();
        assert_eq!(all, ["a", "b", "c", "d", "", "", ""]);
    }

    proptest! {
        #[test]
        fn plain_lines_are_read_as_all_others(text in "[ \t=a;\\[]{0,12}") {
            let line = line_at(&text, 0).0;
            prop_assert!(line.is_plain);
            let other = Line { is_plain: false, ..line };
            prop_assert_eq!(line.trimmed().text, other.trimmed().text);
            prop_assert_eq!(line.trimmed().sides(), other.trimmed().sides());
        }
    }
}
