//! The findings as text for a terminal, each with its line, a marker under its place, and its fix.

use super::{CheckedFile, Counts, Located};
use crate::escape::printable;
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use canvass_analyzer::dictionary::Severity;
use canvass_analyzer::dictionary::source::Source;
use std::borrow::Cow;
use std::ops::Range;

/// Maximum length of a shown line. A longer line is cut around the place of its finding.
const LONGEST: usize = 300;

/// The style of the drawing.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Whether colours are used.
    pub colors: bool,
    /// The width in columns.
    pub width: usize,
}

/// The findings in one file that are not waived. `source` is the text of the file.
pub fn render(file: &CheckedFile, source: &Source<'_>, style: Style) -> String {
    let renderer = if style.colors { Renderer::styled() } else { Renderer::plain() };
    let renderer = renderer.term_width(style.width);
    let mut drawn = String::new();
    for located in file.open() {
        drawn.push_str(&renderer.render(&[group(file, located, source)]));
        drawn.push_str("\n\n");
    }
    drawn
}

/// The number of files and findings.
pub fn summary(files: usize, counts: &Counts) -> String {
    let files = if files == 1 { "1 file".to_owned() } else { format!("{files} files") };
    format!("{files}: {counts}\n")
}

fn group<'a>(file: &'a CheckedFile, located: &'a Located, source: &Source<'_>) -> Group<'a> {
    let finding = &located.finding;
    let problem = &finding.problem;
    let level = match finding.severity() {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Hint => Level::NOTE.with_name("hint"),
    };
    let title = level.primary_title(problem.rule.title()).id(problem.rule.id);
    let label = format!("expected {}, found \"{}\"", problem.expected, problem.found);
    let label = printable(&label).into_owned();
    let name = printable(&file.name);
    let group = if finding.line == 0 {
        title.element(Origin::path(name)).element(Level::NOTE.message(label))
    } else {
        let (shown, span) = shown(source, located);
        let annotation = AnnotationKind::Primary.span(span).label(label);
        title.element(Snippet::source(shown).path(name).line_start(finding.line as usize).annotation(annotation))
    };
    let help = match &finding.fix {
        Some(fix) => format!("can be fixed automatically: {}", fix.title),
        None => problem.rule.advice(),
    };
    group.element(Level::HELP.message(printable(&help).into_owned()))
}

/// The line of a finding as it is shown, and the range of the place within it.
fn shown(source: &Source<'_>, located: &Located) -> (String, Range<usize>) {
    let finding = &located.finding;
    let line = source.whole_line(finding.line);
    let end = finding.span.end.min(line.end);
    let part = |range: Range<usize>| source.text.get(range).unwrap_or_default().trim_end_matches(['\r', '\n']);
    let before = last(&visible(part(line.start..finding.span.start)), LONGEST);
    let mark = first(&visible(part(finding.span.start..end)), LONGEST);
    let after = first(&visible(part(end..line.end)), LONGEST);
    let span = before.len()..before.len() + mark.len();
    (before + &mark + &after, span)
}

/// A tabulator would have an unknown width in the drawing, so a blank replaces it.
fn visible(text: &str) -> String {
    match printable(&text.replace('\t', " ")) {
        Cow::Borrowed(text) => text.to_owned(),
        Cow::Owned(text) => text,
    }
}

fn first(text: &str, most: usize) -> String {
    text.chars().take(most).collect()
}

fn last(text: &str, most: usize) -> String {
    text.chars().skip(text.chars().count().saturating_sub(most)).collect()
}
