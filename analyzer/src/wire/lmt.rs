//! LMT: layer management, the forerunner of LSS (CiA DS-205; master 7E5h, slave 7E4h, as LSS).
//!
//! ```text
//! byte 0: command specifier    bytes 1..7: by command; what is not used is reserved and 0
//! ```
//!
//! A slave is addressed by its manufacturer name, product name and serial number, seven bytes each, and not by the
//! four numbers of LSS. Of the command specifiers, 04h, 11h, 13h, 15h and 17h are those of LSS; all others belong
//! to one of the two only, so that the dialogue tells which it is: see [`dialect`].

use super::{Malformed, Wire, named, tail_of};
use nom::{
    IResult, Parser,
    bytes::complete::take,
    number::complete::{le_u16, u8},
};
use std::fmt;

pub use super::lss::{MASTER_CAN_ID, SLAVE_CAN_ID};

/// Which of the two protocols of 7E5h and 7E4h a message belongs to.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Dialect {
    /// Layer setting services, CiA 305.
    Lss,
    /// Layer management, CiA DS-205.
    Lmt,
}

/// The protocol that alone knows the command specifier of a payload; `None` where both know it or neither.
pub fn dialect(payload: &[u8]) -> Option<Dialect> {
    match payload.first()? {
        0x01..=0x03 | 0x05..=0x09 | 0x24..=0x26 => Some(Dialect::Lmt),
        0x40..=0x44 | 0x46..=0x4C | 0x4F..=0x51 | 0x5A..=0x5E => Some(Dialect::Lss),
        _ => None,
    }
}

/// The three parts of an LMT address.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[repr(u8)]
pub enum Part {
    /// Seven characters.
    ManufacturerName = 0,
    /// Seven characters.
    ProductName = 1,
    /// Fourteen digits, BCD.
    SerialNumber = 2,
}

/// The bounds of [`Request::IdentifyRemote`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[repr(u8)]
pub enum Bound {
    /// 05h: the manufacturer name.
    ManufacturerName = 0,
    /// 06h: the product name.
    ProductName = 1,
    /// 07h: the lowest serial number.
    SerialLow = 2,
    /// 08h: the highest serial number.
    SerialHigh = 3,
}

/// The seven bytes of a part of an LMT address.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Seven(pub [u8; 7]);

/// A message from the master.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Request {
    /// 01h to 03h: addresses one slave by the three parts of its address. It is not answered.
    SwitchSelective {
        /// Which of the three.
        part: Part,
        /// Its value.
        value: Seven,
    },
    /// 04h: switches all slaves to operation (0) or configuration (1).
    SwitchGlobal {
        /// 0 operation, 1 configuration; others are reserved.
        mode: u8,
    },
    /// 05h to 08h: asks whether there is a slave within these bounds.
    IdentifyRemote {
        /// Which bound.
        bound: Bound,
        /// Its value.
        value: Seven,
    },
    /// 11h: sets the node-ID that will be used.
    ConfigureNmtAddress {
        /// 1 to 127.
        node_id: u8,
    },
    /// 13h: sets the bit rate that will be used.
    ConfigureBitTiming {
        /// 0 is [`BIT_RATES`].
        table: u8,
        /// The row of the table.
        index: u8,
    },
    /// 15h: all slaves in configuration change to the new bit rate.
    ActivateBitTiming {
        /// The silence before and after the change, in milliseconds.
        delay: u16,
    },
    /// 17h: stores what was configured.
    StoreConfiguration,
    /// 24h to 26h: asks for a part of the LMT address.
    Inquire {
        /// Which of the three.
        part: Part,
    },
    /// Any other command specifier.
    Unknown {
        /// Byte 0.
        command: u8,
        /// The bytes after it, as far as they are there.
        tail: [u8; 7],
    },
}

