//! Values of the object dictionary: converts little-endian bytes to typed values and back (CiA 301, "data type
//! definitions and encoding rules").

use std::fmt;

use super::data_type::{DataClass, DataType};
use canvass_traces::hex;

/// A value of a data type. Numbers of all lengths share one variant; the length is in the [`DataType`], which
/// accompanies the value wherever it is encoded.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// BOOLEAN.
    Boolean(bool),
    /// INTEGER8 to INTEGER64.
    Integer(i64),
    /// UNSIGNED8 to UNSIGNED64.
    Unsigned(u64),
    /// REAL32.
    Real32(f32),
    /// REAL64.
    Real64(f64),
    /// The bytes of a VISIBLE_STRING as received; may be unprintable.
    VisibleString(Vec<u8>),
    /// OCTET_STRING.
    OctetString(Vec<u8>),
    /// The 16-bit units of a UNICODE_STRING; may be invalid UTF-16.
    UnicodeString(Vec<u16>),
    /// TIME_OF_DAY.
    TimeOfDay(DaysAndMilliseconds),
    /// TIME_DIFFERENCE.
    TimeDifference(DaysAndMilliseconds),
    /// DOMAIN.
    Domain(Vec<u8>),
}

/// TIME_OF_DAY and TIME_DIFFERENCE.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DaysAndMilliseconds {
    /// Days; for TIME_OF_DAY, since 1984-01-01.
    pub days: u16,
    /// Milliseconds, 28 bits; for TIME_OF_DAY, after midnight.
    pub milliseconds: u32,
}

/// Why bytes can't be decoded, or a value can't be encoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ValueError {
    /// The number of bytes differs from that of the data type.
    #[error("{data_type} has {expected} bytes, found {found}")]
    Length {
        /// The requested data type.
        data_type: DataType,
        /// The length of the data type in bytes.
        expected: usize,
        /// The actual length in bytes.
        found: usize,
    },
    /// A UNICODE_STRING of an odd number of bytes.
    #[error("UNICODE_STRING has units of 2 bytes, found {found} bytes")]
    OddLength {
        /// The actual length in bytes.
        found: usize,
    },
    /// A BOOLEAN byte that is neither 0 nor 1.
    #[error("BOOLEAN is 0 or 1, found {found:02X}h")]
    NotBoolean {
        /// The byte.
        found: u8,
    },
    /// A record or an unknown data type, which has no value.
    #[error("{0} has no value of its own")]
    NoValue(DataType),
    /// The value is outside the range of the data type, or of another kind.
    #[error("{value} does not fit {data_type}")]
    DoesNotFit {
        /// The value, as displayed.
        value: String,
        /// The requested data type.
        data_type: DataType,
    },
}

