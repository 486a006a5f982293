//! A device description for reading: its objects as a table, one object in detail, its PDOs bit by bit.

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

/// A description to show.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The name of the file, as the user gave it.
    pub file: String,
    /// The content of the file.
    pub description: DeviceDescription,
    /// The node-ID for which formulas are computed. `None`: the formulas themselves are shown.
    pub node: Option<NodeId>,
    /// The only object to show, in detail.
    pub only: Option<Index>,
}

/// The capabilities of the terminal.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Whether colours are used.
    pub colors: bool,
    /// The width in columns.
    pub width: u16,
}

impl Shown {
    /// The text for people: a table, or one object in detail.
    pub fn text(&self, style: Style) -> String {
        text::render(self, style)
    }

    /// One JSON object (`docs/json.md`).
    pub fn json(&self) -> serde_json::Value {
        json::document(self)
    }

    /// The description as an appendix of a manual.
    pub fn markdown(&self) -> String {
        markdown::document(self)
    }

    /// A self-contained page to search and to print.
    ///
    /// # Errors
    /// The errors of `out`.
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

    /// The name of an entry in a standard.
    fn standard(&self, at: Multiplexer) -> Option<ObjectName> {
        object_name(at, self.description.device_profile())
    }

    /// The product name in the file, or otherwise the name of the file.
    fn title(&self) -> &str {
        let name = self.description.device.product_name.trim();
        if name.is_empty() { &self.file } else { name }
    }
}

/// The areas of the object dictionary by their first and last index.
const AREAS: [(u16, u16, &str); 4] = [
    (0x0000, 0x1FFF, "Communication profile"),
    (0x2000, 0x5FFF, "Manufacturer"),
    (0x6000, 0x9FFF, "Device profile"),
    (0xA000, 0xFFFF, "Network variables and others"),
];

/// The version of the file: `1.2` for FileVersion=1 and FileRevision=2.
fn version(file: &FileInfo) -> String {
    let parts = [file.version.as_str(), file.revision.as_str()];
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(".")
}

const fn at(object: &Object, sub: SubIndex) -> Multiplexer {
    Multiplexer { index: object.index, sub }
}

#[cfg(test)]
mod tests;
