//! `canvass eds show`: prints a device description.

use super::found::{Description, description};
use crate::commands::sdo::object::resolve;
use crate::devices::parse_node;
use crate::output::{Color, Output, terminal_width, unless_closed};
use crate::status::{Failure, Status};
use anyhow::{Result, bail};
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::{Index, NodeId};
use canvass_reports::descriptions::show::{Shown, Style};
use canvass_reports::escape::Printable;
use std::io::Write;
use std::path::PathBuf;

/// Show a device description: its objects as a table, one object in detail, its PDOs bit by bit
///
/// An EDS, DCF, XDD or XDC as a table, as the appendix of a manual (markdown), as a self-contained page to search and
/// print (html), or for programs (json).
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass eds show encoder.eds
  canvass eds show encoder.eds 1800
  canvass eds show encoder.eds --format html > encoder.html")]
pub struct Args {
    /// An EDS, DCF, XDD or XDC file; - is standard input
    file: PathBuf,
    /// One object: its index in hexadecimal, or its name
    object: Option<String>,
    /// The node-ID for values and COB-IDs that depend on it [default: that of a DCF]
    #[arg(long, value_parser = parse_node)]
    node: Option<NodeId>,
    /// How to print the description
    #[arg(long, value_enum, default_value_t)]
    format: ShowFormat,
}

#[derive(Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum ShowFormat {
    /// For people: a table
    #[default]
    Text,
    /// One JSON object
    Json,
    /// The appendix of a manual
    Markdown,
    /// A self-contained page to search and print
    Html,
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let description = description(&Description::read(&self.file)?.bytes, &self.file)?;
        let only = self.object.as_deref().map(|object| index(object, &description)).transpose()?;
        let configured = description.commissioning.as_ref().and_then(|commissioning| commissioning.node_id);
        let node = self.node.or(configured);
        let shown = Shown { file: self.file.display().to_string(), description, node, only };
        let style = Style { colors: color.on_stdout(), width: terminal_width().unwrap_or(120) };
        let mut output = Output::text(style.colors);
        let written = match self.format {
            ShowFormat::Text => output.write_all(shown.text(style).as_bytes()),
            ShowFormat::Json => output.write_all(Printable::pretty_json(&shown.json()).as_str().as_bytes()),
            ShowFormat::Markdown => output.write_all(shown.markdown().as_bytes()),
            ShowFormat::Html => shown.html(&mut output),
        };
        unless_closed(written.and_then(|()| Output::flush(&output)))?;
        Ok(Status::Good)
    }
}

/// Finds the object with this index, this name, or a sub-index of this name.
fn index(text: &str, description: &DeviceDescription) -> Result<Index> {
    let wanted = text.to_lowercase();
    let objects = description.dictionary.objects();
    if let Some(object) = objects.iter().find(|object| object.name.to_lowercase() == wanted) {
        return Ok(object.index);
    }
    let index = resolve(text, Some(description))?.index;
    if description.dictionary.object(index).is_none() {
        bail!("the description has no object {index}");
    }
    Ok(index)
}
