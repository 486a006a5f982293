//! Why a file could not be read at all.

/// Maximum size of a device description in bytes: the largest ones, of modular devices, have some megabytes.
pub const LARGEST_FILE: usize = 16 << 20;

/// Why a file could not be read at all.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DescriptionError {
    /// The file is larger than [`LARGEST_FILE`].
    #[error("expected a device description of at most {LARGEST_FILE} bytes, found {found}")]
    TooLarge {
        /// The length of the file in bytes.
        found: usize,
    },
    /// The file has no section at all.
    #[error("expected the sections of an EDS such as [FileInfo] or [1000], found none")]
    NoSections,
    /// The file is XML, but not a CANopen device description.
    #[error("expected a CANopen XDD with a CANopenObjectList, found {found}")]
    NotCanopen {
        /// The text found.
        found: String,
    },
    /// The file is XML with an error before its first object.
    #[error("line {line}: expected well-formed XML with a CANopenObjectList, found {found}")]
    Malformed {
        /// The line, from 1.
        line: u32,
        /// The error of the XML reader.
        found: String,
    },
}
