//! Layer setting: node-ID and bit rate over the bus, in two dialects on the same CAN-IDs.
//!
//! [`lss`](super::lss) is the dialect of CiA 305, [`lmt`](super::lmt) its predecessor of CiA DS-205. This module
//! has their common part:
//!
//! ```text
//! byte 0: command specifier    bytes 1..7: by command; what is not used is reserved and 0
//!
//! 04h  mode                    switch all slaves
//! 11h  node-ID                 configure        11h  error  specific     confirmed
//! 13h  table  index            configure        13h  error  specific     confirmed
//! 15h  delay, two bytes        activate
//! 17h                          store            17h  error  specific     confirmed
//! ```
//!
//! Both dialects address one slave part by part, look for slaves bound by bound, and inquire the parts of an address;
//! the [`Dialect`] defines the parts and bounds, and their command specifiers. Only LSS has slaves without node-ID,
//! Fastscan, the inquiry of the node-ID, and the answer of the addressed slave; the parser of LMT never returns these
//! messages.

mod dialect;

use super::{Field, Fields, Layout, Malformed, Wire, named, tail_of};
pub(super) use dialect::numbered;
pub use dialect::{Dialect, Limit, Numbered, Protocol, Value};
use nom::{
    IResult, Parser,
    number::complete::{le_u16, le_u32, u8},
};
use std::fmt::{self, Display};

/// The CAN-ID from master to slaves.
pub const MASTER_CAN_ID: u16 = 0x7E5;
/// The CAN-ID from slaves to the master.
pub const SLAVE_CAN_ID: u16 = 0x7E4;

/// A message from the master.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Request<D: Dialect> {
    /// 04h: switches all slaves to waiting or operation (0), or to configuration (1).
    SwitchGlobal {
        /// 0 waiting or operation, 1 configuration; others are reserved.
        mode: u8,
    },
    /// 11h: sets the future node-ID; LMT calls it the NMT address.
    ConfigureNodeId {
        /// 1 to 127; for LSS also 255, "not configured".
        node_id: u8,
    },
    /// 13h: sets the future bit rate.
    ConfigureBitTiming {
        /// 0 is the table of the standard, 128 to 255 are manufacturer-specific.
        table: u8,
        /// The row of the table.
        index: u8,
    },
    /// 15h: the slaves in configuration change to the new bit rate.
    ActivateBitTiming {
        /// The silence before and after the change, in milliseconds.
        delay: u16,
    },
    /// 17h: stores the configured values.
    StoreConfiguration,
    /// Addresses one slave by the parts of its address.
    SwitchSelective {
        /// The part of the address.
        part: D::Part,
        /// The value of the part.
        value: D::Value,
    },
    /// Identifies slaves within bounds, bound by bound.
    IdentifyRemote {
        /// The bound.
        bound: D::Bound,
        /// The value of the bound.
        value: D::Value,
    },
    /// Inquires a part of the address.
    Inquire {
        /// The inquired part.
        part: D::Part,
    },
    /// 4Ch, LSS: identifies slaves without node-ID.
    IdentifyNonConfigured,
    /// 51h, LSS: finds a slave without node-ID by halving.
    Fastscan {
        /// The bits found so far.
        id: u32,
        /// The lowest compared bit, 31 to 0; 128 restarts the scan.
        bit_check: u8,
        /// The compared part, 0 to 3.
        sub: u8,
        /// The part of the next request, 0 to 3.
        next: u8,
    },
    /// 5Eh, LSS: inquires the node-ID.
    InquireNodeId,
    /// Any other command specifier.
    Unknown {
        /// Byte 0.
        command: u8,
        /// The bytes after byte 0, filled up with zeros.
        tail: [u8; 7],
    },
}

