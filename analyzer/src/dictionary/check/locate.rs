//! Finds the place of a problem in the text: the value of its field, else its line.

use super::Finding;
use super::source::Source;
use crate::dictionary::problem::EdsProblem;
use crate::dictionary::rules;
use std::ops::Range;

pub(super) use crate::dictionary::eds::is_same;

/// The problem with its place.
pub(super) fn locate(problem: EdsProblem, source: &Source<'_>) -> Finding {
    let span = span(&problem, source);
    let (line, column) = span.as_ref().map_or((0, 0), |span| source.position(span.start));
    Finding { problem, line, column, span: span.unwrap_or(0..0), fix: None, waived: None }
}

fn span(problem: &EdsProblem, source: &Source<'_>) -> Option<Range<usize>> {
    if problem.rule == &rules::text::ENCODING {
        let at = source.text.find(|character: char| !character.is_ascii())?;
        let length = source.text.get(at..)?.chars().next()?.len_utf8();
        return Some(at..at + length);
    }
    if source.is_xml() {
        return attribute(problem, source);
    }
    let mut line = problem.line;
    if line == 0 {
        line = source.section(&problem.section)?;
    }
    if problem.field.is_empty() {
        return Some(source.line(line));
    }
    // A finding of a whole section may be about one of its fields.
    let below = if source.is_section(line) { source.section_lines(line) } else { 0..0 };
    for candidate in std::iter::once(line).chain(below) {
        let Some(field) = source.field(candidate) else { continue };
        if is_same(source.get(&field.name), &problem.field) {
            let is_about_name = ABOUT_NAMES.contains(&problem.rule) || field.value.is_empty();
            return Some(if is_about_name { field.name } else { field.value });
        }
    }
    Some(source.line(line))
}

/// What these rules find is the name of a field, not its value.
const ABOUT_NAMES: [&rules::Rule; 6] = [
    &rules::field::UNKNOWN,
    &rules::file::DUMMY,
    &rules::list::KEY,
    &rules::list::GAP,
    &rules::list::ORDER,
    &rules::list::BESIDE_KEY,
];

/// The value of the attribute, else the line.
fn attribute(problem: &EdsProblem, source: &Source<'_>) -> Option<Range<usize>> {
    if problem.line == 0 {
        return None;
    }
    let line = source.line(problem.line);
    let rest = source.text.get(line.start..)?;
    let element = rest.split_once('>').map_or(rest, |(element, _)| element);
    let lower = element.to_ascii_lowercase();
    let wanted = format!("{}=\"", problem.field.to_ascii_lowercase());
    let found = lower.match_indices(&wanted).find(|(at, _)| lower[..*at].ends_with(char::is_whitespace));
    if let (Some((at, _)), false) = (found, problem.field.is_empty()) {
        let begin = line.start + at + wanted.len();
        let length = source.text.get(begin..)?.find('"')?;
        return Some(begin..begin + length);
    }
    Some(line)
}
