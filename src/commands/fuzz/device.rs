//! The device to fuzz: a simulated device, made anew for each sequence, or a device on a live bus.

use crate::devices::{describe, named};
use crate::live::{CLIENT, limited, open_bus_of, open_device_bus};
use crate::status::Failure;
use anyhow::anyhow;
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_bus::{Bus, Endurance, PatientBus};
use canvass_device::address::BusAddress;
use canvass_device::models::Model;
use canvass_fuzzer::Knowledge;
use canvass_fuzzer::Live;
use canvass_fuzzer::stand::{Simulated, TestStand, of_address};
use canvass_fuzzer::time_limit::TimeLimit;
use canvass_suite::bench::{Decoder, Target, zero_point_of};
use canvass_suite::zero_point::ZeroPoint;

/// The device with its bus.
pub struct Device {
    place: Place,
    knowledge: Knowledge,
    target: Target,
}

enum Place {
    Simulated(Box<Simulated>),
    Live(Box<dyn Bus + Send>),
}

impl Device {
    /// Opens the bus. `device` is the value of `--device`.
    pub fn open(address: &str, node: Option<NodeId>, device: Option<&str>, seed: u64) -> Result<Self, Failure> {
        let named = device.map(named);
        if let BusAddress::Simulated(devices) = address.parse()? {
            let [only] = &devices[..] else {
                let found = devices.len();
                return Err(anyhow!("expected one simulated device to fuzz, found {found} in {address}").into());
            };
            let (stand, mut knowledge) = of_address(only, node, seed)?;
            let model = only.model()?;
            let (mut name, mut known) = (model.id().to_owned(), KnownDevice::clone(model.device()));
            if let Some(named) = named {
                (name, known) = (named.to_owned(), describe(named)?);
                let sheet = Model::by_id(named).map(Model::sheet);
                let patience = knowledge.patience;
                knowledge = Knowledge::new(knowledge.node, Some(&known.description), sheet);
                knowledge.patience = patience;
            }
            let target = Target::known(knowledge.node, name, Some(known));
            return Ok(Self { place: Place::Simulated(Box::new(stand)), knowledge, target });
        }
        let mut opened = open_device_bus(address, seed, CLIENT)?;
        limited(opened.bus.as_mut());
        let usual = || Model::by_id(named?).and_then(Model::default_node);
        let node = node.or_else(usual);
        let node = node.ok_or_else(|| {
            anyhow!("the node-ID of the device is not known: use --node N (canvass scan {address} finds it)")
        })?;
        let known = named.map(describe).transpose()?;
        let sheet = named.and_then(Model::by_id).map(Model::sheet);
        let knowledge = Knowledge::new(node, known.as_ref().map(|known| &known.description), sheet);
        let target = Target::known(node, named.unwrap_or_default().to_owned(), known);
        Ok(Self { place: Place::Live(opened.bus), knowledge, target })
    }

    pub fn is_simulated(&self) -> bool {
        matches!(self.place, Place::Simulated(_))
    }

    /// The knowledge of the device from its model or description.
    pub fn knowledge(&self) -> &Knowledge {
        &self.knowledge
    }

    /// The device's name as the user typed it.
    pub fn name(&self) -> &str {
        &self.target.model
    }

    /// Whether the device can be put into the state without node-ID.
    pub fn has_unconfigured(&self) -> bool {
        match &self.place {
            Place::Simulated(stand) => stand.has_unconfigured(),
            Place::Live(_) => false,
        }
    }

    /// The bit rate in bit/s.
    pub fn bit_rate(&self) -> Option<u32> {
        match &self.place {
            Place::Simulated(stand) => Some(stand.bit_rate()),
            Place::Live(bus) => bus.bit_rate(),
        }
    }

    /// Runs `work` on a bus with the device in its initial state: a simulated device is made anew.
    pub fn on_bus<T>(
        &mut self,
        address: &str,
        seed: u64,
        endurance: Endurance,
        work: impl FnOnce(&mut dyn Bus) -> T,
    ) -> Result<T, Failure> {
        match &mut self.place {
            Place::Live(bus) => Ok(work(&mut PatientBus::new(bus.as_mut(), endurance))),
            Place::Simulated(_) => Ok(work(&mut *open_bus_of(address, seed, self.knowledge.node)?)),
        }
    }

    /// The position of the zero point; `None` if no command moves the zero point, if the device does not answer, or if
    /// the device is simulated and made anew.
    pub fn zero_point(&mut self) -> Option<ZeroPoint> {
        match &mut self.place {
            Place::Live(bus) => zero_point_of(bus.as_mut(), &self.target),
            Place::Simulated(_) => None,
        }
    }

    /// A decoder that knows the device, for the text of its frames.
    pub fn decoder(&self) -> Decoder {
        Decoder::new(&self.target)
    }

    /// Runs `work` on the fuzzer's stand for this device.
    pub fn on_stand<T>(
        &mut self,
        time: &TimeLimit,
        endurance: Endurance,
        work: impl FnOnce(&mut dyn TestStand) -> T,
    ) -> T {
        match &mut self.place {
            Place::Simulated(stand) => work(stand.as_mut()),
            Place::Live(bus) => {
                let mut bus = PatientBus::new(bus.as_mut(), endurance);
                work(&mut Live::new(&mut bus, &self.knowledge).until(time.clone()))
            }
        }
    }
}
