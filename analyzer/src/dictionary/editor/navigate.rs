//! Navigation from the mention of an object to its description, and back.

use crate::dictionary::source::{Field, FieldName, Section, Source};
use crate::identity::Multiplexer;
use crate::object;
use std::ops::Range;

/// The place that describes the object mentioned at `at`: the name of its section.
pub fn definition(source: &Source<'_>, at: usize) -> Option<Range<usize>> {
    let wanted = named_at(source, at)?;
    let of = |with_sub: bool| {
        let mut described = sections(source).filter_map(|section| Some((section.address()?, section)));
        described.find(|((found, is_entry), _)| {
            found.index == wanted.index && *is_entry == with_sub && (!with_sub || found.sub == wanted.sub)
        })
    };
    // A VAR has no section for its sub-index 0.
    of(true).filter(|_| wanted.sub.0 > 0).or_else(|| of(false)).map(|(_, section)| section.name_span().range())
}

/// All places that mention the object at `at`: lists, mappings, and its description.
pub fn references(source: &Source<'_>, at: usize) -> Vec<Range<usize>> {
    let Some(wanted) = named_at(source, at) else { return Vec::new() };
    let mut found = Vec::new();
    for section in sections(source) {
        if section.index() == Some(wanted.index.0) {
            found.push(section.name_span().range());
        }
        let naming =
            section.all_fields().filter(|field| named_by(section, *field).is_some_and(|at| at.index == wanted.index));
        found.extend(naming.map(|field| field.value_span().range()));
    }
    found
}

/// The digits of the index at `at`, if an object is mentioned there.
pub fn index_at(source: &Source<'_>, at: usize) -> Option<Range<usize>> {
    let place = references(source, at).into_iter().find(|range| range.start <= at && at <= range.end)?;
    digits(source, &place)
}

/// The edits that give the object mentioned at `at` another index, in its sections, in lists and in mappings: the ranges of
/// digits to replace, and the new digits. `None` if no object is mentioned, or if the file has an object with the new
/// index.
pub fn rename(source: &Source<'_>, at: usize, index: u16) -> Option<Vec<(Range<usize>, String)>> {
    named_at(source, at)?;
    if sections(source).any(|section| section.index() == Some(index)) {
        return None;
    }
    let edits = references(source, at).into_iter();
    Some(edits.filter_map(|range| Some((digits(source, &range)?, format!("{index:04X}")))).collect())
}

/// The digits of the index in a section's name (`1018sub1`) or in a value (`0x1018`, `0x10180120`).
fn digits(source: &Source<'_>, range: &Range<usize>) -> Option<Range<usize>> {
    let text = source.text.get(range.clone())?;
    let start = if text.get(..2).is_some_and(|begin| begin.eq_ignore_ascii_case("0x")) { 2 } else { 0 };
    let rest = text.get(start..)?;
    let length = rest.bytes().take(4).take_while(u8::is_ascii_hexdigit).count();
    (length > 0).then(|| range.start + start..range.start + start + length)
}

/// The sections of an EDS or DCF; empty for XML.
pub(super) fn sections<'s>(source: &'s Source<'_>) -> impl Iterator<Item = Section<'s>> {
    source.elements().filter(|_| !source.is_xml())
}

/// The object or entry that a section or a value mentions at a place.
fn named_at(source: &Source<'_>, at: usize) -> Option<Multiplexer> {
    let section = source.section_at(at)?;
    if at <= section.name_span().range().end {
        let address = section.address().map(|(at, _)| at);
        return address.or_else(|| Some(Multiplexer::new(section.index()?, 0)));
    }
    named_by(section, section.field_at(at)?)
}

/// The object that a field's value mentions.
fn named_by(section: Section<'_>, field: Field<'_>) -> Option<Multiplexer> {
    match section.address() {
        None => {
            let name = section.name().to_ascii_lowercase();
            let is_list = name.ends_with("objects") || name.ends_with("objectlinks");
            let is_entry = field.name().bytes().all(|byte| byte.is_ascii_digit());
            address_of_value(field.value(), false).filter(|_| is_list && is_entry)
        }
        Some((at, is_entry)) => {
            let is_value = matches!(field.known(), Some(FieldName::DefaultValue | FieldName::ParameterValue));
            let maps = is_entry && at.sub.0 > 0 && object::is_pdo_mapping(at.index.0);
            address_of_value(field.value(), true).filter(|_| is_value && maps)
        }
    }
}

/// The object that a value mentions: `0x1018` is an object, `0x60040020` in a mapping an entry.
pub(super) fn address_of_value(value: &str, is_mapping: bool) -> Option<Multiplexer> {
    let digits = value.trim().strip_prefix("0x").or_else(|| value.trim().strip_prefix("0X"))?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    match (is_mapping, digits.len()) {
        (true, 8) => Some(Multiplexer::new((number >> 16) as u16, (number >> 8) as u8)),
        (false, 1..=4) => Some(Multiplexer::new(number as u16, 0)),
        _ => None,
    }
}
