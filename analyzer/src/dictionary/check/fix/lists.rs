//! Fixes of lists and counts.

use super::lines::{edit, insert_after};
use super::{Fix, Source};
use crate::dictionary::check::Finding;
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::eds::{list_of, number};
use crate::dictionary::rules;
use crate::dictionary::source::{Field, Section};

pub(super) fn of(finding: &Finding, source: &Source<'_>, description: &DeviceDescription) -> Option<Fix> {
    let rule = finding.problem.rule;
    let is = |other: &rules::Rule| rule == other;
    let counts = [
        &rules::list::COUNT,
        &rules::list::BESIDE,
        &rules::list::SUB_NUMBER,
        &rules::file::COMMENT_COUNT,
        &rules::module::COUNT,
    ];
    if is(&rules::file::PDO_COUNT) && !announces_more(finding, source) {
        return count(finding, source);
    }
    if counts.into_iter().any(is) {
        return count(finding, source);
    }
    if is(&rules::list::GAP) {
        return renumber(finding, source);
    }
    if is(&rules::list::ORDER) {
        return sort(finding, source);
    }
    if is(&rules::list::TWICE) {
        let line = source.whole_line(finding.line);
        return Some(Fix::edits("remove the second entry", vec![edit(line, "")]));
    }
    if is(&rules::list::WRONG) || is(&rules::list::UNLISTED) {
        return add(finding, source, description);
    }
    None
}

/// Whether the file announces more objects than it describes. The file alone can't tell whether the device has these
/// objects.
fn announces_more(finding: &Finding, source: &Source<'_>) -> bool {
    let announced = source.field_in(finding.line).and_then(|field| number::value_of(field.value()));
    announced > described(finding).map(i128::from)
}

/// The number of described items that the finding counts.
fn described(finding: &Finding) -> Option<u32> {
    finding.problem.found.split(' ').next()?.parse().ok()
}

/// Corrects a count. The finding gives the right number and the counted unit.
fn count(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let number = described(finding)?;
    if let Some(field) = source.field_in(finding.line) {
        return Some(Fix::replace(field.value_span().range(), number.to_string()));
    }
    let text = format!("{}={number}", finding.problem.field);
    let insertion = insert_after(finding.line, &text, source);
    source.section_in(finding.line).map(|_| Fix::edits(format!("write {text}"), vec![insertion]))
}

/// The numbered entries of a section, in the order of the file.
fn entries(section: Section<'_>) -> Vec<(u32, Field<'_>)> {
    section.all_fields().filter_map(|field| Some((field.name().parse().ok()?, field))).collect()
}

/// The entries of the list in which the finding lies.
fn entries_around<'s>(finding: &Finding, source: &'s Source<'_>) -> Option<Vec<(u32, Field<'s>)>> {
    source.section_at(finding.span.start).map(entries)
}

/// Renumbers the entries; they keep their order.
fn renumber(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let mut entries = entries_around(finding, source)?;
    entries.sort_by_key(|(key, _)| *key);
    // Two entries with the same number have no known order.
    if entries.windows(2).any(|pair| matches!(pair, [(one, _), (other, _)] if one == other)) {
        return None;
    }
    let wrong = (1..).zip(&entries).filter(|(number, (key, _))| number != key);
    let edits = wrong.map(|(number, (_, field))| edit(field.name_span().range(), u32::to_string(&number)));
    Some(Fix::edits("number the entries from 1", edits.collect()))
}

/// Sorts the entries; the lines keep their places.
fn sort(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let entries = entries_around(finding, source)?;
    let mut sorted = entries.clone();
    sorted.sort_by_key(|(key, _)| *key);
    let moved = entries.iter().zip(sorted).filter(|((_, old), (_, new))| old.line() != new.line());
    let edits = moved.map(|((_, old), (_, new))| edit(old.whole().range(), source.get(new.whole())));
    Some(Fix::edits("sort the entries", edits.collect()))
}

/// Adds an object to its list, and removes it from wrong lists.
fn add(finding: &Finding, source: &Source<'_>, description: &DeviceDescription) -> Option<Fix> {
    let index = finding.problem.found.strip_suffix('h').and_then(|digits| u16::from_str_radix(digits, 16).ok())?;
    let list = list_of(index);
    let section = source.section(list)?;
    let entries = entries(section);
    let listed = [&description.lists.mandatory, &description.lists.optional, &description.lists.manufacturer];
    let times = listed.into_iter().flatten().filter(|(listed, _)| listed.0 == index).count();
    let mut edits = Vec::new();
    if finding.problem.rule == &rules::list::WRONG {
        edits.push(edit(source.whole_line(finding.line), ""));
    }
    // An object that is also in the right list is only removed from the wrong one.
    if times <= 1 {
        let key = entries.iter().map(|(key, _)| *key).max().unwrap_or(0).checked_add(1)?;
        let last = entries.last().map(|(_, field)| *field).or_else(|| section.all_fields().last());
        edits.push(insert_after(last.map_or(section.line(), Field::line), &format!("{key}=0x{index:04X}"), source));
    }
    Some(Fix::edits(format!("list {index:04X}h in [{list}]"), edits))
}
