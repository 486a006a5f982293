//! The result as JUnit XML: each property is a case, or, where it is violated, each of its rules that is.

use super::{Run, annotated, outcome, reliability};
use crate::escape::{Visible, printable};
use crate::provenance;
use canvass_fuzzer::{Property, reproducer};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let mut suite = TestSuite::new(format!("fuzz/{}", run.targets));
    suite.add_property(("node", run.node.to_string().as_str()));
    suite.add_property(("bus", printable(&run.bus).as_ref()));
    suite.add_property(("model", printable(&run.model).as_ref()));
    suite.add_property(("seed", run.seed.to_string().as_str()));
    suite.add_property(("repeat", printable(&run.repeat).as_ref()));
    suite.add_property(("outcome", outcome(run).as_str()));
    suite.add_property(("executions", run.outcome.executions.to_string().as_str()));
    suite.add_property(("frames", run.outcome.frames.to_string().as_str()));
    suite.add_property(("coverage_sdo", run.sdo_share().to_string().as_str()));
    suite.add_property(("coverage_lss", run.lss_share().to_string().as_str()));
    for (name, value) in provenance::junit_properties(&run.provenance) {
        suite.add_property((name.as_str(), value.as_str()));
    }
    for &property in Property::ALL {
        suite.add_test_cases(cases(run, property));
    }
    let mut report = Report::new("canvass fuzz");
    report.add_test_suite(suite);
    // What can't be written keeps its cause: nobody reading any more is none.
    let text = report.to_string().map_err(io::Error::other)?;
    Visible::new(out, false).write_all(text.as_bytes())
}

fn cases(run: &Run, property: Property) -> Vec<TestCase> {
    let mut cases: Vec<TestCase> = Vec::new();
    for (found, words) in run.violations().filter(|(found, _)| found.violation.property == property) {
        let violation = &found.violation;
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
        status.set_type(if found.confirmed { "violation" } else { "violation seen once" });
        status.set_message(
            printable(&format!("expected {}, found {}", violation.expected, violation.actual)).into_owned(),
        );
        let mut case = TestCase::new(format!("{property} {}", violation.rule), status);
        case.set_classname(format!("fuzz.{}", run.targets));
        let text = format!(
            "{}\n{}\n{}\n",
            reliability(found, run.outcome.dead),
            annotated(found, words),
            reproducer::candump(&found.sequence)
        );
        let text: Vec<_> = text.lines().map(printable).collect();
        case.set_system_out(text.join("\n"));
        cases.push(case);
    }
    if cases.is_empty() {
        let mut case = TestCase::new(format!("{property} {}", property.title()), TestCaseStatus::success());
        case.set_classname(format!("fuzz.{}", run.targets));
        cases.push(case);
    }
    cases
}
