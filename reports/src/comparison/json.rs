//! The differences as JSON: [`CompareResult`].

use super::{Comparison, Direction};
use crate::provenance;
use crate::results::compare::Summary;
use crate::results::{self, CompareResult, Contract};
use std::io::{self, Write};

/// Writes the JSON document.
///
/// # Errors
/// The errors of `out`.
pub fn render(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let count = |direction| comparison.of(direction).count();
    let (better, other, worse) = (count(Direction::Better), count(Direction::Other), count(Direction::Worse));
    let result = CompareResult {
        changes: comparison.changes.clone(),
        provenance: provenance::json(&comparison.provenance),
        schema: CompareResult::SCHEMA.into(),
        summary: Summary { better, other, worse },
    };
    results::write(&result, out)
}