/// A message from a slave.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Response<D: Dialect> {
    /// 11h, 13h or 17h: the result of a configuration.
    Configured {
        /// The command.
        command: ConfigureCommand,
        /// 0 success, 255 manufacturer-specific error; other values depend on the command.
        error: u8,
        /// The manufacturer-specific error code, if `error` is 255.
        specific: u8,
    },
    /// A slave is within the bounds, or matches the Fastscan.
    Identified,
    /// A part of the address.
    Part {
        /// The inquired part.
        part: D::Part,
        /// The value of the part.
        value: D::Value,
    },
    /// 44h, LSS: the addressed slave is in configuration state.
    Switched,
    /// 50h, LSS: a slave without node-ID exists.
    NonConfigured,
    /// 5Eh, LSS: the node-ID, 255 if there is none.
    NodeId(u8),
    /// Any other command specifier.
    Unknown {
        /// Byte 0.
        command: u8,
        /// The bytes after byte 0, filled up with zeros.
        tail: [u8; 7],
    },
}

/// The commands whose answer has an error code.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[repr(u8)]
pub enum ConfigureCommand {
    /// Configure node-ID, or NMT address.
    NodeId = 0x11,
    /// Configure bit timing.
    BitTiming = 0x13,
    /// Store configuration.
    Store = 0x17,
}

impl ConfigureCommand {
    /// The standard's name of the service.
    pub const fn name<D: Dialect>(self) -> &'static str {
        match self {
            Self::NodeId => D::CONFIGURE_NODE_ID,
            Self::BitTiming => "configure bit timing",
            Self::Store => "store configuration",
        }
    }

    /// The meaning of the error code; `None` for a reserved code.
    pub fn error_name<D: Dialect>(self, error: u8) -> Option<&'static str> {
        match (self, error) {
            (_, 0) => Some("successful"),
            (Self::BitTiming, 1) => Some("bit rate not supported"),
            (Self::Store, 1) => Some("storing not supported"),
            _ => D::error_name(self, error),
        }
    }
}

impl<D: Dialect> Request<D> {
    /// Whether exactly one slave must answer.
    pub(crate) fn wants_answer(self) -> bool {
        match self {
            Self::ConfigureNodeId { .. } | Self::ConfigureBitTiming { .. } | Self::StoreConfiguration => true,
            Self::Inquire { .. } | Self::InquireNodeId => true,
            Self::SwitchSelective { part, .. } => D::PROTOCOL == Protocol::Lss && part.is_last(),
            _ => false,
        }
    }
}

impl<D: Dialect> Response<D> {
    /// Whether this message answers `request`.
    pub fn answers(self, request: Request<D>) -> bool {
        match (self, request) {
            (Self::Configured { command, .. }, request) => match request {
                Request::ConfigureNodeId { .. } => command == ConfigureCommand::NodeId,
                Request::ConfigureBitTiming { .. } => command == ConfigureCommand::BitTiming,
                Request::StoreConfiguration => command == ConfigureCommand::Store,
                _ => false,
            },
            (Self::Identified, Request::IdentifyRemote { bound, .. }) => bound.is_last(),
            (Self::Identified, Request::Fastscan { .. }) => true,
            (Self::Part { part, .. }, Request::Inquire { part: asked }) => part == asked,
            (Self::Switched, Request::SwitchSelective { part, .. }) => part.is_last(),
            (Self::NonConfigured, Request::IdentifyNonConfigured) => true,
            (Self::NodeId(_), Request::InquireNodeId) => true,
            _ => false,
        }
    }

    /// Whether a confirmation has a specific error code although its error code is not 255. Only 255 announces a
    /// specific error code.
    pub const fn says_too_much(self) -> bool {
        matches!(self, Self::Configured { error: 0..=254, specific: 1.., .. })
    }
}

/// The part or bound with the command specifier `command`, if the first part or bound has `first`.
fn at<N: Numbered>(command: u8, first: u8) -> Option<N> {
    N::ALL.get(usize::from(command.checked_sub(first)?)).copied()
}

