//! The differences as JUnit XML: what got worse fails. The names are those of the cases, so that a server shows since when.

use super::{Change, Comparison, Direction};
use crate::escape::{Visible, printable};
use crate::provenance;
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let mut suite = TestSuite::new("compare");
    for (name, value) in provenance::junit_properties(&comparison.provenance) {
        suite.add_property((name.as_str(), value.as_str()));
    }
    suite.add_test_cases(comparison.changes.iter().map(case));
    if comparison.changes.is_empty() {
        let mut case = TestCase::new("no difference", TestCaseStatus::success());
        case.set_classname("compare");
        suite.add_test_case(case);
    }
    let mut report = Report::new("canvass compare");
    report.add_test_suite(suite);
    // What can't be written keeps its cause: nobody reading any more is none.
    let text = report.to_string().map_err(io::Error::other)?;
    Visible::new(out, false).write_all(text.as_bytes())
}

fn case(change: &Change) -> TestCase {
    let (old, new) = change.values();
    let told = printable(&format!("{old} -> {new}")).into_owned();
    let status = match change.direction {
        Direction::Worse => {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_type(if change.returned.is_some() { "returned" } else { "worse" });
            status.set_message(told.clone());
            status.set_description(printable(&change.why().unwrap_or_default()));
            status
        }
        Direction::Better | Direction::Other => TestCaseStatus::success(),
    };
    let mut case = TestCase::new(printable(&change.subject), status);
    case.set_classname(format!("compare.{}", change.kind));
    case.set_system_out(told);
    case
}
