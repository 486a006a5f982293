//! The data types of CiA 301 (table "object dictionary data types"), by their index.

use std::fmt;

/// A data type: its index in the object dictionary, 0001h to 009Fh. It can hold any number, so that a device
/// description with an unknown type can be represented.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DataType(pub u16);

/// The kind of values of a data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DataClass {
    /// `false` or `true`.
    Boolean,
    /// A two's complement number.
    Integer,
    /// A number from 0.
    Unsigned,
    /// An IEEE 754 number.
    Real,
    /// `VISIBLE_STRING`.
    VisibleString,
    /// `OCTET_STRING`.
    OctetString,
    /// `UNICODE_STRING`, units of 16 bits.
    UnicodeString,
    /// `TIME_OF_DAY`: days since 1984-01-01 and milliseconds after midnight.
    TimeOfDay,
    /// `TIME_DIFFERENCE`: days and milliseconds.
    TimeDifference,
    /// Bytes of any length, without a structure that the standard knows.
    Domain,
    /// A record: only its sub-indexes have values.
    Record,
}

macro_rules! data_types {
    ($($(#[$doc:meta])* $name:ident = $index:literal, $class:ident, $bits:expr;)*) => {
        impl DataType {
            $($(#[$doc])* pub const $name: Self = Self($index);)*

            /// Every data type that CiA 301 defines.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// The name of the data type in CiA 301; `None` if the type is unknown.
            pub const fn name(self) -> Option<&'static str> {
                match self.0 {
                    $($index => Some(stringify!($name)),)*
                    _ => None,
                }
            }

            /// The kind of values of the data type; `None` if the type is unknown.
            pub const fn class(self) -> Option<DataClass> {
                match self.0 {
                    $($index => Some(DataClass::$class),)*
                    _ => None,
                }
            }

            /// The length of a value in bits, as in a PDO mapping; `None` if it varies or the type is unknown.
            pub const fn bits(self) -> Option<u32> {
                match self.0 {
                    $($index => $bits,)*
                    _ => None,
                }
            }
        }
    };
}

data_types! {
    /// One bit; one byte in an SDO.
    BOOLEAN = 0x01, Boolean, Some(1);
    /// -128 to 127.
    INTEGER8 = 0x02, Integer, Some(8);
    /// 16 bits, signed.
    INTEGER16 = 0x03, Integer, Some(16);
    /// 32 bits, signed.
    INTEGER32 = 0x04, Integer, Some(32);
    /// 0 to 255.
    UNSIGNED8 = 0x05, Unsigned, Some(8);
    /// 16 bits.
    UNSIGNED16 = 0x06, Unsigned, Some(16);
    /// 32 bits.
    UNSIGNED32 = 0x07, Unsigned, Some(32);
    /// IEEE 754, single precision.
    REAL32 = 0x08, Real, Some(32);
    /// Characters 20h to 7Eh, without a terminating zero.
    VISIBLE_STRING = 0x09, VisibleString, None;
    /// Any bytes.
    OCTET_STRING = 0x0A, OctetString, None;
    /// Units of 16 bits.
    UNICODE_STRING = 0x0B, UnicodeString, None;
    /// 28 bits of milliseconds after midnight, 4 reserved bits, 16 bits of days since 1984-01-01.
    TIME_OF_DAY = 0x0C, TimeOfDay, Some(48);
    /// 28 bits of milliseconds, 4 reserved bits, 16 bits of days.
    TIME_DIFFERENCE = 0x0D, TimeDifference, Some(48);
    /// Application data of any length, such as a firmware image.
    DOMAIN = 0x0F, Domain, None;
    /// 24 bits, signed.
    INTEGER24 = 0x10, Integer, Some(24);
    /// IEEE 754, double precision.
    REAL64 = 0x11, Real, Some(64);
    /// 40 bits, signed.
    INTEGER40 = 0x12, Integer, Some(40);
    /// 48 bits, signed.
    INTEGER48 = 0x13, Integer, Some(48);
    /// 56 bits, signed.
    INTEGER56 = 0x14, Integer, Some(56);
    /// 64 bits, signed.
    INTEGER64 = 0x15, Integer, Some(64);
    /// 24 bits.
    UNSIGNED24 = 0x16, Unsigned, Some(24);
    /// 40 bits.
    UNSIGNED40 = 0x18, Unsigned, Some(40);
    /// 48 bits.
    UNSIGNED48 = 0x19, Unsigned, Some(48);
    /// 56 bits.
    UNSIGNED56 = 0x1A, Unsigned, Some(56);
    /// 64 bits.
    UNSIGNED64 = 0x1B, Unsigned, Some(64);
    /// The record at 1400h.. and 1800h..
    PDO_COMMUNICATION_PARAMETER = 0x20, Record, None;
    /// The record at 1600h.. and 1A00h..
    PDO_MAPPING = 0x21, Record, None;
    /// The record at 1200h.. and 1280h..
    SDO_PARAMETER = 0x22, Record, None;
    /// The record at 1018h.
    IDENTITY = 0x23, Record, None;
    /// The record at 1024h.., reserved in later versions.
    OS_DEBUG = 0x24, Record, None;
    /// The record at 1023h, reserved in later versions.
    OS_COMMAND = 0x25, Record, None;
}

impl DataType {
    /// The length of a value in bytes, as in an SDO (a boolean takes one); `None` if it varies or is unknown.
    pub const fn bytes(self) -> Option<usize> {
        match self.bits() {
            Some(bits) => Some(bits.div_ceil(8) as usize),
            None => None,
        }
    }

    /// The signed type of the same length, for an unsigned type; other types are as they are.
    pub const fn signed(self) -> Self {
        match self {
            Self::UNSIGNED8 => Self::INTEGER8,
            Self::UNSIGNED16 => Self::INTEGER16,
            Self::UNSIGNED24 => Self::INTEGER24,
            Self::UNSIGNED32 => Self::INTEGER32,
            Self::UNSIGNED40 => Self::INTEGER40,
            Self::UNSIGNED48 => Self::INTEGER48,
            Self::UNSIGNED56 => Self::INTEGER56,
            Self::UNSIGNED64 => Self::INTEGER64,
            other => other,
        }
    }
}

/// `UNSIGNED32`, or `data type 00A0h` if CiA 301 has no name.
impl fmt::Display for DataType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "data type {:04X}h", self.0),
        }
    }
}