/// A message from a slave.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Response {
    /// 09h: a slave is within the bounds.
    Identified,
    /// 11h, 13h or 17h: how a configuration went.
    Configured {
        /// Which of the three.
        command: ConfigureCommand,
        /// 0 success, 255 with a manufacturer-specific error; others by command.
        error: u8,
        /// The manufacturer's error where `error` is 255.
        specific: u8,
    },
    /// 24h to 26h: a part of the LMT address.
    Part {
        /// Which of the three.
        part: Part,
        /// Its value.
        value: Seven,
    },
    /// Any other command specifier.
    Unknown {
        /// Byte 0.
        command: u8,
        /// The bytes after it, as far as they are there.
        tail: [u8; 7],
    },
}

/// The commands that a slave answers with an error code.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[repr(u8)]
pub enum ConfigureCommand {
    /// Configure NMT address.
    NmtAddress = 0x11,
    /// Configure bit timing.
    BitTiming = 0x13,
    /// Store configuration.
    Store = 0x17,
}

/// The bit rates of table 0, in bit/s by index. Up to index 4 they are those of LSS; LSS has an empty row 5.
pub const BIT_RATES: [u32; 8] = [1_000_000, 800_000, 500_000, 250_000, 125_000, 50_000, 20_000, 10_000];

impl Part {
    /// All three, in their order.
    pub const ALL: [Self; 3] = [Self::ManufacturerName, Self::ProductName, Self::SerialNumber];

    /// The standard's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ManufacturerName => "manufacturer name",
            Self::ProductName => "product name",
            Self::SerialNumber => "serial number",
        }
    }
}

impl Bound {
    /// All four, in their order.
    pub const ALL: [Self; 4] = [Self::ManufacturerName, Self::ProductName, Self::SerialLow, Self::SerialHigh];

    /// The standard's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ManufacturerName => "manufacturer name",
            Self::ProductName => "product name",
            Self::SerialLow => "lowest serial number",
            Self::SerialHigh => "highest serial number",
        }
    }

    const fn is_name(self) -> bool {
        matches!(self, Self::ManufacturerName | Self::ProductName)
    }
}

impl Seven {
    /// A name, filled up with zeros; `None` if it has more than seven bytes.
    pub fn name(name: &str) -> Option<Self> {
        let mut bytes = [0; 7];
        bytes.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
        Some(Self(bytes))
    }

    fn text(self, is_name: bool) -> SevenText {
        SevenText { bytes: self.0, is_name }
    }
}

impl ConfigureCommand {
    /// The standard's name of the service.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NmtAddress => "configure NMT address",
            Self::BitTiming => "configure bit timing",
            Self::Store => "store configuration",
        }
    }

    /// What the error code means; `None` for a reserved one.
    pub const fn error_name(self, error: u8) -> Option<&'static str> {
        Some(match (self, error) {
            (_, 0) => "successful",
            (Self::BitTiming, 1) => "bit rate not supported",
            (Self::Store, 1) => "storing not supported",
            (_, 255) => "application-specific error",
            _ => return None,
        })
    }
}

