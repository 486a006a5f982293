//! The text of a description as a lossless tree: sections with fields (EDS, DCF), or elements with attributes (XDD,
//! XDC), each with its place. Readers, rules, fixes and editors all use this tree.

mod encoding;
mod error;
mod field_name;
mod ini;
mod lines;
mod names;
mod section;
mod section_name;
mod tree;
mod xml;

#[cfg(test)]
mod tests;

pub(super) use encoding::Encoding;
pub use error::{DescriptionError, LARGEST_FILE};
pub(super) use field_name::FieldName;
pub(super) use names::canonical;
pub(super) use section::{Field, Section};
pub(super) use section_name::{ModulePart, SectionName, standard_section_name};

use super::place::{Place, SectionId, Span, Spot};
use super::problem::{EdsProblem, Problems};
use super::rules::text as rules;
use encoding::{Decoded, decode};
use lines::is_blank;
use std::borrow::Cow;
use std::ops::Range;
use tree::{Builder, SectionIdentity, Tree};

/// The byte order mark, with which an editor may begin a text.
const MARK: char = '\u{FEFF}';

/// The syntax of a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// EDS or DCF.
    Ini,
    /// XDD or XDC.
    Xml,
}

impl Format {
    /// The syntax, recognised by the first bytes.
    fn of(bytes: &[u8]) -> Self {
        let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
        // A merge conflict begins with several `<`. In UTF-16 the first character has a zero beside it.
        let is_xml = text.starts_with(b"<") && !text.starts_with(b"<<")
            || text.starts_with(b"\xFF\xFE<")
            || text.starts_with(b"\xFE\xFF\0<");
        if is_xml { Self::Xml } else { Self::Ini }
    }
}

/// The text of a description, and its tree.
#[derive(Debug)]
pub struct Source<'a> {
    /// The text; all places refer to it.
    pub text: Cow<'a, str>,
    pub(super) encoding: Encoding,
    /// Bytes that are no character, each with its place in the text.
    unread: Vec<(usize, Vec<u8>)>,
    is_xml: bool,
    tree: Tree,
    /// Problems of the text.
    problems: Problems,
}

impl<'a> Source<'a> {
    /// Reads an EDS, DCF, XDD or XDC, distinguished by content.
    ///
    /// # Errors
    /// If the file is larger than [`LARGEST_FILE`].
    pub fn read(bytes: &'a [u8]) -> Result<Self, DescriptionError> {
        Self::read_as(Format::of(bytes), bytes)
    }

    /// Reads a file in the given syntax.
    pub(super) fn read_as(format: Format, bytes: &'a [u8]) -> Result<Self, DescriptionError> {
        if bytes.len() > LARGEST_FILE {
            return Err(DescriptionError::TooLarge { found: bytes.len() });
        }
        Ok(Self::new(format, decode(bytes)))
    }

    /// Reads a text that is already decoded, such as that of an editor.
    pub fn of_text(text: impl Into<Cow<'a, str>>) -> Self {
        let text = text.into();
        Self::new(Format::of(text.as_bytes()), Decoded { text, encoding: Encoding::Utf8, unread: Vec::new() })
    }

    fn new(format: Format, decoded: Decoded<'a>) -> Self {
        let Decoded { text, encoding, unread } = decoded;
        let is_xml = format == Format::Xml;
        let Builder { tree, problems, .. } =
            if is_xml { xml::read(&text) } else { ini::read(&text, of_encoding(encoding, &text)) };
        let source = Self { encoding, unread, is_xml, tree, problems, text };
        source.check_places();
        source
    }

    /// Checks the invariants in debug builds: places lie within the text, on the borders of characters, in order, and
    /// nested parts lie inside their parents.
    fn check_places(&self) {
        debug_assert!(self.elements().zip(self.elements().skip(1)).all(|(one, next)| {
            let is_inside = next.whole().end <= one.whole().end;
            one.whole().end <= next.whole().start || self.is_xml && is_inside && next.id.0 < one.part.next
        }));
        debug_assert!(self.elements().all(|section| {
            let (whole, name) = (section.whole(), section.name_span());
            let mut at = name.end;
            whole.start <= name.start
                && name.end <= whole.end
                && [whole, name, section.part.head].iter().all(|span| self.text.get(span.range()).is_some())
                && section.all_fields().all(|field| {
                    let (name, value) = (field.name_span(), field.value_span());
                    let is_right = at <= name.start && name.end <= value.start && value.end <= whole.end;
                    at = value.end;
                    is_right && [name, value].iter().all(|span| self.text.get(span.range()).is_some())
                })
        }));
    }

