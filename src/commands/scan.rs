//! `canvass scan`: finds the nodes on a bus and reads their identities.

mod bit_rate;

use crate::interrupt::Interrupt;
use crate::live::{ClientArg, Live, parse_span};
use crate::output::{TextOrJson, print};
use crate::reconnect::ReconnectArg;
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_analyzer::network::{Candidates, Shown};
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::{Wire, lss, sdo};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::client::Exchange;
use canvass_bus::client::lss::{LssAddress, ScanStep};
use canvass_bus::client::sdo::{Outcome, Transfer};
use canvass_bus::{BusError, PatientBus};
use canvass_device::address::parse_bit_rate;
use canvass_device::models::Model;
use canvass_reports::escape::{Printable, printable};
use canvass_traces::{Duration, Record, Timestamp};
use serde_json::{Value, json};
use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write;
use std::sync::Arc;
use std::time::Instant;

/// Find the nodes on a bus: by their heartbeats, by SDO and, those without node-ID, by LSS Fastscan
///
/// canvass changes nothing in any device. Exit status 3 if no node is found, or if the scan was not completed.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// Only listen: send nothing
    #[arg(long)]
    passive: bool,
    /// The bit rate of the bus, such as 250k. The word auto finds it by listening at one after the other, without sending or
    /// acknowledging anything
    #[arg(long, value_name = "RATE", value_parser = BitRate::parse)]
    bit_rate: Option<BitRate>,
    /// Leave out Fastscan
    #[arg(long)]
    no_lss: bool,
    /// How long to listen for heartbeats, and at each bit rate
    #[arg(long, default_value = "1.2s", value_name = "SPAN", value_parser = parse_span)]
    listen: Duration,
    /// How long to wait for answers
    #[arg(long, default_value = "200ms", value_name = "SPAN", value_parser = parse_span)]
    timeout: Duration,
    /// Time limit of the whole scan
    #[arg(long = "for", default_value = "2min", value_name = "SPAN", value_parser = parse_span)]
    span: Duration,
    /// How to print the nodes
    #[arg(long, value_enum, default_value_t)]
    format: TextOrJson,
    #[command(flatten)]
    client: ClientArg,
    #[command(flatten)]
    reconnect: ReconnectArg,
}

/// A value of `--bit-rate`.
#[derive(Clone, Copy)]
enum BitRate {
    /// Is looked for.
    Auto,
    /// In bit/s.
    Known(u32),
}

impl BitRate {
    fn parse(text: &str) -> Result<Self, String> {
        if text.eq_ignore_ascii_case("auto") {
            return Ok(Self::Auto);
        }
        parse_bit_rate(text).map(Self::Known).map_err(|error| format!("{error}, or auto"))
    }
}

/// The facts about a node.
#[derive(Default)]
struct Found {
    state: Option<State>,
    answers: bool,
    /// The identity objects that the node has.
    shown: Shown,
}

