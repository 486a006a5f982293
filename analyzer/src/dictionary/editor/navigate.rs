//! From where an object is named to where it is described, and back.

use super::layout::{Section, address_of_value, section_at, sections};
use crate::dictionary::check::{FieldSpans, Source};
use crate::identity::Multiplexer;
use crate::object;
use std::ops::Range;

/// Where what is named at that place is described: the name of its section.
pub fn definition(text: &str, at: usize) -> Option<Range<usize>> {
    let source = Source::new(text);
    let sections = sections(&source);
    let wanted = named_at(&source, &sections, at)?;
    let of = |with_sub: bool| {
        let mut described = sections.iter().filter_map(|section| Some((section.address(&source)?, section)));
        described.find(|((found, is_entry), _)| {
            found.index == wanted.index && *is_entry == with_sub && (!with_sub || found.sub == wanted.sub)
        })
    };
    // A VAR has no section for its sub-index 0.
    of(true).filter(|_| wanted.sub.0 > 0).or_else(|| of(false)).map(|(_, section)| section.name.clone())
}

/// Where the object of that place is named: in lists, in mappings, and where it is described.
pub fn references(text: &str, at: usize) -> Vec<Range<usize>> {
    let source = Source::new(text);
    let sections = sections(&source);
    let Some(wanted) = named_at(&source, &sections, at) else { return Vec::new() };
    let mut found = Vec::new();
    for section in &sections {
        if section.address(&source).is_some_and(|(at, _)| at.index == wanted.index) {
            found.push(section.name.clone());
        }
        for field in section.fields(&source) {
            if named_by(&source, section, &field).is_some_and(|at| at.index == wanted.index) {
                found.push(field.value);
            }
        }
    }
    found
}

/// The object or entry that is named there: by a section, or by a value.
fn named_at(source: &Source<'_>, sections: &[Section], at: usize) -> Option<Multiplexer> {
    let section = section_at(sections, at)?;
    if at <= section.name.end {
        return Some(section.address(source)?.0);
    }
    let field = section.fields(source).find(|field| (field.name.start..=field.value.end).contains(&at))?;
    named_by(source, section, &field)
}

/// The object that a field's value names, where it is one that does.
fn named_by(source: &Source<'_>, section: &Section, field: &FieldSpans) -> Option<Multiplexer> {
    let (name, value) = (source.get(&field.name), source.get(&field.value));
    match section.address(source) {
        None => {
            let is_list = source.get(&section.name).to_ascii_lowercase().ends_with("objects");
            let is_entry = name.bytes().all(|byte| byte.is_ascii_digit());
            address_of_value(value, false).filter(|_| is_list && is_entry)
        }
        Some((at, is_entry)) => {
            let is_value = ["DefaultValue", "ParameterValue"].iter().any(|known| name.eq_ignore_ascii_case(known));
            let maps = is_entry && at.sub.0 > 0 && object::is_pdo_mapping(at.index.0);
            address_of_value(value, true).filter(|_| is_value && maps)
        }
    }
}
