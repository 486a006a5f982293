//! `canvass nmt`: NMT commands.

use super::send::send_and_show;
use crate::devices::{DeviceArg, parse_node};
use crate::live::{ClientArg, Live, parse_span};
use crate::output::Color;
use crate::status::{Failure, Status};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::nmt::{self, Nmt};
use canvass_analyzer::wire::{Wire, emcy, error_control};
use canvass_traces::{Duration, Frame};

/// Send an NMT command to a node or to all nodes, and print how they react
///
/// Prints boot-up messages, heartbeats and emergencies of the commanded nodes, but no PDOs.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The command
    #[arg(value_enum)]
    command: Command,
    /// The node, or `all`
    #[arg(value_name = "NODE|all", value_parser = parse_addressed)]
    node: Addressed,
    /// How long to listen for reactions, such as 500ms
    #[arg(long, default_value = "1s", value_name = "SPAN", value_parser = parse_span)]
    wait: Duration,
    /// The device of a node: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
    #[command(flatten)]
    client: ClientArg,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Command {
    /// Start: enter the state operational
    Start,
    /// Stop: enter the state stopped
    Stop,
    /// Enter the state pre-operational
    PreOperational,
    /// Reset node: restart the device
    ResetNode,
    /// Reset communication: restart the device's communication
    ResetCommunication,
}

#[derive(Clone, Copy)]
struct Addressed(u8);

impl Addressed {
    /// Whether a frame shows the state of an addressed node.
    fn concerns(self, frame: &Frame) -> bool {
        frame.cob_id().is_some_and(|cob_id| {
            let of_state = matches!(cob_id & 0x780, error_control::CAN_ID_BASE | emcy::CAN_ID_BASE);
            let node = NodeId::of_cob_id(cob_id).map(NodeId::raw);
            cob_id == nmt::CAN_ID || of_state && node.is_some_and(|node| self.0 == 0 || self.0 == node)
        })
    }
}

fn parse_addressed(text: &str) -> anyhow::Result<Addressed> {
    if text.eq_ignore_ascii_case("all") { Ok(Addressed(0)) } else { parse_node(text).map(NodeId::raw).map(Addressed) }
}

impl Command {
    const fn specifier(self) -> nmt::Command {
        match self {
            Self::Start => nmt::Command::START,
            Self::Stop => nmt::Command::STOP,
            Self::PreOperational => nmt::Command::ENTER_PRE_OPERATIONAL,
            Self::ResetNode => nmt::Command::RESET_NODE,
            Self::ResetCommunication => nmt::Command::RESET_COMMUNICATION,
        }
    }
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let live = Live::open(&self.bus, None, &self.device, self.client)?;
        let frame = Nmt { command: self.command.specifier(), node: self.node.0 }.to_frame(nmt::CAN_ID);
        send_and_show(live, &[frame], self.wait, &|frame| self.node.concerns(frame), color)
    }
}
