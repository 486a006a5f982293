//! The diagnosis as JUnit XML: each rule is a case, which fails where it has found an error or a warning.

use super::{Diagnosed, frame, times};
use crate::escape::{Visible, printable};
use crate::provenance;
use canvass_analyzer::findings::{Finding, Metadata, Severity, all};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::io::{self, Write};

/// Writes the document. What is less severe than `fail_on` passes; its words stand in the output.
///
/// # Errors
/// What `out` gives.
pub fn render(diagnosed: &Diagnosed<'_>, fail_on: Option<Severity>, out: &mut dyn Write) -> io::Result<()> {
    let mut report = Report::new("canvass diagnose");
    let rules: Vec<&Metadata> = all().map(|definition| definition.metadata).collect();
    for family in rules.chunk_by(|a, b| self::family(a) == self::family(b)) {
        let mut suite = TestSuite::new(family.first().map_or("", |rule| self::family(rule)));
        for (name, value) in provenance::junit_properties(diagnosed.provenance) {
            suite.add_property((name.as_str(), value.as_str()));
        }
        suite.add_test_cases(family.iter().map(|rule| test_case(diagnosed, rule, fail_on)));
        report.add_test_suite(suite);
    }
    // What can't be written keeps its cause: nobody reading any more is none.
    let text = report.to_string().map_err(io::Error::other)?;
    Visible::new(out, false).write_all(text.as_bytes())
}

fn family(rule: &Metadata) -> &str {
    rule.id.split_once('/').map_or(rule.id, |parts| parts.0)
}

fn test_case(diagnosed: &Diagnosed<'_>, rule: &Metadata, fail_on: Option<Severity>) -> TestCase {
    let own: Vec<&Finding> = diagnosed.results.findings.iter().filter(|finding| finding.rule.id == rule.id).collect();
    let fails = |finding: &&&Finding| fail_on.is_some_and(|least| finding.severity >= least);
    let status = match own.iter().find(fails) {
        None => TestCaseStatus::success(),
        Some(worst) => {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_type(worst.severity.name());
            status.set_message(printable(&line(diagnosed, worst)));
            status
        }
    };
    let name = rule.id.split_once('/').map_or(rule.id, |parts| parts.1);
    let mut case = TestCase::new(name, status);
    case.set_classname(format!("canvass.{}", family(rule)));
    case.add_property(("title", rule.title));
    if !own.is_empty() {
        case.set_system_out(output(diagnosed, &own));
    }
    case
}

fn line(diagnosed: &Diagnosed<'_>, finding: &Finding) -> String {
    let whom = diagnosed.whom(finding);
    let whom = if whom.is_empty() { whom } else { format!("{whom}: ") };
    let at = diagnosed.since_start(finding.first);
    format!("{at} s: {whom}{}{}", finding.message, times(diagnosed, finding))
}

fn output(diagnosed: &Diagnosed<'_>, findings: &[&Finding]) -> String {
    let mut lines = Vec::new();
    for finding in findings {
        lines.push(line(diagnosed, finding));
        for exhibit in &finding.evidence {
            lines.push(format!("  {} {} {}", diagnosed.place(exhibit), frame(exhibit), exhibit.text));
        }
    }
    lines.extend(findings.first().map(|finding| finding.rule.advice.to_owned()));
    lines.iter().map(|line| printable(line).into_owned()).collect::<Vec<_>>().join("\n")
}
