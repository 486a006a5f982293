//! Differences between two descriptions of a device in any formats: what a release changed, and which changes break
//! users of the old one.
//!
//! Each part of a description has one file. A kind of change is declared next to the code that finds it; reports
//! print its documentation.

mod device;
mod entries;
mod fact;
mod kind;
mod modules;
mod objects;
mod pdos;
mod values;

#[cfg(test)]
mod tests;

pub use fact::{Fact, Subject};
pub use kind::{ChangeKind, Class};
pub(super) use pdos::mapping;

use super::description::DeviceDescription;
use crate::identity::{Multiplexer, SubIndex};
use std::collections::BTreeSet;

/// A difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The kind of change.
    pub kind: &'static ChangeKind,
    /// The part of the description that has changed.
    pub subject: Subject,
    /// The name of the object or entry, in the new description if it has one. The text comes from a file and may
    /// contain any characters.
    pub name: String,
    /// The value in the old description, if it has one.
    pub before: Option<Fact>,
    /// The value in the new description, if it has one.
    pub after: Option<Fact>,
}

/// All kinds of change, by family.
pub fn kinds() -> impl Iterator<Item = &'static ChangeKind> {
    [device::KINDS, modules::KINDS, objects::KINDS, entries::KINDS, values::KINDS, pdos::KINDS]
        .into_iter()
        .flatten()
        .copied()
}

/// All differences: of the device, its modules and PDOs, then of the objects by index.
pub fn compare(old: &DeviceDescription, new: &DeviceDescription) -> Vec<Difference> {
    let mut comparison = Comparison { old, new, told: BTreeSet::new(), found: Vec::new() };
    device::compare(&mut comparison);
    modules::compare(&mut comparison);
    pdos::compare(&mut comparison);
    objects::compare(&mut comparison);
    device::compare_version(&mut comparison);
    comparison.found
}

/// The two descriptions, and the differences found.
struct Comparison<'a> {
    old: &'a DeviceDescription,
    new: &'a DeviceDescription,
    /// Entries whose start value is already reported with their PDO: no second difference reports it.
    told: BTreeSet<Multiplexer>,
    found: Vec<Difference>,
}

impl Comparison<'_> {
    fn report(&mut self, kind: &'static ChangeKind, subject: Subject, before: Option<Fact>, after: Option<Fact>) {
        let name = match subject {
            Subject::Object(index) => self.name_of(Multiplexer { index, sub: SubIndex(0) }, true),
            Subject::Entry(at) => self.name_of(at, false),
            Subject::Field(_) | Subject::Pdo(_) | Subject::Module(_) => String::new(),
        };
        self.found.push(Difference { kind, subject, name, before, after });
    }

    /// Reports a difference if the two values are not the same.
    fn changed(&mut self, kind: &'static ChangeKind, subject: Subject, before: Option<Fact>, after: Option<Fact>) {
        if before != after {
            self.report(kind, subject, before, after);
        }
    }

    fn name_of(&self, at: Multiplexer, whole_object: bool) -> String {
        let of = |description: &DeviceDescription| {
            let object = description.dictionary.object(at.index)?;
            let name = if whole_object { &object.name } else { &object.entry(at.sub)?.name };
            Some(name.clone())
        };
        of(self.new).or_else(|| of(self.old)).unwrap_or_default()
    }
}
