//! The lines of an EDS: sections, fields and comments, each with its line number, in the file's order and case.
//!
//! CiA 306, basic structure: `[section]`, `field=value`, `;` begins a comment line. Names are the same in any case.
//! What the field has beyond that and is accepted here: blanks around everything, `#` and `//` comments, a text after
//! `]`, line ends of all systems, sections and fields that occur twice (the first counts).

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::field_name::FieldName;
use super::lines::{Line, lines};
use super::section_name::SectionName;
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
    by_name: HashMap<SectionIdentity, usize>,
}

/// What two sections of the same name have in common. Nearly all are spelled as the standard has it.
#[derive(Debug, PartialEq, Eq, Hash)]
enum SectionIdentity {
    Standard(SectionName),
    /// [`canonical`]
    Other(String),
}

impl SectionIdentity {
    fn of(name: &str) -> (SectionName, Self) {
        match SectionName::parse_standard(name) {
            Some(about) => (about, Self::Standard(about)),
            None => {
                let name = canonical(name);
                match SectionName::parse_standard(&name) {
                    Some(about) => (about, Self::Standard(about)),
                    None => (SectionName::parse(&name), Self::Other(name)),
                }
            }
        }
    }
}

/// `[name]` and what follows it.
#[derive(Debug)]
pub(super) struct Section<'a> {
    /// As the file writes it.
    pub name: &'a str,
    /// What it is about.
    pub about: SectionName,
    /// Whether an object or entry is named as the standard writes it, case and blanks aside.
    pub is_standard: bool,
    pub line: u32,
    pub fields: Vec<Field<'a>>,
    /// Once there are more than [`FEW`]; fewer are looked through one by one, which is faster.
    by_name: Option<HashMap<FieldIdentity, usize>>,
}

/// A section that describes an object has no more fields.
const FEW: usize = 16;

/// What two fields of the same name have in common.
#[derive(Debug, PartialEq, Eq, Hash)]
enum FieldIdentity {
    Known(FieldName),
    /// [`canonical`]
    Other(String),
}

/// `name=value`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field<'a> {
    /// As the file writes it.
    pub name: &'a str,
    /// Which one it is, where CiA 306 defines it.
    pub known: Option<FieldName>,
    /// Without blanks at both ends; a comment after the value still stands in it.
    pub value: &'a str,
    pub line: u32,
}

impl Field<'_> {
    fn identity(&self) -> FieldIdentity {
        self.known.map_or_else(|| FieldIdentity::Other(canonical(self.name)), FieldIdentity::Known)
    }

    fn is_same(&self, other: &Self) -> bool {
        match (self.known, other.known) {
            (None, None) => is_same(self.name, other.name),
            (one, other) => one == other,
        }
    }
}

impl<'a> Document<'a> {
    /// The section of that name, in any case.
    pub fn section(&self, name: &str) -> Option<&Section<'a>> {
        self.sections.get(*self.by_name.get(&SectionIdentity::of(name).1)?)
    }
}

