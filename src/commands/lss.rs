//! `canvass lss`: layer setting services.

mod lmt;

use crate::live::{ClientArg, Live, parse_span};
use crate::output::{TextOrJson, diagnostic, print};
use crate::status::{Failure, Status};
use anyhow::{Context, Result, anyhow};
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lss::{ConfigureCommand, Lss, MASTER_CAN_ID, Part, Request, Response, SLAVE_CAN_ID};
use canvass_analyzer::{NodeId, wire::Wire};
use canvass_bus::client::Exchange;
use canvass_bus::client::lss::{LssAddress, ScanStep};
use canvass_reports::escape::Printable;
use canvass_traces::{Duration, Record, Timestamp};
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
    /// differs. On a bus with such a device --bit-rate is refused, unless --address names a device that has LSS.
    Configure {
        #[command(flatten)]
        bus: OnBus,
        #[command(flatten)]
        which: Which,
        /// The node-ID, or none to remove it
        #[arg(long, value_name = "NODE|none", value_parser = parse_node_id)]
        node_id: Option<u8>,
        /// The bit rate, such as 250k; it takes effect when it is activated
        #[arg(long, value_name = "RATE", value_parser = parse_bit_rate)]
        bit_rate: Option<u8>,
        /// Store both in non-volatile memory
        #[arg(long)]
        store: bool,
        /// Make all devices change to the bit rate that was set for them, with a pause of this length before and after
        /// the change, such as 100ms
        #[arg(long, value_name = "SPAN", value_parser = parse_delay)]
        activate: Option<u16>,
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
struct OnBus {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// How long to wait for each answer, such as 100ms. Fastscan waits up to 68 times for each device, "store" waits
    /// at least 10 s
    #[arg(long, value_name = "SPAN", value_parser = parse_span)]
    timeout: Option<Duration>,
    /// How to print the result
    #[arg(long, value_enum, default_value_t)]
    format: TextOrJson,
    /// Same as --format json (former name)
    #[arg(long, hide = true)]
    json: bool,
    #[command(flatten)]
    client: ClientArg,
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

/// Parses a bit rate into its index in table 0 of CiA 305.
fn parse_bit_rate(text: &str) -> Result<u8> {
    let number = |digits: &str, factor: u32| digits.parse::<u32>().ok()?.checked_mul(factor);
    let rate = match text.char_indices().last() {
        Some((at, 'k' | 'K')) => number(&text[..at], 1_000),
        Some((at, 'M')) => number(&text[..at], 1_000_000),
        _ => number(text, 1),
    };
    rate.and_then(Lss::bit_rate_index).with_context(|| {
        let known: Vec<_> = (0..=u8::MAX).filter_map(Lss::bit_rate).map(|rate| format!("{}k", rate / 1000)).collect();
        format!("expected one of {}, found \"{text}\"", known.join(", "))
    })
}

/// The value of the node-ID that means "not configured".
const NO_NODE_ID: u8 = 255;
/// Default timeout for an answer.
const PATIENCE: Duration = Duration::from_millis(1_000);
/// Timeout for "store": the slave erases and writes its memory before it answers.
const STORE_PATIENCE: Duration = Duration::from_millis(10_000);
/// Default timeout for a Fastscan request: silence is one of its two answers, so most requests wait that long.
const SCAN_PATIENCE: Duration = Duration::from_millis(30);
const WAITING: Request = Request::SwitchGlobal { mode: 0 };
const CONFIGURATION: Request = Request::SwitchGlobal { mode: 1 };

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        match self.action {
            Action::Inquire { bus, which } => bus.run(PATIENCE, |master| master.inquire(&which)),
            Action::Configure { bus, which, node_id, bit_rate, store, activate } => {
                if node_id.is_none() && bit_rate.is_none() && !store && activate.is_none() {
                    return Err(anyhow!("nothing to do: use --node-id, --bit-rate, --store or --activate").into());
                }
                let wish = Wish { node_id, bit_rate, store, activate };
                bus.run(PATIENCE, |master| master.configure(&which, wish))
            }
            Action::Fastscan { bus, assign, store } => bus.run(SCAN_PATIENCE, |master| master.fastscan(assign, store)),
        }
    }
}

#[derive(Clone, Copy)]
struct Wish {
    node_id: Option<u8>,
    bit_rate: Option<u8>,
    store: bool,
    activate: Option<u16>,
}

