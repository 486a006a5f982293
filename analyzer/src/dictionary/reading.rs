//! Reads a description in whichever format it is.

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

    /// What such a file says.
    pub fn of(source: &Source<'_>) -> Result<Self, DescriptionError> {
        if source.is_xml() { xdd::describe(source) } else { eds::describe(source) }
    }

    /// What stands in the file that this was read from, and is not kept here: what no other file can be given.
    pub fn unkept(&self, source: &Source<'_>) -> Vec<Loss> {
        if source.is_xml() { xdd::unkept(self, source) } else { eds::unkept(self, source) }
    }
}
