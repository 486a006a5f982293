//! EMCY: a node reports an error or its end (CAN-ID 080h + node-ID unless 1014h says otherwise).
//!
//! ```text
//! bytes 0..1: error code, little-endian    byte 2: error register (1001h)    bytes 3..7: manufacturer-specific
//! ```
//!
//! Shorter messages occur in the field: the five-byte form of old profiles, and the empty form, the boot-up message
//! of devices before CiA 301 V4.

use super::{Field, Fields, Layout, Malformed, Wire};
use canvass_traces::hex;
use nom::IResult;
use std::fmt;

/// The default CAN-ID of node 0; the node-ID is added.
pub const CAN_ID_BASE: u16 = 0x080;

/// An EMCY message of 0 to 8 bytes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Emcy {
    bytes: [u8; 8],
    len: u8,
}

/// An error code of CiA 301 or of a profile. The first digits are its class.
///
/// ```
/// use canvass_analyzer::wire::Wire;
/// use canvass_analyzer::wire::emcy::{Emcy, EmcyCode};
///
/// let emcy = Emcy::read(&[0x30, 0x81, 0x11, 0, 0, 0, 0, 0]).unwrap();
/// assert_eq!(emcy.code(), Some(EmcyCode(0x8130)));
/// assert_eq!(emcy.register().unwrap().names().count(), 2, "generic and communication");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EmcyCode(pub u16);

/// The error register, object 1001h.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ErrorRegister(pub u8);

impl Emcy {
    /// A complete message.
    pub const fn new(code: EmcyCode, register: ErrorRegister, manufacturer: [u8; 5]) -> Self {
        let [low, high] = code.0.to_le_bytes();
        let [a, b, c, d, e] = manufacturer;
        Self { bytes: [low, high, register.0, a, b, c, d, e], len: 8 }
    }

    /// The error code, if there are at least two bytes.
    pub const fn code(&self) -> Option<EmcyCode> {
        if self.len >= 2 { Some(EmcyCode(u16::from_le_bytes([self.bytes[0], self.bytes[1]]))) } else { None }
    }

    /// The error register, if there are at least three bytes.
    pub const fn register(&self) -> Option<ErrorRegister> {
        if self.len >= 3 { Some(ErrorRegister(self.bytes[2])) } else { None }
    }

    /// Writes the message with another name of its code than that of CiA 301.
    ///
    /// # Errors
    /// If the formatter fails.
    pub fn write_named(&self, name: &str, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h {name}", self.code().unwrap_or(EmcyCode(0)).0)?;
        self.write_rest(f)
    }

    /// Writes the error register and the manufacturer-specific bytes.
    fn write_rest(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(register) = self.register() {
            write!(f, ", register {register}")?;
        }
        match self.manufacturer() {
            [] => Ok(()),
            bytes => write!(f, ", data {}", hex::spaced(bytes)),
        }
    }

    /// The manufacturer-specific bytes, as far as the message has them.
    pub fn manufacturer(&self) -> &[u8] {
        self.bytes.get(3..usize::from(self.len)).unwrap_or(&[])
    }

    /// Number of bytes of the message; 8 is the standard.
    pub const fn len(&self) -> usize {
        self.len as usize
    }

    /// Whether the message has no byte: the boot-up message of devices before CiA 301 V4.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }
}

impl EmcyCode {
    /// Error reset or no error.
    pub const NO_ERROR: Self = Self(0x0000);
    /// Generic error.
    pub const GENERIC: Self = Self(0x1000);
    /// Life guard error or heartbeat error.
    pub const HEARTBEAT: Self = Self(0x8130);
    /// PDO not processed due to length error.
    pub const PDO_LENGTH: Self = Self(0x8210);
    /// PDO length exceeded.
    pub const PDO_LENGTH_EXCEEDED: Self = Self(0x8220);
    /// Unexpected SYNC data length.
    pub const SYNC_LENGTH: Self = Self(0x8240);
    /// RPDO timeout.
    pub const RPDO_TIMEOUT: Self = Self(0x8250);

