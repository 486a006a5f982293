//! Where sequences run: on a device that is new each time, or on one that is reset.

use super::{Knowledge, Patience, Start};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control;
use canvass_analyzer::wire::nmt::{self, Command, Nmt};
use canvass_analyzer::wire::sdo::{Payload, REQUEST_BASE, RESPONSE_BASE, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::Machine;
use canvass_bus::{Bus, BusError, SimulatedBus};
use canvass_device::Firmware;
use canvass_device::address::SimulatedDevice;
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_traces::{Duration, Frame, Timestamp};

/// A device on a bus that can be brought back to its start.
pub trait Ground {
    /// Brings the device to the start of a sequence.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    fn begin(&mut self, start: Start) -> Result<Readiness, BusError>;

    /// The bus.
    fn bus(&mut self) -> &mut dyn Bus;

    /// Whether the device can be had without node-ID.
    fn has_unconfigured(&self) -> bool;

    /// Whether each start is the same to the bit, so that what was seen once is seen again.
    fn is_repeatable(&self) -> bool;
}

/// What became of an attempt to start.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Readiness {
    /// The device has started.
    Ready,
    /// It neither boots nor answers any more, also after repeated resets.
    Dead,
}

/// How a simulated device is made.
pub type MakeDevice = Box<dyn Fn(Start) -> Box<dyn Machine>>;

/// A simulated bus with a new device for each sequence.
pub struct Simulated {
    make: MakeDevice,
    bit_rate: u32,
    node: NodeId,
    boot: Duration,
    unconfigured: bool,
    bus: SimulatedBus,
    /// The bus with a device that has just booted, to be had again without booting.
    booted: Option<SimulatedBus>,
}

impl Simulated {
    /// A bus of that bit rate for devices that `make` makes. They have `boot` to boot; `unconfigured`: it can make
    /// devices without node-ID.
    pub fn new(make: MakeDevice, node: NodeId, bit_rate: u32, boot: Duration, unconfigured: bool) -> Self {
        Self { make, bit_rate, node, boot, unconfigured, bus: SimulatedBus::new(bit_rate), booted: None }
    }

    /// In bit/s.
    pub fn bit_rate(&self) -> u32 {
        self.bit_rate
    }
}

impl Ground for Simulated {
    fn begin(&mut self, start: Start) -> Result<Readiness, BusError> {
        if start == Start::Configured
            && let Some(booted) = self.booted.as_ref().and_then(SimulatedBus::duplicate)
        {
            self.bus = booted;
            return Ok(Readiness::Ready);
        }
        self.bus = SimulatedBus::new(self.bit_rate);
        self.bus.attach((self.make)(start));
        if start == Start::Configured {
            wait_for_boot_up(&mut self.bus, self.node, self.boot)?;
            self.booted = self.bus.duplicate();
        }
        Ok(Readiness::Ready)
    }

    fn bus(&mut self) -> &mut dyn Bus {
        &mut self.bus
    }

    fn has_unconfigured(&self) -> bool {
        self.unconfigured
    }

    fn is_repeatable(&self) -> bool {
        true
    }
}

/// A device on a bus that goes on: it is reset before each sequence.
pub struct Live<'a> {
    bus: &'a mut dyn Bus,
    node: NodeId,
    patience: Patience,
    boot_up_message: bool,
}

/// So often a device that shows no sign of life is reset before it is given up.
const RESETS: u32 = 3;

/// Frames of the time before a reset are over after so long.
const LEFTOVERS: Duration = Duration::from_millis(5);

impl<'a> Live<'a> {
    /// The device that `knowledge` is about.
    pub fn new(bus: &'a mut dyn Bus, knowledge: &Knowledge) -> Self {
        let boot_up_message = knowledge.services.boot_up_message;
        Self { bus, node: knowledge.node, patience: knowledge.patience, boot_up_message }
    }

    fn is_alive(&mut self) -> Result<bool, BusError> {
        Ok(ask(self.bus, self.node, self.patience.answer, Multiplexer::new(0x1000, 0))?.is_some())
    }
}

impl Ground for Live<'_> {
    fn begin(&mut self, _: Start) -> Result<Readiness, BusError> {
        for _ in 0..RESETS {
            let reset = Nmt { command: Command::RESET_NODE, node: self.node.raw() };
            self.bus.send(&reset.to_frame(nmt::CAN_ID))?;
            let booted = wait_for_boot_up(self.bus, self.node, self.patience.boot)?;
            // Where there is no boot-up message, an answer is the sign of life.
            if booted && self.boot_up_message || self.is_alive()? {
                let until = self.bus.now() + LEFTOVERS;
                while self.bus.receive(until)?.is_some() {}
                return Ok(Readiness::Ready);
            }
        }
        Ok(Readiness::Dead)
    }

    fn bus(&mut self) -> &mut dyn Bus {
        self.bus
    }

    fn has_unconfigured(&self) -> bool {
        false
    }

    fn is_repeatable(&self) -> bool {
        false
    }
}

