//! In what a device differs from its description, in every form in which it is wanted.

mod json;
mod report;

use crate::page_text::none_or_counted;
use canvass_analyzer::dictionary::survey::compare::{Mismatch, Weight};
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

/// `6004h:00 Position value`.
fn subject(mismatch: &Mismatch) -> String {
    format!("{} {}", mismatch.subject, mismatch.name).trim_end().to_owned()
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
