//! The tree of a text: sections with fields, or elements with attributes, each with its place.

use super::field_name::FieldName;
use super::names::{canonical, is_same};
use super::section_name::SectionName;
use crate::dictionary::place::{Span, Spot};
use crate::dictionary::problem::Problems;
use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// The parts of a text, in the order of the text.
#[derive(Debug, Default)]
pub(super) struct Tree {
    /// The offset of each line.
    pub lines: Vec<u32>,
    /// Sections, or elements in the order of their start tags.
    pub sections: Vec<SectionPart>,
    /// The fields of all sections, or the attributes of all elements.
    pub fields: Vec<FieldPart>,
    pub comments: Vec<Span>,
    /// The first section of each name.
    pub by_name: HashMap<SectionIdentity, u32>,
    /// Values of attributes that differ from the text of the file, by the index of the attribute.
    pub values: HashMap<u32, String>,
    /// The texts of elements, by the index of the element.
    pub texts: HashMap<u32, String>,
}

/// Up to this number of fields a linear search is faster than a map; most sections have fewer fields.
const FEW: usize = 16;

/// A section, or an element.
#[derive(Debug)]
pub(super) struct SectionPart {
    /// The name without brackets or namespace prefix.
    pub name: Span,
    /// The line of the name; for a start tag its first line.
    pub head: Span,
    /// The range up to the next section or the end tag.
    pub whole: Span,
    pub line: u32,
    /// The index of the section's first field, and of the first field of the next section.
    pub fields: (u32, u32),
    /// The index of the next part that is not nested in this one.
    pub next: u32,
    pub about: SectionName,
    /// Whether the section of an object or entry has the standard's name, apart from case and blanks.
    pub is_standard: bool,
    /// Whether an earlier section has the same name.
    pub is_repeated: bool,
}

/// A field, or an attribute.
#[derive(Debug)]
pub(super) struct FieldPart {
    /// The name without namespace prefix.
    pub name: Span,
    /// The value without blanks or quotes around it.
    pub value: Span,
    /// The line of the field; for an attribute, the line of its element.
    pub line: u32,
    pub known: Option<FieldName>,
    /// Whether an earlier field of the section has the same name.
    pub is_repeated: bool,
}

/// The key that sections of the same name share. Nearly all sections have the standard's spelling.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) enum SectionIdentity {
    Standard(SectionName),
    /// The [`canonical`] name.
    Other(String),
}

impl SectionIdentity {
    /// The meaning of the section, and its key.
    pub fn of(name: &str) -> (SectionName, Self) {
        match SectionName::parse_standard(name) {
            Some(about) => (about, Self::Standard(about)),
            None => {
                let name = canonical(name);
                match SectionName::parse_standard(&name) {
                    Some(about) => (about, Self::Standard(about)),
                    None => (SectionName::parse(&name), Self::Other(name.into_owned())),
                }
            }
        }
    }
}

/// Builds the tree of a text, from its beginning to its end.
#[derive(Debug)]
pub(super) struct Builder<'t> {
    pub text: &'t str,
    pub tree: Tree,
    pub problems: Problems,
    is_xml: bool,
    /// The fields of the last section by name, used when there are more than [`FEW`].
    known: HashMap<Cow<'t, str>, u32>,
}

impl<'t> Builder<'t> {
    pub fn new(text: &'t str, is_xml: bool, problems: Problems) -> Self {
        Self { text, is_xml, problems, tree: Tree::default(), known: HashMap::new() }
    }

    pub fn get(&self, span: Span) -> &'t str {
        self.text.get(span.range()).unwrap_or_default()
    }

    /// Begins a section or element, to which the following fields belong.
    pub fn begin(&mut self, section: SectionPart) -> u32 {
        self.known.clear();
        self.tree.sections.push(section);
        self.tree.sections.len() as u32 - 1
    }

    /// Adds a field to the last section; returns an earlier one of the same name.
    pub fn add(&mut self, mut field: FieldPart) -> Option<u32> {
        let section = self.tree.sections.last()?;
        let first = if section.is_repeated { None } else { self.first_of(section.fields.0, &field) };
        field.is_repeated = first.is_some();
        self.tree.fields.push(field);
        let end = self.tree.fields.len() as u32;
        self.tree.sections.last_mut()?.fields.1 = end;
        first
    }

    fn first_of(&mut self, start: u32, field: &FieldPart) -> Option<u32> {
        let fields = self.tree.fields.get(start as usize..).unwrap_or_default();
        if fields.len() < FEW {
            return fields.iter().position(|before| self.is_same(before, field)).map(|at| start + at as u32);
        }
        if self.known.is_empty() {
            let firsts = (start..).zip(fields).filter(|(_, before)| !before.is_repeated);
            self.known = firsts.map(|(number, before)| (self.key(before), number)).collect();
        }
        match self.known.entry(self.key(field)) {
            Entry::Occupied(first) => Some(*first.get()),
            Entry::Vacant(vacant) => {
                vacant.insert(start + fields.len() as u32);
                None
            }
        }
    }

    fn is_same(&self, one: &FieldPart, other: &FieldPart) -> bool {
        match (one.known, other.known) {
            (None, None) if self.is_xml => self.get(one.name) == self.get(other.name),
            (None, None) => is_same(self.get(one.name), self.get(other.name)),
            (one, other) => one == other,
        }
    }

    /// The key that fields of the same name share.
    fn key(&self, field: &FieldPart) -> Cow<'t, str> {
        match field.known {
            Some(known) => Cow::Borrowed(known.text()),
            None if self.is_xml => Cow::Borrowed(self.get(field.name)),
            None => canonical(self.get(field.name)),
        }
    }
}

impl FieldPart {
    /// The place for problems of the field: its value, or its name if the value is empty.
    pub const fn spot(&self) -> Spot {
        if self.value.is_empty() { self.spot_of_name() } else { Spot::Exact(self.value) }
    }

    /// The place for problems of the field's name: the name, or the line if the name is empty.
    pub(crate) const fn spot_of_name(&self) -> Spot {
        if self.name.is_empty() { Spot::Line } else { Spot::Exact(self.name) }
    }
}
