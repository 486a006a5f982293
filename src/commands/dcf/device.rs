//! The devices on a bus, as far as reading and writing configurations needs them.

use crate::commands::eds::device::Reading;
use crate::devices::{DeviceArg, describe};
use crate::interrupt::Interrupt;
use crate::live::{ClientArg, Live, parse_span};
use crate::output::diagnostic;
use crate::reconnect::ReconnectArg;
use crate::status::Failure;
use anyhow::{Result, anyhow};
use canvass_analyzer::dictionary::configuration::Download;
use canvass_analyzer::dictionary::survey::Survey;
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use canvass_analyzer::network::{Candidates, Shown};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::client::sdo::Mode;
use canvass_bus::client::{Exchange, Outcome, Surveyor, Transfer, UploadLimit};
use canvass_bus::{BusError, PatientBus};
use canvass_device::models::Model;
use canvass_traces::{CanId, Duration, Frame, Record, Timestamp};

/// A bus, as typed.
#[derive(clap::Args)]
pub struct BusOptions {
    /// How long to wait for each response, such as 500ms
    #[arg(long, default_value = "1s", value_name = "SPAN", value_parser = parse_span)]
    timeout: Duration,
    #[command(flatten)]
    client: ClientArg,
    #[command(flatten)]
    reconnect: ReconnectArg,
}

/// An open bus with the devices whose configurations are read or written.
pub struct Session {
    /// The address of the bus, as typed.
    pub address: String,
    live: Live,
    patience: Duration,
    reconnect: ReconnectArg,
    interrupt: Interrupt,
}

/// How long to wait for a storing device: writing a flash memory takes some seconds on the slowest known devices.
const STORING: Duration = Duration::from_secs(10);
/// How long to listen for a heartbeat at most.
const HEARTBEAT: Duration = Duration::from_secs(10);
/// How long to wait for the answer to a guarding request.
const GUARDING: Duration = Duration::from_millis(200);

impl Session {
    /// Opens the bus for these nodes.
    pub fn open(address: &str, nodes: &[NodeId], options: &BusOptions) -> Result<Self, Failure> {
        let only = if let [node] = nodes { Some(*node) } else { None };
        let mut live = Live::open(address, only, &[], options.client)?;
        // On a busy bus the other frames would fill the queue.
        let ids = |node: &NodeId| [0x580, 0x600, 0x700].map(|base| (base + u16::from(node.raw()), 0x7FF));
        let ids: Vec<(u16, u16)> = nodes.iter().flat_map(ids).collect();
        live.bus.only(&ids).map_err(Failure::unreachable)?;
        let (patience, reconnect) = (options.timeout, options.reconnect);
        Ok(Self { address: address.to_owned(), live, patience, reconnect, interrupt: Interrupt::watch()? })
    }

    /// The node-ID of the simulated device, if there is one.
    pub fn simulated_node(&self) -> Option<NodeId> {
        self.live.simulated_node()
    }

    /// Whether the devices are real, and so can be left changed.
    pub fn is_live(&self) -> bool {
        self.live.bus.is_live()
    }

    /// The bit rate of the bus in kbit/s, if it is known.
    pub fn bit_rate(&self) -> Option<u16> {
        self.live.bus.bit_rate().and_then(|rate| u16::try_from(rate / 1_000).ok())
    }

    /// Whether the user has asked for the end.
    pub fn is_interrupted(&self) -> bool {
        self.interrupt.came()
    }

    /// Calls `act` with the bus.
    pub fn with<T>(
        &mut self,
        act: impl FnOnce(&mut Exchange<'_>, Duration) -> Result<T, BusError>,
    ) -> Result<T, Failure> {
        let mut bus = PatientBus::new(self.live.bus.as_mut(), self.reconnect.endurance(&self.interrupt));
        let mut exchange = Exchange { bus: &mut bus, observe: &mut |_: &Record| {}, ends: Timestamp::MAX };
        act(&mut exchange, self.patience).map_err(Failure::unreachable)
    }

    /// Reads an entry; `None` if the device gives no value.
    pub fn value(&mut self, node: NodeId, at: Multiplexer) -> Result<Option<Vec<u8>>, Failure> {
        match self.with(|exchange, patience| exchange.transfer(node, Transfer::upload(at), patience))? {
            Outcome::Uploaded(value) => Ok(Some(value)),
            Outcome::Silent => Err(self.silent(node, at)),
            _ => Ok(None),
        }
    }

    /// Writes an entry.
    pub fn write(&mut self, node: NodeId, download: &Download) -> Result<Outcome, Failure> {
        let transfer = Transfer::download(download.at, &download.value, Mode::Shortest);
        self.with(|exchange, patience| exchange.transfer(node, transfer, patience))
    }

    /// Tells the device to store all parameters (CiA 301, 7.5.2.13).
    pub fn store(&mut self, node: NodeId) -> Result<Outcome, Failure> {
        let transfer = Transfer::download(Multiplexer::new(object::STORE_PARAMETERS, 1), b"save", Mode::Shortest);
        self.with(|exchange, patience| exchange.transfer(node, transfer, patience.max(STORING)))
    }

    /// The error of a device that does not answer.
    pub fn silent(&self, node: NodeId, at: Multiplexer) -> Failure {
        Failure::unreachable(anyhow!(
            "node {node} does not answer ({at}): does it exist, and does {} have its bit rate?",
            self.address
        ))
    }

    /// What is known of a device: the model or file of `--device`, the simulated model, or the built-in model that the
    /// device must be; otherwise the reason why it is not known.
    pub fn known(
        &mut self,
        node: NodeId,
        devices: &[DeviceArg],
    ) -> Result<Result<(String, KnownDevice), String>, Failure> {
        if let Some(given) = devices.iter().find(|device| device.nodes.contains(&node)) {
            return Ok(Ok((given.device.clone(), describe(&given.device)?)));
        }
        let models = self.models(node)?;
        Ok(match models[..] {
            [model] => Ok((model.id().to_owned(), KnownDevice::clone(model.device()))),
            [] => Err(format!(
                "node {node} is no device that canvass knows: describe it with --device; `canvass eds from-device {} \
                 --node {node}` makes a first description",
                self.address
            )),
            _ => {
                let ids: Vec<&str> = models.iter().map(|model| model.id()).collect();
                Err(format!("node {node} may be {}: choose one with --device", ids.join(" or ")))
            }
        })
    }

    /// The built-in models that a device may be. Models that a request can't tell apart are of one maker, and have the
    /// same objects.
    pub fn models(&mut self, node: NodeId) -> Result<Vec<&'static Model>, Failure> {
        if self.live.simulated_node() == Some(node) {
            return Ok(self.live.model.into_iter().collect());
        }
        let shown = self.shown(node)?;
        let fitting = Model::candidates().fitting(&shown);
        let mut models: Vec<&'static Model> = fitting.iter().filter_map(|id| Model::by_id(id)).collect();
        // Some models have the same identity: an object that only some of them have decides.
        while let [first, .., last] = models[..]
            && let Some(at) = distinguishing(first, last)
        {
            let exists = self.value(node, at)?.is_some();
            models.retain(|model| has(model, at) == exists);
        }
        Ok(models)
    }

