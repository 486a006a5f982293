//! Sets of abort codes: those of the table of allowed answers, and those of choices that only a fuzzer meets.

use canvass_analyzer::wire::sdo::{ABORT_CODES, AbortCode};
use canvass_suite::situation::Situation;

/// A set of the abort codes of CiA 301.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct CodeSet {
    /// A bit for each row of [`ABORT_CODES`].
    rows: u64,
    /// The one that fits best, which words begin with.
    best: Option<AbortCode>,
}

impl CodeSet {
    pub const NONE: Self = Self { rows: 0, best: None };

    /// The set of those codes, the best one first.
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

    /// The codes that the table of allowed answers has for a situation, and those that CiA's own tool accepts there.
    const fn in_situation(situation: Situation) -> Self {
        let answers = situation.answers();
        Self::of(answers.aborts).or(Self::of(answers.tolerated))
    }

    /// Both sets; the best code is that of the first one.
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

    /// `0602 0000h or 0800 0000h`; of many the best one: `0609 0030h, or one of 12 other codes`.
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

/// More codes than this beside the best one are counted, not named.
const MOST_NAMED: usize = 2;

/// What CiA's own tool accepts beside any specific code.
pub(super) const GENERAL: CodeSet = CodeSet::of(&[AbortCode::GENERAL]);
/// The object does not exist.
pub(super) const NO_OBJECT: CodeSet = CodeSet::in_situation(Situation::MissingObject);
/// The object exists, the sub-index does not.
pub(super) const NO_SUB_INDEX: CodeSet = CodeSet::in_situation(Situation::MissingEntry);
/// Writing what can only be read.
pub(super) const READ_ONLY: CodeSet = CodeSet::in_situation(Situation::ReadOnly);
/// Reading what can only be written.
pub(super) const WRITE_ONLY: CodeSet = CodeSet::in_situation(Situation::WriteOnly);
/// Too many bytes.
pub(super) const TOO_LONG: CodeSet =
    CodeSet::in_situation(Situation::TooLong).or(CodeSet::of(&[AbortCode::OUT_OF_MEMORY]));
/// Too few bytes.
pub(super) const TOO_SHORT: CodeSet = CodeSet::in_situation(Situation::TooShort);
/// Beyond the limits.
pub(super) const TOO_HIGH: CodeSet = CodeSet::in_situation(Situation::TooHigh);
/// Beyond the limits.
pub(super) const TOO_LOW: CodeSet = CodeSet::in_situation(Situation::TooLow);
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
pub(super) const COMMAND: CodeSet = CodeSet::in_situation(Situation::UnknownCommand);
/// A toggle bit that does not alternate.
pub(super) const TOGGLE: CodeSet = CodeSet::in_situation(Situation::RepeatedToggle);
/// A block size of 0 or above 127.
pub(super) const BLOCK_SIZE: CodeSet = CodeSet::in_situation(Situation::BlockSize);
/// A sequence number that was never sent.
pub(super) const SEQUENCE: CodeSet = CodeSet::in_situation(Situation::SequenceNumber);
/// A checksum that does not fit.
pub(super) const CRC: CodeSet = CodeSet::in_situation(Situation::WrongChecksum);
/// What may end a download in the middle of a block: the transfer itself, or what is wrong with the object.
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
