//! The findings in device descriptions, in all output forms.

pub mod configuration;
pub mod dbc;
pub mod difference;
mod fingerprint;
pub mod github;
pub mod json;
mod report;
pub mod rules;
pub mod sarif;
pub mod show;
pub mod text;
pub mod verification;

pub use fingerprint::{BadBaseline, Baseline};
pub use report::CheckedFiles;

use crate::escape::printable;
use crate::page_text::none_or_counted;
use canvass_analyzer::dictionary::check::{Checked, Finding};
use canvass_analyzer::dictionary::{Rule, Severity};

/// A file with its findings, without its text.
#[derive(Clone, Debug)]
pub struct CheckedFile {
    /// The name of the file, as the user gave it.
    pub name: String,
    /// The findings, in the order of the file.
    pub findings: Vec<Located>,
}

/// A finding with its place in lines and columns, counted from 1. All numbers are 0 if the finding concerns no single
/// line.
#[derive(Clone, Debug)]
pub struct Located {
    /// The finding.
    pub finding: Finding,
    /// The line in which the place of the finding ends.
    pub end_line: u32,
    /// The column after the last character of the place.
    pub end_column: u32,
    /// The changes that fix the finding.
    pub edits: Vec<LocatedEdit>,
    /// Whether a baseline has the finding.
    pub is_known: bool,
}

/// A change of the text, with its place in lines and columns, counted from 1. The end is the first character that
/// stays.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LocatedEdit {
    /// Line and column of the beginning.
    pub start: (u32, u32),
    /// Line and column of the end.
    pub end: (u32, u32),
    /// The replacement text.
    pub text: String,
}

impl CheckedFile {
    /// The findings in a file, as far as they are `wanted`.
    pub fn new(name: &str, checked: &Checked<'_>, wanted: impl Fn(&Finding) -> bool) -> Self {
        let source = &checked.source;
        let located = |finding: &Finding| {
            let (end_line, end_column) = if finding.line == 0 { (0, 0) } else { source.position(finding.span.end) };
            let edits = finding.fix.iter().flat_map(|fix| &fix.edits);
            let edits = edits.map(|edit| LocatedEdit {
                start: source.position(edit.range.start),
                end: source.position(edit.range.end),
                text: edit.text.clone(),
            });
            Located { finding: finding.clone(), end_line, end_column, edits: edits.collect(), is_known: false }
        };
        let findings = checked.findings.iter().filter(|finding| wanted(finding)).map(located).collect();
        Self { name: name.to_owned(), findings }
    }

    /// The findings that neither the file nor a baseline waives.
    pub fn open(&self) -> impl Iterator<Item = &Located> {
        self.findings.iter().filter(|located| located.finding.waived.is_none())
    }
}

impl Located {
    const fn rule(&self) -> &'static Rule {
        self.finding.problem.rule
    }

    /// The problem with the expected and the actual text, on one line and safe to show.
    pub fn message(&self) -> String {
        let problem = &self.finding.problem;
        let place = match (problem.section.as_str(), problem.field.as_str()) {
            ("", "") => String::new(),
            ("", field) => format!(" ({field})"),
            (section, "") => format!(" ([{section}])"),
            (section, field) => format!(" ([{section}] {field})"),
        };
        let text =
            format!("{}{place}: expected {}, found \"{}\"", self.rule().title(), problem.expected, problem.found);
        printable(&text).into_owned()
    }
}

/// Number of findings by severity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub errors: usize,
    pub warnings: usize,
    pub hints: usize,
    /// Number of findings that the files or a baseline waive.
    pub waived: usize,
    /// Number of findings that are not waived and can be fixed without guessing.
    pub fixable: usize,
}

impl Counts {
    /// The numbers for several files.
    pub fn of<'a>(files: impl IntoIterator<Item = &'a CheckedFile>) -> Self {
        let mut counts = Self::default();
        for located in files.into_iter().flat_map(|file| &file.findings) {
            if located.finding.waived.is_some() {
                counts.waived += 1;
                continue;
            }
            counts.fixable += usize::from(located.finding.fix.is_some());
            *match located.finding.severity() {
                Severity::Error => &mut counts.errors,
                Severity::Warning => &mut counts.warnings,
                Severity::Hint => &mut counts.hints,
            } += 1;
        }
        counts
    }
}

/// The numbers in words: `1 error, 2 warnings, no hints`.
impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (errors, warnings, hints) = (self.errors, self.warnings, self.hints);
        write!(
            f,
            "{}, {}, {}",
            none_or_counted(errors, "error"),
            none_or_counted(warnings, "warning"),
            none_or_counted(hints, "hint")
        )?;
        match self.waived {
            0 => Ok(()),
            waived => write!(f, ", {waived} waived"),
        }
    }
}
