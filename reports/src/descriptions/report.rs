//! The findings in device descriptions as a report. In JUnit files each file is a suite, and each rule is a case.

use super::{CheckedFile, Counts, Located, json};
use crate::document::junit::{Case, Outcome, Problem, Suite};
use crate::document::{Block, Depth, Document, Report, Row, Section, Table};
use crate::results;
use canvass_analyzer::dictionary::{Rule, Severity, rules};
use std::io::{self, Write};

/// Files with their findings.
#[derive(Clone, Copy, Debug)]
pub struct CheckedFiles<'a> {
    pub files: &'a [CheckedFile],
    /// In JUnit files a less severe finding passes, and the output contains its text.
    pub fail_on: Option<Severity>,
}

impl Report for CheckedFiles<'_> {
    fn document(&self, _: Depth) -> Document {
        Document {
            command: "eds check",
            kind: "CANopen device descriptions",
            title: "Device descriptions".to_owned(),
            outcome: Counts::of(self.files).to_string(),
            sections: self.files.iter().map(section).collect(),
            suites: self.files.iter().map(|file| suite(file, self.fail_on)).collect(),
            ..Document::default()
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        results::write(&json::document(self.files), out)
    }
}

fn section(file: &CheckedFile) -> Section {
    let row = |located: &Located| {
        let line = if located.finding.line == 0 { String::new() } else { located.finding.line.to_string() };
        let rule = located.rule();
        Row::of([line, rule.severity.to_string(), rule.id.to_owned(), located.message()])
    };
    let table = Table::of(["line", "severity", "rule", "finding"], file.open().map(row));
    let nothing = || Block::Text("Nothing found.".to_owned());
    let block = if table.rows.is_empty() { nothing() } else { Block::Table(table) };
    Section { id: "", title: file.name.clone(), blocks: vec![block] }
}

fn suite(file: &CheckedFile, fail_on: Option<Severity>) -> Suite {
    let mut suite = Suite::new(&*file.name);
    suite.add_cases(rules::all().map(|rule| case(file, rule, fail_on)));
    suite
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
    format!("{}:{}:{}: {}", file.name, located.finding.line, located.finding.column, located.message())
}
