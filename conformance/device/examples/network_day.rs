//! Measures how long a simulated day of a network takes: `cargo run --release --example network_day [SECONDS]`.
//!
//! Eight encoders at 250 kbit/s: each sends its position every 100 ms and a heartbeat every second, and gets an SDO
//! request for one object every ten seconds. Prints the frames, the seconds of the network and the nanoseconds of this
//! thread.

use canvass_analyzer::NodeId;
use canvass_bus::{Bus, BusError, SimulatedBus};
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_traces::{CanId, Duration, Frame};
use std::io::Write;
use std::time::Instant;

const DAY: u64 = 86_400;
const NODES: u8 = 8;
const MILLI_RPM: i64 = 60_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seconds = std::env::args().nth(1).map_or(Ok(DAY), |text| text.parse::<u64>())?;
    let model = Model::by_id("reference-406").ok_or("the model is built in")?;
    let mut bus = SimulatedBus::new(250_000);
    for node in NodeId::all().take(usize::from(NODES)) {
        let motion = Motion::constant(0, MILLI_RPM * i64::from(node.raw()));
        bus.attach(Box::new(Device::with_motion(model, Some(node), Faults::NONE, u64::from(node.raw()), &motion)));
    }
    let begin = Instant::now();
    let mut frames = run(&mut bus, Duration::from_secs(1))?;
    for node in 1..=NODES {
        // Requests: a heartbeat every second; TPDO 1 every 100 ms by its timer alone; start.
        for request in
            [[0x2B, 0x17, 0x10, 0, 0xE8, 3, 0, 0], [0x2F, 0, 0x18, 2, 255, 0, 0, 0], [0x2B, 0, 0x62, 0, 100, 0, 0, 0]]
        {
            frames += ask(&mut bus, node, request)?;
        }
        bus.send(&Frame::new(CanId::standard_masked(0), &[1, node]).ok_or("two bytes are a frame")?)?;
    }
    for round in 0..seconds / 10 {
        frames += ask(&mut bus, (round % u64::from(NODES)) as u8 + 1, [0x40, 0x04, 0x60, 0, 0, 0, 0, 0])?;
        frames += run(&mut bus, Duration::from_millis(9_990))?;
    }
    let nanos = begin.elapsed().as_nanos();
    writeln!(std::io::stdout(), "{frames} {} {nanos}", bus.now().nanos() / 1_000_000_000)?;
    Ok(())
}

fn ask(bus: &mut SimulatedBus, node: u8, request: [u8; 8]) -> Result<u64, BusError> {
    bus.send(&Frame::full(CanId::standard_masked(0x600 + u32::from(node)), request))?;
    run(bus, Duration::from_millis(10))
}

fn run(bus: &mut SimulatedBus, time: Duration) -> Result<u64, BusError> {
    let deadline = bus.now() + time;
    let mut frames = 0;
    while bus.receive(deadline)?.is_some() {
        frames += 1;
    }
    Ok(frames)
}
