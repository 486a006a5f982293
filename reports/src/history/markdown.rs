//! The history as Markdown.

use super::{History, sign};
use crate::escape::{Visible, markdown};
use crate::provenance;
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(history: &History, out: &mut dyn Write) -> io::Result<()> {
    let out: &mut dyn Write = &mut Visible::new(out, false);
    writeln!(out, "# History\n\n{}.\n", history.outcome())?;
    let names: Vec<String> = history.releases.iter().map(|release| markdown(&release.name)).collect();
    writeln!(out, "| case | {} | |", names.join(" | "))?;
    writeln!(out, "|---|{}---|", ":-:|".repeat(names.len()))?;
    for (row, course) in history.telling() {
        let signs: Vec<&str> = row.cells.iter().map(|cell| sign(cell.kind())).collect();
        let flaky = if row.is_flaky() { ", flaky" } else { "" };
        writeln!(
            out,
            "| {} | {} | {}{flaky} |",
            markdown(&row.id),
            signs.join(" | "),
            markdown(&course.told(history))
        )?;
    }
    provenance::markdown(&history.provenance, out)
}
