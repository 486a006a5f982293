//! The result as JUnit XML, for continuous integration.
//!
//! A *fail* is a failure; *error* and *inconclusive* are errors, because nothing is known where something should be;
//! *not applicable* is skipped; *tolerated* and *deviation* pass, with their reason in the output.

use super::{Run, authority, cct_forecast, name_in_family, repetitions};
use crate::escape::printable;
use canvass_conformance::runner::CaseReport;
use canvass_conformance::verdict::{Kind, Reason, Verdict};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let mut report = Report::new("canvass test");
    report.set_time(run.summary.duration.into());
    for chunk in run.cases.chunk_by(|a, b| a.case.family() == b.case.family()) {
        report.add_test_suite(suite(run, chunk));
    }
    report.serialize(&mut *out).map_err(io::Error::other)
}

fn suite(run: &Run, cases: &[CaseReport]) -> TestSuite {
    let name = cases.first().map_or("", |report| report.case.family());
    let mut suite = TestSuite::new(name);
    suite.add_property(("node", run.info.node.to_string().as_str()));
    suite.add_property(("bus", printable(&run.info.bus).as_ref()));
    suite.add_property(("model", printable(&run.info.model).as_ref()));
    let [name, _, software] = &run.info.device.names;
    suite.add_property(("device", printable(name.as_deref().unwrap_or_default()).as_ref()));
    suite.add_property(("software", printable(software.as_deref().unwrap_or_default()).as_ref()));
    if let Some(host) = &run.summary.host {
        suite.add_property(("host", super::host::sentence(host).as_str()));
    }
    let nanos = cases.iter().map(|report| report.duration.nanos()).sum();
    suite.set_time(std::time::Duration::from_nanos(nanos));
    suite.add_test_cases(cases.iter().map(test_case));
    suite
}

fn test_case(report: &CaseReport) -> TestCase {
    let mut case = TestCase::new(name_in_family(report.case.id), status(&report.verdict));
    case.set_classname(report.case.family().replace('/', "."));
    case.set_time(report.duration.into());
    case.add_property(("clause", report.case.clause.to_string().as_str()));
    case.add_property(("requirement", printable(report.case.requirement).as_ref()));
    case.add_property(("verdict", report.verdict.kind().name()));
    if let Some(forecast) = cct_forecast(report) {
        case.add_property(("cct_forecast", forecast));
    }
    let output = output(report);
    if !output.is_empty() {
        case.set_system_out(output);
    }
    case
}

fn status(verdict: &Verdict) -> TestCaseStatus {
    let mut status = match verdict.kind() {
        Kind::Pass | Kind::Tolerated | Kind::Deviation => return TestCaseStatus::success(),
        Kind::Fail => TestCaseStatus::non_success(NonSuccessKind::Failure),
        Kind::Error | Kind::Inconclusive => TestCaseStatus::non_success(NonSuccessKind::Error),
        Kind::NotApplicable => TestCaseStatus::skipped(),
    };
    status.set_type(verdict.kind().name());
    if let Some(Reason { duty, expected, actual }) = verdict.reason() {
        status.set_message(printable(&format!("{duty}: expected {expected}, found {actual}")));
    }
    status
}

/// What a person looks at when a case did not simply pass.
fn output(report: &CaseReport) -> String {
    let mut lines: Vec<String> = Vec::new();
    if let Verdict::Tolerated(reason) | Verdict::Deviation { reason, .. } = &report.verdict {
        lines.push(format!("{}: {reason}", report.verdict.kind()));
    }
    lines.extend(report.verdict.documented().map(|text| format!("{}: {text}", authority(report).to_lowercase())));
    lines.extend(repetitions(report));
    lines.extend(report.notes.iter().map(|note| format!("note: {note}")));
    if matches!(report.verdict.kind(), Kind::Fail | Kind::Error | Kind::Inconclusive) {
        for exhibit in report.evidence.frames() {
            let record = &exhibit.record;
            lines.push(format!("({}) {} {}", record.timestamp, record.frame, exhibit.text));
        }
    }
    lines.iter().map(|line| printable(line).into_owned()).collect::<Vec<_>>().join("\n")
}
