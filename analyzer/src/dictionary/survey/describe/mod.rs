//! A description made from what a device answers: a start where none exists.
//!
//! Names, types and access of objects that a standard defines are the standard's; of others they are guessed from what was
//! read, and marked. Nothing can be said about limits.

mod access;
mod device;
mod object;
mod text;
mod types;
mod values;

#[cfg(test)]
mod tests;

use super::{Answer, Survey};
use crate::dictionary::description::{DeviceDescription, FileInfo, ObjectLists};
use crate::dictionary::names::{ObjectName, object_name};
use crate::dictionary::object::ObjectDictionary;
use crate::identity::{Index, Multiplexer, NodeId, SubIndex};
use crate::wire::pdo::MappingEntry;
use std::collections::{BTreeMap, BTreeSet};

/// A description, and what of it is guessed.
#[derive(Clone, Debug)]
pub struct Scanned {
    /// The description.
    pub description: DeviceDescription,
    /// What is guessed of which entry.
    pub guesses: BTreeMap<Multiplexer, Vec<Guess>>,
}

/// What is not known of an entry, and was guessed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guess {
    /// The data type, from a value of so many bytes.
    TypeOf(usize),
    /// The data type, of an entry that gave no value.
    Type,
    /// The data type: that of the standard has another length than the value, which has so many bytes.
    TypeBeside(usize),
    /// The access type: only writing would tell whether the entry can be written.
    Access,
}

/// What is read without knowing whose device it is.
pub struct Scan<'a> {
    /// What the device answered.
    pub survey: &'a Survey,
    /// Its node-ID then.
    pub node: NodeId,
    /// The bit rate in kbit/s at which it was read, if it is known.
    pub bit_rate: Option<u16>,
    /// What the file says about itself.
    pub file: FileInfo,
}

impl Scan<'_> {
    /// The description.
    pub fn describe(self) -> Scanned {
        let facts = Facts::of(&self);
        let mut guesses = BTreeMap::new();
        let indexes: BTreeSet<Index> = self.existing().map(|at| at.index).collect();
        let objects = indexes.into_iter().map(|index| object::describe(&facts, index, &mut guesses));
        let dictionary: ObjectDictionary = objects.collect();
        let device = device::describe(&facts, &dictionary, self.bit_rate);
        let dummy_usage = (1..=7).map(|index| (index, facts.in_rpdos.contains(&Multiplexer::new(index, 0)))).collect();
        let description = DeviceDescription {
            file: self.file,
            device,
            dummy_usage,
            comments: text::comments(&guesses),
            dictionary,
            lists: ObjectLists::default(),
            ..DeviceDescription::default()
        };
        Scanned { description, guesses }
    }

    fn existing(&self) -> impl Iterator<Item = Multiplexer> {
        let existing = self.survey.answers().filter(|(_, answer)| answer.exists() == Some(true));
        existing.map(|(at, _)| at).filter(|at| at.index.0 >= FIRST)
    }
}

/// Below are the data types.
const FIRST: u16 = 0x1000;

/// What the device tells as a whole.
struct Facts<'a> {
    survey: &'a Survey,
    node: NodeId,
    profile: Option<u16>,
    in_rpdos: BTreeSet<Multiplexer>,
    in_tpdos: BTreeSet<Multiplexer>,
}

impl<'a> Facts<'a> {
    fn of(scan: &Scan<'a>) -> Self {
        let survey = scan.survey;
        let mapped = |first: u16| {
            let parameters = first..first + 0x200;
            let entries = parameters.flat_map(|index| {
                let count = survey.count(Index(index)).filter(|&count| count <= 64).unwrap_or(0);
                (1..=count).filter_map(move |sub| survey.number(Multiplexer::new(index, sub)))
            });
            let entries = entries.filter_map(|entry| u32::try_from(entry).ok()).map(MappingEntry);
            entries.map(MappingEntry::object).collect()
        };
        let profile = survey.device_profile();
        Self { survey, node: scan.node, profile, in_rpdos: mapped(0x1600), in_tpdos: mapped(0x1A00) }
    }

    /// What a standard says of an entry, where the device has the object as the standard does: with sub-indexes or without.
    fn standard(&self, at: Multiplexer) -> Option<ObjectName> {
        object_name(at, self.profile).filter(|name| name.object.code.is_single() != self.has_subs(at.index))
    }

    /// Whether the object has sub-indexes, even if it has none at the moment.
    fn has_subs(&self, index: Index) -> bool {
        let exists = |(sub, answer): (SubIndex, &Answer)| sub.0 > 0 && answer.exists() == Some(true);
        let at = Multiplexer { index, sub: SubIndex(0) };
        let counts = || object_name(at, self.profile).is_some_and(|name| !name.object.code.is_single());
        self.survey.of(index).any(exists) || counts() && self.survey.count(index).is_some()
    }
}
