//! Configuration files: DCF, XDC and concise DCF, distinguished by content.

use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::dictionary::configuration::{Download, configured, read_concise};
use canvass_analyzer::dictionary::convert::Form;
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::small_file::{self, OF_HAND};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A configuration file.
pub struct ConfigurationFile {
    pub path: PathBuf,
    pub content: Content,
}

/// The content of a configuration file.
pub enum Content {
    /// A DCF or XDC.
    Description(Box<DeviceDescription>),
    /// A concise DCF, which has values only.
    Concise(Vec<Download>),
}

impl ConfigurationFile {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display();
        let bytes = small_file::read(path, OF_HAND).with_context(|| format!("can't read {name}"))?;
        if let Ok(downloads) = read_concise(&bytes) {
            return Ok(Self { path: path.to_owned(), content: Content::Concise(downloads) });
        }
        let description = crate::devices::read(path)?;
        let has_values = description.dictionary.entries().any(|(_, entry)| entry.configured.is_some());
        if !has_values {
            bail!(
                "{name} has no configured values (ParameterValue), so there is nothing to write or to compare; `canvass \
                 dcf read` makes a DCF of a device"
            );
        }
        Ok(Self { path: path.to_owned(), content: Content::Description(Box::new(description)) })
    }

    /// The node-ID that the file is for.
    pub fn node(&self) -> Option<NodeId> {
        match &self.content {
            Content::Description(description) => description.commissioning.as_ref()?.node_id,
            Content::Concise(_) => None,
        }
    }

    /// The description of the device, with the facts of a manual; `other` describes a device whose file does not.
    pub fn known(&self, other: Option<&KnownDevice>) -> KnownDevice {
        let manual = other.map(|known| known.manual.clone()).unwrap_or_default();
        match &self.content {
            Content::Description(description) => {
                KnownDevice { description: DeviceDescription::clone(description), manual }
            }
            Content::Concise(_) => other.cloned().unwrap_or_default(),
        }
    }

    /// The values for a node.
    pub fn values(&self, node: NodeId) -> Result<Vec<Download>> {
        match &self.content {
            Content::Description(description) => configured(description, node).map_err(|bad| {
                let told: Vec<String> = bad.iter().map(ToString::to_string).collect();
                anyhow!("{} can't be written to node {node}:\n{}", self.path.display(), told.join("\n"))
            }),
            // A concise DCF writes some objects several times, such as the COB-ID of a PDO: the last value counts.
            Content::Concise(downloads) => {
                let last: BTreeMap<Multiplexer, &Download> =
                    downloads.iter().map(|download| (download.at, download)).collect();
                Ok(last.into_values().cloned().collect())
            }
        }
    }
}

/// The format of a file to write, by the ending of its name.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Written {
    Form(Form),
    Concise,
}

impl Written {
    /// The format for a path; a DCF for standard output.
    pub fn of(path: Option<&Path>) -> Result<Self> {
        let Some(path) = path else { return Ok(Self::Form(Form::Dcf)) };
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("dcf") => Ok(Self::Form(Form::Dcf)),
            Some("xdc") => Ok(Self::Form(Form::Xdc)),
            Some("cdc" | "bin") => Ok(Self::Concise),
            _ => bail!(
                "{} does not show which format to write: expected a name that ends in .dcf, .xdc, or .cdc for a concise \
                 DCF",
                path.display()
            ),
        }
    }
}
