//! `canvass send`: single frames, and what comes back.

use super::test::open_bus;
use crate::devices::DeviceArg;
use crate::output::{Color, Output};
use crate::status::{Failure, Status};
use canvass_analyzer::network::Network;
use canvass_analyzer::{Meaning, NodeId, Service};
use canvass_conformance::bus::Bus;
use canvass_reports::decode::{Line, Lines, TextLines, TimeStyle};
use canvass_traces::{Channels, Duration, Frame, FrameSyntax, Record, parse_frame};

/// Send frames and print what comes back, decoded
///
/// Frames are written as candump and cansend write them: 63F#4000600000000000, 701#R.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The frames, sent one after the other
    #[arg(required = true, value_name = "FRAME", value_parser = parse_sent)]
    frames: Vec<Frame>,
    /// How long to listen after each frame, in milliseconds
    #[arg(long, default_value_t = 100, value_name = "MS")]
    wait: u64,
    /// Which device a node is: a built-in model or an EDS or DCF file
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
}

fn parse_sent(text: &str) -> Result<Frame, FrameSyntax> {
    let record = parse_frame(text)?;
    if record.frame.is_error() || record.frame.is_fd() || record.frame.is_xl() {
        let expected = "a classical data or remote frame, which is all that CANopen sends";
        return Err(FrameSyntax { position: 0, expected, found: text.to_owned() });
    }
    Ok(record.frame)
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let mut opened = open_bus(&self.bus, 0)?;
        let mut network = Network::new();
        if let Some((model, node)) = opened.model.and_then(|model| Some((model, model.default_node()?))) {
            network.describe(node, model.description().clone());
            boot(opened.bus.as_mut(), node, &mut network).map_err(Failure::unreachable)?;
        }
        for device in &self.device {
            network.describe(device.node, device.describe()?);
        }
        let mut channels = Channels::new();
        channels.intern(self.bus.split_once(':').map_or(&*self.bus, |(kind, _)| kind));
        let mut lines = TextLines::new(TimeStyle::Absolute, color.on_stdout());
        let output = Output::default();
        for frame in &self.frames {
            opened.bus.send(frame).map_err(Failure::unreachable)?;
            let deadline = opened.bus.now() + Duration::from_millis(self.wait);
            while let Some(record) = opened.bus.receive(deadline).map_err(Failure::unreachable)? {
                show(&record, &channels, &mut network, &mut lines, &output)?;
            }
        }
        output.flush()?;
        Ok(Status::Good)
    }
}

/// Lets a simulated device, which was only just switched on, finish its initialisation.
fn boot(bus: &mut dyn Bus, node: NodeId, network: &mut Network) -> Result<(), canvass_conformance::bus::BusError> {
    let deadline = bus.now() + Duration::from_secs(5);
    while let Some(record) = bus.receive(deadline)? {
        let decoded = network.handle(&record);
        if decoded.service == Service::BootUp && decoded.node == Some(node) {
            break;
        }
    }
    Ok(())
}

fn show(
    record: &Record,
    channels: &Channels,
    network: &mut Network,
    lines: &mut TextLines,
    output: &Output,
) -> std::io::Result<()> {
    let decoded = network.handle(record);
    let Some(bus) = network.bus(record.channel) else { return Ok(()) };
    let meaning = Meaning::new(record, &decoded, bus);
    output.append(|buffer| lines.line(&Line { record, channels, decoded: &decoded, meaning }, buffer))
}
