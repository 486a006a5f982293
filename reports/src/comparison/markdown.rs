//! The differences as Markdown: for a merge request.

use super::{Comparison, Direction};
use crate::escape::{Visible, markdown};
use crate::provenance;
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let out: &mut dyn Write = &mut Visible::new(out, false);
    writeln!(out, "# What the release changed\n\n{}.", comparison.outcome())?;
    for direction in Direction::ALL {
        let mut changes = comparison.of(direction).peekable();
        if changes.peek().is_none() {
            continue;
        }
        writeln!(out, "\n## {}\n\n| | subject | before | now | why |\n|---|---|---|---|---|", direction.title())?;
        for change in changes {
            let (old, new) = change.values();
            let why = change.why().unwrap_or_default();
            let cells = [&*change.kind, &change.subject, old, new, &why];
            writeln!(out, "| {} |", cells.map(markdown).join(" | "))?;
        }
    }
    provenance::markdown(&comparison.provenance, out)
}
