//! Sections with their fields, and elements with their attributes: the interface for readers.

use super::Source;
use super::field_name::FieldName;
use super::section_name::SectionName;
use super::tree::{FieldPart, SectionPart};
use crate::dictionary::place::{Place, SectionId, Span, Spot};
use crate::identity::Multiplexer;
use std::ops::RangeInclusive;

/// A section of an EDS, or an element of an XDD.
#[derive(Clone, Copy)]
pub(in crate::dictionary) struct Section<'s> {
    pub(super) source: &'s Source<'s>,
    pub(super) part: &'s SectionPart,
    pub id: SectionId,
}

/// `name=value` in a section, or an attribute of an element.
#[derive(Clone, Copy)]
pub(in crate::dictionary) struct Field<'s> {
    section: Section<'s>,
    part: &'s FieldPart,
    number: u32,
}

impl<'s> Section<'s> {
    /// The name as in the file, without brackets or namespace prefix.
    pub fn name(self) -> &'s str {
        self.source.get(self.part.name)
    }

    /// The place of the section's name.
    pub(crate) const fn name_span(self) -> Span {
        self.part.name
    }

    /// The range from the section's beginning to the next section, or to the end tag of an element.
    pub const fn whole(self) -> Span {
        self.part.whole
    }

    pub const fn line(self) -> u32 {
        self.part.line
    }

    /// The lines from the section's name to its end.
    pub fn lines(self) -> RangeInclusive<u32> {
        self.part.line..=self.source.position(self.part.whole.range().end.saturating_sub(1)).0
    }

    pub const fn about(self) -> SectionName {
        self.part.about
    }

    /// Whether the section of an object or entry has the standard's name, apart from case and blanks.
    pub const fn is_standard(self) -> bool {
        self.part.is_standard
    }

    /// The object or entry that the section describes, and whether it is an entry.
    pub const fn address(self) -> Option<(Multiplexer, bool)> {
        match self.part.about {
            SectionName::Object(index) => Some((Multiplexer::new(index, 0), false)),
            SectionName::Sub(index, sub) => Some((Multiplexer::new(index, sub), true)),
            _ => None,
        }
    }

    /// The index of the object to which the section belongs: the object's own, those of its entries, and lists beside it
    /// such as `1003Value`.
    pub const fn index(self) -> Option<u16> {
        match self.part.about {
            SectionName::Object(index) | SectionName::Sub(index, _) | SectionName::Beside(index) => Some(index),
            _ => None,
        }
    }

    /// All fields of the section, including repeated ones.
    pub(crate) fn all_fields(self) -> impl DoubleEndedIterator<Item = Field<'s>> + use<'s> {
        let (first, end) = self.part.fields;
        let parts = self.source.tree.fields.get(first as usize..end as usize).unwrap_or_default();
        (first..end).zip(parts).map(move |(number, part)| Field { section: self, part, number })
    }

    /// The fields of the section; of repeated ones only the first.
    pub fn fields(self) -> impl Iterator<Item = Field<'s>> + use<'s> {
        self.all_fields().filter(|field| !field.part.is_repeated)
    }

    /// The first field of that name.
    pub fn field(self, name: FieldName) -> Option<Field<'s>> {
        self.all_fields().find(|field| field.part.known == Some(name))
    }

    /// The field at a place, which may be anywhere from the beginning of its name to the end of its value.
    pub(crate) fn field_at(self, at: usize) -> Option<Field<'s>> {
        self.field_in(self.source.position(at).0).filter(|field| field.whole().touches(at))
    }

    /// The field on that line.
    pub(super) fn field_in(self, line: u32) -> Option<Field<'s>> {
        let (first, end) = self.part.fields;
        let parts = self.source.tree.fields.get(first as usize..end as usize).unwrap_or_default();
        let at = parts.binary_search_by_key(&line, |field| field.line).ok()?;
        Some(Field { section: self, part: parts.get(at)?, number: first + at as u32 })
    }

    /// The place for problems of the section as a whole: its beginning.
    pub fn place(self) -> Place<'s> {
        let spot = Spot::Exact(self.part.head);
        Place { line: self.part.line, section: self.name(), field: "", spot }
    }

    /// The place of a field; the place of the section if the field is missing.
    pub fn place_of(self, name: FieldName) -> Place<'s> {
        let place = self.field(name).map_or_else(|| self.place(), Field::place);
        Place { field: name.text(), ..place }
    }

    /// A non-blank attribute; if no attribute has exactly this name, the attribute whose name differs only in case.
    pub fn attribute(self, name: &str) -> Option<&'s str> {
        Some(self.attribute_field(name)?.value().trim()).filter(|value| !value.is_empty())
    }

    fn attribute_field(self, name: &str) -> Option<Field<'s>> {
        let is_exact = |field: &Field<'_>| field.name() == name;
        let in_any_case = |field: &Field<'_>| field.name().eq_ignore_ascii_case(name);
        self.all_fields().find(is_exact).or_else(|| self.all_fields().find(in_any_case))
    }

    /// The place of an attribute; the place of the element if the attribute is missing.
    pub(crate) fn place_of_attribute<'p>(self, name: &'p str) -> Place<'p>
    where
        's: 'p,
    {
        let field = self.attribute_field(name);
        Place { field: name, ..field.map_or_else(|| self.place(), Field::place) }
    }

    /// The text directly inside an element, without blanks at both ends.
    pub fn text(self) -> &'s str {
        self.source.tree.texts.get(&self.id.0).map_or("", |text| text.trim())
    }

    /// All elements nested in this one.
    pub fn inside(self) -> impl Iterator<Item = Self> + use<'s> {
        self.source.parts(self.id.0 + 1..self.part.next)
    }

    /// The next element that is not nested in this one.
    pub const fn next(self) -> SectionId {
        SectionId(self.part.next)
    }

    /// Whether the element has content: an attribute, a text, or a nested element.
    pub fn has_content(self) -> bool {
        let (first, end) = self.part.fields;
        !self.text().is_empty() || first < end || self.id.0 + 1 < self.part.next
    }
}

impl<'s> Field<'s> {
    /// The name as in the file, without namespace prefix.
    pub fn name(self) -> &'s str {
        self.section.source.get(self.part.name)
    }

    /// The field of CiA 306; `None` if CiA 306 does not define it.
    pub const fn known(self) -> Option<FieldName> {
        self.part.known
    }

    /// The value without blanks at both ends; a comment after the value is part of it. For an attribute, the value with
    /// entities replaced.
    pub fn value(self) -> &'s str {
        let source = self.section.source;
        match source.tree.values.get(&self.number).filter(|_| source.is_xml) {
            Some(value) => value,
            None => source.get(self.part.value),
        }
    }

    pub const fn line(self) -> u32 {
        self.part.line
    }

    pub(crate) const fn name_span(self) -> Span {
        self.part.name
    }

    pub(crate) const fn value_span(self) -> Span {
        self.part.value
    }

    /// The range of name and value.
    pub const fn whole(self) -> Span {
        Span { start: self.part.name.start, end: self.part.value.end }
    }

    /// The place for problems of the field's value.
    pub fn place(self) -> Place<'s> {
        Place { line: self.part.line, section: self.section.name(), field: self.name(), spot: self.part.spot() }
    }

    /// The place for problems of the field's name.
    pub(crate) fn place_of_name(self) -> Place<'s> {
        Place { spot: self.part.spot_of_name(), ..self.place() }
    }
}
