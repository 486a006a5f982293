//! `canvass dcf backup`: the configurations of all devices of a network.

use super::device::{BusOptions, Session};
use super::file::Written;
use super::read::{bytes, read};
use crate::destination::refuse_existing;
use crate::devices::DeviceArg;
use crate::output::diagnostic;
use crate::status::{Failure, Status};
use crate::whole_file::write_whole;
use anyhow::{Context, Result, anyhow};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::configuration::{Project, ProjectNode};
use canvass_analyzer::dictionary::convert::Form;
use std::path::{Path, PathBuf};

/// Read the configurations of all devices of a network into a folder; nothing is written to the devices
///
/// The folder gets a DCF for each node and nodelist.cpj (CiA 306-3), which lists them. `canvass dcf write
/// FOLDER/nodelist.cpj BUS` brings the configurations back. A node that canvass does not know must be described by
/// --device, otherwise it is left out and the exit status is 1.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass dcf backup can0 monday
  canvass dcf backup can0 monday --device 3=drive.eds --device 5..8=encoder.eds")]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The folder; it is created if it does not exist
    folder: PathBuf,
    /// The devices: built-in models, or EDS or DCF files
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
    /// The name of the network in nodelist.cpj
    #[arg(long, value_name = "NAME", default_value = "")]
    network: String,
    /// Overwrite files that exist
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    options: BusOptions,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let list = self.folder.join("nodelist.cpj");
        if !self.force {
            refuse_existing(&list)?;
        }
        let mut session = Session::open(&self.bus, &[], &self.options)?;
        let nodes = session.nodes()?;
        if nodes.is_empty() {
            return Err(Failure::unreachable(anyhow!("no node answers on {}", self.bus)));
        }
        std::fs::create_dir_all(&self.folder).with_context(|| format!("can't create {}", self.folder.display()))?;
        let mut project = Project { name: self.network.clone(), ..Project::default() };
        let mut status = Status::Good;
        for node in nodes {
            match self.keep(&mut session, node)? {
                Some(kept) => drop(project.nodes.insert(node, kept)),
                None => status = Status::Findings,
            }
        }
        write_whole(&list, project.text().as_bytes())?;
        session.report_health();
        diagnostic(&format!("canvass: {} nodes in {}", project.nodes.len(), list.display()));
        Ok(status)
    }

    /// Reads a node into its file; `None` if the node is not known.
    fn keep(&self, session: &mut Session, node: NodeId) -> Result<Option<ProjectNode>, Failure> {
        let name = format!("node{node}.dcf");
        let path = self.folder.join(&name);
        if !self.force {
            refuse_existing(&path)?;
        }
        if let Err(why) = session.known(node, &self.device)? {
            diagnostic(&format!("canvass: {why}; it is left out"));
            return Ok(None);
        }
        let kept = read(session, node, &self.device, Some(Path::new(&name)))?;
        write_whole(&path, &bytes(&kept, node, Written::Form(Form::Dcf))?)?;
        Ok(Some(ProjectNode { name: kept.description.device.product_name, dcf: name }))
    }
}
