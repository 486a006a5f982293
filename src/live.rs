//! Opening of buses, with descriptions of the devices on them.

use crate::devices::DeviceArg;
use crate::output::{Color, Output, diagnostic};
use crate::reconnect::interruptions;
use crate::status::Failure;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_analyzer::network::Network;
use canvass_analyzer::{Meaning, NodeId, Service};
use canvass_bus::{Bus, BusError};
use canvass_device::address::{Opened, open_seeded_at};
use canvass_device::models::Model;
use canvass_reports::decode::{Line, Lines, TextLines, TimeStyle};
use canvass_traces::{Channels, Duration, Record, TimeBase};
use std::io;
use std::net::IpAddr;
use std::sync::Arc;

/// Opens a bus. An invalid address is a usage error, anything else a failure of the bus.
pub fn open_bus(address: &str, seed: u64) -> Result<Opened, Failure> {
    open_bus_at(address, seed, None)
}

/// Opens a bus. A single simulated device whose address gives no node-ID gets `node`.
fn open_bus_at(address: &str, seed: u64, node: Option<NodeId>) -> Result<Opened, Failure> {
    if let Some(place) = open_to_others(address) {
        diagnostic(&format!("canvass: anyone who can reach {place} can use this bus: the protocol has no passwords"));
    }
    open_seeded_at(address, seed, node).map_err(|error| match error {
        BusError::Address { .. } => Failure::from(error),
        _ => Failure::unreachable(error),
    })
}

/// The listening address that is reachable from other machines, if the bus has one.
fn open_to_others(address: &str) -> Option<&str> {
    let place = address.strip_prefix("slcan:listen://")?;
    let place = place.split_once('@').map_or(place, |(place, _)| place);
    let (host, _) = place.rsplit_once(':')?;
    let host = host.trim_start_matches('[').trim_end_matches(']');
    let is_own = host.is_empty() || host == "localhost" || host.parse::<IpAddr>().is_ok_and(|host| host.is_loopback());
    (!is_own).then_some(place)
}

/// Default time to wait for a client of `slcan:listen://`.
pub const CLIENT: Duration = Duration::from_secs(10);

/// The option `--client-timeout`.
#[derive(Clone, Copy, clap::Args)]
pub struct ClientArg {
    /// Maximum time to wait for a client of the bus slcan:listen://
    #[arg(long, default_value = "10s", value_name = "SPAN", value_parser = parse_span)]
    client_timeout: Duration,
}

/// Opens a bus for questions to a device: on `slcan:listen://` it waits for a client first.
pub fn open_device_bus(address: &str, seed: u64, patience: Duration) -> Result<Opened, Failure> {
    open_device_bus_at(address, seed, patience, None)
}

/// As [`open_device_bus`]; a single simulated device whose address gives no node-ID gets `node`.
pub fn open_device_bus_at(
    address: &str,
    seed: u64,
    patience: Duration,
    node: Option<NodeId>,
) -> Result<Opened, Failure> {
    let mut opened = open_bus_at(address, seed, node)?;
    opened.bus.wait_for_client(patience).map_err(Failure::unreachable)?;
    Ok(opened)
}

/// Opens a simulated bus whose device has booted.
pub fn open_bus_of(address: &str, seed: u64, node: NodeId) -> Result<Box<dyn Bus + Send>, Failure> {
    let mut bus = open_bus_at(address, seed, Some(node))?.bus;
    let boots = bus.now() + BOOT;
    while let Some(record) = bus.receive(boots).map_err(Failure::unreachable)? {
        if record.frame.cob_id() == Some(0x700 + u16::from(node.raw())) {
            break;
        }
    }
    Ok(bus)
}

/// Time limit for the boot-up of a simulated device.
const BOOT: Duration = Duration::from_secs(5);

/// Limits the queue of received frames to a third of a second of a full bus at 1 Mbit/s. If the tester falls behind,
/// the oldest frames are lost: frames this late say nothing about the device's times any more.
pub fn limited(bus: &mut dyn Bus) {
    bus.limit_backlog(8_192);
}

/// The name of a bus in listings and captures: the interface, port or kind.
pub fn channel_name(address: &str) -> &str {
    match address.split_once(':') {
        Some(("sim", _)) => "sim",
        Some(("socketcan", interface)) => interface,
        Some(("slcan" | "pcan", rest)) => rest.split('@').next().unwrap_or(rest),
        _ => address,
    }
}

/// The time base of a bus.
pub fn time_base(bus: &dyn Bus) -> TimeBase {
    if bus.is_live() { TimeBase::Utc } else { TimeBase::Start }
}

/// An open bus, with the devices known on it.
pub struct Live {
    /// The bus.
    pub bus: Box<dyn Bus + Send>,
    /// The model of the first simulated device.
    pub model: Option<&'static Model>,
    /// The node-ID of the first simulated device.
    simulated: Option<NodeId>,
    /// The decoder's state of the network.
    pub network: Network,
    /// The name of the bus, as a channel.
    pub channels: Channels,
}

