//! Changes to a model: objects that it no longer has, and entries with another default.

use crate::models::{self, Sheet};
use canvass_analyzer::dictionary::{DeviceDescription, Entry, Object, ObjectDictionary, Setting, Value};
use canvass_analyzer::object;
use canvass_analyzer::{Index, Multiplexer, SubIndex};
use std::ops::RangeInclusive;

/// A model while it is changed: its description and its sheet.
pub(super) struct Edit<'a> {
    pub description: &'a mut DeviceDescription,
    pub sheet: &'a mut Sheet,
}

impl Edit<'_> {
    /// Removes objects.
    pub fn remove(&mut self, indexes: impl IntoIterator<Item = RangeInclusive<u16>>) {
        let ranges: Vec<_> = indexes.into_iter().collect();
        self.keep(|at| !ranges.iter().any(|range| range.contains(&at.index.0)));
    }

    /// Removes sub-indexes of objects.
    pub(crate) fn remove_subs(&mut self, indexes: RangeInclusive<u16>, subs: RangeInclusive<u8>) {
        self.keep(|at| !indexes.contains(&at.index.0) || !subs.contains(&at.sub.0));
    }

    fn keep(&mut self, stays: impl Fn(Multiplexer) -> bool) {
        let mut kept = ObjectDictionary::default();
        for object in self.description.dictionary.objects() {
            let mut copy = Object::new(object.index.0, object.name.clone(), object.code);
            copy.line = object.line;
            let stays = |entry: &&Entry| stays(Multiplexer { index: object.index, sub: entry.sub });
            object.entries().iter().filter(stays).cloned().for_each(|entry| drop(copy.insert(entry)));
            if !copy.entries().is_empty() {
                if copy.entries().len() < object.entries().len() {
                    lower_highest(&mut copy);
                }
                kept.insert(copy);
            }
        }
        self.description.dictionary = kept;
        let dictionary = &self.description.dictionary;
        let lists = &mut self.description.lists;
        for list in [&mut lists.mandatory, &mut lists.optional, &mut lists.manufacturer] {
            list.retain(|(index, _)| dictionary.object(*index).is_some());
        }
        let count = |first: u16| (first..first + 0x200).filter(|&index| has(dictionary, index)).count() as u16;
        (self.description.device.rpdos, self.description.device.tpdos) =
            (count(object::RPDO_COMMUNICATION_PARAMETER), count(object::TPDO_COMMUNICATION_PARAMETER));
    }

    /// Changes an entry, if the device has it.
    pub fn entry(&mut self, index: u16, sub: u8, change: impl FnOnce(&mut Entry)) {
        let object = self.description.dictionary.object_mut(Index(index));
        if let Some(entry) = object.and_then(|object| object.entry_mut(SubIndex(sub))) {
            change(entry);
        }
    }

    /// Changes every entry.
    pub fn entries(&mut self, change: impl Fn(Multiplexer, &mut Entry)) {
        let addresses: Vec<Multiplexer> = self.description.dictionary.entries().map(|(at, _)| at).collect();
        for at in addresses {
            self.entry(at.index.0, at.sub.0, |entry| change(at, entry));
        }
    }

    /// Sets the number with which an entry is delivered.
    pub fn set(&mut self, index: u16, sub: u8, number: u64) {
        self.entry(index, sub, |entry| entry.default = Value::from_raw(entry.data_type, number).map(Setting::Fixed));
        self.sheet.values.retain(|value| value.at != Multiplexer::new(index, sub));
    }

    /// Moves the defaults of an object from the description to the sheet.
    pub(crate) fn move_defaults(&mut self, index: u16) {
        let Some(object) = self.description.dictionary.object_mut(Index(index)) else { return };
        for sub in 1..=u8::MAX {
            let Some(entry) = object.entry_mut(SubIndex(sub)) else { continue };
            let number = entry.default.take().as_ref().and_then(Setting::fixed).and_then(Value::to_raw);
            let at = Multiplexer::new(index, sub);
            if let (Some(number), true) = (number, self.sheet.values.iter().all(|value| value.at != at)) {
                self.sheet.values.push(models::Value::new(at, number as i64));
            }
        }
    }

    /// Appends a byte 00h to a text of the device; the description keeps its text.
    pub(crate) fn end_in_nul(&mut self, index: u16) {
        let at = Multiplexer::new(index, 0);
        let entry = self.description.dictionary.entry(at).ok();
        let described = entry.and_then(|entry| match entry.default.as_ref()?.fixed()? {
            Value::VisibleString(bytes) => Some(String::from_utf8_lossy(bytes).into_owned()),
            _ => None,
        });
        let own = self.sheet.values.iter().find(|value| value.at == at);
        let text = own.and_then(|value| value.value.as_str().map(str::to_owned)).or(described);
        if let Some(text) = text {
            self.sheet.values.retain(|value| value.at != at);
            self.sheet.values.push(models::Value::new(at, format!("{text}\0")));
        }
    }

    /// Sets bits of a COB-ID in its delivered value.
    pub(crate) fn set_cob_id_bits(&mut self, index: u16, bits: u32) {
        self.entry(index, 1, |entry| {
            entry.default = match entry.default.take() {
                Some(Setting::NodeIdPlus(offset)) => Some(Setting::NodeIdPlus(offset | bits)),
                default => {
                    let raw = default.as_ref().and_then(Setting::fixed).and_then(Value::to_raw).unwrap_or(0);
                    Value::from_raw(entry.data_type, raw | u64::from(bits)).map(Setting::Fixed)
                }
            };
        });
    }

    /// The indexes of the communication parameters of all PDOs of one direction, from `first` on.
    pub fn pdos(&self, first: u16) -> Vec<u16> {
        (first..first + 0x200).filter(|&index| has(&self.description.dictionary, index)).collect()
    }

    /// Empties the delivered mapping of a PDO.
    pub(crate) fn unmap(&mut self, mapping: u16) {
        (0..=64).for_each(|sub| self.set(mapping, sub, 0));
    }

    /// Empties the delivered mapping of every PDO that maps an object for which `is_gone` holds.
    pub(crate) fn unmap_where(&mut self, is_gone: impl Fn(Multiplexer) -> bool) {
        let carries = |object: &Object| {
            let entries = object.entries().iter().filter(|entry| entry.sub.0 > 0);
            let mapped = entries.filter_map(|entry| entry.default.as_ref()?.fixed()?.to_raw());
            mapped.filter(|raw| *raw != 0).any(|raw| is_gone(Multiplexer::new((raw >> 16) as u16, (raw >> 8) as u8)))
        };
        let objects = self.description.dictionary.objects().iter();
        let mappings = objects.filter(|object| canvass_analyzer::object::is_pdo_mapping(object.index.0));
        let gone: Vec<u16> = mappings.filter(|object| carries(object)).map(|object| object.index.0).collect();
        gone.into_iter().for_each(|mapping| self.unmap(mapping));
    }
}

fn has(dictionary: &ObjectDictionary, index: u16) -> bool {
    dictionary.object(Index(index)).is_some()
}

/// Lowers the delivered sub-index 0 of a record or array to the highest sub-index that is left.
fn lower_highest(object: &mut Object) {
    let Some(highest) = object.entries().last().map(|entry| entry.sub.0) else { return };
    if let Some(entry) = object.entry_mut(SubIndex(0)) {
        let before = entry.default.as_ref().and_then(Setting::fixed).and_then(Value::to_raw);
        if before.is_some_and(|before| before > u64::from(highest)) {
            entry.default = Value::from_raw(entry.data_type, u64::from(highest)).map(Setting::Fixed);
        }
    }
}