impl fmt::Debug for DataType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DataType({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indexes_are_those_of_cia_301() {
        assert_eq!((DataType::UNSIGNED32.0, DataType::DOMAIN.0, DataType::UNSIGNED64.0), (0x07, 0x0F, 0x1B));
        assert_eq!((DataType(0x17).name(), DataType(0x0E).name()), (None, None), "17h and 0Eh are reserved");
        assert_eq!(DataType::ALL.len(), 31);
    }

    #[test]
    fn signed_types_have_the_same_length() {
        for &data_type in DataType::ALL {
            let signed = data_type.signed();
            assert_eq!(signed.bits(), data_type.bits());
            assert_ne!(signed.class(), Some(DataClass::Unsigned), "{data_type}");
        }
        assert_eq!(DataType::REAL32.signed(), DataType::REAL32);
    }

    #[test]
    fn lengths_follow_from_the_names() {
        for &data_type in DataType::ALL {
            let name = data_type.to_string();
            let digits: String = name.chars().filter(char::is_ascii_digit).collect();
            if let Ok(bits) = digits.parse::<u32>() {
                assert_eq!(data_type.bits(), Some(bits), "{name}");
                assert_eq!(data_type.bytes(), Some(bits as usize / 8), "{name}");
            }
        }
        assert_eq!((DataType::BOOLEAN.bits(), DataType::BOOLEAN.bytes()), (Some(1), Some(1)));
        assert_eq!(DataType::TIME_OF_DAY.bytes(), Some(6));
        assert_eq!(DataType(0xA0).to_string(), "data type 00A0h");
    }
}
