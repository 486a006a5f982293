//! JUnit XML: each file is a suite, each rule a case, which fails where it has found something that counts.

use super::{CheckedFile, Located};
use crate::escape::{Visible, printable};
use canvass_analyzer::dictionary::{Rule, Severity, rules};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::io::{self, Write};

/// Writes the document. What is less severe than `fail_on` passes; its words stand in the output.
///
/// # Errors
/// What `out` gives.
pub fn render(files: &[CheckedFile], fail_on: Option<Severity>, out: &mut dyn Write) -> io::Result<()> {
    let mut report = Report::new("canvass eds check");
    for file in files {
        let mut suite = TestSuite::new(printable(&file.name).into_owned());
        suite.add_test_cases(rules::all().map(|rule| test_case(file, rule, fail_on)));
        report.add_test_suite(suite);
    }
    let text = report.to_string().map_err(io::Error::other)?;
    Visible::new(out, false).write_all(text.as_bytes())
}

fn test_case(file: &CheckedFile, rule: &Rule, fail_on: Option<Severity>) -> TestCase {
    let own: Vec<&Located> = file.open().filter(|located| located.rule() == rule).collect();
    let status = match own.first().filter(|_| fail_on.is_some_and(|least| rule.severity >= least)) {
        None => TestCaseStatus::success(),
        Some(first) => {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_type(rule.severity.name());
            status.set_message(line(file, first));
            status
        }
    };
    let (family, name) = rule.id.rsplit_once('/').unwrap_or(("", rule.id));
    let mut case = TestCase::new(name, status);
    case.set_classname(format!("canvass.{}", family.replace('/', ".")));
    if !own.is_empty() {
        let mut lines: Vec<String> = own.iter().map(|located| line(file, located)).collect();
        lines.push(rule.advice());
        case.set_system_out(lines.join("\n"));
    }
    case
}

fn line(file: &CheckedFile, located: &Located) -> String {
    let name = printable(&file.name);
    format!("{name}:{}:{}: {}", located.finding.line, located.finding.column, located.message())
}
