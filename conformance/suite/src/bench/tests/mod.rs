//! The bench on a simulated correct device: each function has the effect on the bus that its name says.

mod acting;
mod blocks;
mod described;
mod idle;
mod left;
mod memory;
mod messages;
mod pdos;
mod presence;
mod putting_back;
mod states;
mod time;

use super::{Bench, Options, Target};
use crate::scripted::{NODE, ScriptedBus};
use canvass_analyzer::NodeId;
use canvass_bus::{Bus, BusError, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Firmware};
use canvass_traces::{Duration, Frame, Record, Timestamp};
use std::cell::Cell;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;

/// Runs `test` on a bench with a device of `reference-301` that has started.
fn on_device<T>(test: impl FnOnce(&mut Bench<'_>) -> T) -> T {
    with(&Options::default(), test)
}

fn with<T>(options: &Options, test: impl FnOnce(&mut Bench<'_>) -> T) -> T {
    let model = Model::by_id("reference-301").unwrap();
    let node = model.default_node().unwrap();
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    bus.attach(Box::new(Device::new(model, Some(node), Firmware::default(), 0)));
    bus.receive(Timestamp::ZERO + Duration::from_secs(6)).unwrap();
    let (target, cancel) = (Target::of(model, node), AtomicBool::new(false));
    let mut annotate = |record: &Record| record.frame.to_string();
    test(&mut Bench::new(&mut bus, &target, options, &mut annotate, &cancel))
}

/// Runs `test` on a bench with this bus and a device of which nothing is known.
fn on_bus<T>(bus: &mut dyn Bus, options: &Options, test: impl FnOnce(&mut Bench<'_>) -> T) -> T {
    let (target, cancel) = (Target::unknown(NodeId::new(NODE).unwrap()), AtomicBool::new(false));
    let mut annotate = |record: &Record| record.frame.to_string();
    test(&mut Bench::new(bus, &target, options, &mut annotate, &cancel))
}

/// A bus that fails while `fails` is true.
struct Failing {
    bus: ScriptedBus,
    fails: Rc<Cell<bool>>,
}

impl Failing {
    fn new(bus: ScriptedBus) -> Self {
        Self { bus, fails: Rc::default() }
    }

    fn switch(&self) -> Rc<Cell<bool>> {
        Rc::clone(&self.fails)
    }

    fn checked(&self) -> Result<(), BusError> {
        if self.fails.get() { Err(std::io::Error::other("unplugged").into()) } else { Ok(()) }
    }
}

impl Bus for Failing {
    fn now(&self) -> Timestamp {
        self.bus.now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        self.checked()?;
        self.bus.send(frame)
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        self.checked()?;
        self.bus.receive(deadline)
    }

    fn bit_rate(&self) -> Option<u32> {
        None
    }
}

/// A scripted bus that reports itself as live.
struct Live(ScriptedBus);

impl Bus for Live {
    fn now(&self) -> Timestamp {
        self.0.now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        self.0.send(frame)
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        self.0.receive(deadline)
    }

    fn bit_rate(&self) -> Option<u32> {
        None
    }

    fn is_live(&self) -> bool {
        true
    }
}
