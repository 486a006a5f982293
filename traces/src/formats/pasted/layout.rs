//! The meaning of the columns of pasted lines.

use super::token::Commas;
use crate::columns::Unit;

/// The meaning of a column of numbers before the data.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Role {
    /// A number without a meaning for the frame, such as that of a line.
    Skip,
    Time,
    /// The microseconds of the time in seconds before them.
    Micros,
    Channel,
    Id,
    Length,
}

/// How a line holds its frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Core {
    /// Identifier, length and data are columns.
    Apart,
    /// One word in candump's notation.
    Notation,
    /// One word in SLCAN's notation.
    Slcan,
}

/// How the data are written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum DataForm {
    /// Bytes of two hexadecimal digits.
    Padded,
    /// All bytes in one word.
    Compact,
    /// Bytes of one or two hexadecimal digits.
    Unpadded,
    Decimal,
}

/// The column after the data. A remark is no column.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Behind {
    Nothing,
    Time,
    /// The cycle time and count of a list that has each identifier once.
    CycleAndCount,
    /// A date or a time of the day, perhaps after a number of ten digits.
    Clock,
    /// The number of the line, which is its last column.
    Counter,
}

/// The meaning of the columns.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Layout {
    /// The numbers before the data, or before the frame's word.
    pub(super) before: Vec<Role>,
    pub(super) core: Core,
    pub(super) id_is_decimal: bool,
    /// Whether an identifier of eight digits has 11 bits if nothing says that it has 29.
    pub(super) wide_is_standard: bool,
    pub(super) data: DataForm,
    pub(super) behind: Behind,
    pub(super) unit: Unit,
    /// Whether times are differences from the line before.
    pub(super) differences: bool,
    pub(super) words: Words,
    pub(super) commas: Commas,
    /// Whether dates with slashes begin with the month.
    pub(super) month_first: bool,
    /// Whether an arrow after the time of the day is the mark of a terminal, and no direction.
    pub(super) arrow_is_mark: bool,
    /// The numbers of digits that identifiers have, as bits; 0: any.
    pub(super) id_digits: u16,
    /// Whether labels without meaning may be before the identifier.
    pub(super) has_labels: bool,
    /// The details that a person gave, so that the next question keeps them.
    pub(super) given: Given,
}

/// The details of columns that a person gave: `hex`, `11`, `mdy`; empty: none.
#[derive(Clone, Default, PartialEq, Eq, Debug)]
pub(super) struct Given {
    pub(super) id: String,
    pub(super) data: String,
    pub(super) date: String,
}

impl Layout {
    pub(super) fn new(before: Vec<Role>, core: Core, data: DataForm) -> Self {
        Self {
            before,
            core,
            id_is_decimal: false,
            wide_is_standard: false,
            data,
            behind: Behind::Nothing,
            unit: Unit::Seconds,
            differences: false,
            words: Words::All,
            commas: Commas::Separate,
            month_first: true,
            arrow_is_mark: false,
            id_digits: 0,
            has_labels: true,
            given: Given::default(),
        }
    }

    /// Whether no identifier in the lines that decide has this number of digits.
    pub(super) fn is_strange(&self, digits: u8) -> bool {
        self.id_digits != 0 && self.id_digits & 1 << digits.min(15) == 0
    }

    pub(super) fn has(&self, role: Role) -> bool {
        self.before.contains(&role)
    }
}

/// The unknown words that lines of frames have beside their columns. A line with another word is prose.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Words {
    /// Any word.
    All,
    /// The words with these hashes.
    Only(Vec<u64>),
}

impl Words {
    pub(super) fn knows(&self, word: &[u8]) -> bool {
        match self {
            Self::All => true,
            Self::Only(hashes) => hashes.contains(&hash(word)),
        }
    }
}

/// FNV-1a of the word in lower case.
pub(super) fn hash(word: &[u8]) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(byte.to_ascii_lowercase())).wrapping_mul(0x0100_0000_01B3);
    word.iter().fold(0xCBF2_9CE4_8422_2325, step)
}
