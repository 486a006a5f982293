//! The elements of an XML file as a flat list with their depth: a tree of a hostile file could be deeper than any
//! stack.

use std::collections::BTreeMap;
use std::ops::Range;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::dictionary::problem::{Place, Problems};
use crate::dictionary::rules::{text, xdd as rules};

/// What follows is not read.
const MOST_ELEMENTS: usize = 500_000;

/// Device descriptions are some ten elements deep. A bound keeps the time linear: what is inside an element is
/// looked through once for each element around it.
const DEEPEST: usize = 100;

/// One element.
#[derive(Debug, Default)]
pub(super) struct Element {
    /// Without namespace prefix.
    pub name: String,
    pub line: u32,
    depth: u32,
    /// Without namespace prefixes.
    attributes: BTreeMap<String, String>,
    /// The text directly in it.
    pub text: String,
}

impl Element {
    /// An attribute that is there and not blank; in another case too, where there is none in that case.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        let in_any_case = || self.attributes.iter().find(|(other, _)| other.eq_ignore_ascii_case(name));
        let value = self.attributes.get(name).or_else(|| in_any_case().map(|(_, value)| value))?;
        Some(value.trim()).filter(|value| !value.is_empty())
    }

    /// All attributes with their values.
    pub fn attributes(&self) -> impl Iterator<Item = (&str, &str)> {
        self.attributes.iter().map(|(name, value)| (name.as_str(), value.as_str()))
    }

    /// Of the elements that follow this one, those that are not in it.
    pub fn after<'a>(&self, following: &'a [Self]) -> &'a [Self] {
        let inside = following.iter().take_while(|other| other.depth > self.depth).count();
        following.get(inside..).unwrap_or_default()
    }

    pub fn place<'a>(&'a self, attribute: &'a str) -> Place<'a> {
        Place { line: self.line, section: &self.name, field: attribute }
    }
}

/// All elements, in the order of their start tags.
#[derive(Debug, Default)]
pub(super) struct Elements(Vec<Element>);

impl Elements {
    /// All elements, in their order.
    pub fn all(&self) -> &[Element] {
        &self.0
    }

    /// All elements of that name, with their positions.
    pub fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = (usize, &'a Element)> {
        self.0.iter().enumerate().filter(move |(_, element)| element.name == name)
    }

    /// Everything inside the element at that position.
    pub fn inside(&self, position: usize) -> &[Element] {
        let Some((element, after)) = self.0.get(position..).and_then(<[Element]>::split_first) else { return &[] };
        let Range { start, end } = 0..after.iter().take_while(|other| other.depth > element.depth).count();
        after.get(start..end).unwrap_or_default()
    }

    /// The text of the first element of that name that has one.
    pub fn text<'a>(&'a self, name: &'a str) -> Option<&'a str> {
        self.named(name).map(|(_, element)| element.text.trim()).find(|text| !text.is_empty())
    }
}

/// Reads as far as the file is XML; what stops the reading is a problem.
pub(super) fn read(text: &str, problems: &mut Problems) -> Elements {
    let mut reader = Reader::from_str(text);
    let mut lines = Lines { text: text.as_bytes(), position: 0, line: 1 };
    let mut elements = Vec::new();
    // The elements that are open, by their positions.
    let mut open: Vec<usize> = Vec::new();
    loop {
        let line = lines.at(reader.buffer_position());
        let place = Place { line, ..Place::default() };
        if elements.len() > MOST_ELEMENTS || open.len() > DEEPEST {
            let expected = "at most 500000 elements, 100 deep; the rest is left out";
            problems.report(place, &text::TOO_MUCH, expected, "more");
            break;
        }
        match reader.read_event() {
            Ok(Event::Start(start)) => {
                elements.push(element(&start, line, open.len(), problems));
                open.push(elements.len() - 1);
            }
            Ok(Event::Empty(start)) => elements.push(element(&start, line, open.len(), problems)),
            Ok(Event::End(_)) => drop(open.pop()),
            Ok(Event::Eof) => break,
            Ok(event) => {
                if let (Some(text), Some(element)) =
                    (characters(&event), open.last().and_then(|&at| elements.get_mut(at)))
                {
                    element.text.push_str(&text);
                }
            }
            Err(error) => {
                let expected = "well-formed XML; the rest is not read";
                problems.report(place, &rules::MALFORMED, expected, &error.to_string());
                break;
            }
        }
    }
    Elements(elements)
}

fn element(start: &BytesStart<'_>, line: u32, depth: usize, problems: &mut Problems) -> Element {
    let name = String::from_utf8_lossy(start.local_name().as_ref()).into_owned();
    let mut element = Element { name, line, depth: depth as u32, ..Element::default() };
    // The reader's own check for duplicates takes quadratic time.
    for attribute in start.attributes().with_checks(false) {
        let value = attribute.map_err(quick_xml::Error::from).and_then(|attribute| {
            let name = String::from_utf8_lossy(attribute.key.local_name().as_ref()).into_owned();
            Ok((name, attribute.normalized_value(XmlVersion::Implicit1_0)?.into_owned()))
        });
        match value {
            Ok((name, value)) => {
                if let Some(first) = element.attributes.insert(name.clone(), value.clone()) {
                    let expected = "an attribute once; the first counts";
                    problems.report(element.place(&name), &rules::ATTRIBUTE_TWICE, expected, &value);
                    element.attributes.insert(name, first);
                }
            }
            Err(error) => {
                let expected = "attributes of well-formed XML";
                problems.report(element.place(""), &rules::MALFORMED, expected, &error.to_string());
            }
        }
    }
    element
}

/// The characters of an event between tags. Entities other than the five of XML are left out: none is ever expanded.
fn characters(event: &Event<'_>) -> Option<String> {
    match event {
        Event::Text(text) => text.decode().ok().map(std::borrow::Cow::into_owned),
        Event::CData(text) => text.decode().ok().map(std::borrow::Cow::into_owned),
        Event::GeneralRef(reference) => match reference.resolve_char_ref() {
            Ok(Some(character)) => Some(character.to_string()),
            _ => quick_xml::escape::resolve_xml_entity(&reference.decode().ok()?).map(str::to_owned),
        },
        _ => None,
    }
}

/// Counts lines up to rising positions.
struct Lines<'a> {
    text: &'a [u8],
    position: usize,
    line: u32,
}

impl Lines<'_> {
    /// The line of the next character that is no blank.
    fn at(&mut self, position: u64) -> u32 {
        let position = usize::try_from(position).unwrap_or(usize::MAX).min(self.text.len());
        let passed = self.text.get(self.position..position).unwrap_or_default();
        self.line += passed.iter().filter(|&&byte| byte == b'\n').count() as u32;
        self.position = self.position.max(position);
        self.line
    }
}
