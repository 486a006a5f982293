//! `canvass sdo`: reads and writes single objects.

mod batch;
pub mod object;
mod value;

use crate::devices::{DeviceArg, describe, named, parse_node};
use crate::live::{ClientArg, Live, parse_span};
use crate::output::{TextOrJson, diagnostic, print};
use crate::status::{Failure, Status};
use crate::upload_limit::{self, UploadLimitArgs};
use anyhow::anyhow;
#[cfg(test)]
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::network::{Event, Network};
use canvass_analyzer::{Multiplexer, NodeId, TransferText};
use canvass_bus::client::sdo::{Bytes, Mode, Outcome, Transfer};
use canvass_bus::client::{Exchange, UploadLimit};
use canvass_reports::escape::Printable;
use canvass_traces::{Duration, Record, Timestamp, hex};
use serde_json::json;

/// Read or write an object of a device
///
/// Objects are INDEX:SUB in hexadecimal, such as 1018:01, or names of the device's description. The data type comes
/// from the description or the standard; --type gives it for other objects.
#[derive(clap::Args)]
pub struct Args {
    /// The operation
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    Batch(batch::Args),
    /// Read an object
    Read {
        #[command(flatten)]
        target: Target,
        #[command(flatten)]
        limit: UploadLimitArgs,
    },
    /// Write an object; the device keeps the value until a reset, or permanently if it stores it
    Write {
        #[command(flatten)]
        target: Target,
        /// The value: a number, a text, or bytes in hexadecimal
        #[arg(allow_hyphen_values = true)]
        value: String,
        /// Use a segmented transfer even if the value is short
        #[arg(long)]
        segmented: bool,
    },
}

#[derive(clap::Args)]
struct Target {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The device's node-ID
    #[arg(value_parser = parse_node)]
    node: NodeId,
    /// The object: INDEX:SUB in hexadecimal, or a name
    object: String,
    /// The device: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "[NODE=]MODEL|FILE")]
    device: Option<String>,
    /// The data type: u8 to u64, i8 to i64, f32, f64, bool, string, bytes, or a name such as UNSIGNED32
    #[arg(long = "type", value_name = "TYPE", value_parser = value::parse_type)]
    data_type: Option<canvass_analyzer::dictionary::DataType>,
    /// How long to wait for each response, such as 500ms
    #[arg(long, default_value = "1s", value_name = "SPAN", value_parser = parse_span)]
    timeout: Duration,
    /// How to print the result
    #[arg(long, value_enum, default_value_t)]
    format: TextOrJson,
    #[command(flatten)]
    client: ClientArg,
}

/// The typed request: read, or write with a value.
enum Wish {
    Read(UploadLimit),
    Write { value: String, segmented: bool },
}

/// The facts of a transfer that are shown.
#[derive(Default)]
struct Shown {
    object: String,
    value: String,
    duration: Duration,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        match self.action {
            Action::Batch(args) => args.run(),
            Action::Read { target, limit } => target.run(&Wish::Read(limit.or(UploadLimit::default()))),
            Action::Write { target, value, segmented } => target.run(&Wish::Write { value, segmented }),
        }
    }
}

impl Target {
    fn run(self, wish: &Wish) -> Result<Status, Failure> {
        let device = self.device.as_deref().map(named);
        let devices: Vec<DeviceArg> =
            device.iter().map(|device| DeviceArg { nodes: vec![self.node], device: (*device).to_owned() }).collect();
        let known = device.map(describe).transpose()?;
        let mut live = Live::open(&self.bus, Some(self.node), &devices, self.client)?;
        let model = live.model.filter(|_| live.simulated_node() == Some(self.node));
        let known = known.as_ref().or_else(|| model.map(|model| &**model.device()));
        let description = known.map(|known| &known.description);
        let address = object::resolve(&self.object, description)?;
        let data_type = self.data_type.or_else(|| value::known_type(address, description));
        let transfer = match wish {
            Wish::Read(limit) => Transfer::upload_within(address, *limit),
            Wish::Write { value, segmented } => {
                let bytes = value::encode(value, address, data_type)?;
                Transfer::download(address, &bytes, if *segmented { Mode::Segmented } else { Mode::Shortest })
            }
        };
        let (outcome, shown) = self.carry_out(&mut live, transfer)?;
        live.report_health();
        self.report(address, data_type, &outcome, &shown)
    }

