//! Checks a device description as a text: every breach of a rule has its place in the file, and its fix.
//!
//! Programs that show the file use it: the command line prints the places, an editor underlines them and offers the
//! edits.

mod apply;
mod beside;
mod fix;
mod waiver;

pub use apply::{FixedFile, apply_fixes};
pub use beside::Folder;
pub use fix::{Edit, Fix};

use super::Severity;
use super::description::DeviceDescription;
use super::place::{Place, Span};
use super::problem::{EdsProblem, Problems};
use super::source::{DescriptionError, Source};
use super::{consistency, rules};
use std::ops::Range;

/// The result of checking one file.
#[derive(Debug)]
pub struct Checked<'a> {
    /// The text of the file; all places refer to it.
    pub source: Source<'a>,
    /// The parsed description.
    pub description: Result<DeviceDescription, DescriptionError>,
    /// All findings, in the order of the file; findings without a line come first.
    pub findings: Vec<Finding>,
}

/// A breach of a rule with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The problem. Its texts come from the file and may contain any characters.
    pub problem: EdsProblem,
    /// The line, from 1; 0 if the finding concerns no single line.
    pub line: u32,
    /// The column in characters, from 1; 0 without a line.
    pub column: u32,
    /// The place in the text, in bytes; empty without a line.
    pub span: Range<usize>,
    /// The fix, if the finding has one that needs no guessing.
    pub fix: Option<Fix>,
    /// The reason given by a waiver in the file.
    pub waived: Option<String>,
}

impl Finding {
    /// The severity of the problem.
    pub const fn severity(&self) -> Severity {
        self.problem.rule.severity
    }
}

impl Checked<'_> {
    /// The findings that the file does not waive.
    pub fn open(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| finding.waived.is_none())
    }
}

/// Checks an EDS, DCF, XDD or XDC. `name` is the name of the file without folders, if known.
///
/// # Errors
/// If the file is too large. A file that is no description gets a finding instead.
pub fn check<'a>(bytes: &'a [u8], name: Option<&str>) -> Result<Checked<'a>, DescriptionError> {
    check_in(bytes, name, None)
}

/// Checks a description like [`check`], and a DCF also against the files in its folder, if given.
///
/// # Errors
/// See [`check`].
pub fn check_in<'a>(
    bytes: &'a [u8],
    name: Option<&str>,
    folder: Option<&dyn Folder>,
) -> Result<Checked<'a>, DescriptionError> {
    Ok(check_source(Source::read(bytes)?, name, folder))
}

/// Checks a parsed source.
pub fn check_source<'a>(source: Source<'a>, name: Option<&str>, folder: Option<&dyn Folder>) -> Checked<'a> {
    let description = DeviceDescription::of(&source);
    let mut problems = Vec::new();
    if let Ok(read) = &description {
        problems.clone_from(&read.problems);
        problems.extend(consistency::check(read));
        problems.extend(name.and_then(|name| other_name(read, name)));
        problems.extend(folder.into_iter().flat_map(|folder| beside::check(read, &source, folder)));
    }
    problems.sort_by_key(|problem| problem.line);
    let mut findings: Vec<Finding> = problems.into_iter().map(|problem| located(problem, &source)).collect();
    findings.sort_by_key(|finding| (finding.line, finding.column));
    let waivers = waiver::read(&source);
    for finding in &mut findings {
        finding.waived = waivers.iter().find(|waiver| waiver.covers(finding)).map(|waiver| waiver.reason.clone());
        // A fix is offered only if the rest of the file can be written back byte for byte.
        if source.is_exact()
            && let Ok(read) = &description
        {
            finding.fix = fix::of(finding, &source, read);
        }
    }
    Checked { source, description, findings }
}

/// Adds the place to a problem.
fn located(problem: EdsProblem, source: &Source<'_>) -> Finding {
    let span = source.place(&problem).map(Span::range);
    let (line, column) = span.as_ref().map_or((0, 0), |span| source.position(span.start));
    Finding { problem, line, column, span: span.unwrap_or(0..0), fix: None, waived: None }
}

/// The problem if `FileName` differs from the name of the file, ignoring case.
fn other_name(description: &DeviceDescription, name: &str) -> Option<EdsProblem> {
    let said = &description.file.name;
    if said.is_empty() || said.eq_ignore_ascii_case(name) {
        return None;
    }
    let mut problems = Problems::default();
    // Section and field determine the line.
    let place = Place { section: "FileInfo", field: "FileName", ..Place::default() };
    problems.report(place, &rules::file::NAME, "the name of the file", said);
    problems.into_sorted().pop()
}
