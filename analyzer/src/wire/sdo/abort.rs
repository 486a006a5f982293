//! SDO abort: one side ends a transfer, with the reason.
//!
//! ```text
//! byte 0: 100-----  80h    bytes 1..3: multiplexer    bytes 4..7: abort code, little-endian
//! ```

use super::{emit_initiate, multiplexer};
use crate::Multiplexer;
use crate::wire::{Malformed, Wire, named};
use nom::{
    IResult, Parser,
    number::complete::{le_u32, u8},
};
use std::fmt;

/// The end of a transfer.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Abort {
    /// The object of the transfer.
    pub multiplexer: Multiplexer,
    /// The reason.
    pub code: AbortCode,
}

/// An abort code: error class, error code, additional code.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AbortCode(pub u32);

/// The abort codes of CiA 301, ascending, each with its meaning.
pub const ABORT_CODES: &[(AbortCode, &str)] = &[
    (AbortCode::TOGGLE, "toggle bit not alternated"),
    (AbortCode::TIMEOUT, "SDO protocol timed out"),
    (AbortCode::COMMAND_SPECIFIER, "command specifier not valid or unknown"),
    (AbortCode::BLOCK_SIZE, "invalid block size"),
    (AbortCode::SEQUENCE_NUMBER, "invalid sequence number"),
    (AbortCode::CRC, "CRC error"),
    (AbortCode::OUT_OF_MEMORY, "out of memory"),
    (AbortCode::UNSUPPORTED_ACCESS, "unsupported access to an object"),
    (AbortCode::WRITE_ONLY, "attempt to read a write only object"),
    (AbortCode::READ_ONLY, "attempt to write a read only object"),
    (AbortCode::NO_OBJECT, "object does not exist in the object dictionary"),
    (AbortCode::NOT_MAPPABLE, "object cannot be mapped to the PDO"),
    (AbortCode::PDO_LENGTH, "number and length of the mapped objects would exceed the PDO length"),
    (AbortCode::PARAMETER_INCOMPATIBLE, "general parameter incompatibility"),
    (AbortCode::INTERNAL_INCOMPATIBLE, "general internal incompatibility in the device"),
    (AbortCode::HARDWARE, "access failed due to a hardware error"),
    (AbortCode::LENGTH, "data type does not match, length of service parameter does not match"),
    (AbortCode::LENGTH_TOO_HIGH, "data type does not match, length of service parameter too high"),
    (AbortCode::LENGTH_TOO_LOW, "data type does not match, length of service parameter too low"),
    (AbortCode::NO_SUB_INDEX, "sub-index does not exist"),
    (AbortCode::INVALID_VALUE, "invalid value for parameter"),
    (AbortCode::VALUE_TOO_HIGH, "value of parameter written too high"),
    (AbortCode::VALUE_TOO_LOW, "value of parameter written too low"),
    (AbortCode::MAXIMUM_BELOW_MINIMUM, "maximum value is less than minimum value"),
    (AbortCode::NO_CONNECTION, "resource not available: SDO connection"),
    (AbortCode::GENERAL, "general error"),
    (AbortCode::NOT_TRANSFERRED, "data cannot be transferred or stored to the application"),
    (AbortCode::LOCAL_CONTROL, "data cannot be transferred or stored because of local control"),
    (AbortCode::DEVICE_STATE, "data cannot be transferred or stored because of the present device state"),
    (AbortCode::NO_DICTIONARY, "object dictionary dynamic generation fails or no object dictionary is present"),
    (AbortCode::NO_DATA, "no data available"),
];

/// The classes and codes of CAL (CiA DS-202), which DS-301 V3.0 still used, ascending: class, code, meaning. They are
/// the upper two bytes of an abort code; most codes of CiA 301 derive from them.
pub const CAL_ERRORS: &[(u8, u8, &str)] = &[
    (5, 3, "service error, parameter inconsistent"),
    (5, 4, "service error, illegal parameter"),
    (6, 1, "access error, object access unsupported"),
    (6, 2, "access error, object non-existent"),
    (6, 6, "access error, hardware fault"),
    (6, 7, "access error, type conflict"),
    (6, 9, "access error, object attribute inconsistent"),
    (8, 0, "other error"),
];

