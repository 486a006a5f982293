//! `canvass lmt`: layer management, the predecessor of LSS.

use super::layer_setting::{Master, OnBus, PATIENCE, Rest, Wish, parse_bit_rate};
use crate::output::print;
use crate::status::{Failure, Status};
use anyhow::{Context, Result, anyhow, ensure};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lmt::{Bound, Lmt, Part, Request, Response, Seven};
use canvass_reports::escape::Printable;
use serde_json::json;
use std::str::FromStr;

/// Read and set node-ID and bit rate by LMT (CiA DS-205), which older devices have in place of LSS
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Read a device's manufacturer name, product name and serial number
    ///
    /// LMT has no inquiry of the node-ID.
    Inquire {
        #[command(flatten)]
        bus: OnBus,
        #[command(flatten)]
        which: Which,
    },
    /// Ask whether there is a device with these names, and a serial number within these bounds
    ///
    /// All devices with LMT take part, and none has to be in configuration. Several may answer at once.
    Identify {
        #[command(flatten)]
        bus: OnBus,
        /// The manufacturer name, up to seven characters
        #[arg(long, value_name = "NAME", value_parser = parse_name)]
        manufacturer: Seven,
        /// The product name, up to seven characters
        #[arg(long, value_name = "NAME", value_parser = parse_name)]
        product: Seven,
        /// The lowest and the highest serial number, 14 digits each
        #[arg(long, value_name = "LOW..HIGH", default_value = "00000000000000..99999999999999")]
        serial: Serials,
    },
    /// Give a device a node-ID, a bit rate, or both
    ///
    /// The row of a bit rate is that of the table of LMT, which differs from that of LSS. Nothing is configured if no
    /// device answers to LMT.
    Configure {
        #[command(flatten)]
        bus: OnBus,
        #[command(flatten)]
        which: Which,
        /// The node-ID, which LMT calls the NMT address
        #[arg(long, value_name = "NODE", value_parser = crate::devices::parse_node)]
        node_id: Option<NodeId>,
        /// The bit rate, such as 250k; it takes effect when it is activated, or stored and the device switched on again
        #[arg(long, value_name = "RATE", value_parser = parse_bit_rate::<Lmt>)]
        bit_rate: Option<u8>,
        #[command(flatten)]
        rest: Rest,
    },
}

#[derive(clap::Args)]
struct Which {
    /// The device's LMT address (default: all devices are switched to configuration, so there must be only one)
    #[arg(long = "slave", value_name = "MANUFACTURER:PRODUCT:SERIAL")]
    address: Option<Address>,
}

/// An LMT address: manufacturer name, product name and serial number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Address([Seven; 3]);

/// The lowest and the highest serial number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Serials([Seven; 2]);

fn parse_name(text: &str) -> Result<Seven> {
    let name = Seven::name(text).filter(|_| text.is_ascii() && !text.is_empty());
    name.with_context(|| format!("expected a name of one to seven characters such as TR-ELEC, found \"{text}\""))
}

/// Parses the 14 digits of a serial number; shorter numbers are filled with zeros on the left.
fn parse_serial(text: &str) -> Result<Seven> {
    let expected = || format!("expected a serial number of up to 14 digits, found \"{text}\"");
    ensure!((1..=14).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit()), expected());
    let digits = format!("{text:0>14}");
    let mut bytes = [0; 7];
    for (byte, pair) in bytes.iter_mut().zip(digits.as_bytes().chunks_exact(2)) {
        *byte = (pair[0] - b'0') << 4 | (pair[1] - b'0');
    }
    Ok(Seven(bytes))
}

impl FromStr for Address {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let parts: Vec<&str> = text.split(':').collect();
        let [manufacturer, product, serial] = parts[..] else {
            return Err(anyhow!(
                "expected manufacturer name, product name and serial number, such as TR-ELEC:LMP30:32200044002100, \
                 found \"{text}\""
            ));
        };
        Ok(Self([parse_name(manufacturer)?, parse_name(product)?, parse_serial(serial)?]))
    }
}

impl FromStr for Serials {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (low, high) = text.split_once("..").unwrap_or((text, text));
        Ok(Self([parse_serial(low)?, parse_serial(high)?]))
    }
}

const OPERATION: Request = Request::SwitchGlobal { mode: 0 };
const CONFIGURATION: Request = Request::SwitchGlobal { mode: 1 };

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        match self.action {
            Action::Inquire { bus, which } => bus.run(PATIENCE, |master| inquire(master, &which)),
            Action::Identify { bus, manufacturer, product, serial } => {
                bus.run(PATIENCE, |master| identify(master, manufacturer, product, serial))
            }
            Action::Configure { bus, which, node_id, bit_rate, rest } => {
                let wish = Wish { node_id: node_id.map(NodeId::raw), bit_rate, rest };
                wish.expect_something()?;
                bus.run(PATIENCE, |master| configure(master, &which, &wish))
            }
        }
    }
}