impl<D: Dialect> Wire for Request<D> {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, command) = named(D::SPECIFIER, u8).parse(input)?;
        if let Some(part) = at(command, D::SWITCH_SELECTIVE) {
            return D::Value::parse.map(|value| Self::SwitchSelective { part, value }).parse(rest);
        }
        if let Some(bound) = at(command, D::IDENTIFY_REMOTE) {
            return D::Value::parse.map(|value| Self::IdentifyRemote { bound, value }).parse(rest);
        }
        if let Some(part) = at(command, D::INQUIRE) {
            return Ok((rest, Self::Inquire { part }));
        }
        let is_lss = D::PROTOCOL == Protocol::Lss;
        match command {
            0x04 => named("a mode", u8).map(|mode| Self::SwitchGlobal { mode }).parse(rest),
            0x11 => named("a node-ID", u8).map(|node_id| Self::ConfigureNodeId { node_id }).parse(rest),
            0x13 => (named("a table selector", u8), named("a table index", u8))
                .map(|(table, index)| Self::ConfigureBitTiming { table, index })
                .parse(rest),
            0x15 => named("a delay in two bytes", le_u16).map(|delay| Self::ActivateBitTiming { delay }).parse(rest),
            0x17 => Ok((rest, Self::StoreConfiguration)),
            0x4C if is_lss => Ok((rest, Self::IdentifyNonConfigured)),
            0x51 if is_lss => (le_u32, u8, u8, u8)
                .map(|(id, bit_check, sub, next)| Self::Fastscan { id, bit_check, sub, next })
                .parse(rest),
            0x5E if is_lss => Ok((rest, Self::InquireNodeId)),
            _ => {
                let (tail, rest) = tail_of(rest);
                Ok((rest, Self::Unknown { command, tail }))
            }
        }
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
            Self::SwitchSelective { part, value } => emit_value(D::SWITCH_SELECTIVE, part, value, buffer),
            Self::IdentifyRemote { bound, value } => emit_value(D::IDENTIFY_REMOTE, bound, value, buffer),
            Self::Inquire { part } => buffer[0] = D::INQUIRE + part.position() as u8,
            Self::IdentifyNonConfigured => buffer[0] = 0x4C,
            Self::Fastscan { id, bit_check, sub, next } => {
                let [a, b, c, d] = id.to_le_bytes();
                *buffer = [0x51, a, b, c, d, bit_check, sub, next];
            }
            Self::InquireNodeId => buffer[0] = 0x5E,
            Self::Unknown { command, tail } => emit_unknown(command, tail, buffer),
        }
        8
    }
}

impl<D: Dialect> Wire for Response<D> {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, command) = named(D::SPECIFIER, u8).parse(input)?;
        if let Some(part) = at(command, D::INQUIRE) {
            return D::Value::parse.map(|value| Self::Part { part, value }).parse(rest);
        }
        let configured = |command| {
            (named("an error code", u8), named("a specific error", u8))
                .map(move |(error, specific)| Self::Configured { command, error, specific })
                .parse(rest)
        };
        let is_lss = D::PROTOCOL == Protocol::Lss;
        match command {
            0x11 => configured(ConfigureCommand::NodeId),
            0x13 => configured(ConfigureCommand::BitTiming),
            0x17 => configured(ConfigureCommand::Store),
            0x44 if is_lss => Ok((rest, Self::Switched)),
            0x50 if is_lss => Ok((rest, Self::NonConfigured)),
            0x5E if is_lss => named("a node-ID", u8).map(Self::NodeId).parse(rest),
            _ if command == D::IDENTIFIED => Ok((rest, Self::Identified)),
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
            Self::Identified => buffer[0] = D::IDENTIFIED,
            Self::Part { part, value } => emit_value(D::INQUIRE, part, value, buffer),
            Self::Switched => buffer[0] = 0x44,
            Self::NonConfigured => buffer[0] = 0x50,
            Self::NodeId(node_id) => buffer[..2].copy_from_slice(&[0x5E, node_id]),
            Self::Unknown { command, tail } => emit_unknown(command, tail, buffer),
        }
        8
    }
}

const SPECIFIER: Field = Field::new("command specifier", 0, 0, 8);

const WITHOUT_PARAMETERS: &[Field] = &[SPECIFIER, Field::reserved(1, 0, 56)];

