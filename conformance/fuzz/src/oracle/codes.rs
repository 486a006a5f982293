//! Sets of abort codes.

use canvass_analyzer::wire::sdo::{ABORT_CODES, AbortCode};

/// A set of the abort codes of CiA 301.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct CodeSet(u64);

impl CodeSet {
    pub const NONE: Self = Self(0);

    /// The set of those codes.
    pub const fn of(codes: &[AbortCode]) -> Self {
        let mut set = 0;
        let mut n = 0;
        while n < codes.len() {
            let mut at = 0;
            while at < ABORT_CODES.len() {
                if ABORT_CODES[at].0.0 == codes[n].0 {
                    set |= 1 << at;
                }
                at += 1;
            }
            n += 1;
        }
        Self(set)
    }

    /// Both sets.
    pub const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub fn has(self, code: AbortCode) -> bool {
        ABORT_CODES.binary_search_by_key(&code, |row| row.0).is_ok_and(|at| self.0 >> at & 1 != 0)
    }

    /// `0602 0000h or 0800 0000h`.
    pub fn text(self) -> String {
        let named: Vec<String> = ABORT_CODES
            .iter()
            .enumerate()
            .filter(|(at, _)| self.0 >> at & 1 != 0)
            .map(|(_, (code, _))| format!("{:04X} {:04X}h", code.0 >> 16, code.0 & 0xFFFF))
            .collect();
        named.join(" or ")
    }
}

/// What CiA's own tool accepts beside any specific code.
pub(super) const GENERAL: CodeSet = CodeSet::of(&[AbortCode::GENERAL]);
/// The object does not exist.
pub(super) const NO_OBJECT: CodeSet = CodeSet::of(&[AbortCode::NO_OBJECT]).or(GENERAL);
/// The object exists, the sub-index does not.
pub(super) const NO_SUB_INDEX: CodeSet = CodeSet::of(&[AbortCode::NO_SUB_INDEX]).or(GENERAL);
/// Writing what can only be read.
pub(super) const READ_ONLY: CodeSet = CodeSet::of(&[AbortCode::READ_ONLY, AbortCode::UNSUPPORTED_ACCESS]).or(GENERAL);
/// Reading what can only be written.
pub(super) const WRITE_ONLY: CodeSet = CodeSet::of(&[AbortCode::WRITE_ONLY, AbortCode::UNSUPPORTED_ACCESS]).or(GENERAL);
/// Too many bytes.
pub(super) const TOO_LONG: CodeSet =
    CodeSet::of(&[AbortCode::LENGTH_TOO_HIGH, AbortCode::LENGTH, AbortCode::OUT_OF_MEMORY]).or(GENERAL);
/// Too few bytes.
pub(super) const TOO_SHORT: CodeSet = CodeSet::of(&[AbortCode::LENGTH_TOO_LOW, AbortCode::LENGTH]).or(GENERAL);
/// Beyond the limits.
pub(super) const TOO_HIGH: CodeSet = CodeSet::of(&[AbortCode::VALUE_TOO_HIGH, AbortCode::INVALID_VALUE]).or(GENERAL);
/// Beyond the limits.
pub(super) const TOO_LOW: CodeSet = CodeSet::of(&[AbortCode::VALUE_TOO_LOW, AbortCode::INVALID_VALUE]).or(GENERAL);
/// A value that the device may refuse for reasons of its own.
pub(super) const REFUSED: CodeSet = CodeSet::of(&[
    AbortCode::INVALID_VALUE,
    AbortCode::VALUE_TOO_HIGH,
    AbortCode::VALUE_TOO_LOW,
    AbortCode::MAXIMUM_BELOW_MINIMUM,
    AbortCode::UNSUPPORTED_ACCESS,
    AbortCode::NOT_MAPPABLE,
    AbortCode::PDO_LENGTH,
    AbortCode::PARAMETER_INCOMPATIBLE,
    AbortCode::INTERNAL_INCOMPATIBLE,
    AbortCode::HARDWARE,
    AbortCode::NOT_TRANSFERRED,
    AbortCode::LOCAL_CONTROL,
    AbortCode::DEVICE_STATE,
])
.or(GENERAL);
/// What a device says of data that it does not have at the moment.
pub(super) const NO_DATA: CodeSet = CodeSet::of(&[
    AbortCode::NO_DATA,
    AbortCode::NOT_TRANSFERRED,
    AbortCode::LOCAL_CONTROL,
    AbortCode::DEVICE_STATE,
    AbortCode::HARDWARE,
])
.or(GENERAL);
/// A command that has no place in this state.
pub(super) const COMMAND: CodeSet = CodeSet::of(&[AbortCode::COMMAND_SPECIFIER]);
/// A toggle bit that does not alternate.
pub(super) const TOGGLE: CodeSet = CodeSet::of(&[AbortCode::TOGGLE]);
/// A block size of 0 or above 127.
pub(super) const BLOCK_SIZE: CodeSet = CodeSet::of(&[AbortCode::BLOCK_SIZE]);
/// A sequence number that was never sent.
pub(super) const SEQUENCE: CodeSet = CodeSet::of(&[AbortCode::SEQUENCE_NUMBER, AbortCode::COMMAND_SPECIFIER]);
/// A checksum that does not fit.
pub(super) const CRC: CodeSet = CodeSet::of(&[AbortCode::CRC]);
