//! The result as Markdown: for a merge request or a wiki.

use super::{Run, annotated, left, outcome, reliability, rust_test, trouble};
use crate::escape::{Visible, markdown, printable};
use crate::provenance;
use canvass_fuzzer::reproducer;
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let out: &mut dyn Write = &mut Visible::new(out, false);
    writeln!(out, "# Fuzzing of node {}\n", run.node)?;
    writeln!(out, "Bus: {}. Target: {}. Seed: {}.\n", markdown(&run.bus), run.targets, run.seed)?;
    writeln!(out, "{}.\n", sentence(&outcome(run)))?;
    writeln!(out, "| | |\n|---|---:|")?;
    writeln!(out, "| exchanges | {} |", run.outcome.executions)?;
    writeln!(out, "| frames sent | {} |", run.outcome.frames)?;
    writeln!(out, "| sequences | {} |", run.outcome.sequences)?;
    writeln!(out, "| SDO, state × command | {} |", run.sdo_share())?;
    writeln!(out, "| LSS, state × command | {} |", run.lss_share())?;
    for line in [trouble(run), left(run)].iter().filter(|line| !line.is_empty()) {
        writeln!(out, "\n{}.", sentence(&markdown(line).to_string()))?;
    }
    writeln!(out, "\nRepeat with:")?;
    code(out, "sh", &run.repeat)?;
    for (found, words) in run.violations() {
        let violation = &found.violation;
        writeln!(out, "\n## {}: {}\n", violation.property, markdown(violation.rule))?;
        writeln!(out, "{}.\n", sentence(violation.property.title()))?;
        writeln!(out, "- Expected: {}", markdown(&violation.expected))?;
        writeln!(out, "- Found: {}", markdown(&violation.actual))?;
        writeln!(out, "- It {}", reliability(found, run.outcome.dead))?;
        writeln!(out, "\nThe sequence:")?;
        code(out, "text", &annotated(found, words))?;
        writeln!(out, "\nAs a log for `canplayer` and `canvass fuzz --replay`:")?;
        code(out, "text", &reproducer::candump(&found.sequence))?;
        writeln!(out, "\nAs a test:")?;
        code(out, "rust", &rust_test(run, found))?;
    }
    provenance::markdown(&run.provenance, out)
}

/// With a capital letter.
fn sentence(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

/// A block that nothing in it can end: it is indented by nothing that Markdown knows, and its fence is longer than any
/// in it.
fn code(out: &mut dyn Write, language: &str, text: &str) -> io::Result<()> {
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest.max(2) + 1);
    writeln!(out, "\n{fence}{language}")?;
    text.lines().try_for_each(|line| writeln!(out, "{}", printable(line).trim_end()))?;
    writeln!(out, "{fence}")
}
