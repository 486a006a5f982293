//! The diagnosis as Markdown: for a ticket or a wiki.

use super::{Diagnosed, frame, node_table, story, terminal, times};
use crate::escape::{Visible, markdown};
use crate::provenance;
use canvass_analyzer::findings::Finding;
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(diagnosed: &Diagnosed<'_>, out: &mut dyn Write) -> io::Result<()> {
    let out: &mut dyn Write = &mut Visible::new(out, false);
    writeln!(out, "# Diagnosis\n")?;
    for capture in diagnosed.captures {
        writeln!(out, "- {} ({})", markdown(capture.name), capture.format)?;
    }
    writeln!(out)?;
    for line in terminal::summary(diagnosed, terminal::Advice::default()) {
        writeln!(out, "- {}", markdown(&line))?;
    }
    if diagnosed.results.findings.is_empty() {
        writeln!(out, "\nNothing was found.")?;
    }
    for told in story::all(diagnosed) {
        for finding in told.head() {
            section(diagnosed, finding, None, out)?;
        }
        for (consequence, findings) in told.consequences() {
            let cause = diagnosed.results.findings.get(consequence.of);
            for finding in findings {
                section(diagnosed, finding, cause, out)?;
            }
        }
    }
    nodes(diagnosed, out)?;
    cases(diagnosed, out)?;
    provenance::markdown(diagnosed.provenance, out)
}

/// The cases of a certification run.
fn cases(diagnosed: &Diagnosed<'_>, out: &mut dyn Write) -> io::Result<()> {
    let runs = diagnosed.results.buses.iter().map(|(_, bus)| &bus.test_run);
    for run in runs.filter(|run| !run.cases.is_empty()) {
        writeln!(out, "\n## Test run\n\n| case | verdict | frames | s | where |\n|---|---|---:|---:|---|")?;
        for case in &run.cases {
            writeln!(out, "| {} |", terminal::of_case(diagnosed, case).map(|cell| markdown(&cell)).join(" | "))?;
        }
    }
    Ok(())
}

fn section(
    diagnosed: &Diagnosed<'_>,
    finding: &Finding,
    cause: Option<&Finding>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let whom = diagnosed.whom(finding);
    let whom = if whom.is_empty() { whom } else { format!(", {}", markdown(&whom)) };
    // What follows from something is below it.
    let level = if cause.is_some() { "###" } else { "##" };
    writeln!(out, "\n{level} {}: {}{whom}\n", finding.severity, finding.rule.title)?;
    if let Some(cause) = cause {
        let whom = markdown(&diagnosed.whom(cause));
        writeln!(out, "This follows from: {}{}{}.\n", whom, if whom.is_empty() { "" } else { ", " }, cause.rule.title)?;
    }
    let at = diagnosed.since_start(finding.first);
    writeln!(out, "At {at} s: {}{}\n", markdown(&finding.message), times(diagnosed, finding))?;
    if !finding.evidence.is_empty() {
        writeln!(out, "| where | s | frame | meaning |\n|---|---:|---|---|")?;
    }
    for exhibit in &finding.evidence {
        let (place, at) = (markdown(&diagnosed.place(exhibit)), diagnosed.since_start(exhibit.time));
        writeln!(out, "| {place} | {at} | {} | {} |", markdown(&frame(exhibit)), markdown(&exhibit.text))?;
    }
    writeln!(out, "\n{} (rule {})", finding.rule.advice, finding.rule.id)
}

fn nodes(diagnosed: &Diagnosed<'_>, out: &mut dyn Write) -> io::Result<()> {
    let rows = node_table::rows(diagnosed, true);
    let Some((head, rows)) = rows.split_first() else { return Ok(()) };
    writeln!(out, "\n## Nodes\n\n| {} |\n|{}", head.join(" | "), "---|".repeat(head.len()))?;
    for row in rows {
        let cells: Vec<String> = row.iter().map(|cell| markdown(cell)).collect();
        writeln!(out, "| {} |", cells.join(" | "))?;
    }
    Ok(())
}
