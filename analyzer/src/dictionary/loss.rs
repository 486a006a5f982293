//! Losses when a description is written to another file.

use super::problem::EdsProblem;
use super::rules;
use std::fmt;

/// A loss with its place. The texts come from the file and may contain any characters; [`fmt::Display`] escapes them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    /// The line of the original file, from 1; 0 if the loss concerns no single line.
    pub line: u32,
    /// The place: section and field, element and attribute, or object.
    pub place: String,
    /// The lost text.
    pub text: String,
    /// The reason of the loss.
    pub kind: LossKind,
}

/// The reason of a loss.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LossKind {
    /// The text could not be understood.
    Unread,
    /// A description in memory does not keep the text; the number tells how often the file has it.
    Unkept(usize),
    /// The written format has no place for the text.
    NoPlace,
    /// The written file has another form of the text, which is given.
    Changed(String),
}

/// `line 12, [2000] UploadFile "a.bin": is not kept`, with all unprintable characters escaped.
impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line != 0 {
            write!(f, "line {}, ", self.line)?;
        }
        write!(f, "{}", self.place.escape_debug())?;
        if !self.text.is_empty() {
            write!(f, " \"{}\"", self.text.escape_debug())?;
        }
        match &self.kind {
            LossKind::Unread => f.write_str(": can't be read"),
            LossKind::Unkept(1) => f.write_str(": is not kept"),
            LossKind::Unkept(times) => write!(f, ": is not kept, nor {} more", times - 1),
            LossKind::NoPlace => f.write_str(": the format has no place for it"),
            LossKind::Changed(written) => write!(f, ": written as \"{}\"", written.escape_debug()),
        }
    }
}

/// Collects losses.
#[derive(Debug, Default)]
pub(super) struct Losses(pub Vec<Loss>);

impl Losses {
    /// Limit of the length of a lost text.
    const LONGEST: usize = 200;

    pub fn add(&mut self, line: u32, place: impl Into<String>, text: &str, kind: LossKind) {
        let text = text.chars().take(Self::LONGEST).collect();
        self.0.push(Loss { line, place: place.into(), text, kind });
    }

    /// Reports a non-empty text without a place in the format.
    pub(crate) fn no_place(&mut self, line: u32, place: impl Into<String>, text: &str) {
        if !text.trim().is_empty() {
            self.add(line, place, text, LossKind::NoPlace);
        }
    }

    /// Reports a text that the file has `times` times, first on `line`.
    pub fn unkept(&mut self, line: u32, place: impl Into<String>, text: &str, times: usize) {
        self.add(line, place, text, LossKind::Unkept(times));
    }

    /// The text on one line without control characters: neither format allows them.
    pub fn line(&mut self, line: u32, place: &str, text: &str) -> String {
        let plain: String =
            text.chars().map(|character| if character.is_control() { ' ' } else { character }).collect();
        let plain = plain.trim();
        if plain != text {
            self.add(line, place, text, LossKind::Changed(plain.to_owned()));
        }
        plain.to_owned()
    }

    /// Reports the unreadable parts whose content is missing.
    pub fn unread(&mut self, problems: &[EdsProblem]) {
        let lost = [
            &rules::number::UNREADABLE,
            &rules::number::RANGE,
            &rules::field::RANGE,
            &rules::field::TWICE,
            &rules::section::TWICE,
            &rules::text::UNREAD,
            &rules::text::TOO_MUCH,
            &rules::text::CONFLICT,
            &rules::file::NODE_ID,
            &rules::file::BIT_RATE,
            &rules::file::DUMMY,
            &rules::xdd::MALFORMED,
            &rules::xdd::ATTRIBUTE_TWICE,
            &rules::xdd::TWICE,
            &rules::xdd::NUMBER,
        ];
        for problem in problems.iter().filter(|problem| lost.contains(&problem.rule)) {
            let place = match (problem.section.as_str(), problem.field.as_str()) {
                ("", field) => field.to_owned(),
                (section, "") => format!("[{section}]"),
                (section, field) => format!("[{section}] {field}"),
            };
            self.add(problem.line, place, &problem.found, LossKind::Unread);
        }
    }
}
