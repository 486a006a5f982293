//! Reads a description in whichever format it is.

use super::description::DeviceDescription;
use super::eds::{self, DescriptionError};
use super::xdd;

impl DeviceDescription {
    /// Reads an EDS, DCF, XDD or XDC, told apart by content.
    pub fn read(bytes: &[u8]) -> Result<Self, DescriptionError> {
        let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
        // In UTF-16 the first character has a zero beside it.
        if text.starts_with(b"<") || text.starts_with(b"\xFF\xFE<") || text.starts_with(b"\xFE\xFF\0<") {
            xdd::read(bytes)
        } else {
            eds::read(bytes)
        }
    }
}
