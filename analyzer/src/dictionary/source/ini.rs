//! The lines of an EDS: sections, fields and comments, in the order and case of the file.
//!
//! CiA 306, basic structure: `[section]`, `field=value`, `;` begins a comment line. Case of names is ignored. This
//! reader also accepts variants from the field: blanks anywhere, `#` and `//` comments, a text after `]`, line ends
//! of all systems, repeated sections and fields (the first counts).

use super::field_name::FieldName;
use super::lines::{Line, lines};
use super::names::canonical;
use super::tree::{Builder, FieldPart, SectionIdentity, SectionPart};
use crate::dictionary::place::{Place, Span};
use crate::dictionary::problem::Problems;
use crate::dictionary::rules;
use std::collections::hash_map::Entry;

/// CiA 306: the maximum number of characters in a line.
const LONGEST_LINE: usize = 255;

/// Maximum number of lines that are read: each short line of a hostile file takes many times its own memory.
const MOST_LINES: u32 = 1_000_000;

/// The number of non-empty lines, and of unreadable ones among them.
#[derive(Default)]
struct Count {
    used: u32,
    unread: u32,
}

/// Reads all sections of the text.
pub(super) fn read(text: &str, problems: Problems) -> Builder<'_> {
    let mut builder = Builder::new(text, false, problems);
    // An estimate of the number of sections: most sections have more than 128 bytes, so the tables rarely have to grow.
    let sections = text.len() / 128;
    builder.tree.sections.reserve(sections);
    builder.tree.by_name.reserve(sections);
    builder.tree.fields.reserve(text.len() / 24);
    let mut count = Count::default();
    for (number, line) in (1..).zip(lines(text)) {
        if number > MOST_LINES {
            let expected = "at most 1000000 lines; the rest is left out";
            builder.problems.report(Place::line(number), &rules::text::TOO_MUCH, expected, line.text);
            break;
        }
        builder.tree.lines.push(line.start as u32);
        builder.check_line(&line, number);
        builder.line(line, number, &mut count);
    }
    builder.end_section(text.len());
    if count.unread > 0 && count.unread * 2 >= count.used {
        let found = format!("{} of {} lines can't be read", count.unread, count.used);
        builder.problems.report(Place::line(1), &rules::text::HALF_READ, "a device description", &found);
    }
    builder.check_line_ends();
    builder
}

impl<'t> Builder<'t> {
    /// Checks the length of a line, and its control characters.
    fn check_line(&mut self, line: &Line<'_>, number: u32) {
        if line.text.len() > LONGEST_LINE && line.text.chars().nth(LONGEST_LINE).is_some() {
            let expected = "at most 255 characters";
            self.problems.report(Place::line(number), &rules::text::TOO_LONG, expected, line.text);
        }
        if line.is_plain {
            return;
        }
        let text = line.text.trim_matches('\0');
        if text.bytes().any(|byte| byte < b' ' && byte != b'\t' || byte == 0x7F) {
            self.problems.report(Place::line(number), &rules::text::CONTROL, "no control characters", text);
        }
    }

    fn line(&mut self, line: Line<'t>, number: u32, count: &mut Count) {
        let begins = line.start;
        let line = line.trimmed();
        let Some(&first) = line.text.as_bytes().first() else { return };
        if first == b';' {
            self.tree.comments.push(line.span());
            return;
        }
        if matches!(first, b'<' | b'>') && (line.text.starts_with("<<<<<<< ") || line.text.starts_with(">>>>>>> ")) {
            let expected = "one side of the merge conflict";
            self.problems.report(Place::line(number), &rules::text::CONFLICT, expected, line.text);
            return;
        }
        count.used += 1;
        if first == b'[' {
            self.end_section(begins);
            self.begin_section(&line, begins, number);
        } else if first == b'#' || first == b'/' && line.text.starts_with("//") {
            self.tree.comments.push(line.span());
            let expected = "a comment to begin with ;";
            self.problems.report(Place::line(number), &rules::text::COMMENT, expected, line.text);
        } else if let Some((name, value)) = line.sides() {
            self.field(&line, name, value, number);
        } else {
            count.unread += 1;
            let section = self.tree.sections.last().filter(|section| !section.is_repeated);
            let section = section.map_or("", |section| self.get(section.name));
            let place = Place { section, ..Place::line(number) };
            self.problems.report(place, &rules::text::UNREAD, "[section], field=value or ;comment", line.text);
        }
    }

    fn end_section(&mut self, at: usize) {
        if let Some(section) = self.tree.sections.last_mut() {
            section.whole.end = at as u32;
        }
    }

    fn begin_section(&mut self, line: &Line<'t>, begins: usize, number: u32) {
        let rest = line.text.get(1..).unwrap_or_default();
        let (inside, after) = rest.split_once(']').unwrap_or((rest, "?"));
        let name = inside.trim();
        let place = Place { section: name, ..Place::line(number) };
        let after = after.trim();
        if !after.is_empty() && !after.starts_with(';') {
            let found = if rest.contains(']') { after } else { rest };
            self.problems.report(place, &rules::text::SECTION_LINE, "a section name between [ and ]", found);
        }
        let at = self.tree.sections.len() as u32;
        let (about, identity) = SectionIdentity::of(name);
        let is_standard = matches!(identity, SectionIdentity::Standard(_));
        let is_repeated = match self.tree.by_name.entry(identity) {
            Entry::Occupied(_) => {
                let expected = "a section once; the first counts";
                self.problems.report(place, &rules::section::TWICE, expected, name);
                true
            }
            Entry::Vacant(vacant) => {
                vacant.insert(at);
                false
            }
        };
        let start = line.start + 1 + (inside.len() - inside.trim_start().len());
        let fields = self.tree.fields.len() as u32;
        self.begin(SectionPart {
            name: Span::new(start, start + name.len()),
            head: line.span(),
            whole: Span::new(begins, begins),
            line: number,
            fields: (fields, fields),
            next: at + 1,
            about,
            is_standard,
            is_repeated,
        });
    }

    fn field(&mut self, line: &Line<'t>, name: &'t str, value: &'t str, number: u32) {
        let is_exact = || name.bytes().all(|byte| byte.is_ascii_graphic());
        let known =
            FieldName::parse(name).or_else(|| if is_exact() { None } else { FieldName::parse(&canonical(name)) });
        let Span { start, end } = line.span();
        let first = self.add(FieldPart {
            name: Span { start, end: start + name.len() as u32 },
            value: Span { start: end - value.len() as u32, end },
            line: number,
            known,
            is_repeated: false,
        });
        let first = first.and_then(|first| self.tree.fields.get(first as usize));
        if let (Some(first), Some(section), Some(field)) = (first, self.tree.sections.last(), self.tree.fields.last()) {
            let rule = if self.get(first.value) == value { &rules::field::REPEATED } else { &rules::field::TWICE };
            let place = Place { line: number, section: self.get(section.name), field: name, spot: field.spot() };
            self.problems.report(place, rule, "a field once; the first counts", value);
        }
    }

    /// Checks that all lines end in the same way, and not by a carriage return alone.
    fn check_line_ends(&mut self) {
        let text = self.text;
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
        self.problems.report(Place::line(1), &rules::text::LINE_ENDS, "one way to end lines, CR LF or LF", found);
    }
}
