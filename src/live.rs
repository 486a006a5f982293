//! Buses, as commands use them: opened, with what is known of the devices on them.

use crate::devices::DeviceArg;
use crate::output::{Color, Output, diagnostic};
use crate::status::Failure;
use canvass_analyzer::network::Network;
use canvass_analyzer::{Meaning, NodeId, Service};
use canvass_bus::{Bus, BusError};
use canvass_device::address::Opened;
use canvass_device::models::Model;
use canvass_reports::decode::{Line, Lines, TextLines, TimeStyle};
use canvass_traces::{Channels, Duration, Record, TimeBase};
use std::io;

/// Opens a bus; an address that names none is a mistake of the user, anything else is the bus's.
pub fn open_bus(address: &str, seed: u64) -> Result<Opened, Failure> {
    canvass_device::address::open_seeded(address, seed).map_err(|error| match error {
        BusError::Address { .. } => Failure::from(error),
        _ => Failure::unreachable(error),
    })
}

/// What a bus is called in listings and captures: the interface, port or kind.
pub fn channel_name(address: &str) -> &str {
    match address.split_once(':') {
        Some(("sim", _)) => "sim",
        Some(("socketcan", interface)) => interface,
        Some(("slcan", rest)) => rest.split('@').next().unwrap_or(rest),
        _ => address,
    }
}

/// What the times of a bus count from.
pub fn time_base(bus: &dyn Bus) -> TimeBase {
    if bus.is_live() { TimeBase::Utc } else { TimeBase::Start }
}

/// A bus with the devices that are known on it.
pub struct Live {
    /// The bus.
    pub bus: Box<dyn Bus>,
    /// The model of the first simulated device.
    pub model: Option<&'static Model>,
    /// Its node-ID.
    simulated: Option<NodeId>,
    /// What the traffic means.
    pub network: Network,
    /// The bus's name.
    pub channels: Channels,
}

impl Live {
    /// Opens a bus, describes the devices on it, and lets a simulated one, which was only just switched on, finish its
    /// initialisation.
    pub fn open(address: &str, devices: &[DeviceArg]) -> Result<Self, Failure> {
        let opened = open_bus(address, 0)?;
        let mut channels = Channels::new();
        channels.intern(channel_name(address));
        let (model, simulated) = (opened.model, opened.node());
        let mut live = Self { bus: opened.bus, model, simulated, network: Network::new(), channels };
        for attached in &opened.devices {
            if let Some(node) = attached.node {
                live.network.describe(node, attached.model.description().clone());
            }
        }
        if let Some(node) = simulated {
            live.boot(node).map_err(Failure::unreachable)?;
        }
        for device in devices {
            live.network.describe(device.node, device.describe()?);
        }
        Ok(live)
    }

    fn boot(&mut self, node: NodeId) -> Result<(), BusError> {
        let deadline = self.bus.now() + Duration::from_secs(5);
        while let Some(record) = self.bus.receive(deadline)? {
            let decoded = self.network.handle(&record);
            if decoded.service == Service::BootUp && decoded.node == Some(node) {
                break;
            }
        }
        Ok(())
    }

    /// The node-ID of the simulated device, where there is one.
    pub fn simulated_node(&self) -> Option<NodeId> {
        self.simulated
    }

    /// Says what went wrong on the way from and to the bus.
    pub fn report_health(&self) {
        let health = self.bus.health();
        if health.lost > 0 {
            diagnostic(&format!("canvass: {} frames were lost: this machine did not keep up", health.lost));
        }
        if let Some(trouble) = health.trouble {
            diagnostic(&format!("canvass: {trouble}"));
        }
    }
}

/// One line for each frame.
pub struct FrameLines {
    lines: TextLines,
    output: Output,
}

impl FrameLines {
    pub fn new(color: Color) -> Self {
        Self { lines: TextLines::new(TimeStyle::Absolute, color.on_stdout()), output: Output::default() }
    }

    pub fn show(&mut self, record: &Record, network: &mut Network, channels: &Channels) -> io::Result<()> {
        let decoded = network.handle(record);
        let Some(bus) = network.bus(record.channel) else { return Ok(()) };
        let meaning = Meaning::new(record, &decoded, bus);
        self.output.append(|buffer| self.lines.line(&Line { record, channels, decoded: &decoded, meaning }, buffer))
    }

    pub fn flush(&self) -> io::Result<()> {
        self.output.flush()
    }
}

/// A span as typed: seconds, or a number with `ms`, `s`, `min` or `h`.
pub fn parse_span(text: &str) -> anyhow::Result<Duration> {
    let unit_at = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(unit_at);
    let nanos = match unit {
        "ms" => 1e6,
        "" | "s" => 1e9,
        "min" | "m" => 60e9,
        "h" => 3_600e9,
        _ => anyhow::bail!("expected a span such as 10, 500ms, 5min or 1h, found \"{text}\""),
    };
    match number.parse::<f64>() {
        Ok(number) if number > 0.0 && number * nanos < u64::MAX as f64 => Ok(Duration((number * nanos) as u64)),
        _ => anyhow::bail!("expected a span such as 10, 500ms, 5min or 1h, found \"{text}\""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_as_typed() {
        let parsed = |text: &str| parse_span(text).unwrap();
        assert_eq!(parsed("10"), Duration::from_secs(10));
        assert_eq!(parsed("0.5s"), Duration::from_millis(500));
        assert_eq!(parsed("250ms"), Duration::from_millis(250));
        assert_eq!(parsed("1h"), Duration::from_secs(3_600));
        for wrong in ["", "s", "-1", "0", "1x", "nan"] {
            assert!(parse_span(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_bus_has_a_name() {
        let names = ["can0", "socketcan:vcan1", "sim:x+y", "slcan:/dev/ttyACM0@250k"].map(channel_name);
        assert_eq!(names, ["can0", "vcan1", "sim", "/dev/ttyACM0"]);
    }
}
