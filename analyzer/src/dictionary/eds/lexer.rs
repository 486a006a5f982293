//! The lines of an EDS: sections, fields and comments, each with its line number, in the file's order and case.
//!
//! CiA 306, basic structure: `[section]`, `field=value`, `;` begins a comment line. Names are the same in any case.
//! What the field has beyond that and is accepted here: blanks around everything, `#` and `//` comments, a text after
//! `]`, line ends of all systems, sections and fields that occur twice (the first counts).

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::dictionary::problem::{Place, Problems};
use crate::dictionary::rules;

/// CiA 306: at most so many characters in a line.
const LONGEST_LINE: usize = 255;

/// What follows is not read: each short line of a hostile file would take many times its own memory.
const MOST_LINES: u32 = 1_000_000;

/// All sections of a file.
#[derive(Debug, Default)]
pub(super) struct Document<'a> {
    pub sections: Vec<Section<'a>>,
    by_name: HashMap<String, usize>,
}

/// `[name]` and what follows it.
#[derive(Debug)]
pub(super) struct Section<'a> {
    /// As the file writes it.
    pub name: &'a str,
    pub line: u32,
    pub fields: Vec<Field<'a>>,
    /// Once there are more than [`FEW`]; fewer are looked through one by one, which is faster.
    by_name: HashMap<String, usize>,
}

/// A section that describes an object has no more fields.
const FEW: usize = 16;

/// `name=value`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field<'a> {
    /// As the file writes it.
    pub name: &'a str,
    /// Without blanks at both ends; a comment after the value still stands in it.
    pub value: &'a str,
    pub line: u32,
}

impl<'a> Document<'a> {
    /// The section of that name, in any case.
    pub fn section(&self, name: &str) -> Option<&Section<'a>> {
        self.sections.get(*self.by_name.get(&canonical(name))?)
    }
}

impl<'a> Section<'a> {
    /// The field of that name, in any case.
    pub fn field(&self, name: &str) -> Option<Field<'a>> {
        if self.fields.len() <= FEW {
            return self.fields.iter().find(|field| is_same(field.name, name)).copied();
        }
        self.fields.get(*self.by_name.get(&canonical(name))?).copied()
    }

    /// Takes a field; gives the first one of that name if there is one.
    fn add(&mut self, field: Field<'a>) -> Option<Field<'a>> {
        if let Some(first) = self.field(field.name) {
            return Some(first);
        }
        if self.fields.len() == FEW {
            self.by_name = self.fields.iter().enumerate().map(|(at, field)| (canonical(field.name), at)).collect();
        }
        if self.fields.len() >= FEW {
            self.by_name.insert(canonical(field.name), self.fields.len());
        }
        self.fields.push(field);
        None
    }

    /// Where a field stands, or would stand.
    pub fn place<'b>(&'b self, field: &'b str) -> Place<'b> {
        let line = self.field(field).map_or(self.line, |field| field.line);
        Place { line, section: self.name, field }
    }
}

/// Names are compared in lower case and without blanks.
pub(in crate::dictionary) fn canonical(name: &str) -> String {
    if name.is_ascii() {
        let mut same: String = name.chars().filter(|character| !character.is_whitespace()).collect();
        same.make_ascii_lowercase();
        return same;
    }
    name.chars().filter(|character| !character.is_whitespace()).flat_map(char::to_lowercase).collect()
}

/// Whether two names are [`canonical`]ly the same. Nearly all names have neither blanks nor other letters.
pub(in crate::dictionary) fn is_same(one: &str, other: &str) -> bool {
    // Most names differ in their first letter.
    if let ([first, ..], [second, ..]) = (one.as_bytes(), other.as_bytes())
        && first.is_ascii_graphic()
        && second.is_ascii_graphic()
        && !first.eq_ignore_ascii_case(second)
    {
        return false;
    }
    let is_plain = |name: &str| name.bytes().all(|byte| byte.is_ascii_graphic());
    one.eq_ignore_ascii_case(other) || !(is_plain(one) && is_plain(other)) && canonical(one) == canonical(other)
}

