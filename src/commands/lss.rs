//! `canvass lss`: layer setting services.

mod lmt;

use super::layer_setting::{Master, OnBus, PATIENCE, Rest, Wish, parse_bit_rate};
use crate::output::{diagnostic, print};
use crate::status::{Failure, Status};
use anyhow::{Context, Result, anyhow};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::lss::{ConfigureCommand, Lss, Part, Request, Response};
use canvass_bus::client::lss::{LssAddress, ScanStep};
use canvass_reports::escape::Printable;
use canvass_traces::Duration;
use serde_json::json;
use std::collections::BTreeMap;
use std::str::FromStr;

/// Read and set node-ID and bit rate by LSS (CiA 305)
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Read a device's LSS address and node-ID
    Inquire {
        #[command(flatten)]
        bus: OnBus,
        #[command(flatten)]
        which: Which,
    },
    /// Give a device a node-ID, a bit rate, or both
    ///
    /// Devices that have LMT (CiA DS-205) in place of LSS understand the same commands, but their table of bit rates
    /// differs: canvass lmt configures them. On a bus with such a device --bit-rate is refused, unless --address names
    /// a device that has LSS.
    Configure {
        #[command(flatten)]
        bus: OnBus,
        #[command(flatten)]
        which: Which,
        /// The node-ID, or none to remove it
        #[arg(long, value_name = "NODE|none", value_parser = parse_node_id)]
        node_id: Option<u8>,
        /// The bit rate, such as 250k; it takes effect when it is activated
        #[arg(long, value_name = "RATE", value_parser = parse_bit_rate::<Lss>)]
        bit_rate: Option<u8>,
        #[command(flatten)]
        rest: Rest,
    },
    /// Find a device without node-ID by Fastscan
    Fastscan {
        #[command(flatten)]
        bus: OnBus,
        /// Assign this node-ID to the device, and the following node-IDs to further devices until none is found; exit
        /// status 1 if a device is found again
        #[arg(long, value_name = "NODE", value_parser = crate::devices::parse_node)]
        assign: Option<NodeId>,
        /// Store the node-IDs in non-volatile memory
        #[arg(long, requires = "assign")]
        store: bool,
    },
}

#[derive(clap::Args)]
struct Which {
    /// The device's LSS address (default: all devices are switched to configuration, so there must be only one)
    #[arg(long, value_name = "VENDOR:PRODUCT:REVISION:SERIAL")]
    address: Option<Address>,
}

#[derive(Clone, Copy)]
struct Address(LssAddress);

impl FromStr for Address {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let number = |part: &str| match part.strip_prefix("0x").or_else(|| part.strip_prefix("0X")) {
            Some(hex) => u32::from_str_radix(hex, 16),
            None => part.parse(),
        };
        let parts: Result<Vec<u32>, _> = text.split(':').map(number).collect();
        let parts = parts.ok().and_then(|parts| LssAddress::try_from(parts).ok());
        parts.map(Self).with_context(|| {
            format!("expected vendor-ID, product code, revision and serial number, such as 0x13:0x1:0x2:0x3, found \"{text}\"")
        })
    }
}

fn parse_node_id(text: &str) -> Result<u8> {
    if text == "none" { Ok(NO_NODE_ID) } else { crate::devices::parse_node(text).map(NodeId::raw) }
}

/// The value of the node-ID that means "not configured".
const NO_NODE_ID: u8 = 255;
/// Default timeout for a Fastscan request: silence is one of its two answers, so most requests wait that long.
const SCAN_PATIENCE: Duration = Duration::from_millis(30);
const WAITING: Request = Request::SwitchGlobal { mode: 0 };
const CONFIGURATION: Request = Request::SwitchGlobal { mode: 1 };

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        match self.action {
            Action::Inquire { bus, which } => bus.run(PATIENCE, |master| master.inquire(&which)),
            Action::Configure { bus, which, node_id, bit_rate, rest } => {
                let wish = Wish { node_id, bit_rate, rest };
                wish.expect_something()?;
                bus.run(PATIENCE, |master| master.configure(&which, &wish))
            }
            Action::Fastscan { bus, assign, store } => bus.run(SCAN_PATIENCE, |master| master.fastscan(assign, store)),
        }
    }
}