/// Whether the boot-up message came in time.
fn wait_for_boot_up(bus: &mut dyn Bus, node: NodeId, boot: Duration) -> Result<bool, BusError> {
    let deadline = bus.now() + boot;
    let id = error_control::CAN_ID_BASE + u16::from(node.raw());
    while let Some(record) = bus.receive(deadline)? {
        if record.frame.cob_id() == Some(id) && record.frame.data() == [0] {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether the device answered an SDO request at all.
pub(super) type Answers = bool;

/// Reads what the device holds after power-on: its identity, and every number of its dictionary.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub(super) fn learn(ground: &mut dyn Ground, knowledge: &mut Knowledge) -> Result<Answers, BusError> {
    ground.begin(Start::Configured)?;
    let (node, answer) = (knowledge.node, knowledge.patience.answer);
    if ask(ground.bus(), node, answer, Multiplexer::new(0x1000, 0))?.is_none() {
        return Ok(false);
    }
    let addresses: Vec<Multiplexer> = knowledge
        .entries()
        .iter()
        .filter(|known| known.readable && known.size.is_some_and(|size| size <= 4))
        .map(|known| known.at)
        .collect();
    for at in addresses {
        if let Some(raw) = read(ground.bus(), node, answer, at)? {
            knowledge.learn(at, raw);
        }
    }
    let mut address = [0; 4];
    for (sub, part) in (1..).zip(&mut address) {
        match read(ground.bus(), node, answer, Multiplexer::new(0x1018, sub))? {
            Some(raw) => *part = raw as u32,
            None => return Ok(true),
        }
    }
    knowledge.address = Some(address);
    Ok(true)
}

fn read(bus: &mut dyn Bus, node: NodeId, answer: Duration, at: Multiplexer) -> Result<Option<u64>, BusError> {
    Ok(ask(bus, node, answer, at)?.and_then(|response| match response {
        Response::InitiateUpload { multiplexer, payload: Payload::Expedited(value) } if multiplexer == at => {
            Some(value.data().iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte)))
        }
        _ => None,
    }))
}

fn ask(bus: &mut dyn Bus, node: NodeId, answer: Duration, at: Multiplexer) -> Result<Option<Response>, BusError> {
    let node = u16::from(node.raw());
    let request: Frame = Request::upload(at).to_frame(REQUEST_BASE + node);
    bus.send(&request)?;
    let deadline = bus.now() + answer;
    while let Some(record) = bus.receive(deadline)? {
        if record.frame.cob_id() == Some(RESPONSE_BASE + node) {
            return Ok(Response::read(record.frame.data()).ok());
        }
    }
    Ok(None)
}

/// A model on a simulated bus, and what its description says.
///
/// `node` is the node-ID that it is given; `bit_rate` in bit/s; `seed` chooses what is left to chance in the device.
pub fn simulated(
    model: &'static Model,
    node: NodeId,
    firmware: impl Into<Firmware>,
    bit_rate: u32,
    seed: u64,
) -> (Simulated, Knowledge) {
    simulated_moving(model, node, firmware.into(), bit_rate, None, seed)
}

/// The device of a simulated bus's address, and what its description says; its node-ID is `node`, if that is given.
///
/// # Errors
/// [`BusError::Address`] if a file that it names can't be read.
pub fn of_address(
    device: &SimulatedDevice,
    node: Option<NodeId>,
    seed: u64,
) -> Result<(Simulated, Knowledge), BusError> {
    let model = device.model()?;
    let node = node.or(device.given_id()).or(model.default_node()).unwrap_or(NodeId::MIN);
    let bit_rate = device.bit_rate.unwrap_or_else(|| model.default_bit_rate());
    Ok(simulated_moving(model, node, device.firmware, bit_rate, device.motion()?, seed))
}

fn simulated_moving(
    model: &'static Model,
    node: NodeId,
    firmware: Firmware,
    bit_rate: u32,
    motion: Option<Motion>,
    seed: u64,
) -> (Simulated, Knowledge) {
    let described = model.taking(firmware.liberties);
    let sheet = described.sheet();
    let mut knowledge = Knowledge::new(node, Some(described.description()), Some(sheet));
    if let Some((known, sheet)) = knowledge.lmt.as_mut().zip(sheet.lmt) {
        known.serial_number = Some(sheet.serial_number);
    }
    // In virtual time a wait costs nothing but what happens in it; answers come within the sheet's times.
    let boot = Duration::from_millis(sheet.timing.boot_ms + 100);
    let response = sheet.timing.sdo_response_us + sheet.timing.sdo_response_jitter_us;
    knowledge.patience = Patience {
        answer: Duration::from_micros(response + 40_000),
        quiet: Duration::from_micros(response + 5_000),
        boot,
        jitter: Duration::from_millis(2),
    };
    let new = move |node: Option<NodeId>| {
        let mut device = Device::new(model, node, firmware, seed);
        if let Some(motion) = &motion {
            device.set_motion(Timestamp::ZERO, motion.clone());
        }
        device
    };
    // A clone is cheaper than what the files of a model make.
    let (configured, unconfigured) = (new(Some(node)), sheet.network.lss.then(|| new(None)));
    let has_unconfigured = unconfigured.is_some();
    let make: MakeDevice = Box::new(move |start| match (start, &unconfigured) {
        (Start::Unconfigured, Some(device)) => Box::new(device.clone()),
        _ => Box::new(configured.clone()),
    });
    (Simulated::new(make, node, bit_rate, boot, has_unconfigured), knowledge)
}
