//! LMT: layer management, the predecessor of LSS (CiA DS-205).
//!
//! ```text
//! 01h..03h  part, seven bytes                  05h..08h  bound, seven bytes    09h  identified
//! 24h..26h                       24h..26h  part
//! ```
//!
//! A slave is addressed by its manufacturer name, product name and serial number, seven bytes each, instead of the four
//! numbers of LSS. The slave does not confirm that it was addressed. [`layer_setting`] has the messages that both
//! protocols share.

use super::{Field, Malformed, layer_setting, named};
use canvass_traces::hex;
use layer_setting::{Dialect, Limit, Protocol, Value, numbered};
use nom::{IResult, Parser, bytes::complete::take};
use std::fmt::{self, Display};

pub use layer_setting::{ConfigureCommand, MASTER_CAN_ID, SLAVE_CAN_ID};

/// The dialect of CiA DS-205.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Lmt;

/// A message from the master.
pub type Request = layer_setting::Request<Lmt>;
/// A message from a slave.
pub type Response = layer_setting::Response<Lmt>;

numbered! {
    /// The three parts of an LMT address.
    Part {
        /// Seven characters.
        ManufacturerName = "manufacturer name",
        /// Seven characters.
        ProductName = "product name",
        /// Fourteen digits, BCD.
        SerialNumber = "serial number",
    }
}

numbered! {
    /// The bounds of [`Request::IdentifyRemote`].
    Bound {
        /// 05h.
        ManufacturerName = "manufacturer name",
        /// 06h.
        ProductName = "product name",
        /// 07h.
        SerialLow = "lowest serial number",
        /// 08h.
        SerialHigh = "highest serial number",
    }
}

/// The seven bytes of a part of an LMT address. Serial numbers compare by their digits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Seven(pub [u8; 7]);

/// The bit rates of table 0, in bit/s by index. Up to index 4 they are the same as in LSS, which has an empty row 5.
const BIT_RATES: [u32; 8] = [1_000_000, 800_000, 500_000, 250_000, 125_000, 50_000, 20_000, 10_000];

impl Seven {
    /// A name, filled up with zeros; `None` if it has more than seven bytes.
    pub fn name(name: &str) -> Option<Self> {
        let mut bytes = [0; 7];
        bytes.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
        Some(Self(bytes))
    }
}

impl Value for Seven {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, taken) = named("seven bytes of an LMT address", take(7_usize)).parse(input)?;
        let mut bytes = [0; 7];
        bytes.copy_from_slice(taken);
        Ok((rest, Self(bytes)))
    }

    fn emit(self, tail: &mut [u8]) {
        tail.copy_from_slice(&self.0);
    }
}

impl Dialect for Lmt {
    type Part = Part;
    type Bound = Bound;
    type Value = Seven;

    const PROTOCOL: Protocol = Protocol::Lmt;
    const SPECIFIER: &'static str = "an LMT command specifier";
    const SWITCH_SELECTIVE: u8 = 0x01;
    const IDENTIFY_REMOTE: u8 = 0x05;
    const IDENTIFIED: u8 = 0x09;
    const INQUIRE: u8 = 0x24;
    const PART_FIELDS: &'static [Field] = &[Field::new("command specifier", 0, 0, 8), Field::new("value", 1, 0, 56)];
    const STATE: &'static str = "mode";
    const WAITING: &'static str = "operation";
    const CONFIGURE_NODE_ID: &'static str = "configure NMT address";

    fn limits(bound: Bound) -> (Part, Limit) {
        match bound {
            Bound::ManufacturerName => (Part::ManufacturerName, Limit::Equal),
            Bound::ProductName => (Part::ProductName, Limit::Equal),
            Bound::SerialLow => (Part::SerialNumber, Limit::Lowest),
            Bound::SerialHigh => (Part::SerialNumber, Limit::Highest),
        }
    }

    fn bit_rate(index: u8) -> Option<u32> {
        BIT_RATES.get(usize::from(index)).copied()
    }

    fn error_name(_: ConfigureCommand, error: u8) -> Option<&'static str> {
        (error == 255).then_some("application-specific error")
    }

    /// `"LMP30"`, or the digits of a serial number.
    fn words(part: Part, Seven(bytes): Seven) -> impl Display {
        fmt::from_fn(move |f| {
            if part == Part::SerialNumber {
                return hex::compact(&bytes).fmt(f);
            }
            let filled = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
            write!(f, "\"{}\"", bytes[..filled].escape_ascii())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Wire;
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
        both_ways(&[0x11, 12, 0, 0, 0, 0, 0, 0], Request::ConfigureNodeId { node_id: 12 });
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
        assert_eq!(configured(ConfigureCommand::NodeId, 0, 0), "configure NMT address: successful");
        assert_eq!(configured(ConfigureCommand::BitTiming, 1, 0), "configure bit timing: bit rate not supported");
        assert_eq!(configured(ConfigureCommand::Store, 2, 0), "store configuration: reserved error 2");
        assert_eq!(configured(ConfigureCommand::Store, 255, 7), "store configuration: application-specific error 7");
    }

    #[test]
    fn bit_rates_in_words() {
        let rate = |index| Request::ConfigureBitTiming { table: 0, index }.to_string();
        assert_eq!(rate(4), "configure bit timing: 125 kbit/s");
        assert_eq!(rate(5), "configure bit timing: 50 kbit/s");
        assert_eq!(rate(7), "configure bit timing: 10 kbit/s");
        assert_eq!(rate(8), "configure bit timing: reserved index 8");
    }

    #[test]
    fn names_are_escaped() {
        let hostile = Request::SwitchSelective { part: Part::ProductName, value: Seven(*b"\x1b[31m\"\x00") };
        assert_eq!(hostile.to_string(), "switch mode selective: product name \"\\x1b[31m\\\"\"");
    }

    proptest! {
        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<Request>(&bytes);
            stable::<Response>(&bytes);
        }
    }
}
