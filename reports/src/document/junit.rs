//! JUnit XML for continuous integration, written here for all commands.
//!
//! Tools validate JUnit files against one of two schemas: that of Ant's JUnit task (`JUnit.xsd`) and that of Jenkins
//! (`junit-10.xsd`). A document keeps to what both allow, as in `tests/peers/junit.xsd`: suites have each attribute
//! that Ant requires, and cases have no properties and no output of their own. So the details of a failure are in its
//! text, and remarks on a case that passes are in the output of its suite.

use crate::escape::{Visible, printable};
use canvass_traces::{Duration, Timestamp};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::io::{self, Write};

/// Cases that belong together, with the properties of the run.
#[derive(Debug)]
pub struct Suite {
    name: String,
    properties: Vec<(String, String)>,
    began: Timestamp,
    cases: Vec<Case>,
}

/// A single test of a suite.
#[derive(Debug)]
pub struct Case {
    /// The family of the case, with dots: `canvass.nodes`.
    pub family: String,
    /// The name of the case within its family.
    pub name: String,
    /// The duration of the case.
    pub duration: Duration,
    /// The outcome of the case.
    pub outcome: Outcome,
    /// Remarks on a case that did not fail, each with its subject. May be empty.
    pub remarks: Vec<String>,
}

/// The outcome of a case.
#[derive(Debug)]
pub enum Outcome {
    /// The case passed.
    Passed,
    /// The case was not judged.
    Skipped {
        /// The reason why the case was skipped.
        message: String,
    },
    /// The tested object is wrong.
    Failed(Problem),
    /// The case could not be judged, although it should have been.
    Error(Problem),
}

/// The reason why a case did not pass.
#[derive(Debug)]
pub struct Problem {
    /// The kind of the problem in one or two words.
    pub kind: &'static str,
    /// The problem in one sentence.
    pub message: String,
    /// The details for a person.
    pub details: Vec<String>,
}

impl Suite {
    /// A suite without cases yet.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), properties: Vec::new(), began: Timestamp::ZERO, cases: Vec::new() }
    }

    /// Adds properties of the run.
    pub(crate) fn add_properties<K: Into<String>>(&mut self, properties: impl IntoIterator<Item = (K, String)>) {
        self.properties.extend(properties.into_iter().map(|(name, value)| (name.into(), value)));
    }

    /// Sets the time of the first frame. On a simulated bus it counts from power-on, so that the same run gives the
    /// same bytes.
    pub(crate) fn set_began(&mut self, began: Timestamp) {
        self.began = began;
    }

    /// All cases.
    pub(crate) fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// Adds cases.
    pub(crate) fn add_cases(&mut self, cases: impl IntoIterator<Item = Case>) {
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
    /// A case that passed, without remarks.
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
    /// The kind of a violation that no repetition has shown again.
    pub(crate) const SEEN_ONCE: &'static str = "violation seen once";

    /// Whether the problem is confirmed. A violation that was seen only once may come from a disturbance.
    pub(crate) fn is_certain(&self) -> bool {
        self.kind != Self::SEEN_ONCE
    }

    fn to_junit(&self, kind: NonSuccessKind) -> TestCaseStatus {
        let mut status = TestCaseStatus::non_success(kind);
        status.set_type(self.kind);
        status.set_message(shown(&self.message));
        status.set_description(self.details.iter().map(|line| shown(line)).collect::<Vec<_>>().join("\n"));
        status
    }
}

/// Writes a document. `command` is the command that was run, such as `diagnose`.
///
/// # Errors
/// The errors of `out`.
pub(crate) fn write(command: &str, suites: &[Suite], out: &mut dyn Write) -> io::Result<()> {
    let mut report = Report::unnamed();
    report.add_test_suites(suites.iter().enumerate().map(|(number, suite)| suite.to_junit(number, command)));
    let text = report.to_string().map_err(io::Error::other)?;
    // The error keeps its cause, because a closed pipe is no failure.
    Visible::new(out, false).write_all(without_totals(&text).as_bytes())
}

/// Removes the attributes of the root, which Ant's schema does not know. The writer escapes each `>` in attributes, so
/// that the first `>` ends the tag.
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

/// Date and time in UTC to the second, without a time zone, as the schemas require.
fn date_time(at: Timestamp) -> String {
    let seconds = i64::try_from(at.nanos() / 1_000_000_000).unwrap_or(0);
    let at = jiff::Timestamp::from_second(seconds).unwrap_or(jiff::Timestamp::UNIX_EPOCH);
    at.strftime("%Y-%m-%dT%H:%M:%S").to_string()
}

fn shown(text: &str) -> String {
    printable(text).into_owned()
}