impl Value {
    /// Decodes a value. The four reserved bits of TIME_OF_DAY and TIME_DIFFERENCE are ignored.
    ///
    /// ```
    /// use canvass_analyzer::dictionary::{DataType, Value};
    ///
    /// assert_eq!(Value::decode(DataType::INTEGER16, &[0xFE, 0xFF])?, Value::Integer(-2));
    /// assert_eq!(Value::Integer(-2).encode(DataType::INTEGER16)?, [0xFE, 0xFF]);
    /// assert!(Value::decode(DataType::UNSIGNED32, &[1, 2]).is_err(), "expected 4 bytes");
    /// # Ok::<(), canvass_analyzer::dictionary::ValueError>(())
    /// ```
    pub fn decode(data_type: DataType, bytes: &[u8]) -> Result<Self, ValueError> {
        if let Some(expected) = data_type.bytes() {
            if bytes.len() != expected {
                return Err(ValueError::Length { data_type, expected, found: bytes.len() });
            }
            let raw = bytes.iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte));
            return match (data_type, raw) {
                (DataType::BOOLEAN, 2..) => Err(ValueError::NotBoolean { found: raw as u8 }),
                _ => Self::from_raw(data_type, raw).ok_or(ValueError::NoValue(data_type)),
            };
        }
        match data_type.class() {
            Some(DataClass::VisibleString) => Ok(Self::VisibleString(bytes.to_vec())),
            Some(DataClass::OctetString) => Ok(Self::OctetString(bytes.to_vec())),
            Some(DataClass::Domain) => Ok(Self::Domain(bytes.to_vec())),
            Some(DataClass::UnicodeString) => {
                let (units, rest) = bytes.as_chunks::<2>();
                if !rest.is_empty() {
                    return Err(ValueError::OddLength { found: bytes.len() });
                }
                Ok(Self::UnicodeString(units.iter().map(|&unit| u16::from_le_bytes(unit)).collect()))
            }
            _ => Err(ValueError::NoValue(data_type)),
        }
    }

    /// The value in the lowest bits of `raw`, as cut out of a PDO; higher bits are ignored. `None` if the type has no
    /// fixed length.
    pub fn from_raw(data_type: DataType, raw: u64) -> Option<Self> {
        let unused = 64 - data_type.bits()?;
        let unsigned = raw << unused >> unused;
        Some(match data_type.class()? {
            DataClass::Boolean => Self::Boolean(unsigned != 0),
            DataClass::Unsigned => Self::Unsigned(unsigned),
            DataClass::Integer => Self::Integer((raw << unused) as i64 >> unused),
            DataClass::Real if data_type == DataType::REAL32 => Self::Real32(f32::from_bits(raw as u32)),
            DataClass::Real => Self::Real64(f64::from_bits(raw)),
            DataClass::TimeOfDay => Self::TimeOfDay(DaysAndMilliseconds::from_raw(raw)),
            DataClass::TimeDifference => Self::TimeDifference(DaysAndMilliseconds::from_raw(raw)),
            _ => return None,
        })
    }

    /// The bits of the value as a number, for a PDO; `None` for a string or domain. Negative numbers are
    /// sign-extended to 64 bits.
    pub fn to_raw(&self) -> Option<u64> {
        Some(match self {
            Self::Boolean(value) => u64::from(*value),
            Self::Integer(value) => *value as u64,
            Self::Unsigned(value) => *value,
            Self::Real32(value) => u64::from(value.to_bits()),
            Self::Real64(value) => value.to_bits(),
            Self::TimeOfDay(time) | Self::TimeDifference(time) => time.to_raw(),
            _ => return None,
        })
    }

    /// Encodes the value in a data type, little-endian.
    pub fn encode(&self, data_type: DataType) -> Result<Vec<u8>, ValueError> {
        let does_not_fit = || ValueError::DoesNotFit { value: self.to_string(), data_type };
        match (self, data_type.class()) {
            (Self::VisibleString(bytes), Some(DataClass::VisibleString))
            | (Self::OctetString(bytes), Some(DataClass::OctetString))
            | (Self::Domain(bytes), Some(DataClass::Domain)) => Ok(bytes.clone()),
            (Self::UnicodeString(units), Some(DataClass::UnicodeString)) => {
                Ok(units.iter().flat_map(|unit| unit.to_le_bytes()).collect())
            }
            _ => {
                let raw = self.to_raw().ok_or_else(does_not_fit)?;
                let length = data_type.bytes().ok_or_else(does_not_fit)?;
                // Decoding the bits must give the same value: the same kind, and no bit lost.
                let back = Self::from_raw(data_type, raw).ok_or_else(does_not_fit)?;
                let same = std::mem::discriminant(&back) == std::mem::discriminant(self);
                if !same || back.to_raw() != Some(raw) {
                    return Err(does_not_fit());
                }
                Ok(raw.to_le_bytes().into_iter().take(length).collect())
            }
        }
    }

    /// The value as a number, if it is a boolean, signed or unsigned.
    pub fn as_number(&self) -> Option<i128> {
        match self {
            Self::Boolean(value) => Some(i128::from(*value)),
            Self::Integer(value) => Some(i128::from(*value)),
            Self::Unsigned(value) => Some(i128::from(*value)),
            _ => None,
        }
    }
}

impl DaysAndMilliseconds {
    const MILLISECONDS: u64 = 0x0FFF_FFFF;

    fn from_raw(raw: u64) -> Self {
        Self { days: (raw >> 32) as u16, milliseconds: (raw & Self::MILLISECONDS) as u32 }
    }

    pub(in crate::dictionary) fn to_raw(self) -> u64 {
        u64::from(self.days) << 32 | u64::from(self.milliseconds)
    }
}

/// Strings are quoted, with all unprintable characters escaped: control characters never reach a terminal.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean(value) => write!(f, "{value}"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Unsigned(value) => write!(f, "{value}"),
            Self::Real32(value) => write!(f, "{value}"),
            Self::Real64(value) => write!(f, "{value}"),
            Self::VisibleString(bytes) => quoted(f, bytes.iter().map(|&byte| char::from(byte))),
            Self::UnicodeString(units) => quoted(
                f,
                char::decode_utf16(units.iter().copied()).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)),
            ),
            Self::OctetString(bytes) | Self::Domain(bytes) => hex::spaced(bytes).fmt(f),
            Self::TimeOfDay(time) => write!(f, "day {} + {} ms", time.days, time.milliseconds),
            Self::TimeDifference(time) => write!(f, "{} days + {} ms", time.days, time.milliseconds),
        }
    }
}

