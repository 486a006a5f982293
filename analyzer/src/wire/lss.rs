//! LSS: node-ID and bit rate over the bus (CiA 305; master 7E5h, slave 7E4h).
//!
//! ```text
//! byte 0: command specifier    bytes 1..7: by command; what is not used is reserved and 0
//! ```

use super::{Malformed, Wire, named, tail_of};
use nom::{
    IResult, Parser,
    number::complete::{le_u16, le_u32, u8},
};
use std::fmt;

/// The CAN-ID from master to slaves.
pub const MASTER_CAN_ID: u16 = 0x7E5;
/// The CAN-ID from slaves to the master.
pub const SLAVE_CAN_ID: u16 = 0x7E4;

/// The four parts of an LSS address, which are 1018h:1 to 4.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[repr(u8)]
pub enum Part {
    /// 1018h:1.
    VendorId = 0,
    /// 1018h:2.
    ProductCode = 1,
    /// 1018h:3.
    RevisionNumber = 2,
    /// 1018h:4.
    SerialNumber = 3,
}

/// The bounds of [`Request::IdentifyRemote`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[repr(u8)]
pub enum Bound {
    /// 46h: the vendor-ID.
    VendorId = 0,
    /// 47h: the product code.
    ProductCode = 1,
    /// 48h: the lowest revision number.
    RevisionLow = 2,
    /// 49h: the highest revision number.
    RevisionHigh = 3,
    /// 4Ah: the lowest serial number.
    SerialLow = 4,
    /// 4Bh: the highest serial number.
    SerialHigh = 5,
}

/// A message from the master.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Request {
    /// 04h: switches all slaves to waiting (0) or configuration (1).
    SwitchGlobal {
        /// 0 waiting, 1 configuration; others are reserved.
        mode: u8,
    },
    /// 11h: sets the node-ID that will be used.
    ConfigureNodeId {
        /// 1 to 127, or 255 for "not configured".
        node_id: u8,
    },
    /// 13h: sets the bit rate that will be used.
    ConfigureBitTiming {
        /// 0 is the table of CiA 301, 128 to 255 are the manufacturer's.
        table: u8,
        /// The row of the table.
        index: u8,
    },
    /// 15h: all slaves change to the new bit rate.
    ActivateBitTiming {
        /// The silence before and after the change, in milliseconds.
        delay: u16,
    },
    /// 17h: stores what was configured.
    StoreConfiguration,
    /// 40h to 43h: addresses one slave by its four numbers.
    SwitchSelective {
        /// Which of the four.
        part: Part,
        /// Its value.
        value: u32,
    },
    /// 46h to 4Bh: asks whether there is a slave within these bounds.
    IdentifyRemote {
        /// Which bound.
        bound: Bound,
        /// Its value.
        value: u32,
    },
    /// 4Ch: asks whether there is a slave without node-ID.
    IdentifyNonConfigured,
    /// 51h: finds a slave without node-ID by halving.
    Fastscan {
        /// The bits found so far.
        id: u32,
        /// The lowest bit that is compared, 31 to 0; 128 begins anew.
        bit_check: u8,
        /// The part that is being compared, 0 to 3.
        sub: u8,
        /// The part that is compared next, 0 to 3.
        next: u8,
    },
    /// 5Ah to 5Dh: asks for a part of the LSS address.
    Inquire {
        /// Which of the four.
        part: Part,
    },
    /// 5Eh: asks for the node-ID.
    InquireNodeId,
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
    /// 11h, 13h or 17h: how a configuration went.
    Configured {
        /// Which of the three.
        command: ConfigureCommand,
        /// 0 success, 255 with a manufacturer-specific error; others by command.
        error: u8,
        /// The manufacturer's error where `error` is 255.
        specific: u8,
    },
    /// 44h: the slave that was addressed is in configuration state.
    Switched,
    /// 4Fh: a slave is within the bounds, or fits the Fastscan.
    Identified,
    /// 50h: there is a slave without node-ID.
    NonConfigured,
    /// 5Ah to 5Dh: a part of the LSS address.
    Part {
        /// Which of the four.
        part: Part,
        /// Its value.
        value: u32,
    },
    /// 5Eh: the node-ID, 255 if there is none.
    NodeId(u8),
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
    /// Configure node-ID.
    NodeId = 0x11,
    /// Configure bit timing.
    BitTiming = 0x13,
    /// Store configuration.
    Store = 0x17,
}

impl Part {
    /// All four, in their order.
    pub const ALL: [Self; 4] = [Self::VendorId, Self::ProductCode, Self::RevisionNumber, Self::SerialNumber];

    /// The standard's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::VendorId => "vendor-ID",
            Self::ProductCode => "product code",
            Self::RevisionNumber => "revision number",
            Self::SerialNumber => "serial number",
        }
    }
}

