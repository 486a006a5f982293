//! In steady state a frame makes neither the simulated bus nor a device allocate memory.

use crate::rig::{model, parse};
use canvass_analyzer::NodeId;
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::Faults;
use canvass_device::{Device, Motion};
use canvass_traces::{Duration, Frame};

const FIRST: u8 = 60;
const NODES: u8 = 8;

/// Sends the requests every 100 ms for one second; returns the number of frames on the bus.
fn second(bus: &mut SimulatedBus, requests: &[Frame]) -> u32 {
    let mut frames = 0;
    for _ in 0..10 {
        requests.iter().for_each(|request| bus.send(request).unwrap());
        let deadline = bus.now() + Duration::from_millis(100);
        while bus.receive(deadline).unwrap().is_some() {
            frames += 1;
        }
    }
    frames
}

fn to_all(bytes: &str) -> Vec<Frame> {
    (FIRST..FIRST + NODES).map(|node| parse(&format!("{:03X}#{bytes}", 0x600 + u16::from(node)))).collect()
}

#[test]
fn frames_cost_no_memory() {
    let mut bus = SimulatedBus::new(250_000);
    for node in (FIRST..FIRST + NODES).map(NodeId::new) {
        let motion = Motion::constant(0, 60_000);
        bus.attach(Box::new(Device::with_motion(model(), node, Faults::NONE, 1, &motion)));
    }
    second(&mut bus, &[]);
    // TPDO 1 every 10 ms; start.
    second(&mut bus, &to_all("2B0062000A000000"));
    second(&mut bus, &[parse("000#0100")]);
    // SYNC, a successful read, a failing read, and a write.
    let mut requests = vec![parse("080#")];
    requests.extend(["4004600000000000", "4000500000000000", "2B17100064000000"].map(to_all).concat());
    second(&mut bus, &requests);
    let mut frames = 0;
    let counted = allocation_counter::measure(|| frames = second(&mut bus, &requests));
    assert!(frames > 1_200, "{frames}");
    assert_eq!(counted.count_total, 0, "of {frames} frames");
}
