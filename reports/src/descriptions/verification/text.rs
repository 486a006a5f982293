//! For people: a table, then what each kind of difference means.

use super::{Style, Verification, remark, side, subject};
use crate::color::Color;
use crate::escape::printable;
use canvass_analyzer::dictionary::survey::compare::{Mismatch, MismatchKind};
use comfy_table::{Cell, Table};
use std::collections::BTreeSet;
use std::fmt::Write;

pub(super) fn render(verification: &Verification, style: Style) -> String {
    let mut text = String::new();
    if !verification.mismatches.is_empty() {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{}\n", table(verification, style));
        let kinds: BTreeSet<MismatchKind> = verification.mismatches.iter().map(|mismatch| mismatch.kind).collect();
        for kind in kinds {
            let _ = writeln!(text, "{}: {}", kind.id(), kind.meaning());
        }
        text.push('\n');
    }
    let incomplete = verification.incomplete();
    if !incomplete.is_empty() {
        let _ = writeln!(text, "{incomplete}");
    }
    let (file, bus) = (printable(&verification.file), printable(&verification.bus));
    let _ = writeln!(text, "{file}, node {} on {bus}: {}", verification.node, verification.summary());
    text
}

fn table(verification: &Verification, style: Style) -> Table {
    let mut table = crate::table::table(style.width, style.colors);
    table.set_header(["object", "what", "described", "found"]);
    for mismatch in verification.differences() {
        table.add_row(row(mismatch, true));
    }
    for mismatch in verification.explicable() {
        table.add_row(row(mismatch, false));
    }
    table
}

fn row(mismatch: &Mismatch, counts: bool) -> [Cell; 4] {
    let what = Cell::new(match remark(mismatch.weight) {
        "" => mismatch.kind.id().to_owned(),
        remark => format!("{} ({remark})", mismatch.kind.id()),
    });
    let what = if counts { Color::Red } else { Color::Yellow }.cell(what);
    [Cell::new(subject(mismatch)), what, Cell::new(side(&mismatch.described)), Cell::new(side(&mismatch.found))]
}
