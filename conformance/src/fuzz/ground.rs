//! Where sequences run: on a device that is new each time, or on one that is reset.

use super::{Knowledge, Patience, Start};
use crate::bus::{Bus, BusError, SimulatedBus};
use crate::device::Device;
use crate::models::Model;
use crate::{Faults, Machine};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control;
use canvass_analyzer::wire::nmt::{self, Command, Nmt};
use canvass_analyzer::wire::sdo::{Payload, REQUEST_BASE, RESPONSE_BASE, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::{Duration, Frame};

/// A device on a bus that can be brought back to its start.
pub trait Ground {
    /// Brings the device to the start of a sequence.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    fn begin(&mut self, start: Start) -> Result<(), BusError>;

    /// The bus.
    fn bus(&mut self) -> &mut dyn Bus;

    /// Whether the device can be had without node-ID.
    fn has_unconfigured(&self) -> bool;

    /// Whether each start is the same to the bit, so that what was seen once is seen again.
    fn is_repeatable(&self) -> bool;
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
}

impl Simulated {
    /// A bus of that bit rate for devices that `make` makes. They have `boot` to boot.
    pub fn new(make: MakeDevice, node: NodeId, bit_rate: u32, boot: Duration, unconfigured: bool) -> Self {
        Self { make, bit_rate, node, boot, unconfigured, bus: SimulatedBus::new(bit_rate) }
    }
}

impl Ground for Simulated {
    fn begin(&mut self, start: Start) -> Result<(), BusError> {
        self.bus = SimulatedBus::new(self.bit_rate);
        self.bus.attach((self.make)(start));
        if start == Start::Configured {
            wait_for_boot_up(&mut self.bus, self.node, self.boot)?;
        }
        Ok(())
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
    boot: Duration,
}

impl<'a> Live<'a> {
    /// The device with that node-ID. It has `boot` to boot.
    pub fn new(bus: &'a mut dyn Bus, node: NodeId, boot: Duration) -> Self {
        Self { bus, node, boot }
    }
}

impl Ground for Live<'_> {
    fn begin(&mut self, _: Start) -> Result<(), BusError> {
        let reset = Nmt { command: Command::RESET_NODE, node: self.node.raw() };
        self.bus.send(&reset.to_frame(nmt::CAN_ID))?;
        wait_for_boot_up(self.bus, self.node, self.boot)?;
        Ok(())
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

/// Reads what the device holds after power-on: its identity, and every number of its dictionary.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub fn learn(ground: &mut dyn Ground, knowledge: &mut Knowledge) -> Result<(), BusError> {
    ground.begin(Start::Configured)?;
    let addresses: Vec<Multiplexer> = knowledge
        .entries()
        .iter()
        .filter(|known| known.readable && known.size.is_some_and(|size| size <= 4))
        .map(|known| known.at)
        .collect();
    for at in addresses {
        if let Some(raw) = read(ground.bus(), knowledge, at)? {
            knowledge.learn(at, raw);
        }
    }
    let mut address = [0; 4];
    for (sub, part) in (1..).zip(&mut address) {
        match read(ground.bus(), knowledge, Multiplexer::new(0x1018, sub))? {
            Some(raw) => *part = raw as u32,
            None => return Ok(()),
        }
    }
    knowledge.address = Some(address);
    Ok(())
}

/// Whether the device answers an SDO request at all.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub fn is_reachable(ground: &mut dyn Ground, knowledge: &Knowledge) -> Result<bool, BusError> {
    ground.begin(Start::Configured)?;
    Ok(ask(ground.bus(), knowledge, Multiplexer::new(0x1000, 0))?.is_some())
}

fn read(bus: &mut dyn Bus, knowledge: &Knowledge, at: Multiplexer) -> Result<Option<u64>, BusError> {
    Ok(ask(bus, knowledge, at)?.and_then(|response| match response {
        Response::InitiateUpload { multiplexer, payload: Payload::Expedited(value) } if multiplexer == at => {
            Some(value.data().iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte)))
        }
        _ => None,
    }))
}

fn ask(bus: &mut dyn Bus, knowledge: &Knowledge, at: Multiplexer) -> Result<Option<Response>, BusError> {
    let node = u16::from(knowledge.node.raw());
    let request: Frame = Request::upload(at).to_frame(REQUEST_BASE + node);
    bus.send(&request)?;
    let deadline = bus.now() + knowledge.patience.answer;
    while let Some(record) = bus.receive(deadline)? {
        if record.frame.cob_id() == Some(RESPONSE_BASE + node) {
            return Ok(Response::read(record.frame.data()).ok());
        }
    }
    Ok(None)
}

/// A model on a simulated bus, and what its description says.
///
/// `node` is the node-ID that it is given; `bit_rate` in bit/s.
pub fn simulated(
    model: &'static Model,
    node: NodeId,
    faults: Faults,
    bit_rate: u32,
    seed: u64,
) -> (Simulated, Knowledge) {
    let sheet = model.sheet();
    let mut knowledge = Knowledge::new(node, Some(model.description()), Some(sheet));
    // In virtual time a wait costs nothing but what happens in it; answers come within the sheet's times.
    let boot = Duration::from_millis(sheet.timing.boot_ms + 100);
    knowledge.patience = Patience {
        answer: Duration::from_micros(sheet.timing.sdo_response_us + sheet.timing.sdo_response_jitter_us + 40_000),
        quiet: Duration::from_micros(sheet.timing.sdo_response_us + sheet.timing.sdo_response_jitter_us + 5_000),
        boot,
    };
    let make: MakeDevice = Box::new(move |start| {
        let node = (start == Start::Configured).then_some(node);
        Box::new(Device::new(model, node, faults, seed))
    });
    (Simulated::new(make, node, bit_rate, boot, sheet.network.lss), knowledge)
}