impl Master<'_> {
    /// Switches the device to the configuration state.
    fn select(&mut self, which: &Which) -> Result<(), Failure> {
        let Some(Address(address)) = which.address else { return self.tell(&CONFIGURATION) };
        self.tell(&WAITING)?;
        let [vendor, product, revision, serial] = address;
        for (part, value) in Part::ALL.into_iter().zip([vendor, product, revision]) {
            self.tell(&Request::SwitchSelective { part, value })?;
        }
        match self.ask(&Request::SwitchSelective { part: Part::SerialNumber, value: serial })? {
            Response::Switched => Ok(()),
            other => Err(anyhow!("expected \"{}\", found \"{other}\"", Response::Switched).into()),
        }
    }

    fn address(&mut self) -> Result<LssAddress, Failure> {
        let mut address = LssAddress::default();
        for (part, slot) in Part::ALL.into_iter().zip(&mut address) {
            match self.ask(&Request::Inquire { part })? {
                Response::Part { part: found, value } if found == part => *slot = value,
                other => return Err(anyhow!("expected the {}, found \"{other}\"", part.name()).into()),
            }
        }
        Ok(address)
    }

    fn inquire(&mut self, which: &Which) -> Result<Status, Failure> {
        self.select(which)?;
        if which.address.is_none() {
            self.refuse_only_lmt()?;
        }
        let address = self.address()?;
        let node_id = match self.ask(&Request::InquireNodeId)? {
            Response::NodeId(node_id) => node_id,
            other => return Err(anyhow!("expected the node-ID, found \"{other}\"").into()),
        };
        self.print(address, Some(node_id))?;
        Ok(Status::Good)
    }

    fn configure(&mut self, which: &Which, wish: &Wish) -> Result<Status, Failure> {
        self.select(which)?;
        // With `--address` only the selected slave is in configuration, and the answer to its selection has shown that
        // it has LSS.
        if let (Some(index), None) = (wish.bit_rate, &which.address) {
            self.refuse_lmt(index)?;
        }
        self.carry_out::<Lss>(wish)
    }

    fn fastscan(&mut self, assign: Option<NodeId>, store: bool) -> Result<Status, Failure> {
        let mut next = assign;
        let mut seen = BTreeMap::new();
        loop {
            match self.exchange.fastscan(self.patience).map_err(Failure::unreachable)? {
                ScanStep::Found(address) => {
                    if let Some(node) = seen.insert(address, next) {
                        self.print(address, node.map(NodeId::raw))?;
                        diagnostic(&format!("canvass: {}", found_again(address, node)));
                        return Ok(Status::Findings);
                    }
                    if let Some(node) = next {
                        self.configured(ConfigureCommand::NodeId, &Request::ConfigureNodeId { node_id: node.raw() })?;
                        if store {
                            self.configured(ConfigureCommand::Store, &Request::StoreConfiguration)?;
                        }
                    }
                    self.print(address, next.map(NodeId::raw))?;
                    self.tell(&WAITING)?;
                    let Some(node) = next else { break };
                    next = NodeId::new(node.raw() + 1);
                    if next.is_none() {
                        break;
                    }
                }
                ScanStep::Lost(part) => {
                    let why = format!("no answer to the {} confirmed it: wait longer with --timeout", part.name());
                    return Err(Failure::unreachable(anyhow!(why)));
                }
                ScanStep::Nobody | ScanStep::Ask(_) => break,
            }
        }
        if seen.is_empty() {
            return Err(Failure::unreachable(anyhow!("no device without a node-ID was found")));
        }
        Ok(Status::Good)
    }

    fn print(&self, address: LssAddress, node_id: Option<u8>) -> Result<(), Failure> {
        let node_id = node_id.filter(|&node_id| node_id != NO_NODE_ID);
        let [vendor, product, revision, serial] = address;
        if self.json {
            let document = json!({
                "schema": "canvass/lss/1", "vendor_id": vendor, "product_code": product, "revision_number": revision,
                "serial_number": serial, "node": node_id,
            });
            return Ok(print(&Printable::json(&document))?);
        }
        let node_id = node_id.map_or_else(|| "none".to_owned(), |node_id| node_id.to_string());
        Ok(print(&Printable::document(&format!(
            "vendor-ID {vendor:08X}h, product code {product:08X}h, revision number {revision:08X}h, serial number \
             {serial:08X}h, node-ID {node_id}\n"
        )))?)
    }
}

/// The error with which a Fastscan stops that finds a configured device again. Without the stop, Fastscan would assign
/// one node-ID after the other to this device, and store each.
fn found_again(address: LssAddress, node: Option<NodeId>) -> String {
    let [vendor, product, revision, serial] = address;
    let given = node.map(|node| format!("was given node-ID {node} and ")).unwrap_or_default();
    format!(
        "the device with vendor-ID {vendor:08X}h, product code {product:08X}h, revision number {revision:08X}h and \
         serial number {serial:08X}h {given}answers Fastscan again: either it takes part although it is configured, \
         or two devices have the same LSS address; the scan ends here"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_and_bit_rates() {
        let address: Address = "0x13:2:0xFFFFFFFF:0".parse().unwrap();
        assert_eq!(address.0, [0x13, 2, u32::MAX, 0]);
        assert!("1:2:3".parse::<Address>().is_err() && "1:2:3:x".parse::<Address>().is_err());
        assert_eq!(parse_bit_rate::<Lss>("250k").unwrap(), 3);
        assert_eq!(parse_bit_rate::<Lss>("1M").unwrap(), 0);
        assert!(parse_bit_rate::<Lss>("300k").is_err() && parse_bit_rate::<Lss>("").is_err());
    }
}