    fn carry_out(
        &self,
        live: &mut Live,
        transfer: (Transfer, canvass_analyzer::wire::sdo::Request),
    ) -> Result<(Outcome, Shown), Failure> {
        let node = u16::from(self.node.raw());
        // The bus filter admits only the two COB-IDs of this SDO server, so that a busy bus does not overflow the
        // queue.
        live.bus.only(&[(0x580 + node, 0x7FF), (0x600 + node, 0x7FF)]).map_err(Failure::unreachable)?;
        let (network, mut shown) = (&mut live.network, Shown::default());
        let mut observe = |record: &Record| see(network, record, &mut shown);
        let mut exchange = Exchange { bus: live.bus.as_mut(), observe: &mut observe, ends: Timestamp::MAX };
        let patience = self.timeout;
        let outcome = exchange.transfer(self.node, transfer, patience).map_err(Failure::unreachable)?;
        Ok((outcome, shown))
    }

    fn report(
        &self,
        address: Multiplexer,
        data_type: Option<canvass_analyzer::dictionary::DataType>,
        outcome: &Outcome,
        shown: &Shown,
    ) -> Result<Status, Failure> {
        let node = self.node;
        let object = if shown.object.is_empty() { address.to_string() } else { shown.object.clone() };
        match outcome {
            Outcome::Silent => Err(Failure::unreachable(anyhow!("node {node} does not answer ({object})"))),
            Outcome::Aborted(_) | Outcome::Violated(_) => {
                diagnostic(&format!("canvass: node {node}, {object}: {outcome}"));
                Ok(Status::Findings)
            }
            Outcome::Exceeded(excess) => {
                diagnostic(&format!("canvass: node {node}, {object}: {}", upload_limit::told(excess)));
                Ok(Status::Findings)
            }
            Outcome::Uploaded(bytes) => {
                self.print(address, &object, Some((bytes, data_type)), shown)?;
                Ok(Status::Good)
            }
            Outcome::Downloaded => {
                self.print(address, &object, None, shown)?;
                Ok(Status::Good)
            }
        }
    }

    fn print(
        &self,
        address: Multiplexer,
        object: &str,
        read: Option<(&Vec<u8>, Option<canvass_analyzer::dictionary::DataType>)>,
        shown: &Shown,
    ) -> std::io::Result<()> {
        if matches!(self.format, TextOrJson::Text) {
            return print(&Printable::document(&match read {
                None => format!("{object} = {} written\n", shown.value),
                // If frames were lost, the decoder has no value; the client's bytes are printed instead.
                Some((bytes, _)) if shown.value.is_empty() => format!("{object} = {}\n", Bytes(bytes)),
                Some(_) => format!("{object} = {}\n", shown.value),
            }));
        }
        let bytes = read.map(|(bytes, _)| hex::compact(bytes).to_string());
        let document = json!({
            "schema": "canvass/sdo/1",
            "node": self.node.raw(),
            "index": address.index.0,
            "sub": address.sub.0,
            "object": object,
            "data": bytes,
            "value": read.map(|(bytes, data_type)| value::json(bytes, data_type)),
            "text": shown.value,
            "duration_ns": shown.duration.nanos(),
        });
        print(&Printable::json(&document))
    }
}

/// Decodes a frame; keeps the transfer that ends with it.
fn see(network: &mut Network, record: &Record, shown: &mut Shown) {
    let decoded = network.handle(record);
    let Some(bus) = network.bus(record.channel) else { return };
    let transfer = decoded.channel.and_then(|channel| Some((bus.server(channel)?, bus.transfer(channel)?)));
    if let (true, Some((server, transfer))) = (bus.events().contains(&Event::TransferEnded), transfer) {
        let text = TransferText::new(bus, server, transfer);
        *shown =
            Shown { object: text.object().to_string(), value: text.value().to_string(), duration: transfer.duration() };
    }
}

/// A description that several tests share.
#[cfg(test)]
fn encoder() -> DeviceDescription {
    canvass_device::models::Model::by_id("kuebler-sendix-58x8").unwrap().description().clone()
}
