//! Makes a description from a device's answers, as a start if none exists.
//!
//! Standard objects get the standard's names, types and access. The names, types and access of other objects are
//! guessed from the values read, and marked as guesses. Limits remain unknown.

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

/// A description made from a device's answers, with its guesses.
#[derive(Clone, Debug)]
pub struct Scanned {
    /// The description.
    pub description: DeviceDescription,
    /// The guesses for each entry.
    pub guesses: BTreeMap<Multiplexer, Vec<Guess>>,
}

/// An unknown property of an entry that was guessed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guess {
    /// The data type, from a value with this number of bytes.
    TypeOf(usize),
    /// The data type, for an entry without a value.
    Type,
    /// The data type: the value has a number of bytes that the standard's type does not have.
    TypeBeside(usize),
    /// The access type: only writing would show whether the entry can be written.
    Access,
}

/// The input for a description: all data read from a device.
pub struct Scan<'a> {
    /// The device's answers.
    pub survey: &'a Survey,
    /// The node-ID of the device.
    pub node: NodeId,
    /// The bit rate in kbit/s, if known.
    pub bit_rate: Option<u16>,
    /// The data about the file.
    pub file: FileInfo,
}

impl Scan<'_> {
    /// Makes the description.
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

/// The first index of an object; indexes below are data types.
const FIRST: u16 = 0x1000;

/// The answers of the device, and the facts derived from them.
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

    /// The standard's object, if the device's object has the same structure: with or without sub-indexes.
    fn standard(&self, at: Multiplexer) -> Option<ObjectName> {
        object_name(at, self.profile).filter(|name| name.object.code.is_single() != self.has_subs(at.index))
    }

    /// Whether the object has sub-indexes, even if there are none at the moment.
    fn has_subs(&self, index: Index) -> bool {
        let exists = |(sub, answer): (SubIndex, &Answer)| sub.0 > 0 && answer.exists() == Some(true);
        let at = Multiplexer { index, sub: SubIndex(0) };
        let counts = || object_name(at, self.profile).is_some_and(|name| !name.object.code.is_single());
        self.survey.of(index).any(exists) || counts() && self.survey.count(index).is_some()
    }
}