    /// The problems of the text.
    pub(super) fn problems(&self) -> Problems {
        self.problems.clone()
    }

    /// Whether each byte is a part of a character, so that a changed text can be written back exactly.
    pub(super) const fn is_exact(&self) -> bool {
        self.unread.is_empty()
    }

    /// Whether the text is XML.
    pub(crate) const fn is_xml(&self) -> bool {
        self.is_xml
    }

    /// The text at a place.
    pub(super) fn get(&self, span: Span) -> &str {
        self.text.get(span.range()).unwrap_or_default()
    }

    fn parts<'s>(&'s self, range: Range<u32>) -> impl DoubleEndedIterator<Item = Section<'s>> + use<'s, 'a> {
        let Range { start, end } = range;
        let parts = self.tree.sections.get(start as usize..end as usize).unwrap_or_default();
        (start..end).zip(parts).map(|(id, part)| Section { source: self, part, id: SectionId(id) })
    }

    /// All elements in the order of their start tags, or all sections, including repeated ones.
    pub(super) fn elements(&self) -> impl DoubleEndedIterator<Item = Section<'_>> {
        self.parts(0..self.tree.sections.len() as u32)
    }

    /// The sections; of repeated ones only the first. Empty for XML.
    pub(super) fn sections(&self) -> impl DoubleEndedIterator<Item = Section<'_>> {
        self.elements().filter(|section| !section.part.is_repeated && !self.is_xml)
    }

    /// The elements of that name.
    pub(super) fn named<'s, 'n>(
        &'s self,
        name: &'n str,
    ) -> impl DoubleEndedIterator<Item = Section<'s>> + use<'s, 'n, 'a> {
        self.elements().filter(move |element| element.name() == name)
    }

    /// The section of that name, ignoring case.
    pub(super) fn section(&self, name: &str) -> Option<Section<'_>> {
        self.by_id(*self.tree.by_name.get(&SectionIdentity::of(name).1)?)
    }

    /// Whether the file calls itself an EDS. Many DCFs lack the section of a configured device, or have no name at all.
    pub(super) fn is_eds(&self) -> bool {
        let name = self.section("FileInfo").and_then(|section| section.field(FieldName::FileName));
        let ends_so = name.is_some_and(|name| name.value().to_ascii_lowercase().ends_with(".eds"));
        ends_so && !self.is_dcf()
    }

    /// Whether the file is a DCF: it has the section of a configured device, in the standard's spelling or the usual one.
    pub(super) fn is_dcf(&self) -> bool {
        ["DeviceComissioning", "DeviceCommissioning"].iter().any(|name| self.section(name).is_some())
    }

    fn by_id(&self, id: u32) -> Option<Section<'_>> {
        self.parts(id..id + 1).next()
    }

    /// The section around a place; `None` before the first section.
    pub(super) fn section_at(&self, at: usize) -> Option<Section<'_>> {
        let before = self.tree.sections.partition_point(|section| section.whole.range().start <= at);
        self.by_id(before.checked_sub(1)? as u32).filter(|_| !self.is_xml)
    }

    /// The section whose name is on that line.
    pub(super) fn section_in(&self, line: u32) -> Option<Section<'_>> {
        let found = self.tree.sections.binary_search_by_key(&line, |section| section.line).ok()?;
        self.by_id(found as u32).filter(|_| !self.is_xml)
    }

    /// The field on that line of an EDS.
    pub(super) fn field_in(&self, line: u32) -> Option<Field<'_>> {
        self.section_at(self.whole_line(line).start)?.field_in(line)
    }

    /// The comments, including their marks.
    pub(super) fn comments(&self) -> impl Iterator<Item = Span> {
        self.tree.comments.iter().copied()
    }

    /// The number of lines.
    pub(super) const fn lines(&self) -> u32 {
        self.tree.lines.len() as u32
    }

    /// The range of a line with its end; empty after the last line.
    pub fn whole_line(&self, number: u32) -> Range<usize> {
        let start = |line: usize| self.tree.lines.get(line).map_or(self.text.len(), |&start| start as usize);
        (number as usize).checked_sub(1).map_or(self.text.len()..self.text.len(), |line| start(line)..start(line + 1))
    }

    /// The range of a line without blanks at both ends.
    pub(super) fn line(&self, number: u32) -> Span {
        self.trimmed(self.whole_line(number))
    }

    /// The range without blanks at both ends, and without a byte order mark at the beginning of the text. If the range
    /// holds nothing else, the result is the empty range at its beginning.
    pub(super) fn trimmed(&self, range: Range<usize>) -> Span {
        let text = self.text.get(range.clone()).unwrap_or_default();
        let is_before = |character| is_blank(character) || character == MARK && range.start == 0;
        let rest = text.trim_start_matches(is_before);
        let start = if rest.is_empty() { range.start } else { range.start + (text.len() - rest.len()) };
        Span::new(start, start + rest.trim_end_matches(is_blank).len())
    }

    /// The line end for new lines: the line end of the first line.
    pub(super) fn line_end(&self) -> &'static str {
        if self.text.get(self.whole_line(1)).is_some_and(|line| line.ends_with("\r\n")) { "\r\n" } else { "\n" }
    }

    /// Line and column of a place, both from 1; the column counts characters.
    pub fn position(&self, at: usize) -> (u32, u32) {
        let line = self.tree.lines.partition_point(|&start| start as usize <= at) as u32;
        let before = self.text.get(self.whole_line(line).start..at).unwrap_or_default();
        (line, before.chars().count() as u32 + 1)
    }

    /// The place of a problem in this source; `None` if it concerns no single line.
    pub(super) fn place(&self, problem: &EdsProblem) -> Option<Span> {
        let section = match problem.spot {
            Spot::Exact(span) => return Some(span),
            Spot::Section(id) => self.by_id(id.0),
            Spot::Line if problem.line > 0 => return Some(self.line(problem.line)),
            Spot::Line => self.section(&problem.section),
        };
        let section = section?;
        let place = if self.is_xml {
            section.place_of_attribute(&problem.field)
        } else {
            FieldName::parse(&problem.field).map_or_else(|| section.place(), |name| section.place_of(name))
        };
        match place.spot {
            Spot::Exact(span) => Some(span),
            _ => None,
        }
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = self.encoding.mark().to_vec();
        let mut at = 0;
        for (place, unread) in &self.unread {
            self.encoding.append(self.text.get(at..*place).unwrap_or_default(), &mut bytes);
            bytes.extend_from_slice(unread);
            at = place + char::REPLACEMENT_CHARACTER.len_utf8();
        }
        self.encoding.append(self.text.get(at..).unwrap_or_default(), &mut bytes);
        bytes
    }
}

/// Problems of the character set of an EDS. XML allows every character set.
fn of_encoding(encoding: Encoding, text: &str) -> Problems {
    let mut problems = Problems::default();
    let (rule, found) = match encoding {
        Encoding::Utf16LowFirst => (&rules::UTF_16, "UTF-16, low byte first"),
        Encoding::Utf16HighFirst => (&rules::UTF_16, "UTF-16, high byte first"),
        Encoding::Utf8 if !text.starts_with(MARK) => (&rules::ENCODING, "UTF-8"),
        Encoding::Latin1 => (&rules::ENCODING, "Latin-1"),
        Encoding::Utf8 | Encoding::Utf8WithMark => (&rules::BYTE_ORDER_MARK, "UTF-8 with byte order mark"),
    };
    let mut place = Place::line(1);
    if rule == &rules::ENCODING {
        let first = text.char_indices().find(|(_, character)| !character.is_ascii());
        let Some((at, character)) = first else { return problems };
        place.spot = Spot::Exact(Span::new(at, at + character.len_utf8()));
    }
    problems.report(place, rule, "ASCII text without byte order mark", found);
    problems
}
