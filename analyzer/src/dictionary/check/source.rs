//! The text of a file by its lines, each with its place.

use std::borrow::Cow;
use std::ops::Range;

/// The text, and where its lines begin.
#[derive(Debug)]
pub struct Source<'a> {
    /// The text.
    pub text: &'a str,
    pub(super) lines: Cow<'a, Lines>,
}

/// The lines of a text.
#[derive(Clone, Debug, Default)]
pub(super) struct Lines {
    /// Where each begins.
    starts: Vec<usize>,
    /// Those that begin a section, rising.
    headers: Vec<u32>,
    /// Whether it is XML, whose lines end in LF only.
    is_xml: bool,
}

/// `name=value` of a line, without the blanks around both.
#[derive(Clone, Debug)]
pub struct FieldSpans {
    /// Before the equals sign.
    pub name: Range<usize>,
    /// After it.
    pub value: Range<usize>,
}

impl<'a> Source<'a> {
    /// Looks for the lines of a text.
    pub fn new(text: &'a str) -> Self {
        let is_xml = text.trim_start().starts_with('<') && !text.trim_start().starts_with("<<");
        let bytes = text.as_bytes();
        let mut starts = Vec::with_capacity(text.len() / 16 + 1);
        starts.push(0);
        for (at, &byte) in bytes.iter().enumerate() {
            // Most bytes are neither of them, which takes one look.
            let ends = byte <= b'\r'
                && match byte {
                    b'\n' => true,
                    b'\r' => !is_xml && bytes.get(at + 1) != Some(&b'\n'),
                    _ => false,
                };
            if ends {
                starts.push(at + 1);
            }
        }
        let mut source = Self { text, lines: Cow::Owned(Lines { starts, headers: Vec::new(), is_xml }) };
        source.lines.to_mut().headers = (1..=source.lines()).filter(|&line| source.begins_section(line)).collect();
        source
    }

    /// What is known of the lines, without the text.
    pub(super) fn into_lines(self) -> Lines {
        self.lines.into_owned()
    }

    /// Whether it is XML.
    pub fn is_xml(&self) -> bool {
        self.lines.is_xml
    }

    /// How many lines there are.
    pub(in crate::dictionary) fn lines(&self) -> u32 {
        self.lines.starts.len() as u32
    }

    /// A line with its end; empty after the last.
    pub fn whole_line(&self, number: u32) -> Range<usize> {
        let begin = (number as usize).checked_sub(1).and_then(|at| self.lines.starts.get(at)).copied();
        let end = self.lines.starts.get(number as usize).copied().unwrap_or(self.text.len());
        begin.map_or(self.text.len()..self.text.len(), |begin| begin..end)
    }

    /// A line without blanks around it.
    pub(in crate::dictionary) fn line(&self, number: u32) -> Range<usize> {
        self.trimmed(self.whole_line(number))
    }

    /// What stands there.
    pub(in crate::dictionary) fn get(&self, range: &Range<usize>) -> &'a str {
        self.text.get(range.clone()).unwrap_or_default()
    }

    /// The range without blanks at both ends; its beginning if there is nothing else.
    pub(in crate::dictionary) fn trimmed(&self, range: Range<usize>) -> Range<usize> {
        let text = self.get(&range);
        let rest = text.trim_start_matches(is_blank);
        if rest.is_empty() {
            return range.start..range.start;
        }
        let begin = range.start + (text.len() - rest.len());
        begin..begin + rest.trim_end_matches(is_blank).len()
    }

    /// Name and value of a line, if it is a field.
    pub(in crate::dictionary) fn field(&self, number: u32) -> Option<FieldSpans> {
        let line = self.line(number);
        let text = self.get(&line);
        if matches!(text.as_bytes(), [b';' | b'[' | b'#', ..]) {
            return None;
        }
        let equals = line.start + text.find('=')?;
        Some(FieldSpans { name: self.trimmed(line.start..equals), value: self.trimmed(equals + 1..line.end) })
    }

    /// Whether a line begins a section.
    pub(in crate::dictionary) fn is_section(&self, number: u32) -> bool {
        self.lines.headers.binary_search(&number).is_ok()
    }

    fn begins_section(&self, number: u32) -> bool {
        let at = self.lines.starts.get(number as usize - 1).copied().unwrap_or(self.text.len());
        match self.text.as_bytes().get(at) {
            Some(b'[') => true,
            // Nearly all other lines begin with a letter or a digit.
            Some(byte) if byte.is_ascii_alphanumeric() => false,
            _ => self.get(&self.whole_line(number)).trim_start_matches(is_blank).as_bytes().first() == Some(&b'['),
        }
    }

    /// The lines that begin a section, rising.
    pub(in crate::dictionary) fn headers(&self) -> &[u32] {
        &self.lines.headers
    }

    /// The line that begins the section in which that line is; none before the first.
    pub(super) fn header_of(&self, line: u32) -> Option<u32> {
        let before = self.lines.headers.partition_point(|&header| header <= line);
        self.lines.headers.get(before.checked_sub(1)?).copied()
    }

    /// The lines of the section that begins in that line, without that line.
    pub(super) fn section_lines(&self, header: u32) -> Range<u32> {
        let next = self.lines.headers.partition_point(|&line| line <= header);
        let end = self.lines.headers.get(next).copied().unwrap_or(self.lines() + 1);
        header + 1..end
    }

    /// The line in which the section of that name begins, the names as [`super::locate::is_same`] has them.
    pub(super) fn section(&self, name: &str) -> Option<u32> {
        self.lines.headers.iter().copied().find(|&line| {
            let text = self.get(&self.whole_line(line)).trim_start_matches(is_blank);
            let begun = text.get(1..).and_then(|rest| rest.split([']', '\r', '\n']).next());
            begun.is_some_and(|begun| super::locate::is_same(begun, name))
        })
    }

    /// How the first line ends, and so new ones do.
    pub(super) fn line_end(&self) -> &'static str {
        let first = self.get(&self.whole_line(1));
        if first.ends_with("\r\n") { "\r\n" } else { "\n" }
    }

    /// Line and column of a place, both from 1, the column in characters.
    pub fn position(&self, at: usize) -> (u32, u32) {
        let line = self.lines.starts.partition_point(|&start| start <= at);
        let start = line.checked_sub(1).and_then(|line| self.lines.starts.get(line)).copied().unwrap_or(0);
        (line as u32, self.get(&(start..at)).chars().count() as u32 + 1)
    }
}

/// What stands around a line or a field and is not meant.
fn is_blank(character: char) -> bool {
    character.is_whitespace() || character == '\0'
}