impl Bound {
    /// All six, in their order.
    pub const ALL: [Self; 6] =
        [Self::VendorId, Self::ProductCode, Self::RevisionLow, Self::RevisionHigh, Self::SerialLow, Self::SerialHigh];

    /// The standard's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::VendorId => "vendor-ID",
            Self::ProductCode => "product code",
            Self::RevisionLow => "lowest revision number",
            Self::RevisionHigh => "highest revision number",
            Self::SerialLow => "lowest serial number",
            Self::SerialHigh => "highest serial number",
        }
    }
}

impl ConfigureCommand {
    /// What the error code means; `None` for a reserved one.
    pub const fn error_name(self, error: u8) -> Option<&'static str> {
        Some(match (self, error) {
            (_, 0) => "successful",
            (Self::NodeId, 1) => "node-ID out of range",
            (Self::BitTiming, 1) => "bit rate not supported",
            (Self::Store, 1) => "storing not supported",
            (Self::Store, 2) => "storage media access error",
            (_, 255) => "manufacturer-specific error",
            _ => return None,
        })
    }
}

/// The bit rates of table 0, in bit/s by index (CiA 305); index 5 is reserved, index 9 is automatic detection.
pub const BIT_RATES: [Option<u32>; 9] = [
    Some(1_000_000),
    Some(800_000),
    Some(500_000),
    Some(250_000),
    Some(125_000),
    None,
    Some(50_000),
    Some(20_000),
    Some(10_000),
];

impl Wire for Request {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, command) = named("an LSS command specifier", u8).parse(input)?;
        let value = |rest| named("a value in four bytes", le_u32).parse(rest);
        let (rest, message) = match command {
            0x04 => named("a mode", u8).map(|mode| Self::SwitchGlobal { mode }).parse(rest)?,
            0x11 => named("a node-ID", u8).map(|node_id| Self::ConfigureNodeId { node_id }).parse(rest)?,
            0x13 => (named("a table selector", u8), named("a table index", u8))
                .map(|(table, index)| Self::ConfigureBitTiming { table, index })
                .parse(rest)?,
            0x15 => named("a delay in two bytes", le_u16).map(|delay| Self::ActivateBitTiming { delay }).parse(rest)?,
            0x17 => (rest, Self::StoreConfiguration),
            0x40..=0x43 => {
                let part = Part::ALL[usize::from(command - 0x40)];
                value(rest).map(|(rest, value)| (rest, Self::SwitchSelective { part, value }))?
            }
            0x46..=0x4B => {
                let bound = Bound::ALL[usize::from(command - 0x46)];
                value(rest).map(|(rest, value)| (rest, Self::IdentifyRemote { bound, value }))?
            }
            0x4C => (rest, Self::IdentifyNonConfigured),
            0x51 => (le_u32, u8, u8, u8)
                .map(|(id, bit_check, sub, next)| Self::Fastscan { id, bit_check, sub, next })
                .parse(rest)?,
            0x5A..=0x5D => (rest, Self::Inquire { part: Part::ALL[usize::from(command - 0x5A)] }),
            0x5E => (rest, Self::InquireNodeId),
            _ => {
                let (tail, rest) = tail_of(rest);
                (rest, Self::Unknown { command, tail })
            }
        };
        Ok((rest, message))
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        *buffer = [0; 8];
        match *self {
            Self::SwitchGlobal { mode } => buffer[..2].copy_from_slice(&[0x04, mode]),
            Self::ConfigureNodeId { node_id } => buffer[..2].copy_from_slice(&[0x11, node_id]),
            Self::ConfigureBitTiming { table, index } => buffer[..3].copy_from_slice(&[0x13, table, index]),
            Self::ActivateBitTiming { delay } => {
                buffer[0] = 0x15;
                buffer[1..3].copy_from_slice(&delay.to_le_bytes());
            }
            Self::StoreConfiguration => buffer[0] = 0x17,
            Self::SwitchSelective { part, value } => emit_value(0x40 + part as u8, value, buffer),
            Self::IdentifyRemote { bound, value } => emit_value(0x46 + bound as u8, value, buffer),
            Self::IdentifyNonConfigured => buffer[0] = 0x4C,
            Self::Fastscan { id, bit_check, sub, next } => {
                emit_value(0x51, id, buffer);
                buffer[5..].copy_from_slice(&[bit_check, sub, next]);
            }
            Self::Inquire { part } => buffer[0] = 0x5A + part as u8,
            Self::InquireNodeId => buffer[0] = 0x5E,
            Self::Unknown { command, tail } => {
                buffer[0] = command;
                buffer[1..].copy_from_slice(&tail);
            }
        }
        8
    }
}