impl Wire for Request {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, command) = named("an LMT command specifier", u8).parse(input)?;
        match command {
            0x01..=0x03 => {
                let part = Part::ALL[usize::from(command - 0x01)];
                seven.map(|value| Self::SwitchSelective { part, value }).parse(rest)
            }
            0x04 => named("a mode", u8).map(|mode| Self::SwitchGlobal { mode }).parse(rest),
            0x05..=0x08 => {
                let bound = Bound::ALL[usize::from(command - 0x05)];
                seven.map(|value| Self::IdentifyRemote { bound, value }).parse(rest)
            }
            0x11 => named("a node-ID", u8).map(|node_id| Self::ConfigureNmtAddress { node_id }).parse(rest),
            0x13 => (named("a table selector", u8), named("a table index", u8))
                .map(|(table, index)| Self::ConfigureBitTiming { table, index })
                .parse(rest),
            0x15 => named("a delay in two bytes", le_u16).map(|delay| Self::ActivateBitTiming { delay }).parse(rest),
            0x17 => Ok((rest, Self::StoreConfiguration)),
            0x24..=0x26 => Ok((rest, Self::Inquire { part: Part::ALL[usize::from(command - 0x24)] })),
            _ => {
                let (tail, rest) = tail_of(rest);
                Ok((rest, Self::Unknown { command, tail }))
            }
        }
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        *buffer = [0; 8];
        match *self {
            Self::SwitchSelective { part, value } => emit_seven(0x01 + part as u8, value.0, buffer),
            Self::SwitchGlobal { mode } => buffer[..2].copy_from_slice(&[0x04, mode]),
            Self::IdentifyRemote { bound, value } => emit_seven(0x05 + bound as u8, value.0, buffer),
            Self::ConfigureNmtAddress { node_id } => buffer[..2].copy_from_slice(&[0x11, node_id]),
            Self::ConfigureBitTiming { table, index } => buffer[..3].copy_from_slice(&[0x13, table, index]),
            Self::ActivateBitTiming { delay } => {
                buffer[0] = 0x15;
                buffer[1..3].copy_from_slice(&delay.to_le_bytes());
            }
            Self::StoreConfiguration => buffer[0] = 0x17,
            Self::Inquire { part } => buffer[0] = 0x24 + part as u8,
            Self::Unknown { command, tail } => emit_seven(command, tail, buffer),
        }
        8
    }
}

impl Wire for Response {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, command) = named("an LMT command specifier", u8).parse(input)?;
        let configured = |command, rest| {
            (named("an error code", u8), named("a specific error", u8))
                .map(|(error, specific)| Self::Configured { command, error, specific })
                .parse(rest)
        };
        match command {
            0x09 => Ok((rest, Self::Identified)),
            0x11 => configured(ConfigureCommand::NmtAddress, rest),
            0x13 => configured(ConfigureCommand::BitTiming, rest),
            0x17 => configured(ConfigureCommand::Store, rest),
            0x24..=0x26 => {
                let part = Part::ALL[usize::from(command - 0x24)];
                seven.map(|value| Self::Part { part, value }).parse(rest)
            }
            _ => {
                let (tail, rest) = tail_of(rest);
                Ok((rest, Self::Unknown { command, tail }))
            }
        }
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        *buffer = [0; 8];
        match *self {
            Self::Identified => buffer[0] = 0x09,
            Self::Configured { command, error, specific } => {
                buffer[..3].copy_from_slice(&[command as u8, error, specific]);
            }
            Self::Part { part, value } => emit_seven(0x24 + part as u8, value.0, buffer),
            Self::Unknown { command, tail } => emit_seven(command, tail, buffer),
        }
        8
    }
}

fn seven(input: &[u8]) -> IResult<&[u8], Seven, Malformed> {
    let (rest, taken) = named("seven bytes of an LMT address", take(7_usize)).parse(input)?;
    let mut bytes = [0; 7];
    bytes.copy_from_slice(taken);
    Ok((rest, Seven(bytes)))
}

fn emit_seven(command: u8, value: [u8; 7], buffer: &mut [u8; 8]) {
    buffer[0] = command;
    buffer[1..].copy_from_slice(&value);
}

/// Part of an LMT address in words: `"LMP30"`, or the digits of a serial number.
struct SevenText {
    bytes: [u8; 7],
    is_name: bool,
}

