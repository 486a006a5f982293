//! Sets of abort codes, from the table of allowed answers and for situations that only a fuzzer reaches.

use canvass_analyzer::wire::sdo::{ABORT_CODES, AbortCode};
use canvass_suite::situation::Situation;

/// A set of the abort codes of CiA 301.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct CodeSet {
    /// One bit for each row of [`ABORT_CODES`].
    rows: u64,
    /// The most suitable code, which texts name first.
    best: Option<AbortCode>,
}

impl CodeSet {
    pub const NONE: Self = Self { rows: 0, best: None };

    /// The set of the codes. The first code is the best.
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
        Self { rows: set, best: if codes.is_empty() { None } else { Some(codes[0]) } }
    }

    /// The codes that the table of allowed answers and CiA's own tool accept in a situation.
    const fn in_situation(situation: Situation) -> Self {
        let answers = situation.answers();
        Self::of(answers.aborts).or(Self::of(answers.tolerated))
    }

    /// The union of both sets, with the best code of the first.
    pub const fn or(self, other: Self) -> Self {
        let best = if self.best.is_some() { self.best } else { other.best };
        Self { rows: self.rows | other.rows, best }
    }

    pub const fn is_empty(self) -> bool {
        self.rows == 0
    }

    pub fn has(self, code: AbortCode) -> bool {
        ABORT_CODES.binary_search_by_key(&code, |row| row.0).is_ok_and(|at| self.rows >> at & 1 != 0)
    }

    /// The set as text, best code first, such as `0602 0000h or 0800 0000h`, or for many codes `0609 0030h, or one of
    /// 12 other codes`.
    pub fn text(self) -> String {
        let words = |code: AbortCode| format!("{:04X} {:04X}h", code.0 >> 16, code.0 & 0xFFFF);
        let rows = ABORT_CODES.iter().enumerate().filter(|(at, _)| self.rows >> at & 1 != 0).map(|(_, row)| row.0);
        let mut codes: Vec<AbortCode> = rows.collect();
        codes.sort_by_key(|code| Some(*code) != self.best);
        match &codes[..] {
            [best, others @ ..] if others.len() > MOST_NAMED => {
                format!("{}, or one of {} other codes", words(*best), others.len())
            }
            few => few.iter().copied().map(words).collect::<Vec<_>>().join(" or "),
        }
    }
}

/// Maximum number of codes named after the best code. Further codes are only counted.
const MOST_NAMED: usize = 2;

/// The general code, which CiA's own tool accepts instead of any specific code.
pub(super) const GENERAL: CodeSet = CodeSet::of(&[AbortCode::GENERAL]);
/// The object does not exist.
pub(super) const NO_OBJECT: CodeSet = CodeSet::in_situation(Situation::MissingObject);
/// The object exists, but the sub-index does not.
pub(super) const NO_SUB_INDEX: CodeSet = CodeSet::in_situation(Situation::MissingEntry);
/// A read-only object is written.
pub(super) const READ_ONLY: CodeSet = CodeSet::in_situation(Situation::ReadOnly);
/// A write-only object is read.
pub(super) const WRITE_ONLY: CodeSet = CodeSet::in_situation(Situation::WriteOnly);
/// The value has too many bytes.
pub(super) const TOO_LONG: CodeSet =
    CodeSet::in_situation(Situation::TooLong).or(CodeSet::of(&[AbortCode::OUT_OF_MEMORY]));
/// The value has too few bytes.
pub(super) const TOO_SHORT: CodeSet = CodeSet::in_situation(Situation::TooShort);
/// The value is above the limit.
pub(super) const TOO_HIGH: CodeSet = CodeSet::in_situation(Situation::TooHigh);
/// The value is below the limit.
pub(super) const TOO_LOW: CodeSet = CodeSet::in_situation(Situation::TooLow);
/// The device refuses the value for reasons of its own.
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
/// The device does not have the data at the moment.
pub(super) const NO_DATA: CodeSet = CodeSet::of(&[
    AbortCode::NO_DATA,
    AbortCode::NOT_TRANSFERRED,
    AbortCode::LOCAL_CONTROL,
    AbortCode::DEVICE_STATE,
    AbortCode::HARDWARE,
])
.or(GENERAL);
/// The command does not fit the state.
pub(super) const COMMAND: CodeSet = CodeSet::in_situation(Situation::UnknownCommand);
/// The toggle bit does not alternate.
pub(super) const TOGGLE: CodeSet = CodeSet::in_situation(Situation::RepeatedToggle);
/// The block size is 0 or above 127.
pub(super) const BLOCK_SIZE: CodeSet = CodeSet::in_situation(Situation::BlockSize);
/// The sequence number was never sent.
pub(super) const SEQUENCE: CodeSet = CodeSet::in_situation(Situation::SequenceNumber);
/// The checksum does not match.
pub(super) const CRC: CodeSet = CodeSet::in_situation(Situation::WrongChecksum);
/// The codes that may end a download within a block, because of the transfer or of the object.
pub(super) const IN_BLOCK_DOWNLOAD: CodeSet =
    SEQUENCE.or(REFUSED).or(TOO_LONG).or(TOO_SHORT).or(READ_ONLY).or(NO_OBJECT).or(NO_SUB_INDEX);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_code_comes_first_and_many_are_counted() {
        assert_eq!(NO_OBJECT.text(), "0602 0000h or 0800 0000h");
        assert_eq!(CRC.or(TOO_SHORT).text(), "0504 0004h, or one of 3 other codes");
        assert_eq!(TOO_SHORT.or(REFUSED).text(), "0607 0013h, or one of 15 other codes");
        assert!(CRC.or(TOO_SHORT).has(AbortCode::CRC) && CRC.or(TOO_SHORT).has(AbortCode::LENGTH_TOO_LOW));
        assert!(CodeSet::NONE.is_empty() && !NO_DATA.is_empty());
    }
}