impl Response {
    /// Whether a confirmation has a specific error code although its error code is not 255, which alone announces one.
    pub const fn says_too_much(self) -> bool {
        matches!(self, Self::Configured { error: 0..=254, specific: 1.., .. })
    }
}

impl Wire for Response {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, command) = named("an LSS command specifier", u8).parse(input)?;
        let configured = |command, rest| {
            (named("an error code", u8), named("a specific error", u8))
                .map(|(error, specific)| Self::Configured { command, error, specific })
                .parse(rest)
        };
        match command {
            0x11 => configured(ConfigureCommand::NodeId, rest),
            0x13 => configured(ConfigureCommand::BitTiming, rest),
            0x17 => configured(ConfigureCommand::Store, rest),
            0x44 => Ok((rest, Self::Switched)),
            0x4F => Ok((rest, Self::Identified)),
            0x50 => Ok((rest, Self::NonConfigured)),
            0x5A..=0x5D => {
                let part = Part::ALL[usize::from(command - 0x5A)];
                named("a value in four bytes", le_u32).map(|value| Self::Part { part, value }).parse(rest)
            }
            0x5E => named("a node-ID", u8).map(Self::NodeId).parse(rest),
            _ => {
                let (tail, rest) = tail_of(rest);
                Ok((rest, Self::Unknown { command, tail }))
            }
        }
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        *buffer = [0; 8];
        match *self {
            Self::Configured { command, error, specific } => {
                buffer[..3].copy_from_slice(&[command as u8, error, specific]);
            }
            Self::Switched => buffer[0] = 0x44,
            Self::Identified => buffer[0] = 0x4F,
            Self::NonConfigured => buffer[0] = 0x50,
            Self::Part { part, value } => emit_value(0x5A + part as u8, value, buffer),
            Self::NodeId(node_id) => buffer[..2].copy_from_slice(&[0x5E, node_id]),
            Self::Unknown { command, tail } => {
                buffer[0] = command;
                buffer[1..].copy_from_slice(&tail);
            }
        }
        8
    }
}

fn emit_value(command: u8, value: u32, buffer: &mut [u8; 8]) {
    buffer[0] = command;
    buffer[1..5].copy_from_slice(&value.to_le_bytes());
}

/// The bit rate of a row of table 0, in words.
fn bit_rate(table: u8, index: u8) -> String {
    match (table, BIT_RATES.get(usize::from(index))) {
        (0, Some(Some(rate))) => format!("{} kbit/s", rate / 1000),
        (0, None) if index == 9 => "automatic bit rate detection".to_owned(),
        (0, _) => format!("reserved index {index}"),
        _ => format!("table {table}, index {index}"),
    }
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::SwitchGlobal { mode: 0 } => f.write_str("switch state global: waiting"),
            Self::SwitchGlobal { mode: 1 } => f.write_str("switch state global: configuration"),
            Self::SwitchGlobal { mode } => write!(f, "switch state global: reserved mode {mode}"),
            Self::ConfigureNodeId { node_id: 255 } => f.write_str("configure node-ID: none"),
            Self::ConfigureNodeId { node_id } => write!(f, "configure node-ID {node_id}"),
            Self::ConfigureBitTiming { table, index } => {
                write!(f, "configure bit timing: {}", bit_rate(table, index))
            }
            Self::ActivateBitTiming { delay } => write!(f, "activate bit timing, delay {delay} ms"),
            Self::StoreConfiguration => f.write_str("store configuration"),
            Self::SwitchSelective { part, value } => {
                write!(f, "switch state selective: {} {value:08X}h", part.name())
            }
            Self::IdentifyRemote { bound, value } => {
                write!(f, "identify remote slave: {} {value:08X}h", bound.name())
            }
            Self::IdentifyNonConfigured => f.write_str("identify non-configured remote slave"),
            Self::Fastscan { bit_check: 128, .. } => f.write_str("Fastscan: begin"),
            Self::Fastscan { id, bit_check, sub, next } => {
                let part = Part::ALL.get(usize::from(sub)).map_or("reserved part", |part| part.name());
                write!(f, "Fastscan: {part} {id:08X}h down to bit {bit_check}, next part {next}")
            }
            Self::Inquire { part } => write!(f, "inquire {}", part.name()),
            Self::InquireNodeId => f.write_str("inquire node-ID"),
            Self::Unknown { command, .. } => write!(f, "unknown command specifier {command:02X}h"),
        }
    }
}

