//! The wire matrix: the results of the cases for each wrong field.

use super::line;
use crate::results::selftest::{WireCounts, WirePrimitive, WireSelftestResult, WireSurvivor};
use crate::results::{self, Contract};
use canvass_suite::selftest::wire::{Counts, Outcome, Primitive, WireMatrix, WireRow};
use std::io::{self, Write};

/// Writes the document, indented, with a line end.
///
/// # Errors
/// The errors of `out`.
pub fn json(matrix: &WireMatrix, out: &mut dyn Write) -> io::Result<()> {
    let primitive =
        |(primitive, counts): (Primitive, Counts)| WirePrimitive { counts: counted(counts), primitive: primitive.id() };
    let result = WireSelftestResult {
        misnamed: misnamed(matrix).map(|(row, case, breach)| survivor(row, Some(case), Some(breach))).collect(),
        primitives: primitives(matrix).into_iter().map(primitive).collect(),
        schema: WireSelftestResult::SCHEMA.into(),
        summary: counted(matrix.counts(|_| true)),
        survivors: matrix.survivors().map(|row| survivor(row, undecided(row), None)).collect(),
        unsent: matrix.unsent.iter().map(Primitive::id).collect(),
    };
    results::write(&result, out)
}

fn counted(counts: Counts) -> WireCounts {
    let Counts { made, changed, open, found, named, inconclusive } = counts;
    WireCounts { changed, found, inconclusive, made, named, open }
}

fn survivor(row: &WireRow, case: Option<&str>, breach: Option<&str>) -> WireSurvivor {
    WireSurvivor {
        breach: breach.map(str::to_owned),
        case: case.map(|case| case.to_owned().into()),
        model: row.model.into(),
        mutant: row.mutant.to_string(),
    }
}

/// The first case that could not be judged.
fn undecided(row: &WireRow) -> Option<&'static str> {
    match row.outcome {
        Outcome::Inconclusive(case, _) => Some(case.id),
        _ => None,
    }
}

/// The mutants whose first failed case belongs to another service.
fn misnamed(matrix: &WireMatrix) -> impl Iterator<Item = (&WireRow, &'static str, &str)> {
    matrix.rows.iter().filter_map(|row| match &row.outcome {
        Outcome::Found { case, is_named: false, breach } => Some((row, case.id, breach.as_str())),
        _ => None,
    })
}

fn primitives(matrix: &WireMatrix) -> Vec<(Primitive, Counts)> {
    let of = |primitive: Primitive| {
        matrix.counts(|row| primitive.is(row.mutant.primitive.service, row.mutant.primitive.layout))
    };
    Primitive::all().into_iter().map(|primitive| (primitive, of(primitive))).collect()
}

/// The survivors, the mutants found by a case of another service, the messages that no model sends, and a table by
/// primitive.
pub fn text(matrix: &WireMatrix) -> String {
    let mut text = String::new();
    for row in matrix.survivors() {
        let what = match row.outcome {
            Outcome::Inconclusive(case, count) => format!("inconclusive in {count} cases, first {}", case.id),
            _ => "passed".to_owned(),
        };
        line(&mut text, &format!("survived: {} on {}: {what}", row.mutant, row.model));
    }
    for (row, case, breach) in misnamed(matrix) {
        line(&mut text, &format!("named otherwise: {} on {}: {case}: {breach}", row.mutant, row.model));
    }
    for primitive in &matrix.unsent {
        line(&mut text, &format!("never sent: {}", primitive.id()));
    }
    line(&mut text, "");
    line(
        &mut text,
        "| message | mutants | changed the traffic | left open | found of the others | rightly named | inconclusive only |",
    );
    line(&mut text, "|---|---|---|---|---|---|---|");
    for (primitive, counts) in primitives(matrix).into_iter().filter(|(_, counts)| counts.made > 0) {
        counts_line(&mut text, &primitive.id(), counts);
    }
    counts_line(&mut text, "all", matrix.counts(|_| true));
    text
}

fn counts_line(text: &mut String, name: &str, counts: Counts) {
    let share = |part: usize, of: usize| match (part * 1000).checked_div(of) {
        Some(share) => format!("{part} ({}.{} %)", share / 10, share % 10),
        None => part.to_string(),
    };
    let Counts { made, changed, open, found, named, inconclusive } = counts;
    let (share_found, share_named) = (share(found, changed - open), share(named, found));
    line(text, &format!("| {name} | {made} | {changed} | {open} | {share_found} | {share_named} | {inconclusive} |"));
}