impl<D: Dialect> Request<D> {
    const SWITCH_GLOBAL: Layout =
        Layout { name: "switch global", fields: &[SPECIFIER, Field::new("mode", 1, 0, 8), Field::reserved(2, 0, 48)] };
    const CONFIGURE_NODE_ID: Layout = Layout {
        name: "configure node-ID",
        fields: &[SPECIFIER, Field::new("node-ID", 1, 0, 8), Field::reserved(2, 0, 48)],
    };
    const CONFIGURE_BIT_TIMING: Layout = Layout {
        name: "configure bit timing",
        fields: &[
            SPECIFIER,
            Field::new("table", 1, 0, 8),
            Field::new("table index", 2, 0, 8),
            Field::reserved(3, 0, 40),
        ],
    };
    const ACTIVATE_BIT_TIMING: Layout = Layout {
        name: "activate bit timing",
        fields: &[SPECIFIER, Field::new("delay", 1, 0, 16), Field::reserved(3, 0, 40)],
    };
    const STORE: Layout = Layout { name: "store configuration", fields: WITHOUT_PARAMETERS };
    const SWITCH_SELECTIVE: Layout = Layout { name: "switch selective", fields: D::PART_FIELDS };
    const IDENTIFY_REMOTE: Layout = Layout { name: "identify remote slave", fields: D::PART_FIELDS };
    const INQUIRE: Layout = Layout { name: "inquire", fields: WITHOUT_PARAMETERS };
    const IDENTIFY_NON_CONFIGURED: Layout =
        Layout { name: "identify slave without node-ID", fields: WITHOUT_PARAMETERS };
    const FASTSCAN: Layout = Layout {
        name: "Fastscan",
        fields: &[
            SPECIFIER,
            Field::new("ID number", 1, 0, 32),
            Field::new("bit check", 5, 0, 8),
            Field::new("LSS sub", 6, 0, 8),
            Field::new("LSS next", 7, 0, 8),
        ],
    };
    const INQUIRE_NODE_ID: Layout = Layout { name: "inquire node-ID", fields: WITHOUT_PARAMETERS };
    const UNKNOWN: Layout = Layout { name: "unknown", fields: &[SPECIFIER, Field::new("data", 1, 0, 56)] };
}

impl<D: Dialect> Fields for Request<D> {
    const LAYOUTS: &'static [&'static Layout] = match D::PROTOCOL {
        Protocol::Lss => &[
            &Self::SWITCH_GLOBAL,
            &Self::CONFIGURE_NODE_ID,
            &Self::CONFIGURE_BIT_TIMING,
            &Self::ACTIVATE_BIT_TIMING,
            &Self::STORE,
            &Self::SWITCH_SELECTIVE,
            &Self::IDENTIFY_REMOTE,
            &Self::INQUIRE,
            &Self::IDENTIFY_NON_CONFIGURED,
            &Self::FASTSCAN,
            &Self::INQUIRE_NODE_ID,
            &Self::UNKNOWN,
        ],
        Protocol::Lmt => &[
            &Self::SWITCH_GLOBAL,
            &Self::CONFIGURE_NODE_ID,
            &Self::CONFIGURE_BIT_TIMING,
            &Self::ACTIVATE_BIT_TIMING,
            &Self::STORE,
            &Self::SWITCH_SELECTIVE,
            &Self::IDENTIFY_REMOTE,
            &Self::INQUIRE,
            &Self::UNKNOWN,
        ],
    };

    fn layout(&self) -> &'static Layout {
        match self {
            Self::SwitchGlobal { .. } => &Self::SWITCH_GLOBAL,
            Self::ConfigureNodeId { .. } => &Self::CONFIGURE_NODE_ID,
            Self::ConfigureBitTiming { .. } => &Self::CONFIGURE_BIT_TIMING,
            Self::ActivateBitTiming { .. } => &Self::ACTIVATE_BIT_TIMING,
            Self::StoreConfiguration => &Self::STORE,
            Self::SwitchSelective { .. } => &Self::SWITCH_SELECTIVE,
            Self::IdentifyRemote { .. } => &Self::IDENTIFY_REMOTE,
            Self::Inquire { .. } => &Self::INQUIRE,
            Self::IdentifyNonConfigured => &Self::IDENTIFY_NON_CONFIGURED,
            Self::Fastscan { .. } => &Self::FASTSCAN,
            Self::InquireNodeId => &Self::INQUIRE_NODE_ID,
            Self::Unknown { .. } => &Self::UNKNOWN,
        }
    }
}

