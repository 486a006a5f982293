//! Fixes of lines: comments, names of sections, missing fields and sections, repeated lines.

use super::{Edit, Fix, Source};
use crate::dictionary::check::Finding;
use crate::dictionary::rules;
use crate::dictionary::source::{FieldName, standard_section_name};

pub(super) fn of(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let rule = finding.problem.rule;
    let is = |other: &rules::Rule| rule == other;
    let line = source.line(finding.line);
    let text = source.get(line);
    let line = line.range();
    if is(&rules::text::COMMENT) {
        let length = if text.starts_with("//") { 2 } else { 1 };
        return Some(Fix::edits("begin the comment with ;", vec![edit(line.start..line.start + length, ";")]));
    }
    if is(&rules::text::SECTION_LINE) && text.starts_with('[') && !text.contains(']') {
        return Some(Fix::edits("close the section's name", vec![edit(line.end..line.end, "]")]));
    }
    if is(&rules::section::SPELLING) {
        let name = standard_section_name(&finding.problem.section)?;
        return Some(Fix::replace(line, format!("[{name}]")));
    }
    if is(&rules::file::COMMISSIONING) {
        return Some(Fix::replace(line, "[DeviceComissioning]"));
    }
    if is(&rules::field::REPEATED) {
        return Some(Fix::edits("remove the line", vec![edit(source.whole_line(finding.line), "")]));
    }
    if is(&rules::field::OBJECT_TYPE_MISSING) {
        return object_type(finding, source);
    }
    if is(&rules::section::MISSING) {
        return section(&finding.problem.section, source);
    }
    if is(&rules::text::LINE_ENDS) {
        return Some(line_ends(source));
    }
    None
}

pub(super) fn edit(range: std::ops::Range<usize>, text: impl Into<String>) -> Edit {
    Edit { range, text: text.into() }
}

/// Inserts a new line after `line`.
pub(super) fn insert_after(line: u32, text: &str, source: &Source<'_>) -> Edit {
    let at = source.whole_line(line);
    let end = source.line_end();
    let is_ended = source.text.get(at.clone()).is_some_and(|line| line.ends_with(['\n', '\r']));
    let text = if is_ended { format!("{text}{end}") } else { format!("{end}{text}") };
    edit(at.end..at.end, text)
}

/// Inserts a missing object code: an object that has a data type and no sub-indexes is a VAR.
fn object_type(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let section = source.section_in(finding.line)?;
    let has = |name| section.field(name).is_some();
    let whole = !has(FieldName::SubNumber) && !has(FieldName::CompactSubObj) && has(FieldName::DataType);
    let title = "write ObjectType=0x7";
    whole.then(|| Fix::edits(title, vec![insert_after(finding.line, "ObjectType=0x7", source)]))
}

/// The data types from BOOLEAN to UNSIGNED32, none of which is allowed in mappings by default.
const DUMMIES: [&str; 7] =
    ["Dummy0001=0", "Dummy0002=0", "Dummy0003=0", "Dummy0004=0", "Dummy0005=0", "Dummy0006=0", "Dummy0007=0"];

/// An empty section at the end of the file.
fn section(name: &str, source: &Source<'_>) -> Option<Fix> {
    let fields = match name {
        "Comments" => &["Lines=0"][..],
        "OptionalObjects" | "ManufacturerObjects" => &["SupportedObjects=0"],
        // Some readers fail if one of these fields is missing.
        "DummyUsage" => &DUMMIES,
        _ => return None,
    };
    let end = source.line_end();
    let fields = fields.join(end);
    let before = match &*source.text {
        "" => "",
        text if text.ends_with(['\n', '\r']) => end,
        _ => "\n\n",
    };
    let at = source.text.len();
    let text = format!("{before}[{name}]{end}{fields}{end}");
    Some(Fix::edits(format!("add an empty section [{name}]"), vec![edit(at..at, text)]))
}

/// All lines get the most frequent line end that is not CR alone; if there is none, CR LF, as on the systems that
/// read EDS files.
fn line_ends(source: &Source<'_>) -> Fix {
    let both = source.text.matches("\r\n").count();
    let feeds = source.text.matches('\n').count() - both;
    let wanted = if feeds > both { "\n" } else { "\r\n" };
    let mut edits = Vec::new();
    for line in 1..=source.lines() {
        let range = source.whole_line(line);
        let text = source.text.get(range.clone()).unwrap_or_default();
        let end = ["\r\n", "\n", "\r"].into_iter().find(|end| text.ends_with(end));
        if let Some(end) = end.filter(|&end| end != wanted) {
            edits.push(edit(range.end - end.len()..range.end, wanted));
        }
    }
    Fix::edits("end all lines in the same way", edits)
}
