//! The place and the values of a difference.

use crate::PdoNumber;
use crate::dictionary::data_type::DataType;
use crate::dictionary::object::{Access, ObjectCode, Setting};
use crate::dictionary::value::Value;
use crate::identity::{CobId, Index, Multiplexer};
use crate::wire::pdo::MappingEntry;
use std::fmt;

/// The part of a description that differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// Data about the file or the device: a field of a section.
    Field(&'static str),
    /// A whole object.
    Object(Index),
    /// An entry: a sub-index of an object, or the value of an object without sub-indexes.
    Entry(Multiplexer),
    /// A PDO.
    Pdo(PdoNumber),
    /// A module of a modular device, by its number.
    Module(u16),
}

/// A value in a description.
#[derive(Clone, Debug, PartialEq)]
pub enum Fact {
    /// A text of the file; may contain any characters.
    Text(String),
    /// A number that is usually shown in decimal.
    Number(u32),
    /// A number that is usually shown in hexadecimal.
    Code(u32),
    /// 0 or 1.
    Flag(bool),
    /// A bit rate in kbit/s.
    BitRate(u16),
    /// An object code.
    ObjectCode(ObjectCode),
    /// A data type.
    DataType(DataType),
    /// An access type.
    Access(Access),
    /// A default, a limit or a configured value.
    Setting(Setting),
    /// A COB-ID, fixed or with the node-ID.
    CobId(Setting),
    /// The entries of a PDO mapping, in order.
    Mapping(Vec<MappingEntry>),
}

/// The value as the standards write it; in texts of the file all unprintable characters are escaped.
impl fmt::Display for Fact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => write!(f, "\"{}\"", text.escape_debug()),
            Self::Number(number) => write!(f, "{number}"),
            Self::Code(code) => write!(f, "{code:08X}h"),
            Self::Flag(flag) => write!(f, "{}", u8::from(*flag)),
            Self::BitRate(rate) => write!(f, "{rate} kbit/s"),
            Self::ObjectCode(code) => write!(f, "{code}"),
            Self::DataType(data_type) => write!(f, "{data_type}"),
            Self::Access(access) => write!(f, "{access}"),
            Self::CobId(Setting::Fixed(value)) => match value.to_raw().and_then(|raw| u32::try_from(raw).ok()) {
                Some(raw) => write!(f, "{}", CobId(raw)),
                None => write!(f, "{value}"),
            },
            // Large numbers, such as an identity or device type, consist of parts, which hexadecimal digits show.
            Self::Setting(Setting::Fixed(Value::Unsigned(number @ 0x1_0000..))) => write!(f, "{number} ({number:X}h)"),
            Self::Setting(setting) | Self::CobId(setting) => write!(f, "{setting}"),
            Self::Mapping(entries) if entries.is_empty() => f.write_str("nothing"),
            Self::Mapping(entries) => {
                for (position, entry) in entries.iter().enumerate() {
                    let comma = if position == 0 { "" } else { ", " };
                    write!(f, "{comma}{} ({} bits)", entry.object(), entry.bits())?;
                }
                Ok(())
            }
        }
    }
}

/// `6004h:00`, `1A00h`, `TPDO 1`, `VendorNumber`, `module 2`.
impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Field(name) => f.write_str(name),
            Self::Object(index) => write!(f, "{index}"),
            Self::Entry(at) => write!(f, "{at}"),
            Self::Pdo(PdoNumber::Transmit(number)) => write!(f, "TPDO {number}"),
            Self::Pdo(PdoNumber::Receive(number)) => write!(f, "RPDO {number}"),
            Self::Module(number) => write!(f, "module {number}"),
        }
    }
}
