//! In what a device differs from its description, in every form in which it is wanted.

mod json;
mod markdown;
mod text;

use crate::escape::printable;
use canvass_analyzer::dictionary::survey::compare::{Mismatch, Side, Weight};
use canvass_analyzer::{Index, NodeId};

/// A device that was compared with its description.
#[derive(Clone, Debug)]
pub struct Verification {
    /// The description, as the user named it.
    pub file: String,
    /// The bus, as the user named it.
    pub bus: String,
    /// The device.
    pub node: NodeId,
    /// Whether nobody has configured the device: values other than the defaults are differences then.
    pub as_delivered: bool,
    /// How many entries were read.
    pub read: usize,
    /// How many of them the device has.
    pub existing: usize,
    /// From where on no more indexes were looked at, as the device does not answer for those that it does not have.
    pub given_up: Option<Index>,
    /// What was found, by index.
    pub mismatches: Vec<Mismatch>,
}

impl Verification {
    /// For people: a table, no wider than the terminal.
    pub fn text(&self, style: Style) -> String {
        text::render(self, style)
    }

    /// One JSON object (`docs/json.md`).
    pub fn json(&self) -> serde_json::Value {
        json::document(self)
    }

    /// For tickets and wikis.
    pub fn markdown(&self) -> String {
        markdown::document(self)
    }

    /// What shows that description or device is wrong.
    pub fn differences(&self) -> impl Iterator<Item = &Mismatch> {
        self.mismatches.iter().filter(|mismatch| self.counts(mismatch))
    }

    /// What configuration or state of the device may explain.
    pub fn explicable(&self) -> impl Iterator<Item = &Mismatch> {
        self.mismatches.iter().filter(|mismatch| !self.counts(mismatch))
    }

    fn counts(&self, mismatch: &Mismatch) -> bool {
        match mismatch.weight {
            Weight::Differs => true,
            Weight::MayBeConfiguration => self.as_delivered,
            Weight::MayBeState => false,
        }
    }

    /// `214 entries read, 2 differences, 1 value that may be configuration or state`.
    fn summary(&self) -> String {
        let counted = |count: usize, one: &str, more: &str| match count {
            0 => format!("no {more}"),
            1 => format!("1 {one}"),
            _ => format!("{count} {more}"),
        };
        let entries = counted(self.read, "entry", "entries");
        let differences = counted(self.differences().count(), "difference", "differences");
        let possible = match self.explicable().count() {
            0 => String::new(),
            1 => ", 1 value that may be configuration or state".to_owned(),
            count => format!(", {count} values that may be configuration or state"),
        };
        format!("{entries} read, {differences}{possible}")
    }

    /// What is to be known of the area that was looked at; empty if it was all.
    fn incomplete(&self) -> String {
        match self.given_up {
            None => String::new(),
            Some(index) => format!(
                "the device does not answer where it has no object, instead of abort 0602 0000h: from {index} on nothing \
                 was looked at that is not described"
            ),
        }
    }
}

/// How the table is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// With colours.
    pub colors: bool,
    /// The columns that there are.
    pub width: u16,
}

/// `6004h:00 Position value`, on one line and safe to show.
fn subject(mismatch: &Mismatch) -> String {
    let name = printable(&mismatch.name);
    let space = if name.is_empty() { "" } else { " " };
    format!("{}{space}{name}", mismatch.subject)
}

/// What one of the two says, on one line and safe to show.
fn side(side: &Side) -> String {
    printable(&side.to_string()).into_owned()
}

/// What is added to a difference that may be none.
const fn remark(weight: Weight) -> &'static str {
    match weight {
        Weight::Differs => "",
        Weight::MayBeConfiguration => "may be configuration",
        Weight::MayBeState => "may be state",
    }
}

#[cfg(test)]
mod tests;
