//! The findings as text for a terminal, each with its line, a marker under its place, and its fix.

use super::{CheckedFile, Counts, Located};
use crate::escape::printable;
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use canvass_analyzer::dictionary::Rule;
use canvass_analyzer::dictionary::Severity;
use canvass_analyzer::dictionary::source::Source;
use std::borrow::Cow;
use std::cmp::Reverse;
use std::fmt::Write as _;
use std::ops::Range;

/// Maximum length of a shown line. A longer line is cut around the place of its finding.
const LONGEST: usize = 300;

/// Maximum number of lines for the hints of a file.
const HINT_LINES: usize = 3;

/// The style of the drawing.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Whether colours are used.
    pub colors: bool,
    /// The width in columns.
    pub width: usize,
}

/// How hints are shown.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Hints {
    /// Each with its line, as errors and warnings.
    Each,
    /// Counted by rule, in three lines at most: many descriptions have hundreds, most of them of one rule.
    Counted,
}

/// The findings in one file that are not waived. `source` is the text of the file.
pub fn render(file: &CheckedFile, source: &Source<'_>, style: Style, hints: Hints) -> String {
    let renderer = if style.colors { Renderer::styled() } else { Renderer::plain() };
    let renderer = renderer.term_width(style.width);
    let mut drawn = String::new();
    let is_drawn = |located: &&Located| hints == Hints::Each || located.finding.severity() != Severity::Hint;
    for located in file.open().filter(is_drawn) {
        drawn.push_str(&renderer.render(&[group(file, located, source)]));
        drawn.push_str("\n\n");
    }
    if hints == Hints::Counted {
        drawn.push_str(&counted(file));
    }
    drawn
}

/// The hints by rule, in [`HINT_LINES`] lines at most.
fn counted(file: &CheckedFile) -> String {
    let mut rules: Vec<(&'static Rule, Vec<u32>)> = Vec::new();
    for located in file.open().filter(|located| located.finding.severity() == Severity::Hint) {
        let (rule, line) = (located.rule(), located.finding.line);
        match rules.iter_mut().find(|(known, _)| known.id == rule.id) {
            Some((_, lines)) => lines.push(line),
            None => rules.push((rule, vec![line])),
        }
    }
    rules.sort_by_key(|(_, lines)| Reverse(lines.len()));
    let shown = if rules.len() > HINT_LINES { HINT_LINES - 1 } else { rules.len() };
    let (most, others) = rules.split_at(shown);
    let mut text = String::new();
    for (rule, lines) in most {
        let title = rule.title();
        // Writing to a string does not fail.
        let _ = writeln!(text, "hint[{}]: {} × {title} ({})", rule.id, lines.len(), places(lines));
    }
    if !others.is_empty() {
        let findings: usize = others.iter().map(|(_, lines)| lines.len()).sum();
        let _ = writeln!(text, "hint: {findings} of {} other rules", others.len());
    }
    if !text.is_empty() {
        text.push('\n');
    }
    text
}

/// The first places of a rule: `lines 5, 9, 12, …`.
fn places(lines: &[u32]) -> String {
    const MOST: usize = 3;
    let known: Vec<String> = lines.iter().filter(|&&line| line > 0).map(u32::to_string).collect();
    let more = if known.len() > MOST { ", …" } else { "" };
    match known.get(..MOST).unwrap_or(&known) {
        [] => "the whole file".to_owned(),
        [line] => format!("line {line}"),
        first => format!("lines {}{more}", first.join(", ")),
    }
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
    // The line alone does not tell whose field it is.
    let of_section = !problem.section.is_empty() && !problem.field.is_empty() && finding.line > 0;
    let group = match of_section {
        true => group.element(Level::NOTE.message(format!("in [{}]", printable(&problem.section)))),
        false => group,
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
