//! Prints how many SDO exchanges per second one thread of this machine simulates: `cargo run --release --example
//! bus_speed [EXCHANGES]`. Seconds are processor time, where Linux reports it, so that other load on the machine
//! matters little.

use canvass_bus::{Bus, BusError, SimulatedBus};
use canvass_device::Device;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_traces::{CanId, Direction, Duration, Frame, Timestamp};
use std::io::Write;
use std::time::{Duration as Time, Instant};

const EXCHANGES: u32 = 2_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::by_id("kuebler-sendix-58x8").ok_or("the model is built in")?;
    let exchanges = std::env::args().nth(1).map_or(Ok(EXCHANGES), |text| text.parse())?;
    let mut out = std::io::stdout().lock();
    for devices in [1_usize, 10] {
        let mut bus = SimulatedBus::new(1_000_000);
        for node in canvass_analyzer::NodeId::all().skip(62).take(devices) {
            bus.attach(Box::new(Device::new(model, Some(node), Faults::NONE, 1)));
        }
        while bus.receive(Timestamp(1_000_000_000))?.is_some() {}
        let simulated = bus.now();
        let (begin, on_processor) = (Instant::now(), processor_time());
        for _ in 0..exchanges / devices as u32 {
            exchange(&mut bus)?;
        }
        let elapsed = begin.elapsed();
        let worked = processor_time().zip(on_processor).map_or(elapsed, |(after, before)| after.saturating_sub(before));
        let rate = f64::from(exchanges / devices as u32) / worked.as_secs_f64() / 1e6;
        let virtual_time = bus.now().since(simulated);
        writeln!(
            out,
            "{devices} devices: {rate:.2} million SDO exchanges per second of the processor ({:.2} s of it, {:.2} s \
             by the clock, {virtual_time} of bus time)",
            worked.as_secs_f64(),
            elapsed.as_secs_f64()
        )?;
    }
    Ok(())
}

/// The time that this thread has been on a processor.
fn processor_time() -> Option<Time> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(Time::from_nanos(text.split_whitespace().next()?.parse().ok()?))
}

/// Reads 6004h of node 63.
fn exchange(bus: &mut SimulatedBus) -> Result<(), BusError> {
    let request = Frame::full(CanId::standard_masked(0x63F), [0x40, 0x04, 0x60, 0, 0, 0, 0, 0]);
    bus.send(&request)?;
    let deadline = bus.now() + Duration::from_millis(100);
    while let Some(record) = bus.receive(deadline)? {
        if record.direction == Direction::Rx {
            return Ok(());
        }
    }
    Ok(())
}