impl fmt::Display for SevenText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.is_name {
            return self.bytes.iter().try_for_each(|byte| write!(f, "{byte:02X}"));
        }
        let filled = self.bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
        write!(f, "\"{}\"", self.bytes[..filled].escape_ascii())
    }
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::SwitchSelective { part, value } => {
                write!(f, "switch mode selective: {} {}", part.name(), value.text(part != Part::SerialNumber))
            }
            Self::SwitchGlobal { mode: 0 } => f.write_str("switch mode global: operation"),
            Self::SwitchGlobal { mode: 1 } => f.write_str("switch mode global: configuration"),
            Self::SwitchGlobal { mode } => write!(f, "switch mode global: reserved mode {mode}"),
            Self::IdentifyRemote { bound, value } => {
                write!(f, "identify remote slave: {} {}", bound.name(), value.text(bound.is_name()))
            }
            Self::ConfigureNmtAddress { node_id } => write!(f, "configure NMT address: node-ID {node_id}"),
            Self::ConfigureBitTiming { table: 0, index } => match BIT_RATES.get(usize::from(index)) {
                Some(rate) => write!(f, "configure bit timing: {} kbit/s", rate / 1000),
                None => write!(f, "configure bit timing: reserved index {index}"),
            },
            Self::ConfigureBitTiming { table, index } => {
                write!(f, "configure bit timing: table {table}, index {index}")
            }
            Self::ActivateBitTiming { delay } => write!(f, "activate bit timing, delay {delay} ms"),
            Self::StoreConfiguration => f.write_str("store configuration"),
            Self::Inquire { part } => write!(f, "inquire {}", part.name()),
            Self::Unknown { command, .. } => write!(f, "unknown command specifier {command:02X}h"),
        }
    }
}

