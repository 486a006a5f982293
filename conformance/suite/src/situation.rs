//! The answers that CiA 301 allows in each situation: one table for the cases and the fuzzer's oracle.
//!
//! A situation is a request in terms of the standard: a write to a read-only object, a repeated toggle bit. For each
//! situation the table gives the answers that pass, the answers that only CiA's own test tool accepts, the clause of
//! the standard, and how binding that clause is.

use crate::clause::{Clause, Confidence, Level};
use canvass_analyzer::wire::sdo::AbortCode as Code;
use canvass_bus::observation::Observation;

/// The allowed answers in a situation.
#[derive(Clone, Copy, Debug)]
pub struct Answers {
    /// The row's name, for `canvass explain`.
    pub id: &'static str,
    /// The required answer in a few words: `a write to a read-only object is refused`.
    pub requirement: &'static str,
    /// The clause of the standard.
    pub clause: Clause,
    /// Whether the standard requires the answer, recommends it, or leaves it open.
    pub level: Level,
    /// The abort codes that pass, the best one first.
    pub aborts: &'static [Code],
    /// Whether any abort code passes: the standard asks for a refusal and names no code for all devices.
    pub any_abort: bool,
    /// Whether silence passes.
    pub silence: bool,
    /// Whether a confirmation passes.
    pub confirmation: bool,
    /// The abort codes that only CiA's test tool accepts.
    pub tolerated: &'static [Code],
}

/// The result of comparing an answer with the allowed ones.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Judgement {
    /// The standard allows the answer.
    Allowed,
    /// Only CiA's test tool accepts the answer.
    Tolerated,
    /// Neither the standard nor CiA's test tool accepts the answer.
    Wrong,
}