impl<'a> Section<'a> {
    /// The first field of that name.
    pub fn field(&self, name: FieldName) -> Option<Field<'a>> {
        match &self.by_name {
            None => self.fields.iter().find(|field| field.known == Some(name)).copied(),
            Some(by_name) => self.fields.get(*by_name.get(&FieldIdentity::Known(name))?).copied(),
        }
    }

    /// Takes a field; gives the first one of that name if there is one.
    fn add(&mut self, field: Field<'a>) -> Option<Field<'a>> {
        if self.fields.len() < FEW {
            let first = self.fields.iter().find(|first| first.is_same(&field)).copied();
            if first.is_none() {
                self.fields.push(field);
            }
            return first;
        }
        let all = || self.fields.iter().enumerate().map(|(at, field)| (field.identity(), at)).collect();
        match self.by_name.get_or_insert_with(all).entry(field.identity()) {
            Entry::Occupied(first) => self.fields.get(*first.get()).copied(),
            Entry::Vacant(vacant) => {
                vacant.insert(self.fields.len());
                self.fields.push(field);
                None
            }
        }
    }

    /// Where the section begins.
    pub fn place(&self) -> Place<'_> {
        Place { line: self.line, section: self.name, field: "" }
    }

    /// Where a field stands, or would stand.
    pub fn place_of(&self, name: FieldName) -> Place<'_> {
        let line = self.field(name).map_or(self.line, |field| field.line);
        Place { line, section: self.name, field: name.text() }
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
    // Most sections have more bytes: nothing is copied because a table was too small.
    let sections = text.len() / 128;
    let mut document = Document { sections: Vec::with_capacity(sections), by_name: HashMap::with_capacity(sections) };
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
            problems.report(place, &rules::text::TOO_MUCH, expected, line.text);
            break;
        }
        check_line(&line, number, problems);
        let line = line.trimmed();
        let Some(&first) = line.text.as_bytes().first() else { continue };
        if first == b';' {
            continue;
        }
        let place = Place { line: number, ..Place::default() };
        if matches!(first, b'<' | b'>') && (line.text.starts_with("<<<<<<< ") || line.text.starts_with(">>>>>>> ")) {
            problems.report(place, &rules::text::CONFLICT, "one side of the merge conflict", line.text);
            continue;
        }
        used += 1;
        if let (b'[', Some(rest)) = (first, line.text.get(1..)) {
            current = begin_section(&mut document, rest, number, problems);
            continue;
        }
        if first == b'#' || first == b'/' && line.text.starts_with("//") {
            problems.report(place, &rules::text::COMMENT, "a comment to begin with ;", line.text);
            continue;
        }
        let section = current.and_then(|position| document.sections.get_mut(position));
        field(section, &line, number, problems);
    }
    let unread = problems.count_of(&rules::text::UNREAD) - before;
    if unread > 0 && unread * 2 >= used {
        let found = format!("{unread} of {used} lines can't be read");
        problems.report(Place { line: 1, ..Place::default() }, &rules::text::HALF_READ, "a device description", &found);
    }
    check_line_ends(text, problems);
    document
}

/// Lines are not too long and have no control characters.
fn check_line(line: &Line<'_>, number: u32, problems: &mut Problems) {
    let place = Place { line: number, ..Place::default() };
    if line.text.len() > LONGEST_LINE && line.text.chars().nth(LONGEST_LINE).is_some() {
        problems.report(place, &rules::text::TOO_LONG, "at most 255 characters", line.text);
    }
    if line.is_plain {
        return;
    }
    let text = line.text.trim_matches('\0');
    if text.bytes().any(|byte| byte < b' ' && byte != b'\t' || byte == 0x7F) {
        problems.report(place, &rules::text::CONTROL, "no control characters", text);
    }
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
    let (about, identity) = SectionIdentity::of(name);
    let is_standard = matches!(identity, SectionIdentity::Standard(_));
    match document.by_name.entry(identity) {
        Entry::Occupied(_) => {
            let expected = "a section once; the first counts";
            problems.report(place, &rules::section::TWICE, expected, name);
            None
        }
        Entry::Vacant(vacant) => {
            let position = document.sections.len();
            vacant.insert(position);
            let fields = Vec::with_capacity(FEW / 2);
            document.sections.push(Section { name, about, is_standard, line, fields, by_name: None });
            Some(position)
        }
    }
}

fn field<'a>(section: Option<&mut Section<'a>>, text: &Line<'a>, line: u32, problems: &mut Problems) {
    let Some((name, value)) = text.sides() else {
        let section = section.map_or("", |section| section.name);
        let place = Place { line, section, field: "" };
        problems.report(place, &rules::text::UNREAD, "[section], field=value or ;comment", text.text);
        return;
    };
    // The fields of a section that occurs again have been reported with the section.
    let Some(section) = section else { return };
    let is_exact = || name.bytes().all(|byte| byte.is_ascii_graphic());
    let known = FieldName::parse(name).or_else(|| if is_exact() { None } else { FieldName::parse(&canonical(name)) });
    let field = Field { name, known, value, line };
    if let Some(first) = section.add(field) {
        let place = Place { line, section: section.name, field: name };
        let rule = if first.value == value { &rules::field::REPEATED } else { &rules::field::TWICE };
        problems.report(place, rule, "a field once; the first counts", value);
    }
}
