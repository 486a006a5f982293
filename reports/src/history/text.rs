//! The history on a terminal.

use super::{History, sign};
use crate::escape::{Visible, printable};
use crate::provenance;
use std::io::{self, Write};

/// Writes a line for each case that was bad, flaky, new or removed.
///
/// # Errors
/// What `out` gives.
pub fn render(history: &History, out: &mut dyn Write) -> io::Result<()> {
    let out: &mut dyn Write = &mut Visible::new(out, false);
    for (at, release) in history.releases.iter().enumerate() {
        let software: Vec<String> = release.software.iter().map(|name| printable(name).into_owned()).collect();
        let cancelled = if release.cancelled { ", a run was cancelled" } else { "" };
        let (name, software) = (printable(&release.name), software.join(", "));
        writeln!(out, "{:>3}  {name}: software {software}, {} results{cancelled}", at + 1, release.samples)?;
    }
    writeln!(out)?;
    let width = history.telling().map(|(row, _)| row.id.len()).max().unwrap_or(0);
    for (row, course) in history.telling() {
        let signs: String = row.cells.iter().map(|cell| format!("{} ", sign(cell.kind()))).collect();
        let flaky = if row.is_flaky() { "  flaky" } else { "" };
        writeln!(out, "{:width$}  {signs} {}{flaky}", printable(&row.id), printable(&course.told(history)))?;
    }
    writeln!(out, "\n{}\n", history.outcome())?;
    provenance::short_text(&history.provenance).iter().try_for_each(|line| writeln!(out, "{line}"))
}
