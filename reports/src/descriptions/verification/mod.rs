//! The differences between a device and its description, in all output forms.

mod json;
mod report;

use crate::page_text::none_or_counted;
use canvass_analyzer::dictionary::survey::compare::{Mismatch, Weight};
use canvass_analyzer::{Index, NodeId};

/// The result of comparing a device with its description.
#[derive(Clone, Debug)]
pub struct Verification {
    /// The name of the description, as the user gave it.
    pub file: String,
    /// The address of the bus, as the user gave it.
    pub bus: String,
    /// The node-ID of the device.
    pub node: NodeId,
    /// Whether the device is still as delivered. Then a value other than the default is a difference.
    pub as_delivered: bool,
    /// Number of entries that were read.
    pub read: usize,
    /// Number of read entries that the device has.
    pub existing: usize,
    /// The first index that was not read any more, because the device does not answer for missing objects.
    pub given_up: Option<Index>,
    /// The mismatches, by index.
    pub mismatches: Vec<Mismatch>,
}

impl Verification {
    /// The mismatches that show an error of the description or the device.
    pub fn differences(&self) -> impl Iterator<Item = &Mismatch> {
        self.mismatches.iter().filter(|mismatch| self.counts(mismatch))
    }

    /// The mismatches that configuration or state of the device may explain.
    pub(crate) fn explicable(&self) -> impl Iterator<Item = &Mismatch> {
        self.mismatches.iter().filter(|mismatch| !self.counts(mismatch))
    }

    fn counts(&self, mismatch: &Mismatch) -> bool {
        match mismatch.weight {
            Weight::Differs => true,
            Weight::MayBeConfiguration => self.as_delivered,
            Weight::MayBeState => false,
        }
    }

    /// The numbers in words: `214 entries read, 2 differences, 1 value that may be configuration or state`.
    fn summary(&self) -> String {
        let (differences, possible) = (self.differences().count(), self.explicable().count());
        let entries = if self.read == 1 { "1 entry".to_owned() } else { format!("{} entries", self.read) };
        let differences = none_or_counted(differences, "difference");
        let possible = match possible {
            0 => String::new(),
            1 => ", 1 value that may be configuration or state".to_owned(),
            count => format!(", {count} values that may be configuration or state"),
        };
        format!("{entries} read, {differences}{possible}")
    }

    /// The remark that a part of the dictionary was not read. Empty if all was read.
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

/// The object of a mismatch: `6004h:00 Position value`.
fn subject(mismatch: &Mismatch) -> String {
    format!("{} {}", mismatch.subject, mismatch.name).trim_end().to_owned()
}

/// The remark on a mismatch that need not be an error.
const fn remark(weight: Weight) -> &'static str {
    match weight {
        Weight::Differs => "",
        Weight::MayBeConfiguration => "may be configuration",
        Weight::MayBeState => "may be state",
    }
}

#[cfg(test)]
mod tests;