    /// Whether the code reports the end of an error (00xxh).
    pub const fn is_reset(self) -> bool {
        self.0 >> 8 == 0
    }

    /// The meaning of the code in CiA 301, else the meaning of its class; `None` for an unknown class.
    pub fn name(self) -> Option<&'static str> {
        let find = |code: u16| EMCY_CODES.binary_search_by_key(&code, |row| row.0).ok().map(|at| EMCY_CODES[at].1);
        // If only the class is defined, its row is xx00h: CiA 301 writes "xx" for any value.
        find(self.0).or_else(|| find(self.0 & 0xFF00)).or_else(|| find(self.0 & 0xF000))
    }

    /// The bits of the error register that CiA 301 assigns to the code's class; 0 if there is none.
    pub const fn register_bits(self) -> u8 {
        match self.0 >> 12 {
            0x2 => ErrorRegister::CURRENT.0,
            0x3 => ErrorRegister::VOLTAGE.0,
            0x4 => ErrorRegister::TEMPERATURE.0,
            0x8 if self.0 >> 8 == 0x81 || self.0 >> 8 == 0x82 => ErrorRegister::COMMUNICATION.0,
            _ => 0,
        }
    }
}

/// Error codes and classes of CiA 301 (table of emergency error codes); a class `nnxx` stands as nn00h.
pub(crate) const EMCY_CODES: &[(u16, &str)] = &[
    (0x0000, "error reset or no error"),
    (0x1000, "generic error"),
    (0x2000, "current"),
    (0x2100, "current, device input side"),
    (0x2200, "current inside the device"),
    (0x2300, "current, device output side"),
    (0x3000, "voltage"),
    (0x3100, "mains voltage"),
    (0x3200, "voltage inside the device"),
    (0x3300, "output voltage"),
    (0x4000, "temperature"),
    (0x4100, "ambient temperature"),
    (0x4200, "device temperature"),
    (0x5000, "device hardware"),
    (0x6000, "device software"),
    (0x6100, "internal software"),
    (0x6200, "user software"),
    (0x6300, "data set"),
    (0x7000, "additional modules"),
    (0x8000, "monitoring"),
    (0x8100, "communication"),
    (0x8110, "CAN overrun (objects lost)"),
    (0x8120, "CAN in error passive mode"),
    (0x8130, "life guard error or heartbeat error"),
    (0x8140, "recovered from bus off"),
    (0x8150, "CAN-ID collision"),
    (0x8200, "protocol error"),
    (0x8210, "PDO not processed due to length error"),
    (0x8220, "PDO length exceeded"),
    (0x8230, "DAM MPDO not processed, destination object not available"),
    (0x8240, "unexpected SYNC data length"),
    (0x8250, "RPDO timeout"),
    (0x9000, "external error"),
    (0xF000, "additional functions"),
    (0xFF00, "device specific"),
];

impl ErrorRegister {
    /// Bit 0: generic error, set with every other bit.
    pub const GENERIC: Self = Self(0x01);
    /// Bit 1: current.
    pub(crate) const CURRENT: Self = Self(0x02);
    /// Bit 2: voltage.
    pub(crate) const VOLTAGE: Self = Self(0x04);
    /// Bit 3: temperature.
    pub const TEMPERATURE: Self = Self(0x08);
    /// Bit 4: communication error (overrun, error state).
    pub const COMMUNICATION: Self = Self(0x10);
    /// Bit 5: device profile specific.
    pub const PROFILE: Self = Self(0x20);
    /// Bit 7: manufacturer-specific.
    pub const MANUFACTURER: Self = Self(0x80);

    /// The bits' names, bit 0 first.
    pub(crate) const BIT_NAMES: [&'static str; 8] =
        ["generic", "current", "voltage", "temperature", "communication", "device profile", "reserved", "manufacturer"];

    /// The names of the set bits.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        (0..8).filter(move |bit| self.0 >> bit & 1 != 0).map(|bit: usize| Self::BIT_NAMES[bit])
    }
}