    fn shown(&mut self, node: NodeId) -> Result<Shown, Failure> {
        let mut shown = Shown::default();
        for at in Candidates::objects() {
            if let Some(value) = self.value(node, at)? {
                shown.insert(at, value);
            }
        }
        Ok(shown)
    }

    /// Reads the identity and all described entries of a device.
    pub fn survey(&mut self, node: NodeId, description: &DeviceDescription) -> Result<Survey, Failure> {
        let interrupt = self.interrupt.clone();
        let patience = self.patience;
        let mut bus = PatientBus::new(self.live.bus.as_mut(), self.reconnect.endurance(&interrupt));
        let mut exchange = Exchange { bus: &mut bus, observe: &mut |_: &Record| {}, ends: Timestamp::MAX };
        let mut reading = Reading::begin(node);
        let mut watch = |at: Multiplexer| {
            reading.show(at);
            !interrupt.came()
        };
        let mut surveyor = Surveyor::new(&mut exchange, node, patience, &mut watch).within(UploadLimit::OF_MANY);
        let mut read = || {
            for at in canvass_analyzer::dictionary::survey::compare::IDENTITY {
                surveyor.read(at)?;
            }
            surveyor.described(description)
        };
        let done = read();
        let (survey, _) = surveyor.into_survey();
        reading.end();
        done.map_err(Failure::unreachable)?;
        Ok(survey)
    }

    /// The state of a device, from its heartbeat or its answer to guarding; `None` if it shows none. A device whose
    /// life guarding the question would start is not asked.
    pub fn state(&mut self, node: NodeId, survey: &Survey) -> Result<Option<State>, Failure> {
        let number = |index| survey.number(Multiplexer::new(index, 0)).unwrap_or(0);
        let heartbeat = number(object::PRODUCER_HEARTBEAT_TIME);
        let guarded = number(object::GUARD_TIME) * number(object::LIFE_TIME_FACTOR) > 0;
        let can_id = error_control::CAN_ID_BASE + u16::from(node.raw());
        let span = match heartbeat {
            0 if guarded => return Ok(None),
            0 => GUARDING,
            period => Duration::from_millis(2 * period + 100).min(HEARTBEAT),
        };
        self.with(|exchange, _| {
            if heartbeat == 0
                && let Some(request) = CanId::standard(u32::from(can_id)).and_then(|id| Frame::remote(id, 1))
            {
                exchange.bus.send(&request)?;
            }
            exchange.wait_for(span, |record| {
                let is_its = record.frame.cob_id() == Some(can_id) && !record.frame.data().is_empty();
                let message = ErrorControl::read(record.frame.data()).ok().filter(|_| is_its)?;
                Some(message.state)
            })
        })
    }

    /// The nodes that answer a request for their device type.
    pub fn nodes(&mut self) -> Result<Vec<NodeId>, Failure> {
        self.live.bus.only(&[(0x580, 0x780), (0x600, 0x780), (0x700, 0x780)]).map_err(Failure::unreachable)?;
        let found = self.with(crate::commands::scan::answering)?;
        Ok(found)
    }

    /// Reports what the bus lost.
    pub fn report_health(&self) {
        self.live.report_health();
    }
}

/// A readable entry that only one of two models has.
fn distinguishing(one: &Model, other: &Model) -> Option<Multiplexer> {
    let lacks = |from: &Model, than: &Model| {
        let entries = from.description().dictionary.entries();
        let readable = entries.filter(|(_, entry)| entry.access.is_readable() && !entry.flags.refuses_read_on_scan());
        readable.map(|(at, _)| at).find(|at| !has(than, *at))
    };
    lacks(one, other).or_else(|| lacks(other, one))
}

fn has(model: &Model, at: Multiplexer) -> bool {
    model.description().dictionary.entry(at).is_ok()
}

/// Prints objects behind a reason, the first ones by address.
pub fn told_objects(objects: &[Multiplexer]) -> String {
    const SHOWN: usize = 8;
    let first: Vec<String> = objects.iter().take(SHOWN).map(ToString::to_string).collect();
    match objects.len().saturating_sub(SHOWN) {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

/// Prints a line about a node.
pub fn tell(node: NodeId, text: &str) {
    diagnostic(&format!("canvass: node {node}: {text}"));
}