impl fmt::Display for Response {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Identified => f.write_str("slave identified"),
            Self::Configured { command, error, specific } => {
                match command.error_name(error) {
                    Some(name) => write!(f, "{}: {name}", command.name())?,
                    None => write!(f, "{}: reserved error {error}", command.name())?,
                }
                if error == 255 || specific != 0 { write!(f, " {specific}") } else { Ok(()) }
            }
            Self::Part { part, value } => write!(f, "{} {}", part.name(), value.text(part != Part::SerialNumber)),
            Self::Unknown { command, .. } => write!(f, "unknown command specifier {command:02X}h"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::{both_ways, stable};
    use super::*;
    use proptest::prelude::*;

    const SERIAL: Seven = Seven([0x32, 0x20, 0x00, 0x44, 0x00, 0x21, 0x00]);

    /// The names and the serial number of TR-Electronic manual 004, 4.7.5.
    #[test]
    fn address_of_the_manual() {
        let manufacturer = Seven::name("TR-ELEC").unwrap();
        let product = Seven::name("LMP30").unwrap();
        for (n, part) in (0..).zip(Part::ALL) {
            both_ways(&[0x24 + n, 0, 0, 0, 0, 0, 0, 0], Request::Inquire { part });
        }
        let answer = |part, value| Response::Part { part, value };
        both_ways(&[0x24, 0x54, 0x52, 0x2D, 0x45, 0x4C, 0x45, 0x43], answer(Part::ManufacturerName, manufacturer));
        both_ways(&[0x25, 0x4C, 0x4D, 0x50, 0x33, 0x30, 0, 0], answer(Part::ProductName, product));
        both_ways(&[0x26, 0x32, 0x20, 0, 0x44, 0, 0x21, 0], answer(Part::SerialNumber, SERIAL));
        assert_eq!(answer(Part::ProductName, product).to_string(), "product name \"LMP30\"");
        assert_eq!(answer(Part::SerialNumber, SERIAL).to_string(), "serial number 32200044002100");
        assert_eq!(Seven::name("TR-ELECTRONIC"), None);
    }

    /// The protocols of TR-Electronic manual 004, 4.7.3 to 4.7.6.
    #[test]
    fn every_command() {
        both_ways(&[0x04, 1, 0, 0, 0, 0, 0, 0], Request::SwitchGlobal { mode: 1 });
        both_ways(&[0x11, 12, 0, 0, 0, 0, 0, 0], Request::ConfigureNmtAddress { node_id: 12 });
        both_ways(&[0x13, 0, 5, 0, 0, 0, 0, 0], Request::ConfigureBitTiming { table: 0, index: 5 });
        both_ways(&[0x15, 0xE8, 0x03, 0, 0, 0, 0, 0], Request::ActivateBitTiming { delay: 1000 });
        both_ways(&[0x17, 0, 0, 0, 0, 0, 0, 0], Request::StoreConfiguration);
        for (n, part) in (0..).zip(Part::ALL) {
            both_ways(&[0x01 + n, 0x32, 0x20, 0, 0x44, 0, 0x21, 0], Request::SwitchSelective { part, value: SERIAL });
        }
        for (n, bound) in (0..).zip(Bound::ALL) {
            both_ways(&[0x05 + n, 0x32, 0x20, 0, 0x44, 0, 0x21, 0], Request::IdentifyRemote { bound, value: SERIAL });
        }
        both_ways(&[0x09, 0, 0, 0, 0, 0, 0, 0], Response::Identified);
        both_ways(&[0x99, 1, 2, 3, 4, 5, 6, 7], Response::Unknown { command: 0x99, tail: [1, 2, 3, 4, 5, 6, 7] });
        assert!(Request::read(&[0x01, 0x54, 0x52]).is_err());
    }

    #[test]
    fn errors_in_words() {
        let configured = |command, error, specific| Response::Configured { command, error, specific }.to_string();
        assert_eq!(configured(ConfigureCommand::NmtAddress, 0, 0), "configure NMT address: successful");
        assert_eq!(configured(ConfigureCommand::BitTiming, 1, 0), "configure bit timing: bit rate not supported");
        assert_eq!(configured(ConfigureCommand::Store, 2, 0), "store configuration: reserved error 2");
        assert_eq!(configured(ConfigureCommand::Store, 255, 7), "store configuration: application-specific error 7");
    }

    /// From index 5 on the table differs from that of LSS.
    #[test]
    fn bit_rates_shifted_against_lss() {
        let rate = |index| Request::ConfigureBitTiming { table: 0, index }.to_string();
        assert_eq!(rate(4), "configure bit timing: 125 kbit/s");
        assert_eq!(rate(5), "configure bit timing: 50 kbit/s");
        assert_eq!(rate(7), "configure bit timing: 10 kbit/s");
        assert_eq!(rate(8), "configure bit timing: reserved index 8");
        assert!(BIT_RATES[..5].iter().zip(super::super::lss::BIT_RATES).all(|(&lmt, lss)| Some(lmt) == lss));
    }

    #[test]
    fn names_are_escaped() {
        let hostile = Request::SwitchSelective { part: Part::ProductName, value: Seven(*b"\x1b[31m\"\x00") };
        assert_eq!(hostile.to_string(), "switch mode selective: product name \"\\x1b[31m\\\"\"");
    }

    #[test]
    fn command_specifiers_tell_the_dialect() {
        for command in 0..=255 {
            let payload = [command, 1, 1, 1, 1, 1, 1, 1];
            let known_to_lmt = !matches!(Request::read(&payload), Ok(Request::Unknown { .. }))
                || !matches!(Response::read(&payload), Ok(Response::Unknown { .. }));
            let lss = super::super::lss::Request::read(&payload);
            let known_to_lss = !matches!(lss, Ok(super::super::lss::Request::Unknown { .. }))
                || !matches!(
                    super::super::lss::Response::read(&payload),
                    Ok(super::super::lss::Response::Unknown { .. })
                );
            let expected = match (known_to_lmt, known_to_lss) {
                (true, false) => Some(Dialect::Lmt),
                (false, true) => Some(Dialect::Lss),
                _ => None,
            };
            assert_eq!(dialect(&payload), expected, "{command:02X}h");
        }
        assert_eq!(dialect(&[]), None);
    }

    proptest! {
        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<Request>(&bytes);
            stable::<Response>(&bytes);
        }
    }
}