impl Wire for Emcy {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (taken, rest) = input.split_at(input.len().min(8));
        let mut bytes = [0; 8];
        bytes[..taken.len()].copy_from_slice(taken);
        Ok((rest, Self { bytes, len: taken.len() as u8 }))
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        let len = self.len();
        buffer[..len].copy_from_slice(&self.bytes[..len]);
        len
    }
}

static EMCY: Layout = Layout {
    name: "EMCY",
    fields: &[
        Field::new("error code", 0, 0, 16),
        Field::new("error register", 2, 0, 8),
        Field::new("manufacturer-specific", 3, 0, 40),
    ],
};

impl Fields for Emcy {
    const LAYOUTS: &'static [&'static Layout] = &[&EMCY];

    fn layout(&self) -> &'static Layout {
        &EMCY
    }
}

impl fmt::Display for EmcyCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h {}", self.0, self.name().unwrap_or("unknown error code"))
    }
}

impl fmt::Debug for EmcyCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "EmcyCode({self})")
    }
}

/// Writes `09h (generic, temperature)`.
impl fmt::Display for ErrorRegister {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02X}h", self.0)?;
        for (n, name) in self.names().enumerate() {
            write!(f, "{}{name}", if n == 0 { " (" } else { ", " })?;
        }
        if self.0 != 0 { f.write_str(")") } else { Ok(()) }
    }
}

impl fmt::Debug for ErrorRegister {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ErrorRegister({self})")
    }
}

/// Writes `8130h life guard error or heartbeat error, register 11h (generic, communication), data 00 00 00 00 00`.
impl fmt::Display for Emcy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(code) = self.code() else {
            return match self.len {
                0 => f.write_str("empty (boot-up of a device before CiA 301 V4)"),
                _ => write!(f, "cut: {:02X}", self.bytes[0]),
            };
        };
        write!(f, "{code}")?;
        self.write_rest(f)
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::{both_ways, stable};
    use super::*;
    use proptest::prelude::*;

    /// Overtemperature, Kübler manual 000, 5.8.2.
    #[test]
    fn overtemperature() {
        let emcy = Emcy::new(EmcyCode(0x4200), ErrorRegister(0x09), [0x80, 0x56, 0x20, 0x50, 0x2E]);
        both_ways(&[0x00, 0x42, 0x09, 0x80, 0x56, 0x20, 0x50, 0x2E], emcy);
        assert_eq!(
            emcy.to_string(),
            "4200h device temperature, register 09h (generic, temperature), data 80 56 20 50 2E"
        );
    }

    #[test]
    fn every_length_keeps_its_bytes() {
        let bytes = [0x30, 0x81, 0x11, 1, 2, 3, 4, 5];
        for len in 0..=8 {
            let emcy = Emcy::read(&bytes[..len]).unwrap();
            both_ways(&bytes[..len], emcy);
            assert_eq!(emcy.code().is_some(), len >= 2);
            assert_eq!(emcy.register().is_some(), len >= 3);
            assert_eq!(emcy.manufacturer().len(), len.saturating_sub(3));
        }
    }

    #[test]
    fn codes_without_a_row_take_the_meaning_of_their_class() {
        assert!(EMCY_CODES.is_sorted_by_key(|row| row.0));
        assert_eq!(EmcyCode(0x8130).name(), Some("life guard error or heartbeat error"));
        assert_eq!(EmcyCode(0x8133).name(), Some("communication"));
        assert_eq!(EmcyCode(0x5051).name(), Some("device hardware"));
        assert_eq!(EmcyCode(0x2400).name(), Some("current"));
        assert_eq!(EmcyCode(0xFF01).name(), Some("device specific"));
        assert_eq!(EmcyCode(0xA000).name(), None);
    }

    proptest! {
        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<Emcy>(&bytes);
        }
    }
}
