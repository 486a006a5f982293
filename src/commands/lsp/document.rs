//! An open file, and conversion between bytes and the protocol's positions.

use canvass_analyzer::dictionary::check::Checked;
use canvass_analyzer::dictionary::source::{LARGEST_FILE, Source};
use lsp_types::{Position, PositionEncodingKind, Range, TextDocumentContentChangeEvent};
use std::cell::OnceCell;

/// The text of an open file.
pub struct Document {
    pub text: String,
    pub version: i32,
    /// The byte at which each line begins.
    starts: Vec<usize>,
    /// The result of the check; empty after a change.
    checked: OnceCell<Checked<'static>>,
}

/// The unit in which the protocol counts characters of a position.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Units {
    /// Bytes, if the editor offers them.
    Utf8,
    /// UTF-16 code units, which every editor supports.
    Utf16,
}

impl Units {
    pub fn agreed(offered: Option<&[PositionEncodingKind]>) -> Self {
        let utf_8 = offered.is_some_and(|offered| offered.contains(&PositionEncodingKind::UTF8));
        if utf_8 { Self::Utf8 } else { Self::Utf16 }
    }

    pub const fn kind(self) -> PositionEncodingKind {
        match self {
            Self::Utf8 => PositionEncodingKind::UTF8,
            Self::Utf16 => PositionEncodingKind::UTF16,
        }
    }

    const fn of(self, character: char) -> usize {
        match self {
            Self::Utf8 => character.len_utf8(),
            Self::Utf16 => character.len_utf16(),
        }
    }
}

impl Document {
    pub fn new(text: String, version: i32) -> Self {
        let mut document = Self { text, version, starts: Vec::new(), checked: OnceCell::new() };
        document.find_lines();
        document
    }

    /// The protocol defines LF, CR LF and CR as line ends.
    fn find_lines(&mut self) {
        let bytes = self.text.as_bytes();
        self.starts.clear();
        self.starts.push(0);
        for (at, &byte) in bytes.iter().enumerate() {
            if byte == b'\n' || byte == b'\r' && bytes.get(at + 1) != Some(&b'\n') {
                self.starts.push(at + 1);
            }
        }
    }

    /// Applies changes one after the other. A change of a part is ignored if it makes the text larger than the limit of
    /// descriptions.
    pub fn change(&mut self, changes: Vec<TextDocumentContentChangeEvent>, version: i32, units: Units) {
        for change in changes {
            match change.range {
                Some(range) => {
                    let (start, end) = (self.offset(range.start, units), self.offset(range.end, units));
                    if self.text.len() + change.text.len() <= LARGEST_FILE {
                        self.text.replace_range(start..end.max(start), &change.text);
                    }
                }
                None => self.text = change.text,
            }
            self.find_lines();
        }
        self.version = version;
        self.checked.take();
    }

    /// The checked text; checks it at the first call after a change.
    pub fn checked(&self, check: impl FnOnce(Source<'static>) -> Checked<'static>) -> &Checked<'static> {
        self.checked.get_or_init(|| check(Source::of_text(self.text.clone())))
    }

    /// The byte of a position. A position beyond the end of its line or of the text means that end.
    pub fn offset(&self, position: Position, units: Units) -> usize {
        let Some(&start) = self.starts.get(position.line as usize) else { return self.text.len() };
        let end = self.starts.get(position.line as usize + 1).copied().unwrap_or(self.text.len());
        let line = self.text.get(start..end).unwrap_or_default().trim_end_matches(['\r', '\n']);
        let mut counted = 0;
        for (at, character) in line.char_indices() {
            if counted >= position.character as usize {
                return start + at;
            }
            counted += units.of(character);
        }
        start + line.len()
    }

    /// The position of a byte.
    pub fn position(&self, offset: usize, units: Units) -> Position {
        let line = self.starts.partition_point(|&start| start <= offset).saturating_sub(1);
        let start = self.starts.get(line).copied().unwrap_or(0);
        let before = self.text.get(start..offset).unwrap_or_default();
        Position::new(line as u32, before.chars().map(|character| units.of(character)).sum::<usize>() as u32)
    }

    pub fn range(&self, range: &std::ops::Range<usize>, units: Units) -> Range {
        Range::new(self.position(range.start, units), self.position(range.end, units))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn places_are_counted_as_agreed() {
        let document = Document::new("a=é€😀x\r\nb=1".to_owned(), 1);
        let after = document.text.find('x').unwrap();
        assert_eq!(document.position(after, Units::Utf16), Position::new(0, 6));
        assert_eq!(document.position(after, Units::Utf8), Position::new(0, 11));
        assert_eq!(document.offset(Position::new(1, 2), Units::Utf16), document.text.find('1').unwrap());
        assert_eq!(document.offset(Position::new(0, 99), Units::Utf16), after + 1);
        assert_eq!(document.offset(Position::new(9, 0), Units::Utf16), document.text.len());
    }

    #[test]
    fn changes_come_one_on_top_of_the_other() {
        let mut document = Document::new("[1000]\nA=1\n".to_owned(), 1);
        let change = |line, from, to, text: &str| TextDocumentContentChangeEvent {
            range: Some(Range::new(Position::new(line, from), Position::new(line, to))),
            range_length: None,
            text: text.to_owned(),
        };
        document.change(vec![change(1, 2, 3, "22\nB=3"), change(2, 2, 3, "4")], 2, Units::Utf16);
        assert_eq!((document.text.as_str(), document.version), ("[1000]\nA=22\nB=4\n", 2));
    }

    proptest! {
        #[test]
        fn each_place_is_found_again(text in "([a-z=é😀]|\r\n|\n|\r){0,40}", utf_8: bool) {
            let units = if utf_8 { Units::Utf8 } else { Units::Utf16 };
            let document = Document::new(text.clone(), 0);
            for (at, character) in text.char_indices().filter(|(_, character)| !matches!(character, '\r' | '\n')) {
                prop_assert_eq!(document.offset(document.position(at, units), units), at, "{:?}", character);
            }
        }
    }
}
