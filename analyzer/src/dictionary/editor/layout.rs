//! The sections of a text, and what stands at a place.

use crate::dictionary::check::{FieldSpans, Source};
use crate::dictionary::eds::address_of_section;
use crate::identity::Multiplexer;
use std::ops::Range;

/// A section.
#[derive(Clone, Debug)]
pub struct Section {
    /// The line of its name.
    pub line: u32,
    /// Its name, without brackets.
    pub name: Range<usize>,
    /// From its name to the next section.
    pub whole: Range<usize>,
    /// The last of its lines.
    pub last: u32,
}

/// All sections, in the order of the text.
pub fn sections(source: &Source<'_>) -> Vec<Section> {
    let mut all: Vec<Section> = Vec::new();
    for &line in source.headers() {
        let whole = source.whole_line(line);
        if let Some(before) = all.last_mut() {
            (before.whole.end, before.last) = (whole.start, line - 1);
        }
        all.push(Section {
            line,
            name: name(source, line),
            whole: whole.start..source.text.len(),
            last: source.lines(),
        });
    }
    all
}

fn name(source: &Source<'_>, line: u32) -> Range<usize> {
    let line = source.line(line);
    let text = source.get(&line);
    let end = text.find(']').unwrap_or(text.len());
    line.start + 1..line.start + end.max(1)
}

/// The section in which a place is.
pub fn section_at(sections: &[Section], at: usize) -> Option<&Section> {
    sections.iter().rev().find(|section| section.whole.start <= at)
}

impl Section {
    /// Its fields.
    pub fn fields<'a>(&self, source: &'a Source<'_>) -> impl Iterator<Item = FieldSpans> + use<'a> {
        (self.line + 1..=self.last).filter_map(|line| source.field(line))
    }

    /// The value of a field.
    pub fn value<'a>(&self, source: &Source<'a>, name: &str) -> Option<&'a str> {
        let field = self.fields(source).find(|field| source.get(&field.name).eq_ignore_ascii_case(name))?;
        Some(source.get(&field.value))
    }

    /// The object or entry that it describes.
    pub fn address(&self, source: &Source<'_>) -> Option<(Multiplexer, bool)> {
        address_of_section(source.get(&self.name))
    }
}

/// What a value names: `0x1018` an object, `0x60040020` in a mapping an entry.
pub fn address_of_value(value: &str, is_mapping: bool) -> Option<Multiplexer> {
    let digits = value.trim().strip_prefix("0x").or_else(|| value.trim().strip_prefix("0X"))?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    match (is_mapping, digits.len()) {
        (true, 8) => Some(Multiplexer::new((number >> 16) as u16, (number >> 8) as u8)),
        (false, 1..=4) => Some(Multiplexer::new(number as u16, 0)),
        _ => None,
    }
}
