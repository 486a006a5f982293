//! `canvass dcf convert`: configurations from one format to another.

use super::file::{ConfigurationFile, Content, Written};
use super::read::bytes_of;
use crate::destination::refuse_existing;
use crate::devices::{describe, named, parse_node};
use crate::files::Files;
use crate::output::write_bytes;
use crate::status::{Failure, Status};
use crate::whole_file::write_whole;
use anyhow::{Result, anyhow, bail};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::configuration::setting_of;
use canvass_analyzer::dictionary::{Commissioning, DeviceDescription};
use std::path::{Path, PathBuf};

/// Convert a configuration: DCF, XDC and concise DCF (1F22h)
///
/// The ending of OUT gives the format: .dcf, .xdc, or .cdc for a concise DCF. A concise DCF has its values in the order
/// in which devices take them. To make a DCF of a concise DCF, the device must be described by --device.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass dcf convert encoder-5.dcf encoder-5.cdc
  canvass dcf convert encoder-5.cdc encoder-5.dcf --device encoder.eds --node 5")]
pub struct Args {
    /// A DCF, XDC or concise DCF
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The file to write; - is a DCF on standard output
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// The device's node-ID (default: that of a DCF)
    #[arg(long, value_parser = parse_node)]
    node: Option<NodeId>,
    /// The device of a concise DCF: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "[NODE=]MODEL|FILE")]
    device: Option<String>,
    /// Overwrite OUT if it exists
    #[arg(long)]
    force: bool,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let output = Some(self.output.as_path()).filter(|path| path.as_os_str() != "-");
        let written = Written::of(output)?;
        Files::new().reads([&self.input]).writes(output)?;
        if let Some(path) = output.filter(|_| !self.force) {
            refuse_existing(path)?;
        }
        let file = ConfigurationFile::read(&self.input)?;
        let node = self.node.or(file.node());
        let node = node.ok_or_else(|| anyhow!("{} names no node-ID: use --node N", self.input.display()))?;
        let bytes = bytes_of(&self.description(file, node)?, node, written)?;
        match output {
            Some(path) => write_whole(path, &bytes)?,
            None => {
                write_bytes(&bytes)?;
            }
        }
        Ok(Status::Good)
    }

    fn description(&self, file: ConfigurationFile, node: NodeId) -> Result<DeviceDescription> {
        let values = file.values(node)?;
        let mut description = match file.content {
            Content::Description(description) => *description,
            Content::Concise(_) => self.described(&file.path)?,
        };
        for download in values {
            let at = download.at;
            let object = description.dictionary.object_mut(at.index);
            let Some(entry) = object.and_then(|object| object.entry_mut(at.sub)) else {
                bail!("{at} is not described: {} is of another device", file.path.display());
            };
            let setting = setting_of(entry, &download.value, node);
            let bytes = canvass_traces::hex::spaced(&download.value);
            let setting = setting.ok_or_else(|| anyhow!("{at}: {bytes} is no value of its data type"))?;
            entry.configured = Some(setting);
        }
        let before = description.commissioning.take().unwrap_or_default();
        description.commissioning = Some(Commissioning { node_id: Some(node), ..before });
        Ok(description)
    }

    fn described(&self, path: &Path) -> Result<DeviceDescription> {
        let device = self.device.as_deref();
        let device = device.map(named);
        let device = device.ok_or_else(|| {
            anyhow!("{} is a concise DCF, which has values only: describe the device with --device", path.display())
        })?;
        Ok(describe(device)?.description)
    }
}