impl AbortCode {
    /// Toggle bit not alternated.
    pub const TOGGLE: Self = Self(0x0503_0000);
    /// SDO protocol timed out.
    pub const TIMEOUT: Self = Self(0x0504_0000);
    /// Client/server command specifier not valid or unknown.
    pub const COMMAND_SPECIFIER: Self = Self(0x0504_0001);
    /// Invalid block size (block mode).
    pub const BLOCK_SIZE: Self = Self(0x0504_0002);
    /// Invalid sequence number (block mode).
    pub const SEQUENCE_NUMBER: Self = Self(0x0504_0003);
    /// CRC error (block mode).
    pub const CRC: Self = Self(0x0504_0004);
    /// Out of memory.
    pub const OUT_OF_MEMORY: Self = Self(0x0504_0005);
    /// Unsupported access to an object.
    pub const UNSUPPORTED_ACCESS: Self = Self(0x0601_0000);
    /// Attempt to read a write only object.
    pub const WRITE_ONLY: Self = Self(0x0601_0001);
    /// Attempt to write a read only object.
    pub const READ_ONLY: Self = Self(0x0601_0002);
    /// Object does not exist in the object dictionary.
    pub const NO_OBJECT: Self = Self(0x0602_0000);
    /// Object cannot be mapped to the PDO.
    pub const NOT_MAPPABLE: Self = Self(0x0604_0041);
    /// Number and length of the mapped objects would exceed the PDO length.
    pub const PDO_LENGTH: Self = Self(0x0604_0042);
    /// General parameter incompatibility reason.
    pub const PARAMETER_INCOMPATIBLE: Self = Self(0x0604_0043);
    /// General internal incompatibility in the device.
    pub const INTERNAL_INCOMPATIBLE: Self = Self(0x0604_0047);
    /// Access failed due to a hardware error.
    pub const HARDWARE: Self = Self(0x0606_0000);
    /// Data type does not match, length of service parameter does not match.
    pub const LENGTH: Self = Self(0x0607_0010);
    /// Length of service parameter too high.
    pub const LENGTH_TOO_HIGH: Self = Self(0x0607_0012);
    /// Length of service parameter too low.
    pub const LENGTH_TOO_LOW: Self = Self(0x0607_0013);
    /// Sub-index does not exist.
    pub const NO_SUB_INDEX: Self = Self(0x0609_0011);
    /// Invalid value for parameter (download only).
    pub const INVALID_VALUE: Self = Self(0x0609_0030);
    /// Value of parameter written too high.
    pub const VALUE_TOO_HIGH: Self = Self(0x0609_0031);
    /// Value of parameter written too low.
    pub const VALUE_TOO_LOW: Self = Self(0x0609_0032);
    /// Maximum value is less than minimum value.
    pub const MAXIMUM_BELOW_MINIMUM: Self = Self(0x0609_0036);
    /// Resource not available: SDO connection.
    pub(crate) const NO_CONNECTION: Self = Self(0x060A_0023);
    /// General error.
    pub const GENERAL: Self = Self(0x0800_0000);
    /// Data cannot be transferred or stored to the application.
    pub const NOT_TRANSFERRED: Self = Self(0x0800_0020);
    /// Data cannot be transferred or stored to the application because of local control.
    pub const LOCAL_CONTROL: Self = Self(0x0800_0021);
    /// Data cannot be transferred or stored to the application because of the present device state.
    pub const DEVICE_STATE: Self = Self(0x0800_0022);
    /// Object dictionary dynamic generation fails or no object dictionary is present.
    pub(crate) const NO_DICTIONARY: Self = Self(0x0800_0023);
    /// No data available.
    pub const NO_DATA: Self = Self(0x0800_0024);

