//! `canvass send`: sends single frames and prints the answers.

use crate::devices::DeviceArg;
use crate::live::{ClientArg, FrameLines, Live, parse_span};
use crate::output::Color;
use crate::status::{Failure, Status};
use canvass_traces::{Duration, Frame, FrameSyntax, parse_frame};

/// Send frames and print the decoded answers
///
/// Frames have the form of candump and cansend: 63F#4000600000000000, 701#R.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The frames, sent one after the other
    #[arg(required = true, value_name = "FRAME", value_parser = parse_sent)]
    frames: Vec<Frame>,
    /// How long to listen after each frame, such as 100ms
    #[arg(long, default_value = "100ms", value_name = "SPAN", value_parser = parse_span)]
    wait: Duration,
    /// The device of a node: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
    #[command(flatten)]
    client: ClientArg,
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
        let live = Live::open(&self.bus, None, &self.device, self.client)?;
        send_and_show(live, &self.frames, self.wait, &|_| true, color)
    }
}

/// Sends the frames one after the other. After each it prints the selected frames of the bus for a while.
pub fn send_and_show(
    mut live: Live,
    frames: &[Frame],
    wait: Duration,
    wanted: &dyn Fn(&Frame) -> bool,
    color: Color,
) -> Result<Status, Failure> {
    let mut lines = FrameLines::new(color);
    for frame in frames {
        live.bus.send(frame).map_err(Failure::unreachable)?;
        let deadline = live.bus.now() + wait;
        while let Some(record) = live.bus.receive(deadline).map_err(Failure::unreachable)? {
            if wanted(&record.frame) {
                lines.show(&record, &mut live.network, &live.channels)?;
            }
            // On a bus that never falls silent, receiving alone would not reach the deadline.
            if record.timestamp > deadline {
                break;
            }
        }
    }
    lines.flush()?;
    live.report_health();
    Ok(Status::Good)
}
