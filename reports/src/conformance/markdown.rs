//! The result as Markdown: for a merge request or a wiki.

use super::dictionary::{REPAIR, left, rows, sentence};
use super::skipped::Skipped;
use super::told::Told;
use super::{Run, cct_forecast, decisive, hex, milliseconds_since, outcome, quarantined, repetitions, symbol, uses};
use crate::escape::{Visible, markdown, printable};
use crate::provenance;
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;
use std::io::{self, Write};

/// At most so many frames of a case are printed, the last ones.
const FRAMES: usize = 20;

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let out: &mut dyn Write = &mut Visible::new(out, false);
    let [name, _, software] = run.info.device.names.each_ref().map(|name| name.as_deref().unwrap_or("unknown"));
    writeln!(out, "# Conformance of node {}\n", run.info.node)?;
    writeln!(out, "Device: {}, software {}. Bus: {}.\n", markdown(name), markdown(software), markdown(&run.info.bus))?;
    writeln!(out, "{}.\n", outcome(&run.summary))?;
    if let Some(host) = &run.summary.host {
        writeln!(out, "{}\n", super::host::sentence(host))?;
    }
    for notice in &run.notices {
        writeln!(out, "- {}", markdown(notice))?;
    }
    if !run.notices.is_empty() {
        writeln!(out)?;
    }
    writeln!(out, "| verdict | cases |\n|---|---:|")?;
    for kind in Kind::ALL {
        writeln!(out, "| {} {kind} | {} |", symbol(kind), run.summary.count(kind))?;
    }
    let told =
        |report: &&CaseReport| report.is_flaky() || !matches!(report.verdict.kind(), Kind::Pass | Kind::NotApplicable);
    compared(run, out)?;
    for report in run.cases.iter().filter(told) {
        section(report, out)?;
    }
    let skipped = Skipped::of(run);
    if !skipped.is_empty() {
        writeln!(out, "\n## What other cases would need\n")?;
    }
    for (reason, cases) in skipped.groups() {
        writeln!(out, "- {}: {}", markdown(&reason), cases.join(", "))?;
    }
    writeln!(out, "\n## All cases\n\n| | case | clause | verdict |\n|---|---|---|---|")?;
    for report in &run.cases {
        let kind = report.verdict.kind();
        writeln!(out, "| {} | {} | {} | {kind} |", symbol(kind), report.case.id, report.case.clause)?;
    }
    provenance::markdown(&run.provenance, out)
}

fn compared(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let Some(comparison) = &run.comparison else { return Ok(()) };
    writeln!(out, "\n## Object dictionary before and after\n\n{}", markdown(&sentence(comparison)))?;
    let Some(comparison) = left(run) else { return Ok(()) };
    writeln!(out, "\n| object | name | before | after |\n|---|---|---|---|")?;
    for row in rows(comparison) {
        let [object, name, before, after] = row.map(|cell| markdown(&cell));
        writeln!(out, "| {object} | {name} | {before} | {after} |")?;
    }
    if !comparison.commands.is_empty() {
        writeln!(out, "\n{REPAIR}\n")?;
    }
    // Indented: a code block that nothing in it can end.
    comparison.commands.iter().try_for_each(|command| writeln!(out, "    {}", printable(command)))
}

fn section(report: &CaseReport, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "\n## {}: {}\n", report.verdict.kind(), report.case.id)?;
    writeln!(out, "{} ({})\n", markdown(report.case.requirement), report.case.clause)?;
    for told in Told::all(report) {
        writeln!(out, "- Duty: {}", markdown(&told.duty))?;
        writeln!(out, "  - Expected: {}", markdown(&told.expected))?;
        writeln!(out, "  - Found: {}", markdown(&told.found))?;
        if let Some(excuse) = &told.excuse {
            writeln!(out, "  - {}: {}", told.authority(), markdown(&excuse.documented))?;
        }
    }
    if let (Some(forecast), Some(number)) = (cct_forecast(report), report.case.cct) {
        writeln!(out, "- Forecast of case {number} of CiA's test tool: {forecast}")?;
    }
    if let Some(quarantined) = quarantined(report) {
        writeln!(out, "- Does not count: {}", markdown(&quarantined))?;
    }
    if let Some(repetitions) = repetitions(report) {
        writeln!(out, "- Repetitions: {repetitions}")?;
    }
    if let Some(uses) = uses(report) {
        writeln!(out, "- Used: {}", markdown(&uses))?;
    }
    for measurement in &report.measurements {
        writeln!(out, "- Measured: {}", markdown(&measurement.to_string()))?;
    }
    for note in &report.notes {
        writeln!(out, "- Note: {}", markdown(note))?;
    }
    let Some(start) = report.evidence.frames().next().map(|first| first.record.timestamp) else { return Ok(()) };
    writeln!(out, "\n| ms | id | data | meaning |\n|---:|---|---|---|")?;
    for exhibit in decisive(report, FRAMES).0 {
        let record = &exhibit.record;
        let time = milliseconds_since(start, record);
        writeln!(out, "| {time} | {} | {} | {} |", record.frame.id(), hex(record), markdown(&exhibit.text))?;
    }
    Ok(())
}