impl Live {
    /// Opens a bus, describes the devices on it, and lets a simulated device, which was just switched on, finish its
    /// initialisation.
    pub fn open(
        address: &str,
        node: Option<NodeId>,
        devices: &[DeviceArg],
        client: ClientArg,
    ) -> Result<Self, Failure> {
        let opened = open_device_bus_at(address, 0, client.client_timeout, node)?;
        let mut channels = Channels::new();
        channels.intern(channel_name(address));
        let (model, simulated) = (opened.model, opened.node());
        let mut live = Self { bus: opened.bus, model, simulated, network: Network::new(), channels };
        for attached in &opened.devices {
            if let Some(node) = attached.node {
                live.network.describe(node, KnownDevice::clone(attached.model.device()));
            }
        }
        if let Some(node) = simulated {
            live.boot(node).map_err(Failure::unreachable)?;
        }
        crate::devices::each(devices, |node, known| live.network.describe(node, Arc::clone(known)))?;
        Ok(live)
    }

    fn boot(&mut self, node: NodeId) -> Result<(), BusError> {
        let deadline = self.bus.now() + BOOT;
        while let Some(record) = self.bus.receive(deadline)? {
            let decoded = self.network.handle(&record);
            if decoded.service == Service::BootUp && decoded.node == Some(node) {
                break;
            }
        }
        Ok(())
    }

    /// The node-ID of the simulated device, if there is one.
    pub fn simulated_node(&self) -> Option<NodeId> {
        self.simulated
    }

    /// Prints the errors and losses of the bus.
    pub fn report_health(&self) {
        report_health(self.bus.as_ref());
    }
}

/// Prints the errors and losses of a bus.
pub fn report_health(bus: &dyn Bus) {
    let health = bus.health();
    if health.lost > 0 {
        diagnostic(&format!("canvass: {} frames were lost: this machine did not keep up", health.lost));
    }
    if let Some(trouble) = interruptions(bus).map(|interruptions| interruptions.to_string()).or(health.trouble) {
        diagnostic(&format!("canvass: {trouble}"));
    }
}

/// Prints one line for each frame.
pub struct FrameLines {
    lines: TextLines,
    output: Output,
}

impl FrameLines {
    pub fn new(color: Color) -> Self {
        let colors = color.on_stdout();
        Self { lines: TextLines::new(TimeStyle::Absolute, colors), output: Output::text(colors) }
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

/// Parses a size in bytes: `500k`, `100M`, `2G`.
pub fn parse_size(text: &str) -> anyhow::Result<u64> {
    let (digits, factor) = match text.char_indices().last() {
        Some((at, 'k' | 'K')) => (&text[..at], 1_000),
        Some((at, 'M')) => (&text[..at], 1_000_000),
        Some((at, 'G')) => (&text[..at], 1_000_000_000),
        _ => (text, 1),
    };
    match digits.parse::<u64>().ok().and_then(|number| number.checked_mul(factor)) {
        Some(size) if size > 0 => Ok(size),
        _ => anyhow::bail!("expected a size such as 500k, 100M or 2G, found \"{text}\""),
    }
}

/// Parses a span: seconds, or a number with `ms`, `s`, `min` or `h`.
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

/// Prints a span in the form that [`parse_span`] takes.
pub fn typed_span(span: Duration) -> String {
    match (span.nanos() / 1_000_000, span.nanos() % 1_000_000) {
        (millis, 0) if millis % 1_000 == 0 => format!("{}s", millis / 1_000),
        (millis, 0) => format!("{millis}ms"),
        _ => format!("{}ms", span.nanos() as f64 / 1e6),
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
    fn sizes_as_typed() {
        assert_eq!(parse_size("500k").unwrap(), 500_000);
        assert_eq!(parse_size("2G").unwrap(), 2_000_000_000);
        assert_eq!(parse_size("17").unwrap(), 17);
        for wrong in ["", "k", "0", "-1", "1T", "99999999999999999999"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn spans_are_told_as_they_are_typed() {
        for text in ["1s", "90s", "1500ms", "0.5ms"] {
            assert_eq!(typed_span(parse_span(text).unwrap()), text);
        }
    }

    #[test]
    fn a_listener_that_others_reach_is_told_of() {
        for own in ["slcan:listen://2000", "slcan:listen://:2000@250k", "slcan:listen://127.0.0.1:2000", "can0"] {
            assert_eq!(open_to_others(own), None, "{own}");
        }
        assert_eq!(open_to_others("slcan:listen://[::1]:2000"), None);
        assert_eq!(open_to_others("slcan:listen://0.0.0.0:2000@500k"), Some("0.0.0.0:2000"));
    }

    #[test]
    fn a_bus_has_a_name() {
        let live = ["can0", "socketcan:vcan1", "slcan:/dev/ttyACM0@250k", "slcan:COM3@1M", "pcan:PCAN_USBBUS1@250k"];
        assert_eq!(live.map(channel_name), ["can0", "vcan1", "/dev/ttyACM0", "COM3", "PCAN_USBBUS1"]);
        assert_eq!(channel_name("sim:x+y"), "sim");
    }
}
