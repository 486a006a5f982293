//! Where something stands in the text of a description.

use std::ops::Range;

/// A part of a text, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// Its first byte.
    pub start: u32,
    /// The byte after its last.
    pub end: u32,
}

impl Span {
    /// From one byte up to another. Descriptions are smaller than 4 GiB.
    pub(super) const fn new(start: usize, end: usize) -> Self {
        debug_assert!(start <= end && end <= u32::MAX as usize);
        Self { start: start as u32, end: end as u32 }
    }

    /// The bytes.
    pub const fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }

    /// Whether there is nothing in it.
    pub const fn is_empty(self) -> bool {
        self.start == self.end
    }

    /// Whether a place is in it or directly after it.
    pub(super) const fn touches(self, at: usize) -> bool {
        self.start as usize <= at && at <= self.end as usize
    }
}

/// Which section of an EDS, or element of an XDD: its position in the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SectionId(pub(super) u32);

/// What is known of a place in the source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spot {
    /// The line alone.
    #[default]
    Line,
    /// The section: the place is its field of the problem's name, or where the section begins.
    Section(SectionId),
    /// The place itself.
    Exact(Span),
}

/// The place of a problem.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place<'a> {
    /// From 1; 0 if it concerns no single line.
    pub line: u32,
    pub section: &'a str,
    pub field: &'a str,
    pub spot: Spot,
}

impl Place<'_> {
    /// A whole line.
    pub fn line(line: u32) -> Self {
        Self { line, ..Self::default() }
    }
}
