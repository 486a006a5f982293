//! `canvass eds convert`: device descriptions from one format to another.

use super::found::{Description, description};
use crate::destination::refuse_existing;
use crate::devices::parse_node;
use crate::files::Files;
use crate::output::{diagnostic, write_bytes};
use crate::status::{Failure, Status};
use crate::whole_file::write_whole;
use anyhow::{Context, Result, bail};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::convert::{Form, convert};
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use canvass_reports::descriptions::dbc;
use clap::ValueEnum;
use std::path::PathBuf;

/// Losses printed without `--all-losses`; the rest is only counted.
const SHOWN: usize = 20;

/// Convert a device description to another format: EDS and XDD, DCF and XDC, and its PDOs to a DBC
///
/// The extension of OUT or --to gives the output format. Standard error reports each item that the output format
/// can't hold, with its place. An EDS made of a DCF has no configured values. A DBC has the PDOs of the device at one
/// node-ID, for tools without CANopen.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass eds convert encoder.eds encoder.xdd
  canvass eds convert line-3.xdc line-3.dcf --force
  canvass eds convert encoder.xdd - --to eds
  canvass eds convert encoder.eds encoder.dbc --node 5")]
pub struct Args {
    /// An EDS, DCF, XDD or XDC file; - is standard input
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The file to write; - is standard output
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// The format to write
    #[arg(long, value_enum)]
    to: Option<To>,
    /// The node-ID for the PDOs of a DBC [default: that of a DCF]
    #[arg(long, value_name = "N", value_parser = parse_node)]
    node: Option<NodeId>,
    /// Overwrite OUT if it exists
    #[arg(long)]
    force: bool,
    /// Report everything that is lost, not only the first 20 items
    #[arg(long)]
    all_losses: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum To {
    /// EDS (CiA 306): a type of device
    Eds,
    /// DCF (CiA 306): a configured device
    Dcf,
    /// XDD (CiA 311): a type of device
    Xdd,
    /// XDC (CiA 311): a configured device
    Xdc,
    /// DBC: a CAN database with the PDOs
    Dbc,
}

/// The output: a description in another format, or a DBC.
#[derive(Clone, Copy)]
enum Target {
    Form(Form),
    Dbc,
}

impl To {
    const fn target(self) -> Target {
        match self {
            Self::Eds => Target::Form(Form::Eds),
            Self::Dcf => Target::Form(Form::Dcf),
            Self::Xdd => Target::Form(Form::Xdd),
            Self::Xdc => Target::Form(Form::Xdc),
            Self::Dbc => Target::Dbc,
        }
    }
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let target = self.target()?;
        let is_stdout = self.output.as_os_str() == "-";
        if !is_stdout {
            Files::new().reads([&self.input]).writes([&self.output])?;
            if !self.force {
                refuse_existing(&self.output)?;
            }
        }
        let bytes = Description::read(&self.input)?.bytes;
        let description = description(&bytes, &self.input)?;
        let (written, losses) = match target {
            Target::Form(form) => self.converted(&bytes, form)?,
            Target::Dbc => self.database(description)?,
        };
        if is_stdout {
            write_bytes(&written)?;
        } else {
            write_whole(&self.output, &written)?;
        }
        self.tell(&losses);
        Ok(Status::Good)
    }

    /// Converts the description; returns the file and the items that it can't hold.
    fn converted(&self, bytes: &[u8], form: Form) -> Result<(Vec<u8>, Vec<String>)> {
        if self.node.is_some() {
            bail!("--node is for a DBC: the {form} names its own node-ID");
        }
        let name = self.output.file_name().filter(|name| *name != "-");
        let name = name.map(|name| name.to_string_lossy().into_owned());
        let converted =
            convert(bytes, form, name.as_deref()).with_context(|| format!("can't convert {}", self.input.display()))?;
        Ok((converted.text.into_bytes(), converted.losses.iter().map(ToString::to_string).collect()))
    }

    /// Converts the PDOs to a DBC; returns the file and the PDOs that it can't hold.
    fn database(&self, description: DeviceDescription) -> Result<(Vec<u8>, Vec<String>)> {
        let input = self.input.display();
        let configured = description.commissioning.as_ref().and_then(|it| it.node_id);
        let node = self.node.or(configured);
        let node = node.with_context(|| format!("{input} names no node-ID: use --node N for the DBC"))?;
        let database = dbc::database(KnownDevice::described(description), node);
        if database.messages == 0 {
            let reasons = database.left_out.join("; ");
            let reasons = if reasons.is_empty() { "the description has none" } else { &reasons };
            bail!("{input} has no PDO that a DBC could hold: {reasons}");
        }
        Ok((database.bytes, database.left_out))
    }

    fn target(&self) -> Result<Target> {
        let ending = self.output.extension().map(|ending| ending.to_string_lossy().into_owned());
        let by_name = ending.and_then(|ending| To::from_str(&ending, true).ok());
        match self.to.or(by_name) {
            Some(to) => Ok(to.target()),
            None => {
                let path = self.output.display();
                bail!("{path} does not show which format to write: use --to with one of eds, dcf, xdd, xdc, dbc")
            }
        }
    }

    fn tell(&self, losses: &[String]) {
        let shown = if self.all_losses { losses.len() } else { SHOWN };
        let name = self.input.display();
        for loss in losses.iter().take(shown) {
            diagnostic(&format!("{name}: {loss}"));
        }
        if losses.len() > shown {
            let rest = losses.len() - shown;
            diagnostic(&format!("{name}: {rest} more items are lost: --all-losses lists all"));
        }
    }
}
