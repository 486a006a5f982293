//! The elements of an XML file as a flat list: a recursive tree of a hostile file could overflow the stack.

use super::MARK;
use super::section_name::SectionName;
use super::tree::{Builder, FieldPart, SectionPart};
use crate::dictionary::place::{Place, Span, Spot};
use crate::dictionary::problem::Problems;
use crate::dictionary::rules::{text, xdd as rules};
use quick_xml::events::attributes::Attribute;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::borrow::Cow;

/// Maximum number of elements that are read.
const MOST_ELEMENTS: usize = 500_000;

/// Maximum depth; device descriptions are some ten elements deep. The limit keeps the time linear: the content of an
/// element is scanned once for each element around it.
const DEEPEST: usize = 100;

/// Reads the elements up to the first XML error, which is reported as a problem.
pub(super) fn read(text: &str) -> Builder<'_> {
    let mut builder = Builder::new(text, true, Problems::default());
    builder.tree.lines.push(0);
    let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
    builder.tree.lines.extend(ends.map(|(at, _)| at as u32 + 1));
    // The XML reader does not count a byte order mark.
    let body = text.trim_start_matches(MARK);
    let mark = text.len() - body.len();
    let mut reader = Reader::from_str(body);
    // The stack of open elements.
    let mut open: Vec<u32> = Vec::new();
    let position = |reader: &Reader<_>| text.len().min(mark + reader.buffer_position() as usize);
    loop {
        let start = position(&reader);
        if builder.tree.sections.len() > MOST_ELEMENTS || open.len() > DEEPEST {
            let expected = "at most 500000 elements, 100 deep; the rest is left out";
            builder.problems.report(Place::line(builder.line_of(start)), &text::TOO_MUCH, expected, "more");
            break;
        }
        let event = reader.read_event();
        let span = Span::new(start, position(&reader).max(start));
        match event {
            Ok(Event::Start(tag)) => open.push(builder.element(&tag, span)),
            Ok(Event::Empty(tag)) => {
                builder.element(&tag, span);
            }
            Ok(Event::End(_)) => builder.end(open.pop(), span.range().end),
            Ok(Event::Comment(_)) => builder.tree.comments.push(span),
            Ok(Event::Eof) => break,
            Ok(event) => builder.characters(open.last(), &event),
            Err(error) => {
                let expected = "well-formed XML; the rest is not read";
                let place = Place::line(builder.line_of(start));
                builder.problems.report(place, &rules::MALFORMED, expected, &error.to_string());
                break;
            }
        }
    }
    while let Some(element) = open.pop() {
        builder.end(Some(element), text.len());
    }
    builder
}

impl<'t> Builder<'t> {
    fn line_of(&self, at: usize) -> u32 {
        self.tree.lines.partition_point(|&start| start as usize <= at) as u32
    }

    /// The place of a part of the text that the XML reader returned.
    fn place_of(&self, part: &[u8]) -> Span {
        let start = part.as_ptr().addr().wrapping_sub(self.text.as_ptr().addr());
        debug_assert!(self.text.as_bytes().get(start..start + part.len()) == Some(part), "a part of the text");
        Span::new(start, start + part.len())
    }

    fn element(&mut self, tag: &BytesStart<'t>, whole: Span) -> u32 {
        let name = self.place_of(tag.local_name().as_ref());
        let first_line = self.get(whole).lines().next().unwrap_or_default().trim_end();
        let head = Span { end: whole.start + first_line.len() as u32, ..whole };
        let (line, next) = (self.line_of(whole.range().start), self.tree.sections.len() as u32 + 1);
        let fields = self.tree.fields.len() as u32;
        let element = SectionPart {
            name,
            head,
            whole,
            line,
            fields: (fields, fields),
            next,
            about: SectionName::Unknown,
            is_standard: false,
            is_repeated: false,
        };
        let place = Place { section: self.get(name), spot: Spot::Exact(head), ..Place::line(line) };
        let element = self.begin(element);
        // The reader's own check for duplicates takes quadratic time.
        for attribute in tag.attributes().with_checks(false) {
            let read = attribute.map_err(quick_xml::Error::from).and_then(|attribute| {
                let value = attribute.normalized_value(XmlVersion::Implicit1_0)?;
                Ok((attribute, value))
            });
            match read {
                Ok((attribute, value)) => self.attribute(&attribute, value, place),
                Err(error) => {
                    let expected = "attributes of well-formed XML";
                    self.problems.report(place, &rules::MALFORMED, expected, &error.to_string());
                }
            }
        }
        element
    }

    fn attribute(&mut self, attribute: &Attribute<'_>, value: Cow<'_, str>, element: Place<'_>) {
        let name = self.place_of(attribute.key.local_name().as_ref());
        let span = self.place_of(&attribute.value);
        let field = FieldPart { name, value: span, line: element.line, known: None, is_repeated: false };
        let (spot, number) = (field.spot(), self.tree.fields.len() as u32);
        if self.add(field).is_some() {
            let place = Place { field: self.get(name), spot, ..element };
            self.problems.report(place, &rules::ATTRIBUTE_TWICE, "an attribute once; the first counts", &value);
        }
        if let Cow::Owned(value) = value {
            self.tree.values.insert(number, value);
        }
    }

    fn end(&mut self, element: Option<u32>, at: usize) {
        let next = self.tree.sections.len() as u32;
        if let Some(element) = element.and_then(|element| self.tree.sections.get_mut(element as usize)) {
            (element.whole.end, element.next) = (at as u32, next);
        }
    }

    /// Appends to the text of the open element; leading blanks are dropped.
    fn characters(&mut self, open: Option<&u32>, event: &Event<'_>) {
        let Some((text, &element)) = characters(event).zip(open) else { return };
        if !text.trim().is_empty() || self.tree.texts.contains_key(&element) {
            self.tree.texts.entry(element).or_default().push_str(&text);
        }
    }
}

/// The characters between tags. Entities other than the five of XML are left out; they are never expanded.
fn characters<'e>(event: &'e Event<'_>) -> Option<Cow<'e, str>> {
    match event {
        Event::Text(text) => text.decode().ok(),
        Event::CData(text) => text.decode().ok(),
        Event::GeneralRef(reference) => match reference.resolve_char_ref() {
            Ok(Some(character)) => Some(Cow::Owned(character.to_string())),
            _ => quick_xml::escape::resolve_xml_entity(&reference.decode().ok()?).map(Cow::Borrowed),
        },
        _ => None,
    }
}