const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);
const NAMES: [(u16, &str); 3] = [
    (object::MANUFACTURER_DEVICE_NAME, "name"),
    (object::MANUFACTURER_HARDWARE_VERSION, "hardware"),
    (object::MANUFACTURER_SOFTWARE_VERSION, "software"),
];
/// Names of the sub-indexes 01 to 04 of 1018h.
const PARTS: [&str; 4] = ["vendor-ID", "product code", "revision number", "serial number"];
/// Number of last frames quoted when a scan can't be completed.
const LAST: usize = 8;
/// Default timeout for a Fastscan request.
const SCAN_PATIENCE: Duration = Duration::from_millis(30);
/// Default timeout for any other LSS request.
const LSS_PATIENCE: Duration = Duration::from_millis(1_000);

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let mut live = Live::open(&self.bus, None, &[], self.client)?;
        let interrupt = Interrupt::watch()?;
        let mut last = VecDeque::with_capacity(LAST);
        let ends = live.bus.now() + self.span;
        // `Live` has waited for the boot-up of the simulated device, which proves the node as a heartbeat would.
        let nodes = live.simulated_node().map(|node| (node, Found::default())).into_iter().collect();
        let bit_rate = self.take_bit_rate(&mut live, &interrupt)?;
        let mut scan = Scan { bit_rate, nodes, unconfigured: None, is_complete: false };
        let found = self.find(&mut live, &interrupt, ends, &mut last, &mut scan);
        // If the bus was lost, the nodes found before are printed all the same.
        match self.format {
            TextOrJson::Text => print(&Printable::document(&text(&scan)))?,
            TextOrJson::Json => print(&Printable::json(&json(&scan)))?,
        }
        live.report_health();
        found.map_err(|error| Failure::unreachable(anyhow::Error::new(error).context("the scan was not completed")))?;
        if live.bus.now() >= ends {
            let frames: Vec<String> = last.iter().rev().map(|record| record.frame.to_string()).collect();
            return Err(Failure::unreachable(anyhow!(
                "the scan was not completed within {} (--for): the devices, or the adapter, do not follow the \
                 protocol; the last frames: {}",
                self.span,
                frames.join(", ")
            )));
        }
        let found = !scan.nodes.is_empty() || scan.unconfigured.is_some();
        Ok(if found { Status::Good } else { Status::Unreachable })
    }

    /// Takes part in the bus at the bit rate that is asked for; returns the one that was found.
    fn take_bit_rate(&self, live: &mut Live, interrupt: &Interrupt) -> Result<Option<bit_rate::Heard>, Failure> {
        let failed = |error: BusError| Failure::unreachable(anyhow::Error::new(error));
        match self.bit_rate {
            None => Ok(None),
            Some(BitRate::Known(rate)) => live.bus.set_bit_rate(rate).map(|()| None).map_err(failed),
            Some(BitRate::Auto) => {
                let search = bit_rate::search(live.bus.as_mut(), self.listen, interrupt).map_err(failed)?;
                match search.found() {
                    Some(heard) => Ok(Some(*heard)),
                    None => Err(Failure::unreachable(anyhow!("{}", search.failure()))),
                }
            }
        }
    }

    fn find(
        &self,
        live: &mut Live,
        interrupt: &Interrupt,
        ends: Timestamp,
        last: &mut VecDeque<Record>,
        scan: &mut Scan,
    ) -> Result<(), BusError> {
        let mut observe = |record: &Record| {
            last.truncate(LAST - 1);
            last.push_front(record.clone());
        };
        let end = Instant::now() + std::time::Duration::from(self.span);
        let mut bus = PatientBus::new(live.bus.as_mut(), self.reconnect.until(Some(end), interrupt.flag()));
        let mut exchange = Exchange { bus: &mut bus, observe: &mut observe, ends };
        undisturbed(&mut exchange, |exchange| listen(exchange, self.listen, &mut scan.nodes))?;
        if !self.passive {
            self.ask(&mut exchange, interrupt, scan)?;
        }
        scan.is_complete = !interrupt.came() && exchange.bus.now() < ends;
        Ok(())
    }

    fn ask(&self, exchange: &mut Exchange<'_>, interrupt: &Interrupt, scan: &mut Scan) -> Result<(), BusError> {
        undisturbed(exchange, |exchange| knock(exchange, self.timeout, &mut scan.nodes))?;
        for (&node, found) in scan.nodes.iter_mut().filter(|(_, found)| found.answers) {
            if interrupt.came() || exchange.bus.now() >= exchange.ends {
                return Ok(());
            }
            undisturbed(exchange, |exchange| ask(exchange, node, self.timeout, found))?;
        }
        if self.no_lss || interrupt.came() || exchange.bus.now() >= exchange.ends {
            return Ok(());
        }
        scan.unconfigured = undisturbed(exchange, |exchange| fastscan(exchange, &scan.nodes))?;
        Ok(())
    }
}

/// Number of tries for a request while the bus is interrupted at each try.
const MOST_TRIES: u32 = 5;

