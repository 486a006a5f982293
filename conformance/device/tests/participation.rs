//! A simulated device takes part in any bus.

// All code here is test code; the attribute tells clippy that it may unwrap.
#![cfg(test)]

use canvass_bus::{Participation, SimulatedBus, participate};
use canvass_device::models::Model;
use canvass_device::{Device, Faults};
use canvass_traces::Timestamp;

/// On a bus with virtual time a device boots, and only the observer receives its frames.
#[test]
fn a_device_takes_part_in_any_bus() {
    let model = Model::by_id("kuebler-sendix-58x8").unwrap();
    let mut device = Device::new(model, model.default_node(), Faults::default(), 0);
    let mut bus = SimulatedBus::new(250_000);
    let mut seen = Vec::new();
    let mut goes_on = |_: &Participation, now: Timestamp| now < Timestamp(2_000_000_000);
    let done = participate(&mut bus, &mut device, &mut goes_on, &mut |record| seen.push(record.frame.to_string()));
    assert_eq!(seen, ["73F#00"]);
    assert_eq!((done.as_ref().unwrap().sent, done.unwrap().unsent), (1, 0));
}
