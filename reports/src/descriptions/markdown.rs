//! For tickets and wikis.

use super::{CheckedFile, Counts};
use crate::escape::markdown;
use std::fmt::Write;

/// What was found in all files, and not waived.
pub fn document(files: &[CheckedFile]) -> String {
    let counts = Counts::of(files);
    let mut text = format!("# Device descriptions\n\n{counts}.\n");
    for file in files {
        // Writing to a string can't fail.
        let _ = write!(text, "\n## {}\n\n", markdown(&file.name));
        if file.open().next().is_none() {
            text.push_str("Nothing found.\n");
            continue;
        }
        text.push_str("| line | severity | rule | finding |\n|---|---|---|---|\n");
        for located in file.open() {
            let finding = &located.finding;
            let line = if finding.line == 0 { String::new() } else { finding.line.to_string() };
            let rule = finding.problem.rule;
            let _ = writeln!(text, "| {line} | {} | {} | {} |", rule.severity, rule.id, markdown(&located.message()));
        }
    }
    text
}