/// Calls `act`, and repeats the call if the bus was interrupted meanwhile: a missing answer then says nothing about the
/// device.
fn undisturbed<T>(
    exchange: &mut Exchange<'_>,
    mut act: impl FnMut(&mut Exchange<'_>) -> Result<T, BusError>,
) -> Result<T, BusError> {
    for _ in 1..MOST_TRIES {
        exchange.bus.wait_until_back()?;
        let before = exchange.bus.health();
        let done = act(exchange)?;
        if exchange.bus.health().since(&before).interruptions == 0 || exchange.bus.now() >= exchange.ends {
            return Ok(done);
        }
    }
    act(exchange)
}

/// The nodes and the unconfigured device that a scan found.
struct Scan {
    /// The bit rate that `--bit-rate auto` found.
    bit_rate: Option<bit_rate::Heard>,
    nodes: BTreeMap<NodeId, Found>,
    /// The device that Fastscan found.
    unconfigured: Option<Scanned>,
    /// Whether the scan was completed.
    is_complete: bool,
}

/// A device that Fastscan found.
#[derive(Clone, Copy)]
struct Scanned {
    address: LssAddress,
    /// The node-ID of a device that takes part in Fastscan although it is configured.
    node: Option<NodeId>,
}

/// Looks for a device by Fastscan: a device without node-ID, or a configured device that wrongly takes part.
fn fastscan(exchange: &mut Exchange<'_>, nodes: &BTreeMap<NodeId, Found>) -> Result<Option<Scanned>, BusError> {
    let scanned = match exchange.fastscan(SCAN_PATIENCE)? {
        ScanStep::Found(address) => Some(Scanned { address, node: configured(exchange, address, nodes)? }),
        _ => None,
    };
    // A found device would otherwise stay in the configuration state.
    exchange.bus.send(&lss::Request::SwitchGlobal { mode: 0 }.to_frame(lss::MASTER_CAN_ID))?;
    Ok(scanned)
}

/// The node-ID of the device that Fastscan left in configuration. If the device does not answer the inquiry and its
/// serial number is not 0, it is taken to be the first node with the same identity.
fn configured(
    exchange: &mut Exchange<'_>,
    address: LssAddress,
    nodes: &BTreeMap<NodeId, Found>,
) -> Result<Option<NodeId>, BusError> {
    if let Some(lss::Response::NodeId(node_id)) = exchange.ask(&lss::Request::InquireNodeId, LSS_PATIENCE)? {
        return Ok(NodeId::new(node_id));
    }
    let is_it = |found: &Found| [1, 2, 3, 4].map(|sub| found.part(sub)) == address.map(Some) && address[3] != 0;
    Ok(nodes.iter().find(|(_, found)| is_it(found)).map(|(node, _)| *node))
}

/// Collects the nodes that send heartbeats or boot-ups.
fn listen(exchange: &mut Exchange<'_>, span: Duration, nodes: &mut BTreeMap<NodeId, Found>) -> Result<(), BusError> {
    exchange.wait_for(span, |record| {
        let cob_id = record.frame.cob_id()?;
        let node = NodeId::of_cob_id(cob_id)?;
        if cob_id & 0x780 == error_control::CAN_ID_BASE
            && let Ok(message) = ErrorControl::read(record.frame.data())
        {
            nodes.entry(node).or_default().state = Some(message.state);
        }
        None::<()>
    })?;
    Ok(())
}

/// Reads the device type of all node-IDs at once: existing nodes answer.
fn knock(exchange: &mut Exchange<'_>, patience: Duration, nodes: &mut BTreeMap<NodeId, Found>) -> Result<(), BusError> {
    for node in NodeId::all() {
        let request = sdo::Request::upload(DEVICE_TYPE);
        exchange.bus.send(&request.to_frame(sdo::REQUEST_BASE + u16::from(node.raw())))?;
    }
    exchange.wait_for(patience, |record| {
        let cob_id = record.frame.cob_id().filter(|cob_id| cob_id & 0x780 == sdo::RESPONSE_BASE)?;
        nodes.entry(NodeId::of_cob_id(cob_id)?).or_default().answers = true;
        None::<()>
    })?;
    Ok(())
}

/// The nodes that answer a request for their device type.
pub fn answering(exchange: &mut Exchange<'_>, patience: Duration) -> Result<Vec<NodeId>, BusError> {
    let mut nodes = BTreeMap::new();
    undisturbed(exchange, |exchange| knock(exchange, patience, &mut nodes))?;
    Ok(nodes.into_iter().filter(|(_, found)| found.answers).map(|(node, _)| node).collect())
}

/// Reads the identity of a node.
fn ask(exchange: &mut Exchange<'_>, node: NodeId, patience: Duration, found: &mut Found) -> Result<(), BusError> {
    for object in Candidates::objects() {
        if let Outcome::Uploaded(value) = exchange.transfer(node, Transfer::upload(object), patience)? {
            found.shown.insert(object, value);
        }
    }
    Ok(())
}

/// Built-in models that a node may be.
enum Models {
    /// Models that match all objects read.
    Fitting(Vec<Arc<str>>),
    /// A model of the same vendor and device profile.
    Similar(&'static Model),
    None,
}

impl Found {
    fn models(&self) -> Models {
        let fitting = Model::candidates().fitting(&self.shown);
        if !fitting.is_empty() {
            return Models::Fitting(fitting);
        }
        let vendor = self.part(1);
        let is_similar = |model: &&Model| {
            let same_profile = self.profile().is_some() && model.description().device_profile() == self.profile();
            same_profile && vendor.is_some() && vendor_of(model) == vendor
        };
        Model::all().iter().find(is_similar).map_or(Models::None, Models::Similar)
    }

    fn number(&self, object: Multiplexer) -> Option<u32> {
        Some(u32::from_le_bytes(*self.shown.get(&object)?.first_chunk()?))
    }

    fn text(&self, index: u16) -> Option<String> {
        let value = self.shown.get(&Multiplexer::new(index, 0))?;
        Some(String::from_utf8_lossy(value).into_owned())
    }

    fn device_type(&self) -> Option<u32> {
        self.number(DEVICE_TYPE)
    }

    /// A value of 1018h, by its sub-index.
    fn part(&self, sub: u8) -> Option<u32> {
        self.number(Multiplexer::new(object::IDENTITY, sub))
    }

    /// The device profile: the low word of 1000h.
    fn profile(&self) -> Option<u16> {
        self.device_type().map(|device_type| device_type as u16).filter(|&profile| profile > 0)
    }
}

fn vendor_of(model: &Model) -> Option<u32> {
    let entry = model.description().dictionary.entry(Multiplexer::new(object::IDENTITY, 1)).ok();
    let start = entry.and_then(|entry| entry.start_value(NodeId::MAX)?.to_raw()).map(|raw| raw as u32);
    start.or(model.description().device.vendor_number)
}

fn text(Scan { bit_rate, nodes, unconfigured: scanned, .. }: &Scan) -> String {
    // Writing to a string can't fail.
    let mut text = String::new();
    if let Some(heard) = bit_rate {
        let _ = writeln!(text, "bit rate {} kbit/s", heard.bit_rate / 1_000);
    }
    for (node, found) in nodes {
        let state = found.state.map_or_else(|| "no heartbeat".to_owned(), |state| state.to_string());
        let state = if found.state == Some(State(0)) { "has just started".to_owned() } else { state };
        let answers = if found.answers { "" } else { ", does not answer SDOs" };
        let _ = writeln!(text, "node {node}: {state}{answers}");
        if let Some(device_type) = found.device_type() {
            let profile = found.profile().map(|profile| format!(", device profile {profile}")).unwrap_or_default();
            let _ = writeln!(text, "  device type {device_type:08X}h{profile}");
        }
        let parts = PARTS.iter().zip(1..).filter_map(|(name, sub)| Some(format!("{name} {:08X}h", found.part(sub)?)));
        let parts: Vec<String> = parts.collect();
        if !parts.is_empty() {
            let _ = writeln!(text, "  {}", parts.join(", "));
        }
        for (index, name) in NAMES {
            if let Some(value) = found.text(index) {
                let _ = writeln!(text, "  {name} {}", printable(&value));
            }
        }
        let _ = match found.models() {
            Models::Fitting(models) => writeln!(text, "  model {}", models.join(" or ")),
            Models::Similar(model) => writeln!(text, "  model {} (same vendor and profile)", model.id()),
            Models::None => Ok(()),
        };
    }
    if let Some(Scanned { node: Some(node), .. }) = scanned {
        let _ = writeln!(text, "node {node} takes part in Fastscan, though it has a node-ID");
    }
    if let Some(Scanned { address: [vendor, product, revision, serial], node: None }) = scanned {
        let _ = writeln!(
            text,
            "without node-ID: vendor-ID {vendor:08X}h, product code {product:08X}h, revision number {revision:08X}h, \
             serial number {serial:08X}h (canvass lss fastscan BUS --assign NODE gives it one)"
        );
    }
    if nodes.is_empty() && scanned.is_none() {
        text.push_str("no node was found\n");
    }
    text
}

fn json(Scan { bit_rate, nodes, unconfigured: scanned, is_complete }: &Scan) -> Value {
    let row = |(node, found): (&NodeId, &Found)| {
        let [vendor, product, revision, serial] = [1, 2, 3, 4].map(|sub| found.part(sub));
        let [name, hardware, software] = NAMES.map(|(index, _)| found.text(index));
        let (models, exact) = match found.models() {
            Models::Fitting(models) => (models, Some(true)),
            Models::Similar(model) => (vec![model.id().into()], Some(false)),
            Models::None => (Vec::new(), None),
        };
        let models: Vec<&str> = models.iter().map(|id| &**id).collect();
        json!({
            "node": node.raw(), "state": found.state.and_then(State::name), "sdo": found.answers,
            "device_type": found.device_type(), "profile": found.profile(), "vendor_id": vendor, "product_code": product,
            "revision_number": revision, "serial_number": serial, "name": name, "hardware_version": hardware,
            "software_version": software, "model": models.first(), "models": models, "model_exact": exact,
        })
    };
    let unconfigured = scanned.filter(|scanned| scanned.node.is_none()).map(|scanned| scanned.address);
    let unconfigured = unconfigured.map(|[vendor, product, revision, serial]| {
        json!({
            "vendor_id": vendor, "product_code": product, "revision_number": revision, "serial_number": serial,
        })
    });
    json!({
        "schema": "canvass/scan/1",
        "complete": is_complete,
        "bit_rate": bit_rate.map(|heard| heard.bit_rate),
        "nodes": nodes.iter().map(row).collect::<Vec<_>>(),
        "unconfigured": unconfigured,
        "fastscan_configured": scanned.and_then(|scanned| scanned.node).map(NodeId::raw),
    })
}