    /// The meaning of the code in CiA 301; `None` for any other code.
    pub fn name(self) -> Option<&'static str> {
        ABORT_CODES.binary_search_by_key(&self, |row| row.0).ok().map(|at| ABORT_CODES[at].1)
    }

    /// The meaning of error class (bits 31..24) and error code (bits 23..16) in CAL; `None` if CAL has none.
    ///
    /// Some devices (manual 004, 8.14 and 12.2) write class 6, code 6 as 0600 0006h: the code is in the lowest byte,
    /// and bits 23..16 are 0.
    pub fn cal_name(self) -> Option<&'static str> {
        let [class, code, _, lowest] = self.0.to_be_bytes();
        let find = |code| CAL_ERRORS.iter().find(|row| (row.0, row.1) == (class, code)).map(|row| row.2);
        find(code).or_else(|| find(lowest).filter(|_| self.0 & 0x00FF_FF00 == 0))
    }

    /// The meaning in CiA 301 or CAL, or a text that says that neither has one.
    pub fn text(self) -> &'static str {
        self.name().or_else(|| self.cal_name()).unwrap_or("unknown abort code")
    }
}

impl Wire for Abort {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        (u8, multiplexer, named("an abort code in four bytes", le_u32))
            .map(|(_, multiplexer, code)| Self { multiplexer, code: AbortCode(code) })
            .parse(input)
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        emit_initiate(0x80, self.multiplexer, self.code.0.to_le_bytes(), buffer);
        8
    }
}

impl AbortCode {
    /// The code as the standard prints it: `0601 0002h`.
    pub fn digits(self) -> impl fmt::Display {
        fmt::from_fn(move |f| write!(f, "{:04X} {:04X}h", self.0 >> 16, self.0 & 0xFFFF))
    }
}

/// Writes `0601 0002h attempt to write a read only object`.
impl fmt::Display for AbortCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ", self.digits())?;
        match (self.name(), self.cal_name()) {
            (Some(name), _) => f.write_str(name),
            (None, Some(name)) => write!(f, "{name} (CAL)"),
            (None, None) => f.write_str("unknown abort code"),
        }
    }
}

impl fmt::Debug for AbortCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "AbortCode({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::vectors::both_ways;

    /// Writing 5000h, which can only be read: Kübler manual 000, 5.8.4.
    #[test]
    fn abort_of_the_manual() {
        let abort = Abort { multiplexer: Multiplexer::new(0x5000, 0), code: AbortCode::READ_ONLY };
        both_ways(&[0x80, 0x00, 0x50, 0x00, 0x02, 0x00, 0x01, 0x06], abort);
        assert_eq!(abort.code.to_string(), "0601 0002h attempt to write a read only object");
    }

    #[test]
    fn all_codes_of_the_standard_are_known() {
        assert!(ABORT_CODES.is_sorted_by_key(|row| row.0));
        assert_eq!(ABORT_CODES.len(), 31);
        assert_eq!(AbortCode(0x0600_0006).name(), None);
    }

    /// EEPROM error and wrong signature of TR-Electronic manual 004, 12.2.
    #[test]
    fn codes_of_cal() {
        assert_eq!(AbortCode(0x0600_0006).to_string(), "0600 0006h access error, hardware fault (CAL)");
        assert_eq!(AbortCode(0x0606_0000).cal_name(), AbortCode(0x0600_0006).cal_name());
        assert_eq!(AbortCode(0x0800_0000).to_string(), "0800 0000h general error");
        assert_eq!(AbortCode(0x0609_0055).to_string(), "0609 0055h access error, object attribute inconsistent (CAL)");
        assert_eq!(AbortCode(0x0600_0106).to_string(), "0600 0106h unknown abort code");
        assert_eq!(AbortCode(0x1234_5678).to_string(), "1234 5678h unknown abort code");
        assert!(CAL_ERRORS.is_sorted());
    }
}
