//! Lists and counts.

use super::lines::{edit, insert_after};
use super::{Edit, Fix, Source};
use crate::dictionary::check::Finding;
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::eds::{list_of, number};
use crate::dictionary::rules;

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

/// Whether there may be more than the file describes, which nobody knows who only sees the file.
fn announces_more(finding: &Finding, source: &Source<'_>) -> bool {
    let announced = source.field(finding.line).map(|field| source.get(&field.value).to_owned());
    announced.and_then(|text| number::value_of(&text)) > described(finding).map(i128::from)
}

/// How many there are of what the finding counts.
fn described(finding: &Finding) -> Option<u32> {
    finding.problem.found.split(' ').next()?.parse().ok()
}

/// What was found is the number, with what it counts.
fn count(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let number = described(finding)?;
    if let Some(field) = source.field(finding.line) {
        return Some(Fix::replace(field.value, number.to_string()));
    }
    let text = format!("{}={number}", finding.problem.field);
    let insertion = insert_after(finding.line, &text, source);
    source.is_section(finding.line).then(|| Fix::edits(format!("write {text}"), vec![insertion]))
}

/// An entry of a list: its number and its line.
struct Entry {
    key: u32,
    line: u32,
}

/// The numbered entries of the section in which that line is, in the order of the file.
fn entries(line: u32, source: &Source<'_>) -> Option<(u32, Vec<Entry>)> {
    let header = source.header_of(line)?;
    let entry = |line| Some(Entry { key: source.get(&source.field(line)?.name).parse().ok()?, line });
    Some((header, source.section_lines(header).filter_map(entry).collect()))
}

/// The entries keep their order, by their numbers.
fn renumber(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let (_, mut entries) = entries(finding.line, source)?;
    entries.sort_by_key(|entry| entry.key);
    // Which of two entries with the same number is meant is not known.
    if entries.windows(2).any(|pair| matches!(pair, [one, other] if one.key == other.key)) {
        return None;
    }
    let wrong = (1..).zip(&entries).filter(|(number, entry)| *number != entry.key);
    let edits: Vec<Edit> = wrong
        .filter_map(|(number, entry)| Some(edit(source.field(entry.line)?.name, u32::to_string(&number))))
        .collect();
    Some(Fix::edits("number the entries from 1", edits))
}

/// The lines stay where they are, with the entries in order.
fn sort(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let (_, entries) = entries(finding.line, source)?;
    let mut sorted: Vec<&Entry> = entries.iter().collect();
    sorted.sort_by_key(|entry| entry.key);
    let moved = entries.iter().zip(sorted).filter(|(place, entry)| place.line != entry.line);
    let edits = moved.map(|(place, entry)| edit(source.line(place.line), source.get(&source.line(entry.line))));
    Some(Fix::edits("sort the entries", edits.collect()))
}

/// Adds an object to its list, and removes it where it does not belong.
fn add(finding: &Finding, source: &Source<'_>, description: &DeviceDescription) -> Option<Fix> {
    let index = finding.problem.found.strip_suffix('h').and_then(|digits| u16::from_str_radix(digits, 16).ok())?;
    let list = list_of(index);
    let header = source.section(list)?;
    let (_, entries) = entries(header, source)?;
    let listed = [&description.lists.mandatory, &description.lists.optional, &description.lists.manufacturer];
    let times = listed.into_iter().flatten().filter(|(listed, _)| listed.0 == index).count();
    let mut edits = Vec::new();
    if finding.problem.rule == &rules::list::WRONG {
        edits.push(edit(source.whole_line(finding.line), ""));
    }
    // An object that the right list has, too, is only removed from the wrong one.
    if times <= 1 {
        let key = entries.iter().map(|entry| entry.key).max().unwrap_or(0).checked_add(1)?;
        let last = entries.iter().map(|entry| entry.line).max();
        let last = last.or_else(|| source.section_lines(header).rfind(|line| source.field(*line).is_some()));
        edits.push(insert_after(last.unwrap_or(header), &format!("{key}=0x{index:04X}"), source));
    }
    Some(Fix::edits(format!("list {index:04X}h in [{list}]"), edits))
}
