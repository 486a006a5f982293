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
    let [worse, waived, better, other] = Direction::ALL.map(count);
    let result = CompareResult {
        changes: comparison.changes.clone(),
        provenance: provenance::json(&comparison.provenance),
        schema: CompareResult::SCHEMA.into(),
        summary: Summary { better, other, waived, worse },
    };
    results::write(&result, out)
}
