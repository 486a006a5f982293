//! `canvass dcf read`: the configuration of a device as a file.

use super::device::{BusOptions, Session, tell, told_objects};
use super::file::Written;
use crate::commands::eds::from_device::file_info;
use crate::destination::refuse_existing;
use crate::devices::{DeviceArg, named, parse_node};
use crate::output::write_bytes;
use crate::status::{Failure, Status};
use crate::whole_file::write_whole;
use anyhow::{Result, anyhow};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::configuration::{Download, Excluded, ReadConfiguration, from_device, write_concise};
use canvass_analyzer::dictionary::convert;
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use std::path::{Path, PathBuf};

/// Read the configuration of a device into a DCF, XDC or concise DCF; nothing is written to the device
///
/// A configuration has the value of every setting: each entry that can be read and written. Entries that act when they
/// are written are left out, such as presets and 1010h, and so are the objects with node-ID and bit rate, which the file
/// has in [DeviceComissioning]. COB-IDs that follow the node-ID by default are written as formulas, so that the file
/// serves other nodes. The description comes from --device; a device that canvass knows needs none.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass dcf read can0 --node 5 --device encoder.eds -o encoder-5.dcf
  canvass dcf read can0 --node 5 -o encoder-5.xdc")]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The device's node-ID (default: that of the simulated device)
    #[arg(long, value_parser = parse_node)]
    node: Option<NodeId>,
    /// The device: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "[NODE=]MODEL|FILE")]
    device: Option<String>,
    /// The file to write: .dcf, .xdc, or .cdc for a concise DCF (default: a DCF on standard output)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Overwrite FILE if it exists
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    options: BusOptions,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let written = Written::of(self.output.as_deref())?;
        if let Some(path) = self.output.as_deref().filter(|_| !self.force) {
            refuse_existing(path)?;
        }
        let given: Vec<NodeId> = self.node.into_iter().collect();
        let mut session = Session::open(&self.bus, &given, &self.options)?;
        let node = self.node.or(session.simulated_node()).ok_or_else(|| anyhow!("which node? use --node N"))?;
        let device = self.device.as_deref().map(named);
        let devices: Vec<DeviceArg> =
            device.iter().map(|device| DeviceArg { nodes: vec![node], device: (*device).to_owned() }).collect();
        let read = read(&mut session, node, &devices, self.output.as_deref())?;
        session.report_health();
        let bytes = bytes(&read, node, written)?;
        match &self.output {
            Some(path) => write_whole(path, &bytes)?,
            None => {
                write_bytes(&bytes)?;
            }
        }
        Ok(if read.unread.is_empty() { Status::Good } else { Status::Findings })
    }
}

/// Reads the configuration of a device, and says what it lacks.
pub fn read(
    session: &mut Session,
    node: NodeId,
    devices: &[DeviceArg],
    output: Option<&Path>,
) -> Result<ReadConfiguration, Failure> {
    let (name, known) = session.known(node, devices)?.map_err(|why| anyhow!("{why}"))?;
    let survey = session.survey(node, &known.description)?;
    let mut read = from_device(&known, &survey, node, session.bit_rate());
    let last = known.description.file.name.clone();
    let description = format!("The configuration of node {node}, read from the device");
    read.description.file = canvass_analyzer::dictionary::FileInfo {
        last_eds: Some(if last.is_empty() { name.clone() } else { last }),
        ..file_info(output, "device.dcf", description)?
    };
    tell_read(node, &name, &read);
    Ok(read)
}

fn tell_read(node: NodeId, name: &str, read: &ReadConfiguration) {
    tell(node, &format!("{} settings, described by {name}", read.settings));
    for (reason, objects) in read.left_out.iter().filter(|(reason, _)| **reason != Excluded::Access) {
        tell(node, &format!("left out, {reason}: {}", told_objects(objects)));
    }
    for (at, answer) in &read.unread {
        let answer = answer.as_ref().map_or_else(|| "not read".to_owned(), ToString::to_string);
        tell(node, &format!("{at} has no value in the file: {answer}"));
    }
}

/// The configuration in a format.
pub fn bytes(read: &ReadConfiguration, node: NodeId, written: Written) -> Result<Vec<u8>> {
    bytes_of(&read.description, node, written)
}

/// A configured description in a format.
pub fn bytes_of(description: &DeviceDescription, node: NodeId, written: Written) -> Result<Vec<u8>> {
    match written {
        Written::Form(form) => {
            let (text, losses) = convert::write(description.clone(), form)?;
            losses.iter().for_each(|loss| crate::output::diagnostic(&format!("canvass: {loss}")));
            Ok(text.into_bytes())
        }
        Written::Concise => {
            let downloads = super::write::in_order(&KnownDevice::described(description.clone()), node)?;
            Ok(write_concise(&downloads.into_iter().collect::<Vec<Download>>()))
        }
    }
}
