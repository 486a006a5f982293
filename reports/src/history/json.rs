//! The history as JSON: `"schema": "canvass/history/1"`.

use super::{Cell, Column, History, ReleaseRow};
use crate::{escape, provenance};
use canvass_suite::verdict::Kind;
use serde_json::{Value, json};
use std::io::{self, Write};

/// The name and version of the contract.
pub const SCHEMA: &str = "canvass/history/1";

/// Writes the document, indented, with a line end.
///
/// # Errors
/// What `out` gives.
pub fn render(history: &History, out: &mut dyn Write) -> io::Result<()> {
    let document = json!({
        "schema": SCHEMA,
        "provenance": provenance::json(&history.provenance),
        "releases": history.releases.iter().map(release).collect::<Vec<_>>(),
        "cases": history.cases.iter().map(|row| case(history, row)).collect::<Vec<_>>(),
    });
    writeln!(out, "{}", escape::json(&format!("{document:#}")))
}

fn release(column: &Column) -> Value {
    json!({
        "name": column.name,
        "software": column.software,
        "samples": column.samples,
        "cancelled": column.is_cancelled,
    })
}

fn case(history: &History, row: &ReleaseRow) -> Value {
    let course = row.course();
    let name = |at: usize| history.name(at);
    json!({
        "id": row.id,
        "first_bad": course.first_bad.map(name),
        "became_bad": course.became_bad.iter().map(|at| name(*at)).collect::<Vec<_>>(),
        "returned": course.returned.iter().map(|at| name(*at)).collect::<Vec<_>>(),
        "became_good": course.became_good.iter().map(|at| name(*at)).collect::<Vec<_>>(),
        "new_in": course.new_in.map(name),
        "gone_in": course.gone_in.map(name),
        "flaky": row.is_flaky(),
        "releases": row.cells.iter().map(cell).collect::<Vec<_>>(),
    })
}

fn cell(cell: &Cell) -> Value {
    json!({
        "verdict": cell.verdict.map(Kind::name),
        "flaky": cell.is_flaky,
        "duration_ns": cell.duration,
        "times_ns": cell.times,
    })
}
