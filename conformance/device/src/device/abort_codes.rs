//! Abort codes of firmware: a fault replaces the right code by a wrong one, and a liberty replaces it by another code
//! that the standard allows for the same reason.

use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::wire::sdo::AbortCode;

impl Firmware {
    /// The code that the firmware sends where the standard demands `code`.
    pub(super) fn abort_code(&self, code: AbortCode) -> AbortCode {
        let wrong = match code {
            AbortCode::LENGTH | AbortCode::LENGTH_TOO_HIGH | AbortCode::LENGTH_TOO_LOW => {
                (Fault::SdoLengthWrongCode, AbortCode::INVALID_VALUE)
            }
            AbortCode::VALUE_TOO_HIGH | AbortCode::VALUE_TOO_LOW => (Fault::SdoRangeWrongCode, AbortCode::READ_ONLY),
            AbortCode::MAXIMUM_BELOW_MINIMUM => (Fault::LimitsSwappedWrongCode, AbortCode::READ_ONLY),
            AbortCode::TOGGLE => (Fault::SdoToggleWrongCode, AbortCode::COMMAND_SPECIFIER),
            AbortCode::COMMAND_SPECIFIER => (Fault::SdoCommandWrongCode, AbortCode::GENERAL),
            AbortCode::CRC => (Fault::SdoBlockCrcWrongCode, AbortCode::GENERAL),
            AbortCode::BLOCK_SIZE => (Fault::SdoBlockSizeWrongCode, AbortCode::INVALID_VALUE),
            AbortCode::WRITE_ONLY => (Fault::SdoWriteOnlyWrongCode, AbortCode::NO_OBJECT),
            AbortCode::NO_SUB_INDEX => (Fault::SdoUnknownAbortCode, AbortCode(0x0A00_0001)),
            code => return self.free_code(code),
        };
        if self.has(wrong.0) { wrong.1 } else { self.free_code(code) }
    }

    /// The code for an object, or a sub-index, that does not exist.
    pub(super) const fn missing_code(&self, code: AbortCode) -> AbortCode {
        match code {
            AbortCode::NO_OBJECT if self.has(Fault::SdoWrongCodeForNoObject) => AbortCode::NO_SUB_INDEX,
            AbortCode::NO_SUB_INDEX if self.has(Fault::SdoWrongCodeForNoSubIndex) => AbortCode::NO_OBJECT,
            code => code,
        }
    }

    /// The code for writing a read-only entry.
    pub(super) const fn read_only_code(&self) -> AbortCode {
        if self.has(Fault::SdoReadOnlyWrongCode) { AbortCode::DEVICE_STATE } else { AbortCode::READ_ONLY }
    }

    /// The code that the firmware's liberties choose in place of `code`; both codes are correct.
    const fn free_code(&self, code: AbortCode) -> AbortCode {
        match code {
            AbortCode::LENGTH_TOO_HIGH | AbortCode::LENGTH_TOO_LOW if self.takes(Liberty::LengthCodeGeneral) => {
                AbortCode::LENGTH
            }
            AbortCode::VALUE_TOO_HIGH | AbortCode::VALUE_TOO_LOW if self.takes(Liberty::RangeCodeGeneral) => {
                AbortCode::INVALID_VALUE
            }
            code => code,
        }
    }

    /// The code for a value above a service's limit.
    pub(super) const fn limit_code(&self) -> AbortCode {
        if self.takes(Liberty::LimitCodePrecise) { AbortCode::VALUE_TOO_HIGH } else { AbortCode::INVALID_VALUE }
    }

    /// The code for an object that can't be mapped.
    pub(super) const fn entry_code(&self, code: AbortCode) -> AbortCode {
        match code {
            AbortCode::NOT_MAPPABLE if self.takes(Liberty::EntryCodeMissing) => AbortCode::NO_OBJECT,
            AbortCode::NO_OBJECT if self.takes(Liberty::EntryCodeUnmappable) => AbortCode::NOT_MAPPABLE,
            code => code,
        }
    }

    /// The code for an impossible number of mapped objects.
    pub(super) const fn count_code(&self, code: AbortCode) -> AbortCode {
        match code {
            AbortCode::PDO_LENGTH if self.takes(Liberty::CountCodeMissing) => AbortCode::NO_OBJECT,
            code => code,
        }
    }

    /// The code for changing the CAN-ID of a valid COB-ID.
    pub(super) const fn cob_id_code(&self, code: AbortCode) -> AbortCode {
        match () {
            () if self.takes(Liberty::CobIdCodeGeneral) => AbortCode::GENERAL,
            () if self.takes(Liberty::CobIdCodeState) => AbortCode::DEVICE_STATE,
            () => code,
        }
    }
}