impl<D: Dialect> Response<D> {
    const CONFIGURED: Layout = Layout {
        name: "configuration confirmed",
        fields: &[
            SPECIFIER,
            Field::new("error code", 1, 0, 8),
            Field::new("specific error code", 2, 0, 8),
            Field::reserved(3, 0, 40),
        ],
    };
    const IDENTIFIED: Layout = Layout { name: "slave identified", fields: &[SPECIFIER, Field::reserved(1, 0, 56)] };
    const PART: Layout = Layout { name: "part of the address", fields: D::PART_FIELDS };
    const SWITCHED: Layout = Layout { name: "slave selected", fields: &[SPECIFIER, Field::reserved(1, 0, 56)] };
    const NON_CONFIGURED: Layout =
        Layout { name: "slave without node-ID", fields: &[SPECIFIER, Field::reserved(1, 0, 56)] };
    const NODE_ID: Layout = Layout {
        name: "node-ID inquired",
        fields: &[SPECIFIER, Field::new("node-ID", 1, 0, 8), Field::reserved(2, 0, 48)],
    };
    const UNKNOWN: Layout = Layout { name: "unknown", fields: &[SPECIFIER, Field::new("data", 1, 0, 56)] };
}

impl<D: Dialect> Fields for Response<D> {
    const LAYOUTS: &'static [&'static Layout] = match D::PROTOCOL {
        Protocol::Lss => &[
            &Self::CONFIGURED,
            &Self::IDENTIFIED,
            &Self::PART,
            &Self::SWITCHED,
            &Self::NON_CONFIGURED,
            &Self::NODE_ID,
            &Self::UNKNOWN,
        ],
        Protocol::Lmt => &[&Self::CONFIGURED, &Self::IDENTIFIED, &Self::PART, &Self::UNKNOWN],
    };

    fn layout(&self) -> &'static Layout {
        match self {
            Self::Configured { .. } => &Self::CONFIGURED,
            Self::Identified => &Self::IDENTIFIED,
            Self::Part { .. } => &Self::PART,
            Self::Switched => &Self::SWITCHED,
            Self::NonConfigured => &Self::NON_CONFIGURED,
            Self::NodeId(_) => &Self::NODE_ID,
            Self::Unknown { .. } => &Self::UNKNOWN,
        }
    }
}

fn emit_value(first: u8, which: impl Numbered, value: impl Value, buffer: &mut [u8; 8]) {
    buffer[0] = first + which.position() as u8;
    value.emit(&mut buffer[1..]);
}

fn emit_unknown(command: u8, tail: [u8; 7], buffer: &mut [u8; 8]) {
    buffer[0] = command;
    buffer[1..].copy_from_slice(&tail);
}

/// The bit rate of a row of a table, as text.
fn bit_rate<D: Dialect>(table: u8, index: u8) -> String {
    match (table, D::bit_rate(index)) {
        (0, Some(rate)) => format!("{} kbit/s", rate / 1000),
        (0, None) if index == 9 && D::PROTOCOL == Protocol::Lss => "automatic bit rate detection".to_owned(),
        (0, None) => format!("reserved index {index}"),
        _ => format!("table {table}, index {index}"),
    }
}

