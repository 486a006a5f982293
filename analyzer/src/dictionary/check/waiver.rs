//! What a file itself says to leave as it is: a comment `; canvass: allow RULE[, RULE...] reason`.
//!
//! Before the first section it holds for the whole file, in a section for that section only. In XML it is a comment of a
//! line and holds for the whole file.

use super::Finding;
use super::source::Source;
use std::ops::RangeInclusive;

/// One such comment.
pub(super) struct Waiver<'a> {
    rules: Vec<&'a str>,
    lines: RangeInclusive<u32>,
    pub reason: String,
}

impl Waiver<'_> {
    /// Whether it is about that finding.
    pub fn covers(&self, finding: &Finding) -> bool {
        self.lines.contains(&finding.line) && self.rules.iter().any(|prefix| finding.problem.rule.is_in(prefix))
    }
}

/// All such comments of a file.
pub(super) fn read<'a>(source: &Source<'a>) -> Vec<Waiver<'a>> {
    const MARK: &str = "canvass: allow ";
    if !source.text.contains(MARK) {
        return Vec::new();
    }
    let mut waivers = Vec::new();
    let mut header = 0;
    for line in 1..=source.lines() {
        let text = source.get(&source.line(line));
        if !source.is_xml() && text.starts_with('[') {
            header = line;
        }
        let comment = if source.is_xml() {
            text.strip_prefix("<!--").map(|text| text.trim_end_matches("-->"))
        } else {
            text.strip_prefix(';')
        };
        let Some(waived) = comment.and_then(|text| text.trim().strip_prefix(MARK)) else { continue };
        let lines = match header {
            0 => 0..=u32::MAX,
            _ => header..=source.section_lines(header).last().unwrap_or(header),
        };
        let (rules, reason) = split(waived.trim());
        waivers.push(Waiver { rules, lines, reason: reason.to_owned() });
    }
    waivers
}

/// The ids, with commas between them, and what follows.
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