/// Switches the device to configuration. A slave does not confirm that it was addressed.
fn select(master: &mut Master<'_>, which: &Which) -> Result<(), Failure> {
    let Some(Address(address)) = which.address else { return master.tell(&CONFIGURATION) };
    master.tell(&OPERATION)?;
    let mut parts = Part::ALL.into_iter().zip(address);
    parts.try_for_each(|(part, value)| master.tell(&Request::SwitchSelective { part, value }))
}

/// The LMT address of the slave in configuration. An LSS slave does not know this inquiry.
fn address(master: &mut Master<'_>) -> Result<Address, Failure> {
    let mut address = [Seven([0; 7]); 3];
    for (part, slot) in Part::ALL.into_iter().zip(&mut address) {
        match master.ask(&Request::Inquire { part })? {
            Response::Part { part: found, value } if found == part => *slot = value,
            other => return Err(anyhow!("expected the {}, found \"{other}\"", part.name()).into()),
        }
    }
    Ok(Address(address))
}

fn inquire(master: &mut Master<'_>, which: &Which) -> Result<Status, Failure> {
    select(master, which)?;
    let Address(address) = address(master)?;
    let words: Vec<String> =
        Part::ALL.into_iter().zip(address).map(|(part, value)| Lmt::words(part, value).to_string()).collect();
    let [manufacturer, product, serial] = &words[..] else { return Err(anyhow!("expected three parts").into()) };
    let text = match master.json {
        true => {
            let unquoted = |name: &str| name.trim_matches('"').to_owned();
            Printable::json(&json!({
                "schema": "canvass/lmt/1", "manufacturer_name": unquoted(manufacturer),
                "product_name": unquoted(product), "serial_number": serial,
            }))
        }
        false => Printable::document(&format!(
            "manufacturer name {manufacturer}, product name {product}, serial number {serial}\n"
        )),
    };
    print(&text)?;
    Ok(Status::Good)
}

fn identify(
    master: &mut Master<'_>,
    manufacturer: Seven,
    product: Seven,
    Serials([low, high]): Serials,
) -> Result<Status, Failure> {
    let bounds = [(Bound::ManufacturerName, manufacturer), (Bound::ProductName, product), (Bound::SerialLow, low)];
    for (bound, value) in bounds {
        master.tell(&Request::IdentifyRemote { bound, value })?;
    }
    match master.ask(&Request::IdentifyRemote { bound: Bound::SerialHigh, value: high })? {
        response @ Response::Identified if !master.json => print(&Printable::document(&format!("{response}\n")))?,
        Response::Identified => {
            print(&Printable::json(&json!({ "schema": "canvass/lmt-identify/1", "identified": true })))?;
        }
        other => return Err(anyhow!("expected \"{}\", found \"{other}\"", Response::Identified).into()),
    }
    Ok(Status::Good)
}

fn configure(master: &mut Master<'_>, which: &Which, wish: &Wish) -> Result<Status, Failure> {
    select(master, which)?;
    let found = address(master)?;
    if let Some(wanted) = which.address.filter(|wanted| *wanted != found) {
        let shown = |Address(parts): Address| {
            let parts = Part::ALL.into_iter().zip(parts).map(|(part, value)| Lmt::words(part, value).to_string());
            parts.collect::<Vec<_>>().join(", ")
        };
        return Err(anyhow!("expected the device {}, found {}", shown(wanted), shown(found)).into());
    }
    master.carry_out::<Lmt>(wish)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_serial_numbers_and_bit_rates() {
        let address: Address = "TR-ELEC:LMP30:32200044002100".parse().unwrap();
        let serial = Seven([0x32, 0x20, 0x00, 0x44, 0x00, 0x21, 0x00]);
        assert_eq!(address.0, [Seven::name("TR-ELEC").unwrap(), Seven::name("LMP30").unwrap(), serial]);
        assert_eq!(parse_serial("7").unwrap(), Seven([0, 0, 0, 0, 0, 0, 7]));
        for wrong in ["", "123456789012345", "12a"] {
            assert!(parse_serial(wrong).is_err(), "{wrong}");
        }
        assert!("TR-ELEC:LMP30".parse::<Address>().is_err() && "TOO-LONG:A:1".parse::<Address>().is_err());
        let serials: Serials = "1..99".parse().unwrap();
        assert_eq!(serials.0, [parse_serial("1").unwrap(), parse_serial("99").unwrap()]);
        // In LSS 50k is row 6.
        assert_eq!((parse_bit_rate::<Lmt>("50k").unwrap(), parse_bit_rate::<Lmt>("10k").unwrap()), (5, 7));
    }
}
