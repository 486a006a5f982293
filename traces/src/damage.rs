//! Damage: a part of a source that can't be read, and its place.

use crate::{Place, Record, SourceError};
use std::borrow::Cow;
use std::fmt;

/// A part of a source that is not a readable frame. Reading goes on after it, unless the damage is
/// [fatal](DamageKind::is_fatal).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Damage {
    /// The kind of damage; totals are counted by kind.
    pub kind: DamageKind,
    /// The line or packet, and its offset.
    pub place: Place,
    /// The column in the line, from 1, if the line's format has columns; counted in bytes.
    pub column: Option<u32>,
    /// The text or value expected at this place.
    pub expected: Cow<'static, str>,
    /// The bytes found instead, cut to a readable length and without control characters.
    pub found: String,
    /// The readable part of a frame that contradicts itself; it does not count as a record of the capture.
    pub salvaged: Option<Box<Record>>,
}

/// The kinds of damage.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum DamageKind {
    /// The line or packet breaks the rules of its format.
    Malformed,
    /// The line or packet ends before it is complete, or the recorder cut it.
    Truncated,
    /// The line or packet is well-formed, but canvass does not read its kind.
    Unsupported,
    /// The number of frames that the recorder reports as lost.
    Dropped(u64),
    /// The file has no proper end, because the recorder was interrupted. The part before was read.
    Unfinished,
    /// The source failed, or the rest of it is unreadable: no record follows.
    Fatal,
}

impl DamageKind {
    /// Whether no record can follow.
    pub const fn is_fatal(self) -> bool {
        matches!(self, Self::Fatal)
    }

    /// The name of the kind, for summaries.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Malformed => "malformed",
            Self::Truncated => "truncated",
            Self::Unsupported => "unsupported",
            Self::Dropped(_) => "dropped by the recorder",
            Self::Unfinished => "unfinished file",
            Self::Fatal => "unreadable",
        }
    }
}

impl Damage {
    /// Maximum length of the found text that is kept, in characters.
    pub(crate) const EXCERPT: usize = 60;

    /// A damage at a place, with the expected text and the bytes found.
    pub fn new(kind: DamageKind, place: Place, expected: impl Into<Cow<'static, str>>, found: &[u8]) -> Self {
        Self { kind, place, column: None, expected: expected.into(), found: excerpt(found), salvaged: None }
    }

    /// The damage for frames that the recorder reports as lost.
    pub(crate) fn dropped(frames: u64, place: Place) -> Self {
        Self::new(DamageKind::Dropped(frames), place, "no lost frames", b"")
    }

    /// The damage for a source that fails: unfinished if a compressed stream ends early, else fatal. No record
    /// follows in either case.
    pub(crate) fn source(error: &SourceError, place: Place) -> Self {
        let cut = matches!(error, SourceError::Io(error) if error.kind() == std::io::ErrorKind::UnexpectedEof);
        let kind = if cut { DamageKind::Unfinished } else { DamageKind::Fatal };
        Self::new(kind, place, format!("more of the file, but {error}"), b"")
    }

    /// Adds the readable part of the frame.
    pub(crate) fn with_salvaged(mut self, record: Record) -> Self {
        self.salvaged = Some(Box::new(record));
        self
    }

    /// Adds the column in the line, from 1.
    pub(crate) fn at_column(mut self, column: usize) -> Self {
        self.column = Some(column.min(u32::MAX as usize) as u32);
        self
    }
}

/// Why bytes are no readable frame; becomes a [`Damage`] when its place is known.
#[derive(Debug)]
pub(crate) struct Flaw {
    kind: DamageKind,
    expected: Cow<'static, str>,
    found: String,
}

impl Flaw {
    pub(crate) fn malformed(expected: impl Into<Cow<'static, str>>, found: impl Into<String>) -> Self {
        Self { kind: DamageKind::Malformed, expected: expected.into(), found: found.into() }
    }

    pub(crate) fn unsupported(expected: impl Into<Cow<'static, str>>, found: impl Into<String>) -> Self {
        Self { kind: DamageKind::Unsupported, expected: expected.into(), found: found.into() }
    }

    /// The flaw of something without which a larger part of the file can't be read.
    pub(crate) fn costing(self, part: &str) -> Self {
        Self { expected: format!("{}, without which {part} can't be read", self.expected).into(), ..self }
    }

    pub(crate) fn damage(self, place: Place) -> Damage {
        Damage::new(self.kind, place, self.expected, self.found.as_bytes())
    }
}

/// The first characters of untrusted bytes, with control characters made visible.
fn excerpt(bytes: &[u8]) -> String {
    let head = &bytes[..bytes.len().min(4 * Damage::EXCERPT)];
    let text = String::from_utf8_lossy(head);
    let mut shown: String =
        text.chars().take(Damage::EXCERPT).map(|c| if c.is_control() { '\u{FFFD}' } else { c }).collect();
    if text.chars().count() > Damage::EXCERPT || head.len() < bytes.len() {
        shown.push('…');
    }
    shown
}

/// `line 12, column 27: malformed: expected …, found "…"`; the caller adds the file's name.
impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            DamageKind::Dropped(1) => f.write_str("the recorder lost 1 frame here")?,
            DamageKind::Dropped(n) => write!(f, "the recorder lost {n} frames here")?,
            kind => f.write_str(kind.name())?,
        }
        if matches!(self.kind, DamageKind::Dropped(_)) && self.found.is_empty() {
            return Ok(());
        }
        write!(f, ": expected {}", self.expected)?;
        if !self.found.is_empty() {
            write!(f, ", found \"{}\"", self.found)?;
        }
        Ok(())
    }
}

impl std::error::Error for Damage {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_found_is_fit_for_a_terminal() {
        let damage = Damage::new(DamageKind::Malformed, Place::default(), "a frame", b"\x1b[31mred\xff");
        assert_eq!(damage.to_string(), "malformed: expected a frame, found \"\u{FFFD}[31mred\u{FFFD}\"");
        let long = Damage::new(DamageKind::Malformed, Place::default(), "a frame", &[b'x'; 5000]);
        assert_eq!(long.found.chars().count(), Damage::EXCERPT + 1);
    }
}