macro_rules! situations {
    ($($(#[doc = $doc:literal])+ $name:ident = $id:literal, $section:literal, $level:ident: $($key:ident $value:tt),+;)+) => {
        /// A row of the table.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub enum Situation {
            $($(#[doc = $doc])+ $name,)+
        }

        impl Situation {
            /// All rows.
            pub const ALL: &'static [Self] = &[$(Self::$name),+];

            /// The allowed answers of the row.
            pub const fn answers(self) -> &'static Answers {
                match self {
                    $(Self::$name => const {
                        let mut row = Answers::row($id, concat!($($doc),+), $section, Level::$level);
                        $(situations!(@set row $key $value);)+
                        &{ row }
                    },)+
                }
            }
        }
    };
    (@set $row:ident aborts [$($code:ident),*]) => { $row.aborts = &[$(Code::$code),*] };
    (@set $row:ident tolerated [$($code:ident),*]) => { $row.tolerated = &[$(Code::$code),*] };
    (@set $row:ident any_abort $value:tt) => { $row.any_abort = $value };
    (@set $row:ident silence $value:tt) => { $row.silence = $value };
    (@set $row:ident confirmation $value:tt) => { $row.confirmation = $value };
}

situations! {
    /// An object that does not exist is refused
    MissingObject = "missing-object", "7.2.4.3.17", Must: aborts [NO_OBJECT], tolerated [GENERAL];
    /// A sub-index that does not exist is refused
    MissingEntry = "missing-entry", "7.2.4.3.17", Must: aborts [NO_SUB_INDEX], tolerated [GENERAL];
    /// Writing a read-only object is refused
    ReadOnly = "read-only", "7.2.4.3.17", Must: aborts [READ_ONLY], tolerated [UNSUPPORTED_ACCESS, GENERAL];
    /// Reading a write-only object is refused
    WriteOnly = "write-only", "7.2.4.3.17", Must: aborts [WRITE_ONLY], tolerated [UNSUPPORTED_ACCESS, GENERAL];
    /// More bytes than the object has are refused
    TooLong = "too-long", "7.2.4.3.17", Must: aborts [LENGTH_TOO_HIGH, LENGTH], tolerated [GENERAL];
    /// Fewer bytes than the object has are refused
    TooShort = "too-short", "7.2.4.3.17", Must: aborts [LENGTH_TOO_LOW, LENGTH], tolerated [GENERAL];
    /// A value above the limit of the description is refused
    TooHigh = "too-high", "7.2.4.3.17", Must: aborts [VALUE_TOO_HIGH, INVALID_VALUE], tolerated [GENERAL];
    /// A value below the limit of the description is refused
    TooLow = "too-low", "7.2.4.3.17", Must: aborts [VALUE_TOO_LOW, INVALID_VALUE], tolerated [GENERAL];
    /// A value that the object can't have is refused
    InvalidValue = "invalid-value", "7.2.4.3.17", Must:
        aborts [INVALID_VALUE, VALUE_TOO_HIGH, VALUE_TOO_LOW], tolerated [GENERAL];
    /// A maximum below the minimum is refused
    MaximumBelowMinimum = "maximum-below-minimum", "7.2.4.3.17", Must:
        aborts [MAXIMUM_BELOW_MINIMUM, INVALID_VALUE, VALUE_TOO_HIGH, VALUE_TOO_LOW, PARAMETER_INCOMPATIBLE],
        tolerated [GENERAL];
    /// A command specifier that does not exist, or is not allowed in the state of the server, is refused
    UnknownCommand = "unknown-command", "7.2.4.3.17", Should: aborts [COMMAND_SPECIFIER];
    /// A segment whose toggle bit does not alternate is ignored, and the transfer may be aborted
    RepeatedToggle = "repeated-toggle", "7.2.4.3.2", Must: aborts [TOGGLE], silence true;
    /// A block size of 0 or above 127 is refused
    BlockSize = "block-size", "7.2.4.3.17", Should: aborts [BLOCK_SIZE], tolerated [COMMAND_SPECIFIER];
    /// A sequence number that was never sent is refused
    SequenceNumber = "sequence-number", "7.2.4.3.17", Should: aborts [SEQUENCE_NUMBER], tolerated [COMMAND_SPECIFIER];
    /// A block download whose checksum is wrong is refused
    WrongChecksum = "wrong-checksum", "7.2.4.3.8", Must: aborts [CRC];
    /// A block download whose checksum is wrong and that has too few bytes is refused for either reason
    WrongChecksumAndTooShort = "wrong-checksum-and-too-short", "7.2.4.3.17", Must:
        aborts [CRC, LENGTH_TOO_LOW, LENGTH];
    /// A block download whose checksum is wrong and that has too many bytes is refused for either reason
    WrongChecksumAndTooLong = "wrong-checksum-and-too-long", "7.2.4.3.17", Must:
        aborts [CRC, LENGTH_TOO_HIGH, LENGTH];
    /// Writing a read-only object with too few bytes is refused for either reason
    ReadOnlyAndTooShort = "read-only-and-too-short", "7.2.4.3.17", Must:
        aborts [READ_ONLY, LENGTH_TOO_LOW, LENGTH], tolerated [UNSUPPORTED_ACCESS, GENERAL];
    /// Writing a sub-index that a read-only object does not have is refused for either reason, or for its length
    MissingEntryOfReadOnly = "missing-entry-of-read-only", "7.2.4.3.17", Must:
        aborts [NO_SUB_INDEX, READ_ONLY, LENGTH_TOO_LOW, LENGTH], tolerated [UNSUPPORTED_ACCESS, GENERAL];
    /// A store or restore command without its signature is refused
    WrongSignature = "wrong-signature", "7.5.2.13", Must:
        aborts [NOT_TRANSFERRED, INVALID_VALUE, GENERAL, LOCAL_CONTROL, DEVICE_STATE];
    /// A device that does not store parameters on command refuses the command
    StoreUnsupported = "store-unsupported", "7.5.2.13", Must: any_abort true;
    /// The device stores parameters in operational too, or refuses the command because of its state
    StoreInOperational = "store-in-operational", "7.3.2.2.3", Should:
        aborts [DEVICE_STATE, LOCAL_CONTROL, NOT_TRANSFERRED, GENERAL], confirmation true;
    /// Reading 1003h:01 while the history is empty is refused
    EmptyHistory = "empty-history", "7.5.2.4", Must: aborts [NO_DATA, GENERAL], tolerated [NO_SUB_INDEX];
    /// Writing anything but 0 to 1003h:00 is refused
    HistoryNotZero = "history-not-zero", "7.5.2.4", Must:
        aborts [INVALID_VALUE], tolerated [VALUE_TOO_HIGH, GENERAL];
    /// Changing 1019h while SYNC has a period is refused
    OverflowWhilePeriod = "overflow-while-period", "7.5.2.22", Must: aborts [DEVICE_STATE, GENERAL];
    /// Setting bit 30 of 1005h is refused by a device that can't produce SYNC
    SyncNotProduced = "sync-not-produced", "7.5.2.5", Must: aborts [INVALID_VALUE], tolerated [GENERAL];
    /// Bits 0 to 29 of a COB-ID in use do not change
    ValidCobIdChanged = "valid-cob-id-changed", "7.5.2.37", Must: any_abort true;
    /// A parameter of a valid PDO does not change
    ValidPdoChanged = "valid-pdo-changed", "7.5.2.37", Must: any_abort true;
    /// A mapping in use does not change
    MappingInUseChanged = "mapping-in-use-changed", "7.5.2.38", Must: any_abort true;
    /// A restricted CAN-ID is refused
    RestrictedCanId = "restricted-can-id", "7.3.5", Must: any_abort true;
    /// A transmission type that is reserved or not supported is refused
    TransmissionType = "transmission-type", "7.5.2.37", Must:
        aborts [INVALID_VALUE, VALUE_TOO_HIGH, VALUE_TOO_LOW], tolerated [GENERAL];
    /// Sub-index 4 of a PDO communication parameter is reserved
    ReservedEntry = "reserved-entry", "7.5.2.37", Must: aborts [NO_SUB_INDEX], tolerated [GENERAL];
    /// Mapping an object that can't be mapped is refused when the entry is written
    Unmappable = "unmappable", "7.5.2.38", Must: aborts [NO_OBJECT, NOT_MAPPABLE], tolerated [GENERAL];
    /// Enabling a mapping that is wrong or too long is refused
    MappingRefused = "mapping-refused", "7.5.2.38", Must:
        aborts [NO_OBJECT, PDO_LENGTH], tolerated [NOT_MAPPABLE, GENERAL];
    /// A mapping entry with an unsupported object or length is refused
    UnsupportedMapping = "unsupported-mapping", "7.5.2.38", Must: any_abort true;
    /// Mapping a sub-index that does not exist is refused
    UnmappableEntry = "unmappable-entry", "7.5.2.38", Must:
        aborts [NO_OBJECT, NOT_MAPPABLE], tolerated [NO_SUB_INDEX, GENERAL];
    /// Mapping an object into a PDO of the other direction is refused
    WrongDirection = "wrong-direction", "7.5.1", Must:
        aborts [NOT_MAPPABLE, NO_OBJECT], tolerated [READ_ONLY, WRITE_ONLY, GENERAL];
    /// A mapping entry that makes the mapping longer than a PDO is refused
    MappingEntryTooLong = "mapping-entry-too-long", "7.5.2.38", Must:
        aborts [PDO_LENGTH, NOT_MAPPABLE, NO_OBJECT], tolerated [GENERAL];
    /// A reserved number of mapped objects is refused
    MappingCount = "mapping-count", "7.5.2.38", Must:
        aborts [PDO_LENGTH, NO_OBJECT, INVALID_VALUE, VALUE_TOO_HIGH],
        tolerated [NOT_MAPPABLE, UNSUPPORTED_ACCESS, GENERAL];
    /// A second consumer entry for the same node is refused
    DuplicateConsumer = "duplicate-consumer", "7.5.2.19", Must: aborts [PARAMETER_INCOMPATIBLE], tolerated [GENERAL];
    /// A correct request is confirmed
    Confirmed = "confirmed", "7.2.4.3", Must: confirmation true;
    /// A message that needs no answer is not answered
    Unanswered = "unanswered", "7.2.4.3", Must: silence true;
}

impl Answers {
    const fn row(id: &'static str, requirement: &'static str, section: &'static str, level: Level) -> Self {
        let clause = Clause { standard: "CiA 301", section: Some(section), confidence: Confidence::Cited };
        Self {
            id,
            requirement,
            clause,
            level,
            aborts: &[],
            any_abort: false,
            silence: false,
            confirmation: false,
            tolerated: &[],
        }
    }
}

impl Situation {
    /// The row with this name.
    pub fn by_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|row| row.id() == id)
    }

    /// The name of the row.
    pub const fn id(self) -> &'static str {
        self.answers().id
    }

    /// The required answer in a few words.
    pub fn requirement(self) -> &'static str {
        self.answers().requirement.trim()
    }

    /// The answers that pass, the best one first. If any abort passes, one observation stands for all codes.
    pub fn allowed(self) -> Vec<Observation> {
        let answers = self.answers();
        let aborts = answers.aborts.iter().copied().map(Observation::Abort);
        let any = answers.any_abort.then_some(Observation::named("any abort"));
        let silence = answers.silence.then_some(Observation::Silence);
        let confirmation = answers.confirmation.then_some(Observation::Confirmation);
        aborts.chain(any).chain(silence).chain(confirmation).collect()
    }

    /// Whether an answer is allowed in this situation.
    pub fn judge(self, answer: &Observation) -> Judgement {
        let answers = self.answers();
        let allowed = match answer {
            Observation::Abort(code) => answers.any_abort || answers.aborts.contains(code),
            Observation::Silence => answers.silence,
            Observation::Confirmation => answers.confirmation,
            _ => false,
        };
        match answer {
            _ if allowed => Judgement::Allowed,
            Observation::Abort(code) if answers.tolerated.contains(code) => Judgement::Tolerated,
            _ => Judgement::Wrong,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_row_has_a_name_of_its_own_and_allows_something() {
        let ids: BTreeSet<&str> = Situation::ALL.iter().map(|situation| situation.id()).collect();
        assert_eq!(ids.len(), Situation::ALL.len());
        for situation in Situation::ALL {
            assert!(!situation.allowed().is_empty(), "{situation:?}");
            let answers = situation.answers();
            assert!(answers.tolerated.iter().all(|code| !answers.aborts.contains(code)), "{situation:?}");
        }
    }

    /// If CiA 301 or a corrigendum names several codes, or none, all codes that it allows pass.
    #[test]
    fn all_codes_pass_that_the_text_allows() {
        let rows: [(Situation, &[Code]); 12] = [
            (Situation::ValidCobIdChanged, &[Code::INVALID_VALUE, Code::GENERAL, Code::DEVICE_STATE]),
            (Situation::ValidPdoChanged, &[Code::INVALID_VALUE, Code::UNSUPPORTED_ACCESS]),
            (Situation::RestrictedCanId, &[Code::INVALID_VALUE, Code::GENERAL]),
            (Situation::OverflowWhilePeriod, &[Code::DEVICE_STATE, Code::GENERAL]),
            (Situation::Unmappable, &[Code::NO_OBJECT, Code::NOT_MAPPABLE]),
            (Situation::UnmappableEntry, &[Code::NO_OBJECT, Code::NOT_MAPPABLE]),
            (Situation::WrongDirection, &[Code::NO_OBJECT, Code::NOT_MAPPABLE]),
            (Situation::MappingRefused, &[Code::NO_OBJECT, Code::PDO_LENGTH]),
            (Situation::MappingCount, &[Code::NO_OBJECT, Code::PDO_LENGTH, Code::VALUE_TOO_HIGH]),
            (Situation::UnsupportedMapping, &[Code::NOT_MAPPABLE, Code::PDO_LENGTH, Code::INVALID_VALUE]),
            (Situation::InvalidValue, &[Code::INVALID_VALUE, Code::VALUE_TOO_HIGH, Code::VALUE_TOO_LOW]),
            (Situation::ReservedEntry, &[Code::NO_SUB_INDEX]),
        ];
        for (situation, codes) in rows {
            for &code in codes {
                assert_eq!(situation.judge(&Observation::Abort(code)), Judgement::Allowed, "{situation:?} {code}");
            }
            assert_eq!(situation.judge(&Observation::Confirmation), Judgement::Wrong, "{situation:?}");
        }
    }

    #[test]
    fn answers_are_allowed_tolerated_or_wrong() {
        let judge = |situation: Situation, answer: Observation| situation.judge(&answer);
        assert_eq!(judge(Situation::RepeatedToggle, Observation::Silence), Judgement::Allowed);
        assert_eq!(judge(Situation::MissingObject, Observation::Abort(Code::GENERAL)), Judgement::Tolerated);
        assert_eq!(judge(Situation::MissingObject, Observation::Silence), Judgement::Wrong);
        assert_eq!(judge(Situation::ValidCobIdChanged, Observation::Abort(Code(1))), Judgement::Allowed);
        assert_eq!(judge(Situation::ValidCobIdChanged, Observation::Confirmation), Judgement::Wrong);
    }
}
