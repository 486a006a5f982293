//! `canvass dcf write`: gives devices the configuration of a file.

mod job;
mod nodes;

use super::allow::Allowed;
use super::device::{BusOptions, Session};
use super::file::{ConfigurationFile, Content};
use crate::output::Color;
use crate::status::{Failure, Status};
use anyhow::{Result, anyhow};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_analyzer::dictionary::configuration::{DeviceSettings, Download, configured, ordered};
use job::Job;
use nodes::{Nodes, plan};
use std::path::PathBuf;

/// Write the configuration of a file to devices, in an order that devices take, and read it back
///
/// First every setting is read; what differs is shown, and only that is written: each PDO is switched off, set up and
/// switched on again (CiA 301, 7.5.2.36 and 7.5.2.38). canvass stops at the first refusal and says what was done. The
/// values before are kept in a journal meanwhile, by which `canvass restore` undoes an interrupted run. A device whose
/// identity (1018h) is not that of the file, or which is operational, is refused. For another node than that of the
/// file, COB-IDs of the predefined connection set follow the node-ID; others that the device would send with are refused.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass dcf write encoder-5.dcf can0 --dry-run
  canvass dcf write encoder-5.dcf can0 --node 1..8 --store
  canvass dcf write backup/nodelist.cpj can0")]
pub struct Args {
    /// A DCF, XDC or concise DCF, or the project of a network (nodelist.cpj)
    file: PathBuf,
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The devices, such as 5 or 1..8 (default: the node of the file)
    #[arg(long, value_name = "NODES")]
    node: Option<Nodes>,
    /// Show what would be written, and write nothing
    #[arg(long)]
    dry_run: bool,
    /// Let the device store all parameters afterwards (1010h:01)
    #[arg(long)]
    store: bool,
    /// What may be changed or disregarded besides
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_enum)]
    allow: Vec<Allowed>,
    /// Keep the journal in FILE, so that `canvass restore` can undo the write later (default: a file in the working
    /// directory that is removed at the end)
    #[arg(long, value_name = "FILE")]
    journal: Option<PathBuf>,
    /// The device of a concise DCF: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "[NODE=]MODEL|FILE")]
    device: Option<String>,
    #[command(flatten)]
    options: BusOptions,
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let planned = plan(&self.file, self.node.as_ref())?;
        let nodes: Vec<NodeId> = planned.iter().map(|(node, _)| *node).collect();
        let mut session = Session::open(&self.bus, &nodes, &self.options)?;
        let mut status = Status::Good;
        for (node, file) in &planned {
            let mut job = Job::prepare(&mut session, *node, file, &self, nodes.len() == 1)?;
            job.show(color)?;
            if !self.dry_run {
                status = job.carry_out(&mut session)?;
            }
            if status != Status::Good {
                break;
            }
        }
        session.report_health();
        Ok(status)
    }
}

/// The settings of a configured description in the order of writing, without entries that act.
pub fn in_order(known: &KnownDevice, node: NodeId) -> Result<Vec<Download>> {
    let values = configured(&known.description, node).map_err(|bad| {
        let told: Vec<String> = bad.iter().map(ToString::to_string).collect();
        anyhow!("{}", told.join("\n"))
    })?;
    let of_device = DeviceSettings::described(known, node);
    let settings: Vec<Download> = values.into_iter().filter(|download| !of_device.acts(download.at)).collect();
    Ok(ordered(&settings, &[]))
}

/// Whether the file says nothing of the device but its values.
fn is_concise(file: &ConfigurationFile) -> bool {
    matches!(file.content, Content::Concise(_))
}
