//! Waivers in the file itself: a comment `; canvass: allow RULE[, RULE...] reason`.
//!
//! A waiver before the first section holds for the whole file, a waiver in a section only for that section. In XML the
//! comment has a line of its own and holds for the whole file.

use super::Finding;
use crate::dictionary::place::Span;
use crate::dictionary::source::{Section, Source};
use std::ops::RangeInclusive;

/// A waiver in a comment.
pub(super) struct Waiver<'a> {
    rules: Vec<&'a str>,
    lines: RangeInclusive<u32>,
    pub reason: String,
}

impl Waiver<'_> {
    /// Whether the waiver covers the finding.
    pub fn covers(&self, finding: &Finding) -> bool {
        self.lines.contains(&finding.line) && self.rules.iter().any(|prefix| finding.problem.rule.is_in(prefix))
    }
}

/// All waivers of a file.
pub(super) fn read<'s>(source: &'s Source<'_>) -> Vec<Waiver<'s>> {
    let waiver = |comment: Span| {
        let text = source.get(comment);
        let inside = match text.strip_prefix("<!--") {
            // The comment needs a line of its own, so that readers notice it.
            Some(inside) if source.line(source.position(comment.range().start).0) == comment => {
                inside.strip_suffix("-->")
            }
            _ => text.strip_prefix(';'),
        };
        let waived = inside?.trim().strip_prefix("canvass: allow ")?;
        let (rules, reason) = split(waived.trim());
        let section = source.section_at(comment.range().start);
        Some(Waiver { rules, lines: section.map_or(0..=u32::MAX, Section::lines), reason: reason.to_owned() })
    };
    source.comments().filter_map(waiver).collect()
}

/// Splits the rule ids, separated by commas, from the reason.
fn split(text: &str) -> (Vec<&str>, &str) {
    let mut rules = Vec::new();
    let mut rest = text;
    loop {
        let (word, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        rules.extend(word.split(',').filter(|id| !id.is_empty()));
        rest = after.trim_start();
        if !word.ends_with(',') || rest.is_empty() {
            return (rules, rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::dictionary::check::check;

    fn waived(comment: &str, at: &str) -> Vec<(&'static str, String)> {
        let text = format!("{comment}\n[FileInfo]\nCreationTime=21:00\n{at}\n[Comments]\nLines=3\n");
        let checked = check(text.as_bytes(), None).unwrap();
        let reasons =
            checked.findings.iter().filter_map(|finding| Some((finding.problem.rule.id, finding.waived.clone()?)));
        reasons.filter(|(id, _)| !id.contains("missing")).collect()
    }

    #[test]
    fn a_comment_waives_for_the_file_or_its_section() {
        let (time, count) = ("eds/file/time", "eds/file/comment-count");
        let because = || "as ordered".to_owned();
        assert_eq!(waived("; canvass: allow eds/file as ordered", ""), [(time, because()), (count, because())]);
        assert_eq!(waived("", "; canvass: allow eds/file as ordered"), [(time, because())]);
        assert_eq!(waived(";canvass: allow eds/file/comment-count, eds/pdo", ""), [(count, String::new())]);
        assert_eq!(waived("; canvass: allow eds/fil", ""), []);
    }
}