impl<D: Dialect> Display for Request<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::SwitchGlobal { mode: 0 } => write!(f, "switch {} global: {}", D::STATE, D::WAITING),
            Self::SwitchGlobal { mode: 1 } => write!(f, "switch {} global: configuration", D::STATE),
            Self::SwitchGlobal { mode } => write!(f, "switch {} global: reserved mode {mode}", D::STATE),
            Self::ConfigureNodeId { node_id } => match (D::PROTOCOL, node_id) {
                (Protocol::Lss, 255) => f.write_str("configure node-ID: none"),
                (Protocol::Lss, _) => write!(f, "configure node-ID {node_id}"),
                (Protocol::Lmt, _) => write!(f, "configure NMT address: node-ID {node_id}"),
            },
            Self::ConfigureBitTiming { table, index } => {
                write!(f, "configure bit timing: {}", bit_rate::<D>(table, index))
            }
            Self::ActivateBitTiming { delay } => write!(f, "activate bit timing, delay {delay} ms"),
            Self::StoreConfiguration => f.write_str("store configuration"),
            Self::SwitchSelective { part, value } => {
                write!(f, "switch {} selective: {} {}", D::STATE, part.name(), D::words(part, value))
            }
            Self::IdentifyRemote { bound, value } => {
                let (part, _) = D::limits(bound);
                write!(f, "identify remote slave: {} {}", bound.name(), D::words(part, value))
            }
            Self::Inquire { part } => write!(f, "inquire {}", part.name()),
            Self::IdentifyNonConfigured => f.write_str("identify non-configured remote slave"),
            Self::Fastscan { bit_check: 128, .. } => f.write_str("Fastscan: begin"),
            Self::Fastscan { id, bit_check, sub, next } => {
                let part = D::Part::ALL.get(usize::from(sub)).map_or("reserved part", |part| part.name());
                write!(f, "Fastscan: {part} {id:08X}h down to bit {bit_check}, next part {next}")
            }
            Self::InquireNodeId => f.write_str("inquire node-ID"),
            Self::Unknown { command, .. } => write!(f, "unknown command specifier {command:02X}h"),
        }
    }
}

impl<D: Dialect> Display for Response<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Configured { command, error, specific } => {
                match command.error_name::<D>(error) {
                    Some(name) => write!(f, "{}: {name}", command.name::<D>())?,
                    None => write!(f, "{}: reserved error {error}", command.name::<D>())?,
                }
                if error == 255 || specific != 0 { write!(f, " {specific}") } else { Ok(()) }
            }
            Self::Identified => f.write_str("slave identified"),
            Self::Part { part, value } => write!(f, "{} {}", part.name(), D::words(part, value)),
            Self::Switched => f.write_str("switched to configuration"),
            Self::NonConfigured => f.write_str("non-configured slave identified"),
            Self::NodeId(255) => f.write_str("node-ID: none"),
            Self::NodeId(node_id) => write!(f, "node-ID {node_id}"),
            Self::Unknown { command, .. } => write!(f, "unknown command specifier {command:02X}h"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::lmt::Lmt;
    use super::super::lss::Lss;
    use super::*;

    fn knows<D: Dialect>(payload: &[u8]) -> bool {
        !matches!(Request::<D>::read(payload), Ok(Request::Unknown { .. }))
            || !matches!(Response::<D>::read(payload), Ok(Response::Unknown { .. }))
    }

    #[test]
    fn command_specifiers_tell_the_protocol() {
        for command in 0..=255 {
            let payload = [command, 1, 1, 1, 1, 1, 1, 1];
            let expected = match (knows::<Lmt>(&payload), knows::<Lss>(&payload)) {
                (true, false) => Some(Protocol::Lmt),
                (false, true) => Some(Protocol::Lss),
                _ => None,
            };
            assert_eq!(Protocol::of(&payload), expected, "{command:02X}h");
        }
        assert_eq!(Protocol::of(&[]), None);
    }

    /// The tables differ from index 5 on.
    #[test]
    fn bit_rates_of_lmt_are_shifted_against_lss() {
        assert!((0..5).all(|index| Lss::bit_rate(index).is_some() && Lss::bit_rate(index) == Lmt::bit_rate(index)));
        assert_eq!(Lss::bit_rate(5), None);
        assert!((5..8).all(|index| Lmt::bit_rate(index).is_some() && Lmt::bit_rate(index) == Lss::bit_rate(index + 1)));
        for index in (0..=255).filter(|&index| Lss::bit_rate(index).is_some()) {
            assert_eq!(Lss::bit_rate(index).and_then(Lss::bit_rate_index), Some(index));
        }
        assert_eq!(Lmt::bit_rate_index(83_333), None);
    }
}
