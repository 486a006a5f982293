//! The outline: sections in the order of the file, entries below their objects.

use super::navigate::sections;
use crate::dictionary::source::{Field, FieldName, Source};
use std::ops::Range;

/// A section in the outline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// The name of the section.
    pub name: String,
    /// `ParameterName` of an object or entry.
    pub detail: String,
    /// The range from the name of the section to its last line.
    pub whole: Range<usize>,
    /// The range of the name.
    pub selected: Range<usize>,
    /// Whether the section describes an object, or an entry of one.
    pub is_object: bool,
    /// The entries of an object.
    pub entries: Vec<Symbol>,
}

/// The sections of a text.
pub fn outline(source: &Source<'_>) -> Vec<Symbol> {
    let mut all: Vec<(Option<u16>, Symbol)> = Vec::new();
    for section in sections(source) {
        let address = section.address();
        let (name, whole) = (section.name_span().range(), section.whole().range());
        let detail = section.field(FieldName::ParameterName).map(Field::value);
        let symbol = Symbol {
            name: section.name().to_owned(),
            detail: detail.unwrap_or_default().to_owned(),
            whole: whole.start..source.trimmed(whole).range().end.max(name.end),
            selected: name,
            is_object: address.is_some(),
            entries: Vec::new(),
        };
        match (address, all.last_mut()) {
            (Some((at, true)), Some((Some(index), object))) if *index == at.index.0 => {
                object.whole.end = symbol.whole.end;
                object.entries.push(symbol);
            }
            (address, _) => all.push((address.map(|(at, _)| at.index.0), symbol)),
        }
    }
    all.into_iter().map(|(_, symbol)| symbol).collect()
}
