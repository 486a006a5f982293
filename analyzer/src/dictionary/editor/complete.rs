//! Completion: missing fields of a section, values, and objects of the standards.

use super::hover::profile;
use super::keys::{self, Key};
use super::navigate::sections;
use crate::dictionary::data_type::DataType;
use crate::dictionary::names::{StandardObject, standard_object};
use crate::dictionary::object::ObjectCode;
use crate::dictionary::source::{Field, Section, Source};
use crate::identity::Index;
use std::ops::Range;

/// A completion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Completion {
    /// The text in the list.
    pub label: String,
    /// An explanation.
    pub detail: String,
    /// The replaced bytes of the text.
    pub range: Range<usize>,
    /// The new text.
    pub text: String,
}

/// The completions at a place, the most likely first.
pub fn complete(source: &Source<'_>, at: usize) -> Vec<Completion> {
    let (line, _) = source.position(at);
    let whole = source.whole_line(line);
    let before = source.text.get(whole.start..at).unwrap_or_default();
    if before.trim_start().starts_with('[') {
        let start = whole.start + before.len() - before.trim_start().len();
        let end = source.trimmed(whole).range().end.max(at);
        return objects(source, start..end);
    }
    let Some(section) = source.section_at(at) else { return Vec::new() };
    let known = keys::of(section);
    match before.split_once('=') {
        Some((name, value)) => values(known, name.trim(), at - value.len()..source.trimmed(whole).range().end.max(at)),
        None => fields(source, section, known, at - before.trim_start().len()..at),
    }
}

/// The fields that the section lacks.
fn fields(source: &Source<'_>, section: Section<'_>, known: &[Key], range: Range<usize>) -> Vec<Completion> {
    let typed = source.text.get(range.clone()).unwrap_or_default();
    let there: Vec<&str> = section.all_fields().map(Field::name).collect();
    let is_missing = |key: &&Key| !there.iter().any(|name| name.eq_ignore_ascii_case(key.name));
    let fits = |key: &&Key| key.name.get(..typed.len()).is_some_and(|start| start.eq_ignore_ascii_case(typed));
    known
        .iter()
        .filter(is_missing)
        .filter(fits)
        .map(|key| Completion {
            label: key.name.to_owned(),
            detail: key.meaning.to_owned(),
            range: range.clone(),
            text: format!("{}=", key.name),
        })
        .collect()
}

fn values(known: &[Key], name: &str, range: Range<usize>) -> Vec<Completion> {
    if name.eq_ignore_ascii_case("DataType") {
        let of_type = |(index, name): (u16, &str)| Completion {
            label: format!("0x{index:04X}"),
            detail: name.to_owned(),
            range: range.clone(),
            text: format!("0x{index:04X}"),
        };
        return keys::data_types().map(of_type).collect();
    }
    let values = known.iter().find(|key| key.name.eq_ignore_ascii_case(name)).map_or(&[][..], |key| key.values);
    let of_value = |value: &&str| Completion {
        label: (*value).to_owned(),
        detail: String::new(),
        range: range.clone(),
        text: (*value).to_owned(),
    };
    values.iter().map(of_value).collect()
}

/// The objects of the standards that are not described yet, each with the sections of the object and its entries.
fn objects(source: &Source<'_>, range: Range<usize>) -> Vec<Completion> {
    let profile = profile(source);
    let typed = source.text.get(range.clone()).unwrap_or_default().trim_matches(['[', ']']).to_ascii_uppercase();
    // The name being typed is no section yet.
    let others = sections(source).filter(|section| !range.contains(&section.name_span().range().start));
    let there: Vec<u16> = others.filter_map(|section| Some(section.address()?.0.index.0)).collect();
    let mut found = Vec::new();
    for index in (0x1000..=0x1FFF).chain(0x6000..=0x67FF) {
        let label = format!("{index:04X}");
        if there.contains(&index) || !label.starts_with(&typed) {
            continue;
        }
        let Some(object) = standard_object(Index(index), profile) else { continue };
        // Of many objects of the same kind, such as 512 TPDOs, only the first missing one is offered.
        if index > object.first && !there.contains(&(index - 1)) {
            continue;
        }
        let text = sections_of(object, index);
        found.push(Completion {
            label: format!("[{label}]"),
            detail: object.name.to_owned(),
            range: range.clone(),
            text,
        });
    }
    found
}

/// The sections of an object, completed from the standard.
fn sections_of(object: &StandardObject, index: u16) -> String {
    let is_var = object.code == ObjectCode::VAR;
    let mut text = format!("[{index:04X}]\nParameterName={}\nObjectType=0x{:X}\n", object.name, object.code.0);
    let entry = |data_type: Option<DataType>, access: Option<_>| {
        let data_type = data_type.map_or(String::new(), |DataType(index)| format!("DataType=0x{index:04X}\n"));
        let access = access.map_or(String::new(), |access| format!("AccessType={access}\n"));
        format!("{data_type}{access}")
    };
    if is_var {
        let first = object.entries.first();
        text += &entry(first.and_then(|entry| entry.data_type), first.and_then(|entry| entry.access));
        return text + "PDOMapping=0";
    }
    text += &format!("SubNumber={}\n", object.entries.len());
    for known in object.entries {
        text += &format!("\n[{index:04X}sub{:X}]\nParameterName={}\nObjectType=0x7\n", known.first, known.name);
        text += &entry(known.data_type, known.access);
        text += "PDOMapping=0\n";
    }
    text.trim_end().to_owned()
}
