//! LSS: layer setting services (CiA 305).
//!
//! ```text
//! 40h..43h  part, four bytes     44h  switched            46h..4Bh  bound, four bytes    4Fh  identified
//! 4Ch                            50h  not configured      51h  Fastscan                  4Fh  identified
//! 5Ah..5Dh                       5Ah..5Dh  part           5Eh                            5Eh  node-ID
//! ```
//!
//! A slave is addressed by the four numbers of 1018h. [`layer_setting`] has the messages that LSS shares with LMT.

use super::{Field, Malformed, layer_setting, named};
use layer_setting::{Dialect, Limit, Protocol, Value, numbered};
use nom::{IResult, Parser, number::complete::le_u32};
use std::fmt::{self, Display};

pub use layer_setting::{ConfigureCommand, MASTER_CAN_ID, SLAVE_CAN_ID};

/// The dialect of CiA 305.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Lss;

/// A message from the master.
pub type Request = layer_setting::Request<Lss>;
/// A message from a slave.
pub type Response = layer_setting::Response<Lss>;

numbered! {
    /// The four parts of an LSS address, which are 1018h:1 to 4.
    Part {
        /// 1018h:1.
        VendorId = "vendor-ID",
        /// 1018h:2.
        ProductCode = "product code",
        /// 1018h:3.
        RevisionNumber = "revision number",
        /// 1018h:4.
        SerialNumber = "serial number",
    }
}

numbered! {
    /// The bounds of [`Request::IdentifyRemote`].
    Bound {
        /// 46h.
        VendorId = "vendor-ID",
        /// 47h.
        ProductCode = "product code",
        /// 48h.
        RevisionLow = "lowest revision number",
        /// 49h.
        RevisionHigh = "highest revision number",
        /// 4Ah.
        SerialLow = "lowest serial number",
        /// 4Bh.
        SerialHigh = "highest serial number",
    }
}

impl Value for u32 {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        named("a value in four bytes", le_u32).parse(input)
    }

    fn emit(self, tail: &mut [u8]) {
        tail[..4].copy_from_slice(&self.to_le_bytes());
    }
}

/// The bit rates of table 0, in bit/s by index; index 5 is reserved, index 9 is automatic detection.
const BIT_RATES: [Option<u32>; 9] = [
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

impl Dialect for Lss {
    type Part = Part;
    type Bound = Bound;
    type Value = u32;

    const PROTOCOL: Protocol = Protocol::Lss;
    const SPECIFIER: &'static str = "an LSS command specifier";
    const SWITCH_SELECTIVE: u8 = 0x40;
    const IDENTIFY_REMOTE: u8 = 0x46;
    const IDENTIFIED: u8 = 0x4F;
    const INQUIRE: u8 = 0x5A;
    const PART_FIELDS: &'static [Field] =
        &[Field::new("command specifier", 0, 0, 8), Field::new("value", 1, 0, 32), Field::reserved(5, 0, 24)];
    const STATE: &'static str = "state";
    const WAITING: &'static str = "waiting";
    const CONFIGURE_NODE_ID: &'static str = "configure node-ID";

    fn limits(bound: Bound) -> (Part, Limit) {
        match bound {
            Bound::VendorId => (Part::VendorId, Limit::Equal),
            Bound::ProductCode => (Part::ProductCode, Limit::Equal),
            Bound::RevisionLow => (Part::RevisionNumber, Limit::Lowest),
            Bound::RevisionHigh => (Part::RevisionNumber, Limit::Highest),
            Bound::SerialLow => (Part::SerialNumber, Limit::Lowest),
            Bound::SerialHigh => (Part::SerialNumber, Limit::Highest),
        }
    }

    fn bit_rate(index: u8) -> Option<u32> {
        BIT_RATES.get(usize::from(index)).copied().flatten()
    }

    fn error_name(command: ConfigureCommand, error: u8) -> Option<&'static str> {
        match (command, error) {
            (ConfigureCommand::NodeId, 1) => Some("node-ID out of range"),
            (ConfigureCommand::Store, 2) => Some("storage media access error"),
            (_, 255) => Some("manufacturer-specific error"),
            _ => None,
        }
    }

    fn words(_: Part, value: u32) -> impl Display {
        fmt::from_fn(move |f| write!(f, "{value:08X}h"))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Wire;
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

    /// Each response of CiA 305 belongs to one service; only 4Fh belongs to two.
    #[test]
    fn responses_answer_their_requests() {
        let read = |data: [u8; 8]| (Request::read(&data).unwrap(), Response::read(&data).unwrap());
        let all = (0..=0xFF).map(|command| [command, 0, 0, 0, 0, 0, 0, 0]);
        let pairs = all.clone().flat_map(|asked| all.clone().map(move |answered| (asked, answered)));
        let fitting: Vec<(u8, u8)> = pairs
            .filter(|&(asked, answered)| read(answered).1.answers(read(asked).0))
            .map(|(asked, answered)| (asked[0], answered[0]))
            .collect();
        let expected = [
            (0x11, 0x11),
            (0x13, 0x13),
            (0x17, 0x17),
            (0x43, 0x44),
            (0x4B, 0x4F),
            (0x4C, 0x50),
            (0x51, 0x4F),
            (0x5A, 0x5A),
            (0x5B, 0x5B),
            (0x5C, 0x5C),
            (0x5D, 0x5D),
            (0x5E, 0x5E),
        ];
        assert_eq!(fitting, expected);
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
