//! Reads a description in any format.

use super::description::DeviceDescription;
use super::eds;
use super::loss::Loss;
use super::source::{DescriptionError, Source};
use super::xdd;

impl DeviceDescription {
    /// Reads an EDS, DCF, XDD or XDC, distinguished by content.
    pub fn read(bytes: &[u8]) -> Result<Self, DescriptionError> {
        Self::of(&Source::read(bytes)?)
    }

    /// Reads the description in a source.
    pub fn of(source: &Source<'_>) -> Result<Self, DescriptionError> {
        if source.is_xml() { xdd::describe(source) } else { eds::describe(source) }
    }

    /// The parts of the source that this description does not keep, and so can't write to another file.
    pub fn unkept(&self, source: &Source<'_>) -> Vec<Loss> {
        if source.is_xml() { xdd::unkept(self, source) } else { eds::unkept(self, source) }
    }
}