/// Parses the delay of "activate bit timing": whole milliseconds in 16 bits.
fn parse_delay(text: &str) -> Result<u16> {
    let millis = parse_span(text)?.nanos() / 1_000_000;
    u16::try_from(millis)
        .ok()
        .filter(|millis| *millis > 0)
        .ok_or_else(|| anyhow!("expected 1ms to 65s, found \"{text}\""))
}

impl OnBus {
    fn run(
        &self,
        patience: Duration,
        act: impl FnOnce(&mut Master<'_>) -> Result<Status, Failure>,
    ) -> Result<Status, Failure> {
        let mut live = Live::open(&self.bus, None, &[], self.client)?;
        let wanted = [(MASTER_CAN_ID, 0x7FF), (SLAVE_CAN_ID, 0x7FF)];
        live.bus.only(&wanted).map_err(Failure::unreachable)?;
        let patience = self.timeout.unwrap_or(patience);
        let mut observe = |_: &Record| {};
        let exchange = Exchange { bus: live.bus.as_mut(), observe: &mut observe, ends: Timestamp::MAX };
        let mut master = Master { exchange, patience, json: self.json || matches!(self.format, TextOrJson::Json) };
        let acted = act(&mut master);
        // No device may stay in configuration, even after an error.
        let left = master.tell(&WAITING);
        let status = acted?;
        left?;
        live.report_health();
        Ok(status)
    }
}

struct Master<'a> {
    exchange: Exchange<'a>,
    patience: Duration,
    json: bool,
}

impl Master<'_> {
    fn ask(&mut self, request: &Request) -> Result<Response, Failure> {
        let usual = if *request == Request::StoreConfiguration { STORE_PATIENCE } else { PATIENCE };
        let response = self.exchange.ask(request, self.patience.max(usual)).map_err(Failure::unreachable)?;
        response.ok_or_else(|| Failure::unreachable(anyhow!("no device answers to \"{request}\"")))
    }

    /// Sends a request that slaves do not answer.
    fn tell(&mut self, request: &Request) -> Result<(), Failure> {
        self.exchange.bus.send(&request.to_frame(MASTER_CAN_ID)).map_err(Failure::unreachable)?;
        // A slave needs time to process this request before it can take the next.
        self.exchange.wait_for(Duration::from_millis(5), |_| None::<()>).map_err(Failure::unreachable)?;
        Ok(())
    }

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

    fn configure(&mut self, which: &Which, wish: Wish) -> Result<Status, Failure> {
        self.select(which)?;
        // With `--address` only the selected slave is in configuration, and the answer to its selection has shown that
        // it has LSS.
        if let (Some(index), None) = (wish.bit_rate, &which.address) {
            self.refuse_lmt(index)?;
        }
        if let Some(node_id) = wish.node_id {
            self.configured(ConfigureCommand::NodeId, &Request::ConfigureNodeId { node_id })?;
        }
        if let Some(index) = wish.bit_rate {
            self.configured(ConfigureCommand::BitTiming, &Request::ConfigureBitTiming { table: 0, index })?;
        }
        if wish.store {
            self.configured(ConfigureCommand::Store, &Request::StoreConfiguration)?;
        }
        if let Some(delay) = wish.activate {
            self.tell(&Request::ActivateBitTiming { delay })?;
            diagnostic(&format!(
                "canvass: all devices change their bit rate in {delay} ms: change that of this interface too"
            ));
        }
        Ok(Status::Good)
    }

    /// Sends a configuration command; every answer but success is an error.
    fn configured(&mut self, command: ConfigureCommand, request: &Request) -> Result<(), Failure> {
        let response = self.ask(request)?;
        let Response::Configured { command: found, error: 0, .. } = response else {
            return Err(anyhow!("{request}: the device answers \"{response}\"").into());
        };
        if found != command {
            return Err(anyhow!("{request}: the device answers \"{response}\"").into());
        }
        if !self.json {
            print(&Printable::document(&format!("{response}\n")))?;
        }
        Ok(())
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
        assert_eq!(parse_bit_rate("250k").unwrap(), 3);
        assert_eq!(parse_bit_rate("1M").unwrap(), 0);
        assert!(parse_bit_rate("300k").is_err() && parse_bit_rate("").is_err());
    }
}
