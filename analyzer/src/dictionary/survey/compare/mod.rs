//! Compares a description with the values read from a device.

mod identity;
mod kind;
mod objects;
mod pdos;
mod undescribed;
mod values;

#[cfg(test)]
mod tests;

pub use kind::{MismatchKind, Weight};

use super::{Answer, Survey};
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::difference::{Fact, Subject};
use crate::dictionary::names::object_name;
use crate::dictionary::value::Value;
use crate::identity::{Multiplexer, NodeId, SubIndex};
use std::collections::BTreeSet;
use std::fmt;

/// A difference between a description and a device.
#[derive(Clone, Debug, PartialEq)]
pub struct Mismatch {
    /// The kind of the difference.
    pub kind: MismatchKind,
    /// Whether the description or the device is wrong for certain.
    pub weight: Weight,
    /// The object, entry or PDO that differs.
    pub subject: Subject,
    /// The name of the object or entry, from the description or else from the standard; may contain any characters.
    pub name: String,
    /// The value or state in the description.
    pub described: Side,
    /// The value or state in the device.
    pub found: Side,
}

/// One side of a difference.
#[derive(Clone, Debug, PartialEq)]
pub enum Side {
    /// The object does not exist.
    Nothing,
    /// The object exists.
    Exists,
    /// No PDO can carry the entry.
    NotMappable,
    /// A value that a description can have.
    Fact(Fact),
    /// Limits.
    Limits(Option<Value>, Option<Value>),
    /// The length of a value, in bytes.
    Length(usize),
    /// An answer of the device.
    Answer(Answer),
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => f.write_str("nothing"),
            Self::Exists => f.write_str("described"),
            Self::NotMappable => f.write_str("not mappable"),
            Self::Fact(fact) => write!(f, "{fact}"),
            Self::Limits(Some(low), Some(high)) => write!(f, "{low} to {high}"),
            Self::Limits(Some(low), None) => write!(f, "at least {low}"),
            Self::Limits(None, Some(high)) => write!(f, "at most {high}"),
            Self::Limits(None, None) => f.write_str("any value"),
            Self::Length(1) => f.write_str("1 byte"),
            Self::Length(bytes) => write!(f, "{bytes} bytes"),
            Self::Answer(answer) => write!(f, "{answer}"),
        }
    }
}

/// All differences between the device at `node`, as far as it was read, and its description; sorted by index.
pub fn compare(description: &DeviceDescription, survey: &Survey, node: NodeId) -> Vec<Mismatch> {
    let mut comparison = Comparison { description, survey, node, told: BTreeSet::new(), found: Vec::new() };
    identity::compare(&mut comparison);
    pdos::compare(&mut comparison);
    objects::compare(&mut comparison);
    undescribed::compare(&mut comparison);
    comparison.found.sort_by_key(|mismatch| place(mismatch.subject));
    comparison.found
}

/// The addresses that identify a device best; they are read even if they are not described.
pub const IDENTITY: [Multiplexer; 5] = [
    Multiplexer::new(0x1000, 0),
    Multiplexer::new(0x1018, 0),
    Multiplexer::new(0x1018, 1),
    Multiplexer::new(0x1018, 2),
    Multiplexer::new(0x1018, 3),
];

/// The sort key of a difference.
fn place(subject: Subject) -> (u16, u16) {
    match subject {
        Subject::Field(_) | Subject::Module(_) => (0, 0),
        Subject::Object(index) => (index.0, 0),
        Subject::Entry(at) => (at.index.0, u16::from(at.sub.0) + 1),
        Subject::Pdo(pdo) => (pdo.mapping_index(), 0),
    }
}

/// The description, the answers of the device, and the differences found.
struct Comparison<'a> {
    description: &'a DeviceDescription,
    survey: &'a Survey,
    node: NodeId,
    /// Entries whose value is already reported with their PDO: no second difference reports it.
    told: BTreeSet<Multiplexer>,
    found: Vec<Mismatch>,
}

impl Comparison<'_> {
    fn report(&mut self, kind: MismatchKind, weight: Weight, subject: Subject, described: Side, found: Side) {
        let name = match subject {
            Subject::Object(index) => self.name_of(Multiplexer { index, sub: SubIndex(0) }, true),
            Subject::Entry(at) => self.name_of(at, false),
            Subject::Field(_) | Subject::Pdo(_) | Subject::Module(_) => String::new(),
        };
        self.found.push(Mismatch { kind, weight, subject, name, described, found });
    }

    fn name_of(&self, at: Multiplexer, whole_object: bool) -> String {
        let described = self.description.dictionary.object(at.index).and_then(|object| {
            if whole_object { Some(&object.name) } else { object.entry(at.sub).map(|entry| &entry.name) }
        });
        let standard = || {
            let name = object_name(at, self.survey.device_profile())?;
            Some(if whole_object { name.object.name.to_owned() } else { name.entry?.name.to_owned() })
        };
        described.cloned().or_else(standard).unwrap_or_default()
    }
}