/// All sections of the text.
pub(super) fn read<'a>(text: &'a str, problems: &mut Problems) -> Document<'a> {
    let mut document = Document::default();
    // Where fields go: `None` before the first section and in a section that occurs again.
    let mut current: Option<usize> = None;
    let mut number = 0;
    let mut used = 0;
    let before = problems.count_of(&rules::text::UNREAD);
    for line in lines(text) {
        number += 1;
        if number > MOST_LINES {
            let place = Place { line: number, ..Place::default() };
            let expected = "at most 1000000 lines; the rest is left out";
            problems.report(place, &rules::text::TOO_MUCH, expected, line);
            break;
        }
        if line.len() > LONGEST_LINE && line.chars().nth(LONGEST_LINE).is_some() {
            let place = Place { line: number, ..Place::default() };
            problems.report(place, &rules::text::TOO_LONG, "at most 255 characters", line);
        }
        let line = line.trim_matches('\0');
        if line.bytes().any(|byte| byte < b' ' && byte != b'\t' || byte == 0x7F) {
            let place = Place { line: number, ..Place::default() };
            problems.report(place, &rules::text::CONTROL, "no control characters", line);
        }
        let line = line.trim_matches(|character: char| character.is_whitespace() || character == '\0');
        let Some(&first) = line.as_bytes().first() else { continue };
        if first == b';' {
            continue;
        }
        if matches!(first, b'<' | b'>') && (line.starts_with("<<<<<<< ") || line.starts_with(">>>>>>> ")) {
            let place = Place { line: number, ..Place::default() };
            problems.report(place, &rules::text::CONFLICT, "one side of the merge conflict", line);
            continue;
        }
        used += 1;
        if let (b'[', Some(rest)) = (first, line.get(1..)) {
            current = begin_section(&mut document, rest, number, problems);
            continue;
        }
        if first == b'#' || first == b'/' && line.starts_with("//") {
            let place = Place { line: number, ..Place::default() };
            problems.report(place, &rules::text::COMMENT, "a comment to begin with ;", line);
            continue;
        }
        let section = current.and_then(|position| document.sections.get_mut(position));
        field(section, line, number, problems);
    }
    let unread = problems.count_of(&rules::text::UNREAD) - before;
    if unread > 0 && unread * 2 >= used {
        let found = format!("{unread} of {used} lines can't be read");
        problems.report(Place { line: 1, ..Place::default() }, &rules::text::HALF_READ, "a device description", &found);
    }
    check_line_ends(text, problems);
    document
}

/// Lines that end in LF, CR LF or CR alone.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n').flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'))
}

/// One way to end a line in the whole file, and not by a carriage return alone.
fn check_line_ends(text: &str, problems: &mut Problems) {
    if !text.contains('\r') {
        return;
    }
    let (returns, both) = (text.matches('\r').count(), text.matches("\r\n").count());
    let feeds = text.matches('\n').count();
    let found = match (returns > both, feeds > both) {
        (false, false) => return,
        (true, false) if both == 0 => "CR alone",
        (true, _) => "several, with CR alone",
        (false, true) => "CR LF and LF",
    };
    let place = Place { line: 1, ..Place::default() };
    problems.report(place, &rules::text::LINE_ENDS, "one way to end lines, CR LF or LF", found);
}

fn begin_section<'a>(document: &mut Document<'a>, rest: &'a str, line: u32, problems: &mut Problems) -> Option<usize> {
    let (name, after) = rest.split_once(']').unwrap_or((rest, "?"));
    let name = name.trim();
    let place = Place { line, section: name, field: "" };
    let after = after.trim();
    if !after.is_empty() && !after.starts_with(';') {
        let found = if rest.contains(']') { after } else { rest };
        problems.report(place, &rules::text::SECTION_LINE, "a section name between [ and ]", found);
    }
    match document.by_name.entry(canonical(name)) {
        Entry::Occupied(_) => {
            let expected = "a section once; the first counts";
            problems.report(place, &rules::section::TWICE, expected, name);
            None
        }
        Entry::Vacant(vacant) => {
            let position = document.sections.len();
            vacant.insert(position);
            document.sections.push(Section { name, line, fields: Vec::new(), by_name: HashMap::new() });
            Some(position)
        }
    }
}

fn field<'a>(section: Option<&mut Section<'a>>, text: &'a str, line: u32, problems: &mut Problems) {
    let Some((name, value)) = text.split_once('=') else {
        let section = section.map_or("", |section| section.name);
        let place = Place { line, section, field: "" };
        problems.report(place, &rules::text::UNREAD, "[section], field=value or ;comment", text);
        return;
    };
    let (name, value) = (name.trim(), value.trim());
    // The fields of a section that occurs again have been reported with the section.
    let Some(section) = section else { return };
    let field = Field { name, value, line };
    if let Some(first) = section.add(field) {
        let place = Place { line, section: section.name, field: name };
        let rule = if first.value == value { &rules::field::REPEATED } else { &rules::field::TWICE };
        problems.report(place, rule, "a field once; the first counts", value);
    }
}
