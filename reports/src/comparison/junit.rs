//! The differences as JUnit XML: what got worse fails. The names are those of the cases, so that a server shows since when.

use super::{Comparison, Direction};
use crate::junit::{Case, Outcome, Problem, Suite, write};
use crate::provenance;
use crate::results::compare::Change;
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let mut suite = Suite::new("compare");
    suite.add_properties(provenance::junit_properties(&comparison.provenance));
    suite.add_cases(comparison.changes.iter().map(case));
    if comparison.changes.is_empty() {
        suite.add_cases([Case::passed("compare", "no difference")]);
    }
    write("compare", &[suite], out)
}

fn case(change: &Change) -> Case {
    let (old, new) = change.values();
    let told = format!("{old} -> {new}");
    let case = Case::passed(format!("compare.{}", change.kind), &*change.subject);
    match change.direction {
        Direction::Worse => case.ended(Outcome::Failed(Problem {
            kind: if change.returned.is_some() { "returned" } else { "worse" },
            message: told,
            details: change.why().into_iter().collect(),
        })),
        Direction::Better | Direction::Other => case.remarked(format!("{}: {told}", change.subject)),
    }
}
