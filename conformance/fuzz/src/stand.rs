//! Test stands on which sequences run, with a new simulated device each time or a live device that is reset.

use super::{Knowledge, Patience, Start};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::error_control;
use canvass_bus::Machine;
use canvass_bus::{Bus, BusError, SimulatedBus};
use canvass_device::Firmware;
use canvass_device::address::SimulatedDevice;
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_traces::{Duration, Timestamp};

/// A device on a bus that can be brought back to its start.
pub trait TestStand {
    /// Brings the device to the start of a sequence.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    fn begin(&mut self, start: Start) -> Result<Readiness, BusError>;

    /// The bus.
    fn bus(&mut self) -> &mut dyn Bus;

    /// Whether the stand can provide the device without node-ID.
    fn has_unconfigured(&self) -> bool;

    /// Whether all starts are identical, so that a violation always comes again.
    fn is_repeatable(&self) -> bool;

    /// Duration of the last start.
    fn restart_time(&self) -> Duration {
        Duration::ZERO
    }

    /// Sets the waiting times from now on.
    fn attune(&mut self, patience: Patience) {
        let _ = patience;
    }
}

/// The result of a start.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Readiness {
    /// The device has started.
    Ready,
    /// The device did not come back from the first reset, but from a further reset.
    Revived,
    /// The device neither boots nor answers any more, even after repeated resets.
    Dead,
}

/// Makes a simulated device.
pub type MakeDevice = Box<dyn Fn(Start) -> Box<dyn Machine>>;

/// A simulated bus with a new device for each sequence.
pub struct Simulated {
    make: MakeDevice,
    bit_rate: u32,
    node: NodeId,
    boot: Duration,
    unconfigured: bool,
    bus: SimulatedBus,
    /// A bus with a device that has just booted, which is copied instead of booting again.
    booted: Option<SimulatedBus>,
}

impl Simulated {
    /// A bus with the bit rate `bit_rate` for devices that `make` makes. `boot` limits their boot time. `unconfigured`:
    /// `make` can also make devices without node-ID.
    pub fn new(make: MakeDevice, node: NodeId, bit_rate: u32, boot: Duration, unconfigured: bool) -> Self {
        Self { make, bit_rate, node, boot, unconfigured, bus: SimulatedBus::new(bit_rate), booted: None }
    }

    /// The bit rate in bit/s.
    pub fn bit_rate(&self) -> u32 {
        self.bit_rate
    }
}

impl TestStand for Simulated {
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

/// Waits for the boot-up message. Returns whether it came in time.
pub(super) fn wait_for_boot_up(bus: &mut dyn Bus, node: NodeId, boot: Duration) -> Result<bool, BusError> {
    let deadline = bus.now() + boot;
    let id = error_control::CAN_ID_BASE + u16::from(node.raw());
    while let Some(record) = bus.receive(deadline)? {
        if record.frame.cob_id() == Some(id) && record.frame.data() == [0] {
            return Ok(true);
        }
    }
    Ok(false)
}

/// A model on a simulated bus, and the knowledge from its description.
///
/// `node` is the node-ID of the device. `bit_rate` is in bit/s. `seed` determines the random choices of the device.
pub fn simulated(
    model: &'static Model,
    node: NodeId,
    firmware: impl Into<Firmware>,
    bit_rate: u32,
    seed: u64,
) -> (Simulated, Knowledge) {
    simulated_moving(model, node, firmware.into(), bit_rate, None, seed)
}

/// The device of a simulated bus's address with the node-ID `node`, if that is given, and the knowledge from its
/// description.
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
    // In virtual time a wait costs no real time. Answers come within the times of the device sheet.
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
    // Cloning a device is cheaper than making it from the files of a model.
    let (configured, unconfigured) = (new(Some(node)), sheet.network.lss.then(|| new(None)));
    let has_unconfigured = unconfigured.is_some();
    let make: MakeDevice = Box::new(move |start| match (start, &unconfigured) {
        (Start::Unconfigured, Some(device)) => Box::new(device.clone()),
        _ => Box::new(configured.clone()),
    });
    (Simulated::new(make, node, bit_rate, boot, has_unconfigured), knowledge)
}