fn quoted(f: &mut fmt::Formatter<'_>, characters: impl Iterator<Item = char>) -> fmt::Result {
    f.write_str("\"")?;
    for character in characters {
        write!(f, "{}", character.escape_debug())?;
    }
    f.write_str("\"")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decode(data_type: DataType, bytes: &[u8]) -> Value {
        Value::decode(data_type, bytes).unwrap()
    }

    #[test]
    fn values_of_the_manuals() {
        // Kübler Sendix: 1000h multi-turn, 6502h = 4096, 1008h; 2150h = 103h is 25.9 degrees.
        assert_eq!(decode(DataType::UNSIGNED32, &[0x96, 0x01, 0x02, 0x00]), Value::Unsigned(0x0002_0196));
        assert_eq!(decode(DataType::UNSIGNED16, &[0x00, 0x10]), Value::Unsigned(4096));
        assert_eq!(decode(DataType::INTEGER16, &[0x03, 0x01]), Value::Integer(259));
        assert_eq!(decode(DataType::VISIBLE_STRING, b"Kuebler").to_string(), "\"Kuebler\"");
        assert_eq!(Value::Unsigned(0x6576_6173).encode(DataType::UNSIGNED32).unwrap(), b"save");
    }

    #[test]
    fn numbers_are_sign_extended_from_their_own_length() {
        assert_eq!(decode(DataType::INTEGER24, &[0xFF, 0xFF, 0xFF]), Value::Integer(-1));
        assert_eq!(decode(DataType::INTEGER40, &[0, 0, 0, 0, 0x80]), Value::Integer(-(1 << 39)));
        assert_eq!(decode(DataType::UNSIGNED56, &[0xFF; 7]), Value::Unsigned((1 << 56) - 1));
        assert_eq!(Value::from_raw(DataType::INTEGER8, 0x1FF), Some(Value::Integer(-1)));
    }

    #[test]
    fn times_have_28_bits_of_milliseconds() {
        let time = decode(DataType::TIME_OF_DAY, &[0xFF, 0x5B, 0x26, 0xF5, 0x68, 0x3B]);
        assert_eq!(time, Value::TimeOfDay(DaysAndMilliseconds { days: 0x3B68, milliseconds: 0x0526_5BFF }));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert!(Value::Unsigned(256).encode(DataType::UNSIGNED8).is_err());
        assert!(Value::Integer(-1).encode(DataType::UNSIGNED8).is_err());
        assert!(Value::Integer(-129).encode(DataType::INTEGER8).is_err());
        assert!(Value::Unsigned(1).encode(DataType::IDENTITY).is_err());
        assert!(Value::VisibleString(vec![]).encode(DataType::UNSIGNED8).is_err());
        assert_eq!(
            Value::decode(DataType::UNSIGNED16, &[1]).unwrap_err().to_string(),
            "UNSIGNED16 has 2 bytes, found 1"
        );
        assert!(Value::decode(DataType::BOOLEAN, &[2]).is_err());
        assert!(Value::decode(DataType::UNICODE_STRING, &[2]).is_err());
        assert!(Value::decode(DataType(0xA0), &[2]).is_err());
    }

    #[test]
    fn control_characters_are_escaped() {
        let hostile = decode(DataType::VISIBLE_STRING, b"\x1B[2J\x07\x9B\"\r\n").to_string();
        assert!(!hostile.chars().any(char::is_control), "{hostile}");
        let turned = Value::UnicodeString("a\u{202E}b".encode_utf16().collect()).to_string();
        assert!(!turned.contains('\u{202E}'), "{turned}");
    }

    fn any_type() -> impl Strategy<Value = DataType> {
        proptest::sample::select(DataType::ALL)
    }

    proptest! {
        #[test]
        fn bytes_survive_the_round_trip(data_type in any_type(), bytes in prop::collection::vec(any::<u8>(), 0..32)) {
            let bytes = &bytes[..data_type.bytes().unwrap_or(bytes.len()).min(bytes.len())];
            if let Ok(value) = Value::decode(data_type, bytes) {
                let mut expected = bytes.to_vec();
                if let (DataType::TIME_OF_DAY | DataType::TIME_DIFFERENCE, Some(byte)) = (data_type, expected.get_mut(3)) {
                    *byte &= 0x0F;
                }
                prop_assert_eq!(value.encode(data_type).unwrap(), expected);
            }
        }

        #[test]
        fn numbers_survive_the_round_trip(data_type in any_type(), raw in any::<u64>()) {
            if let Some(value) = Value::from_raw(data_type, raw) {
                let bytes = value.encode(data_type).unwrap();
                let back = Value::decode(data_type, &bytes).unwrap();
                prop_assert_eq!(back.to_raw(), value.to_raw());
                prop_assert_eq!(bytes.len(), data_type.bytes().unwrap());
            }
        }

        #[test]
        fn nothing_displayed_is_a_control_character(data_type in any_type(), bytes in prop::collection::vec(any::<u8>(), 0..32)) {
            if let Ok(value) = Value::decode(data_type, &bytes) {
                prop_assert!(!value.to_string().chars().any(char::is_control));
            }
        }
    }
}