impl fmt::Display for Response {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Configured { command, error, specific } => {
                let what = match command {
                    ConfigureCommand::NodeId => "configure node-ID",
                    ConfigureCommand::BitTiming => "configure bit timing",
                    ConfigureCommand::Store => "store configuration",
                };
                match command.error_name(error) {
                    Some(name) => write!(f, "{what}: {name}")?,
                    None => write!(f, "{what}: reserved error {error}")?,
                }
                if error == 255 || specific != 0 { write!(f, " {specific}") } else { Ok(()) }
            }
            Self::Switched => f.write_str("switched to configuration"),
            Self::Identified => f.write_str("slave identified"),
            Self::NonConfigured => f.write_str("non-configured slave identified"),
            Self::Part { part, value } => write!(f, "{} {value:08X}h", part.name()),
            Self::NodeId(255) => f.write_str("node-ID: none"),
            Self::NodeId(node_id) => write!(f, "node-ID {node_id}"),
            Self::Unknown { command, .. } => write!(f, "unknown command specifier {command:02X}h"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::{both_ways, stable};
    use super::*;
    use proptest::prelude::*;

    /// The flow of Kübler manual 000, 5.7.6.
    #[test]
    fn flow_of_the_manual() {
        both_ways(&[0x04, 1, 0, 0, 0, 0, 0, 0], Request::SwitchGlobal { mode: 1 });
        both_ways(&[0x5E, 0, 0, 0, 0, 0, 0, 0], Request::InquireNodeId);
        both_ways(&[0x11, 0x2A, 0, 0, 0, 0, 0, 0], Request::ConfigureNodeId { node_id: 42 });
        both_ways(&[0x13, 0, 4, 0, 0, 0, 0, 0], Request::ConfigureBitTiming { table: 0, index: 4 });
        both_ways(&[0x17, 0, 0, 0, 0, 0, 0, 0], Request::StoreConfiguration);
        let done = |command| Response::Configured { command, error: 0, specific: 0 };
        both_ways(&[0x11, 0, 0, 0, 0, 0, 0, 0], done(ConfigureCommand::NodeId));
        both_ways(&[0x13, 0, 0, 0, 0, 0, 0, 0], done(ConfigureCommand::BitTiming));
        both_ways(&[0x17, 0, 0, 0, 0, 0, 0, 0], done(ConfigureCommand::Store));
        assert_eq!(Request::ConfigureBitTiming { table: 0, index: 4 }.to_string(), "configure bit timing: 125 kbit/s");
        // The stray 04 in a reserved byte of the closing message does no harm.
        assert_eq!(Request::read(&[0x04, 0, 4, 0, 0, 0, 0, 0]), Ok(Request::SwitchGlobal { mode: 0 }));
    }

    /// The layouts of CiA 305.
    #[test]
    fn every_command() {
        for (n, part) in Part::ALL.into_iter().enumerate() {
            let n = n as u8;
            both_ways(
                &[0x40 + n, 0x78, 0x56, 0x34, 0x12, 0, 0, 0],
                Request::SwitchSelective { part, value: 0x1234_5678 },
            );
            both_ways(&[0x5A + n, 0, 0, 0, 0, 0, 0, 0], Request::Inquire { part });
            both_ways(&[0x5A + n, 0x13, 0, 0, 0, 0, 0, 0], Response::Part { part, value: 0x13 });
        }
        for (n, bound) in Bound::ALL.into_iter().enumerate() {
            both_ways(&[0x46 + n as u8, 1, 0, 0, 0, 0, 0, 0], Request::IdentifyRemote { bound, value: 1 });
        }
        both_ways(&[0x15, 0xE8, 0x03, 0, 0, 0, 0, 0], Request::ActivateBitTiming { delay: 1000 });
        both_ways(&[0x4C, 0, 0, 0, 0, 0, 0, 0], Request::IdentifyNonConfigured);
        both_ways(
            &[0x51, 0, 0, 0, 0x80, 31, 1, 2],
            Request::Fastscan { id: 0x8000_0000, bit_check: 31, sub: 1, next: 2 },
        );
        both_ways(&[0x44, 0, 0, 0, 0, 0, 0, 0], Response::Switched);
        both_ways(&[0x4F, 0, 0, 0, 0, 0, 0, 0], Response::Identified);
        both_ways(&[0x50, 0, 0, 0, 0, 0, 0, 0], Response::NonConfigured);
        both_ways(&[0x5E, 0xFF, 0, 0, 0, 0, 0, 0], Response::NodeId(255));
        both_ways(
            &[0x13, 255, 1, 0, 0, 0, 0, 0],
            Response::Configured { command: ConfigureCommand::BitTiming, error: 255, specific: 1 },
        );
        both_ways(&[0x99, 1, 2, 3, 4, 5, 6, 7], Request::Unknown { command: 0x99, tail: [1, 2, 3, 4, 5, 6, 7] });
        assert!(Request::read(&[0x51, 0, 0]).is_err());
    }

    proptest! {
        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<Request>(&bytes);
            stable::<Response>(&bytes);
        }
    }
}
