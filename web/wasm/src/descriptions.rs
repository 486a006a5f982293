//! Device descriptions that the user has opened.

use crate::provenance::used;
use canvass_analyzer::dictionary::check::check;
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use canvass_analyzer::{NodeId, NodeRange};
use canvass_reports::descriptions::show::Shown;
use canvass_reports::descriptions::{CheckedFile, Counts, text};
use canvass_reports::provenance::FileUsed;
use serde_json::{Value, json};
use std::io;
use std::sync::Arc;

/// A description with its nodes.
#[derive(Clone, Debug)]
pub struct Described {
    /// The name of the file.
    pub name: String,
    /// The nodes as the user typed them.
    pub nodes_text: String,
    /// The nodes.
    pub nodes: Vec<NodeId>,
    /// The content of the description.
    pub known: Arc<KnownDevice>,
    bytes: Vec<u8>,
}

impl Described {
    /// Reads a description. Without `nodes` the description is for the node that it names itself, or for all nodes.
    ///
    /// # Errors
    /// A text, if the description can't be used.
    pub fn read(name: &str, nodes: &str, bytes: &[u8]) -> Result<Self, String> {
        let description = DeviceDescription::read(bytes).map_err(|error| format!("{name}: {error}"))?;
        description.usable().map_err(|error| format!("{name}: {error}"))?;
        let own = description.commissioning.as_ref().and_then(|commissioning| commissioning.node_id);
        let nodes_text = match own {
            _ if !nodes.is_empty() => nodes.to_owned(),
            Some(node) => node.to_string(),
            None => "all".to_owned(),
        };
        let nodes = NodeRange::list(&nodes_text).map_err(|error| error.to_string())?;
        let known = Arc::new(KnownDevice::described(description));
        Ok(Self { name: name.to_owned(), nodes_text, nodes, known, bytes: bytes.to_owned() })
    }

    /// A summary of the description.
    pub fn summary(&self) -> Value {
        let device = &self.known.description;
        let counts = self.checked().map(|file| Counts::of([&file]).to_string()).unwrap_or_default();
        json!({
            "name": self.name,
            "nodes": self.nodes_text,
            "vendor": device.device.vendor_name,
            "product": device.device.product_name,
            "objects": device.dictionary.objects().len(),
            "checked": counts,
        })
    }

    /// The file with its hash.
    pub fn used(&self) -> FileUsed {
        used("description", &self.name, &self.bytes)
    }

    fn checked(&self) -> Option<CheckedFile> {
        Some(CheckedFile::new(&self.name, &check(&self.bytes, Some(&self.name)).ok()?, |_| true))
    }

    /// The page of the description's dictionary.
    ///
    /// # Errors
    /// None in practice: the output goes to memory.
    pub fn page(&self) -> io::Result<Vec<u8>> {
        let node = self.nodes.first().copied().filter(|_| self.nodes.len() == 1);
        let description = self.known.description.clone();
        let mut out = Vec::new();
        Shown { file: self.name.clone(), description, node, only: None }.html(&mut out)?;
        Ok(out)
    }

    /// The findings in the description, each with its place and fix.
    pub fn findings(&self) -> Value {
        let Some(file) = self.checked() else { return Value::Null };
        json!(canvass_reports::descriptions::json::document(&[file]))
    }

    /// The findings as text.
    pub fn findings_text(&self) -> String {
        let Ok(checked) = check(&self.bytes, Some(&self.name)) else { return String::new() };
        let file = CheckedFile::new(&self.name, &checked, |_| true);
        text::render(&file, &checked.source, text::Style { colors: false, width: 100 }, text::Hints::Each)
    }
}
