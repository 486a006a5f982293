//! Severity and kind of a problem.

use std::fmt;

/// The severity of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// A matter of style, or worth knowing; nothing fails because of it.
    Hint,
    /// The text breaks the letter of the standard, but its meaning is clear and canvass understood it.
    Warning,
    /// A configuration tool or the device fails because of the text, or canvass could not use it.
    Error,
}

impl Severity {
    /// The name of the severity in text and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hint => "hint",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The kind of a problem, for grouping and waivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ProblemKind {
    /// Character set, byte order mark, line ends.
    Encoding,
    /// A line that is neither section, field nor comment, or is too long.
    Line,
    /// A section that occurs twice; the first counts.
    DuplicateSection,
    /// A field that occurs twice in a section; the first counts.
    DuplicateField,
    /// A section that the standard requires is missing.
    MissingSection,
    /// A field that the standard requires is missing.
    MissingField,
    /// A section that the standard does not know.
    UnknownSection,
    /// A field that the standard does not know in its section.
    UnknownField,
    /// A number that can't be read, or is written in a form that the standard does not allow.
    Number,
    /// A value that the field does not allow.
    Value,
    /// A number that does not fit the data type of its entry.
    Range,
    /// A count that differs from the number of items.
    Count,
    /// An object that is listed without description, described without being listed, or listed twice or in the
    /// wrong list.
    List,
    /// A PDO mapping that can't work, or half of a PDO's parameters.
    Mapping,
    /// A COB-ID that is restricted or used twice.
    CobId,
    /// An object that differs from the standard that defines it.
    Standard,
    /// The description is so large that the rest was left out.
    TooMuch,
}
