//! A problem of a device description, with its place.

use super::place::{Place, Spot};
use super::rules::{ProblemKind, Rule, Severity, text};
use std::fmt;

/// A problem and its place. The texts come from the file and may contain any characters; [`fmt::Display`] escapes
/// them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EdsProblem {
    /// The broken rule.
    pub rule: &'static Rule,
    /// The line, from 1; 0 if the problem concerns no single line.
    pub line: u32,
    /// The section, or element of an XDD; empty if the problem concerns none.
    pub section: String,
    /// The field, or attribute of an XDD; empty if the problem concerns none.
    pub field: String,
    /// The place in the source.
    pub spot: Spot,
    /// The form or value that the standard expects.
    pub expected: &'static str,
    /// The form or value found.
    pub found: String,
}

impl EdsProblem {
    /// The severity of a breach of the rule.
    pub const fn severity(&self) -> Severity {
        self.rule.severity
    }

    /// The kind of the problem.
    pub const fn kind(&self) -> ProblemKind {
        self.rule.kind
    }
}

/// `line 12, [1018sub1] DefaultValue: expected a number, found "abc"`, with all unprintable characters escaped.
impl fmt::Display for EdsProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line != 0 {
            write!(f, "line {}, ", self.line)?;
        }
        if !self.section.is_empty() {
            write!(f, "[{}] ", self.section.escape_debug())?;
        }
        if !self.field.is_empty() {
            write!(f, "{}", self.field.escape_debug())?;
        }
        write!(f, ": expected {}, found \"{}\"", self.expected, self.found.escape_debug())
    }
}

/// Collects problems, up to a limit: a hostile file could have one in every line.
#[derive(Clone, Debug, Default)]
pub(super) struct Problems {
    list: Vec<EdsProblem>,
}

impl Problems {
    /// Maximum number of problems that are kept.
    pub(super) const MOST: usize = 10_000;
    /// Maximum length of the text in `found`.
    const LONGEST: usize = 200;

    pub(super) fn report(&mut self, place: Place<'_>, rule: &'static Rule, expected: &'static str, found: &str) {
        let (place, rule, expected, found) = match self.list.len() {
            ..Self::MOST => (place, rule, expected, found),
            Self::MOST => (Place::line(place.line), &text::TOO_MUCH, "fewer problems", "more problems than are listed"),
            _ => return,
        };
        let cut = |text: &str| text.chars().take(Self::LONGEST).collect();
        self.list.push(EdsProblem {
            rule,
            line: place.line,
            section: cut(place.section),
            field: cut(place.field),
            spot: place.spot,
            expected,
            found: cut(found),
        });
    }

    /// The first problem of a rule.
    pub(super) fn first_of(&self, rule: &Rule) -> Option<&EdsProblem> {
        self.list.iter().find(|problem| problem.rule == rule)
    }

    /// All problems, by line.
    pub(super) fn into_sorted(mut self) -> Vec<EdsProblem> {
        self.list.sort_by_key(|problem| problem.line);
        self.list
    }
}
