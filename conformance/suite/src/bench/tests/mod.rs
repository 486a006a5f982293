//! The bench on a simulated device that works: each function does on the bus what it says.

mod left;
mod messages;
mod pdos;
mod states;
mod time;

use super::{Bench, Options, Target};
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Firmware};
use canvass_traces::{Duration, Record, Timestamp};
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
