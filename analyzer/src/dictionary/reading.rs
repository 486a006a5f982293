//! Reads a description in whichever format it is.

use super::description::DeviceDescription;
use super::eds::{self, DescriptionError};
use super::loss::Loss;
use super::xdd;

impl DeviceDescription {
    /// Reads an EDS, DCF, XDD or XDC, distinguished by content.
    pub fn read(bytes: &[u8]) -> Result<Self, DescriptionError> {
        if is_xml(bytes) { xdd::read(bytes) } else { eds::read(bytes) }
    }

    /// What stands in the file that this was read from, and is not kept here: what no other file can be given.
    pub fn unkept(&self, bytes: &[u8]) -> Vec<Loss> {
        if is_xml(bytes) { xdd::unkept(self, bytes) } else { eds::unkept(self, bytes) }
    }
}

/// Whether it is an XDD or XDC.
pub(super) fn is_xml(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    // A merge conflict begins with more of them. In UTF-16 the first character has a zero beside it.
    text.starts_with(b"<") && !text.starts_with(b"<<")
        || text.starts_with(b"\xFF\xFE<")
        || text.starts_with(b"\xFE\xFF\0<")
}
