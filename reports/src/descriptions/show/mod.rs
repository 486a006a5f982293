//! A device description to read: its objects as a table, one object in detail, its PDOs bit by bit.

mod cells;
mod html;
mod json;
mod markdown;
mod picture;
mod text;

use canvass_analyzer::dictionary::layout::{PdoLayout, layouts};
use canvass_analyzer::dictionary::names::{ObjectName, object_name};
use canvass_analyzer::dictionary::{DeviceDescription, FileInfo, Object};
use canvass_analyzer::{Index, Multiplexer, NodeId, SubIndex};
use std::io::{self, Write};

/// A description that is shown.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The file, as the user named it.
    pub file: String,
    /// What it says.
    pub description: DeviceDescription,
    /// The node-ID that formulas are shown for; without it, as formulas.
    pub node: Option<NodeId>,
    /// The object that alone is shown, in detail.
    pub only: Option<Index>,
}

/// How a terminal is written to.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// With colours.
    pub colors: bool,
    /// The columns that there are.
    pub width: u16,
}

impl Shown {
    /// For people: a table, or one object in detail.
    pub fn text(&self, style: Style) -> String {
        text::render(self, style)
    }

    /// One JSON object (`docs/json.md`).
    pub fn json(&self) -> serde_json::Value {
        json::document(self)
    }

    /// The appendix of a manual.
    pub fn markdown(&self) -> String {
        markdown::document(self)
    }

    /// A page of its own, to search and to print.
    ///
    /// # Errors
    /// What `out` gives.
    pub fn html(&self, out: &mut dyn Write) -> io::Result<()> {
        html::render(self, out)
    }

    fn objects(&self) -> impl Iterator<Item = &Object> {
        let objects = self.description.dictionary.objects().iter();
        objects.filter(|object| self.only.is_none_or(|only| only == object.index))
    }

    fn pdos(&self) -> Vec<PdoLayout<'_>> {
        let concerns = |layout: &PdoLayout<'_>, only: Index| {
            only.0 == layout.pdo.mapping_index()
                || only.0 == layout.pdo.communication_index()
                || layout.fields.iter().flatten().any(|field| field.mapped.object().index == only)
        };
        let all = layouts(&self.description).into_iter();
        all.filter(|layout| self.only.is_none_or(|only| concerns(layout, only))).collect()
    }

    /// What a standard says of an entry.
    fn standard(&self, at: Multiplexer) -> Option<ObjectName> {
        object_name(at, self.description.device_profile())
    }

    /// What is called so in the file, or else how the file is called.
    fn title(&self) -> &str {
        let name = self.description.device.product_name.trim();
        if name.is_empty() { &self.file } else { name }
    }
}

/// The parts of the object dictionary, by their first and last index.
const AREAS: [(u16, u16, &str); 4] = [
    (0x0000, 0x1FFF, "Communication profile"),
    (0x2000, 0x5FFF, "Manufacturer"),
    (0x6000, 0x9FFF, "Device profile"),
    (0xA000, 0xFFFF, "Network variables and others"),
];

/// `1.2` of FileVersion=1 and FileRevision=2.
fn version(file: &FileInfo) -> String {
    let parts = [file.version.as_str(), file.revision.as_str()];
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(".")
}

const fn at(object: &Object, sub: SubIndex) -> Multiplexer {
    Multiplexer { index: object.index, sub }
}

#[cfg(test)]
mod tests;
