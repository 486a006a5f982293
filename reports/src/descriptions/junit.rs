//! JUnit XML: each file is a suite, each rule a case, which fails where it has found something that counts.

use super::{CheckedFile, Located};
use crate::escape::printable;
use crate::junit::{Case, Outcome, Problem, Suite, write};
use canvass_analyzer::dictionary::{Rule, Severity, rules};
use std::io::{self, Write};

/// Writes the document. What is less severe than `fail_on` passes; its words stand in the output.
///
/// # Errors
/// What `out` gives.
pub fn render(files: &[CheckedFile], fail_on: Option<Severity>, out: &mut dyn Write) -> io::Result<()> {
    let suites = files.iter().map(|file| {
        let mut suite = Suite::new(&*file.name);
        suite.add_cases(rules::all().map(|rule| case(file, rule, fail_on)));
        suite
    });
    write("eds check", &suites.collect::<Vec<_>>(), out)
}

fn case(file: &CheckedFile, rule: &Rule, fail_on: Option<Severity>) -> Case {
    let own: Vec<&Located> = file.open().filter(|located| located.rule() == rule).collect();
    let (family, name) = rule.id.rsplit_once('/').unwrap_or(("", rule.id));
    let mut case = Case::passed(format!("canvass.{}", family.replace('/', ".")), name);
    let lines = || own.iter().map(|located| line(file, located));
    match own.first().filter(|_| fail_on.is_some_and(|least| rule.severity >= least)) {
        Some(first) => case.ended(Outcome::Failed(Problem {
            kind: rule.severity.name(),
            message: line(file, first),
            details: lines().chain([rule.advice()]).collect(),
        })),
        None => {
            case.remarks.extend(lines().map(|line| format!("{}: {line}", rule.id)));
            case
        }
    }
}

fn line(file: &CheckedFile, located: &Located) -> String {
    let name = printable(&file.name);
    format!("{name}:{}:{}: {}", located.finding.line, located.finding.column, located.message())
}
