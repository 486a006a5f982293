//! The history as JSON: [`HistoryResult`].

use super::{History, ReleaseRow};
use crate::provenance;
use crate::results::history::Case;
use crate::results::{self, Contract, HistoryResult};
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// The errors of `out`.
pub fn render(history: &History, out: &mut dyn Write) -> io::Result<()> {
    let result = HistoryResult {
        cases: history.cases.iter().map(|row| case(history, row)).collect(),
        provenance: provenance::json(&history.provenance),
        releases: history.releases.clone(),
        schema: HistoryResult::SCHEMA.into(),
    };
    results::write(&result, out)
}

fn case(history: &History, row: &ReleaseRow) -> Case {
    let course = row.course();
    let name = |at: usize| history.name(at).to_owned();
    let names = |releases: &[usize]| releases.iter().map(|at| name(*at)).collect();
    Case {
        became_bad: names(&course.became_bad),
        became_good: names(&course.became_good),
        first_bad: course.first_bad.map(name),
        flaky: row.is_flaky(),
        gone_in: course.gone_in.map(name),
        id: row.id.clone(),
        new_in: course.new_in.map(name),
        releases: row.cells.clone(),
        returned: names(&course.returned),
    }
}
