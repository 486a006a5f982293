//! Places in the text of a description.

use std::ops::Range;

/// A part of a text, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// The first byte.
    pub start: u32,
    /// The byte after the last one.
    pub end: u32,
}

impl Span {
    /// The part between two bytes. Descriptions are smaller than 4 GiB.
    pub(super) const fn new(start: usize, end: usize) -> Self {
        debug_assert!(start <= end && end <= u32::MAX as usize);
        Self { start: start as u32, end: end as u32 }
    }

    /// The part as a range.
    pub const fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }

    /// Whether the part is empty.
    pub const fn is_empty(self) -> bool {
        self.start == self.end
    }

    /// Whether a place is inside the part or directly after it.
    pub(super) const fn touches(self, at: usize) -> bool {
        self.start as usize <= at && at <= self.end as usize
    }
}

/// A section of an EDS, or an element of an XDD: its index in the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SectionId(pub(super) u32);

/// The precision of a place in the source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spot {
    /// Only the line is known.
    #[default]
    Line,
    /// The section: the place is the field named in the problem, or the section's beginning.
    Section(SectionId),
    /// The exact place.
    Exact(Span),
}

/// The place of a problem.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place<'a> {
    /// The line, from 1; 0 if the problem concerns no single line.
    pub line: u32,
    pub section: &'a str,
    pub field: &'a str,
    pub spot: Spot,
}

impl Place<'_> {
    /// The place of a whole line.
    pub fn line(line: u32) -> Self {
        Self { line, ..Self::default() }
    }
}
