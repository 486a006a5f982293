//! JUnit XML, for continuous integration: the one writer of all commands that have it.
//!
//! There are two schemas of JUnit files that tools validate against: that of Ant's JUnit task (`JUnit.xsd`) and that of
//! Jenkins (`junit-10.xsd`). A document keeps to what both allow, which `tests/peers/junit.xsd` says: suites have each
//! attribute that Ant wants, cases have no properties and no output of their own. So the details of a failure stand in its
//! text, and what is to be said of a case that passes stands in the output of its suite.

use crate::escape::{Visible, printable};
use canvass_traces::{Duration, Timestamp};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::io::{self, Write};

/// Cases that belong together, with what is to be known of the run.
#[derive(Debug)]
pub struct Suite {
    name: String,
    properties: Vec<(String, String)>,
    began: Timestamp,
    cases: Vec<Case>,
}

/// One thing that was tried.
#[derive(Debug)]
pub struct Case {
    /// What it belongs to, with dots: `canvass.nodes`.
    pub family: String,
    /// Its name in the family.
    pub name: String,
    /// How long it took.
    pub duration: Duration,
    /// How it ended.
    pub outcome: Outcome,
    /// What is to be said though it did not fail, each with what it is about; may be empty.
    pub remarks: Vec<String>,
}

/// How a case ended.
#[derive(Debug)]
pub enum Outcome {
    /// As it should.
    Passed,
    /// It was not judged.
    Skipped {
        /// Why.
        message: String,
    },
    /// What was tried is wrong.
    Failed(Problem),
    /// It could not be judged, where it should have been.
    Error(Problem),
}

/// What is to be said of a case that did not pass.
#[derive(Debug)]
pub struct Problem {
    /// Of what kind it is, in one word or two.
    pub kind: &'static str,
    /// The sentence that tells it.
    pub message: String,
    /// What a person looks at then.
    pub details: Vec<String>,
}

impl Suite {
    /// A suite without cases yet.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), properties: Vec::new(), began: Timestamp::ZERO, cases: Vec::new() }
    }

    /// What is to be known of the run.
    pub fn add_properties<K: Into<String>>(&mut self, properties: impl IntoIterator<Item = (K, String)>) {
        self.properties.extend(properties.into_iter().map(|(name, value)| (name.into(), value)));
    }

    /// When the first of its frames came: of a simulated bus since its power-on, so that the same run gives the same bytes.
    pub fn set_began(&mut self, began: Timestamp) {
        self.began = began;
    }

    /// Further cases.
    pub fn add_cases(&mut self, cases: impl IntoIterator<Item = Case>) {
        self.cases.extend(cases);
    }

    fn to_junit(&self, number: usize, command: &str) -> TestSuite {
        let mut suite = TestSuite::new(shown(&self.name));
        suite.extra.insert("package".into(), "canvass".into());
        suite.extra.insert("id".into(), number.to_string().into());
        suite.extra.insert("timestamp".into(), date_time(self.began).into());
        suite.extra.insert("hostname".into(), "localhost".into());
        suite.set_time(self.cases.iter().map(|case| std::time::Duration::from(case.duration)).sum());
        suite.add_property(("canvass.command", command));
        for (name, value) in &self.properties {
            suite.add_property((shown(name).as_str(), shown(value).as_str()));
        }
        suite.add_test_cases(self.cases.iter().map(Case::to_junit));
        let remarks = self.cases.iter().flat_map(|case| &case.remarks);
        suite.set_system_out(remarks.map(|remark| shown(remark)).collect::<Vec<_>>().join("\n"));
        suite.set_system_err("");
        suite
    }
}

impl Case {
    /// A case that passed and of which nothing is to be said.
    pub fn passed(family: impl Into<String>, name: impl Into<String>) -> Self {
        let (family, name) = (family.into(), name.into());
        Self { family, name, duration: Duration::ZERO, outcome: Outcome::Passed, remarks: Vec::new() }
    }

    /// The case with this outcome.
    #[must_use]
    pub fn ended(self, outcome: Outcome) -> Self {
        Self { outcome, ..self }
    }

    /// The case with one more remark.
    #[must_use]
    pub fn remarked(mut self, remark: String) -> Self {
        self.remarks.push(remark);
        self
    }

    fn to_junit(&self) -> TestCase {
        let status = match &self.outcome {
            Outcome::Passed => TestCaseStatus::success(),
            Outcome::Skipped { message } => {
                let mut status = TestCaseStatus::skipped();
                status.set_message(shown(message));
                status
            }
            Outcome::Failed(problem) => problem.to_junit(NonSuccessKind::Failure),
            Outcome::Error(problem) => problem.to_junit(NonSuccessKind::Error),
        };
        let mut case = TestCase::new(shown(&self.name), status);
        case.set_classname(shown(&self.family));
        case.set_time(self.duration.into());
        case
    }
}

impl Problem {
    fn to_junit(&self, kind: NonSuccessKind) -> TestCaseStatus {
        let mut status = TestCaseStatus::non_success(kind);
        status.set_type(self.kind);
        status.set_message(shown(&self.message));
        status.set_description(self.details.iter().map(|line| shown(line)).collect::<Vec<_>>().join("\n"));
        status
    }
}

/// Writes a document; `command` is what was run: `diagnose`.
///
/// # Errors
/// The errors of `out`.
pub(crate) fn write(command: &str, suites: &[Suite], out: &mut dyn Write) -> io::Result<()> {
    let mut report = Report::unnamed();
    report.add_test_suites(suites.iter().enumerate().map(|(number, suite)| suite.to_junit(number, command)));
    let text = report.to_string().map_err(io::Error::other)?;
    // What can't be written keeps its cause: nobody reading any more is none.
    Visible::new(out, false).write_all(without_totals(&text).as_bytes())
}

/// Ant's schema knows no attributes of the root. The writer escapes each `>` in attributes, so that the first one ends the tag.
fn without_totals(text: &str) -> String {
    const ROOT: &str = "<testsuites";
    let parts = text.split_once(ROOT).and_then(|(declaration, rest)| Some((declaration, rest.split_once('>')?)));
    match parts {
        Some((declaration, (totals, suites))) => {
            let end = if totals.ends_with('/') { "/>" } else { ">" };
            format!("{declaration}{ROOT}{end}{suites}")
        }
        None => text.to_owned(),
    }
}

/// Date and time of day in UTC to the second, without a time zone, as the schemas want it.
fn date_time(at: Timestamp) -> String {
    let seconds = i64::try_from(at.nanos() / 1_000_000_000).unwrap_or(0);
    let at = jiff::Timestamp::from_second(seconds).unwrap_or(jiff::Timestamp::UNIX_EPOCH);
    at.strftime("%Y-%m-%dT%H:%M:%S").to_string()
}

fn shown(text: &str) -> String {
    printable(text).into_owned()
}
