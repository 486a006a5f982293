//! The values of the object dictionary at run time, with their descriptions.

use crate::models::Model;
use canvass_analyzer::dictionary::{DataType, Entry, Setting, Value};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{Multiplexer, NodeId};
use std::ops::Deref;
use std::sync::Arc;

/// All entries of the object dictionary, by rising address.
#[derive(Clone, Debug)]
pub struct Parameters {
    /// The addresses alone: a search touches few cache lines.
    keys: Arc<[u32]>,
    /// For each section of sixteen indexes, the position of its first key: a search is short.
    sections: Arc<[u16]>,
    /// The constant parts of the entries. Devices in different states share them.
    entries: Arc<Vec<Parameter>>,
    /// The value of each entry.
    contents: Vec<Content>,
}

/// One entry with its current value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held<'a> {
    parameter: &'a Parameter,
    pub content: &'a Content,
}

impl Deref for Held<'_> {
    type Target = Parameter;

    fn deref(&self) -> &Parameter {
        self.parameter
    }
}

impl<'a> Held<'a> {
    /// Whether the value differs from the delivered value. A COB-ID that follows the node-ID always counts as changed.
    pub fn is_changed(&self) -> bool {
        match &self.default {
            Default::Fixed(content) => self.fitted(content.clone()) != *self.content,
            Default::NodeIdPlus(_) => false,
        }
    }

    /// The bytes of the value; `live` takes the place of a stored number.
    pub fn reading(&self, live: Option<u64>) -> Reading<'a> {
        match (self.content, live) {
            (Content::Bytes(bytes), _) => Reading::Bytes(bytes),
            (Content::Number(number), live) => {
                Reading::Number(live.unwrap_or(*number).to_le_bytes(), self.size().unwrap_or(8).min(8))
            }
        }
    }
}

/// The description of an entry.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    /// The address of the entry.
    pub at: Multiplexer,
    pub data_type: DataType,
    pub readable: bool,
    pub writable: bool,
    /// Whether the entry can be mapped into TPDOs.
    pub tpdo_mappable: bool,
    /// Whether the entry can be mapped into RPDOs.
    pub rpdo_mappable: bool,
    low: Option<i128>,
    high: Option<i128>,
    default: Default,
}

/// A value: the bits of a number, or the bytes of anything else.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Content {
    /// A number of a type with a fixed length; bits above that length are zero.
    Number(u64),
    /// A string or domain.
    Bytes(Vec<u8>),
}

#[derive(Clone, Debug)]
enum Default {
    Fixed(Content),
    NodeIdPlus(u32),
}

/// The bytes that an SDO upload returns.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Reading<'a> {
    /// A number, little-endian, and its length in bytes.
    Number([u8; 8], usize),
    /// A string or domain.
    Bytes(&'a [u8]),
}

impl Reading<'_> {
    /// The bytes of the value.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Number(bytes, len) => bytes.get(..*len).unwrap_or(bytes),
            Self::Bytes(bytes) => bytes,
        }
    }
}

/// Maximum length of a string or domain.
const LONGEST: usize = 1 << 16;

impl Parameters {
    /// The object dictionary of a model, as delivered.
    pub(crate) fn new(model: &Model, node: NodeId) -> Self {
        let entries: Vec<Parameter> =
            model.description().dictionary.entries().filter_map(|(at, entry)| Parameter::new(at, entry)).collect();
        let contents = vec![Content::Number(0); entries.len()];
        let mut parameters = Self { keys: [].into(), sections: [].into(), entries: Arc::new(entries), contents };
        parameters.find_keys();
        for value in &model.sheet().values {
            let number = value.value.as_integer().map(|number| number as u64);
            let content = match (number, value.value.as_str()) {
                (Some(number), _) => Content::Number(number),
                (_, Some(text)) => Content::Bytes(text.as_bytes().to_vec()),
                _ => continue,
            };
            parameters.redefine(value.at, content);
        }
        parameters.restore(node);
        parameters
    }

    /// Resets all values to the delivered values.
    pub(crate) fn restore(&mut self, node: NodeId) {
        self.entries_mut().for_each(|(entry, content)| *content = entry.default_content(node));
    }

    /// Resets the parameters of the profile area (6000h to 9FFFh) to the delivered values.
    pub(crate) fn restore_profile(&mut self, node: NodeId) {
        for (entry, content) in self.entries_mut().filter(|(entry, _)| matches!(entry.at.index.0, 0x6000..0xA000)) {
            *content = entry.default_content(node);
        }
    }

    /// Removes an entry, or the whole object if `sub` is `None`; the firmware then does not have it.
    pub(crate) fn remove(&mut self, index: u16, sub: Option<u8>) {
        let stays = |entry: &Parameter| entry.at.index.0 != index || sub.is_some_and(|sub| entry.at.sub.0 != sub);
        let mut entries = self.entries.iter();
        self.contents.retain(|_| entries.next().is_some_and(stays));
        Arc::make_mut(&mut self.entries).retain(stays);
        self.find_keys();
    }

    fn find_keys(&mut self) {
        self.keys = self.entries.iter().map(|entry| key(entry.at)).collect();
        let begin = |section: u32| self.keys.partition_point(|key| key >> SECTION < section);
        // Positions fit into 16 bits in every real dictionary; a larger dictionary gets no sections.
        let sections = (0..=SECTIONS).map(|section| u16::try_from(begin(section)).ok());
        self.sections = sections.collect::<Option<_>>().unwrap_or_default();
    }

    /// Changes the data type of an entry.
    pub(crate) fn retype(&mut self, at: Multiplexer, data_type: DataType) {
        if let Some((entry, _)) = self.redefined(at) {
            entry.data_type = data_type;
        }
    }

    /// Makes an entry writable.
    pub(crate) fn open(&mut self, at: Multiplexer) {
        if let Some((entry, _)) = self.redefined(at) {
            entry.writable = true;
        }
    }

    /// Changes the delivered value of an entry.
    pub(crate) fn redefine(&mut self, at: Multiplexer, content: Content) {
        if let Some((entry, held)) = self.redefined(at) {
            let content = entry.fitted(content);
            entry.default = Default::Fixed(content.clone());
            *held = content;
        }
    }

    /// The entry at an address.
    ///
    /// # Errors
    /// The abort code for an absent object, or for an absent sub-index of an object that exists.
    pub(crate) fn entry(&self, at: Multiplexer) -> Result<Held<'_>, AbortCode> {
        let position = self.position(at)?;
        let entry = self.entries.get(position).zip(self.contents.get(position));
        entry.map(|(parameter, content)| Held { parameter, content }).ok_or(AbortCode::NO_OBJECT)
    }

    fn entry_mut(&mut self, at: Multiplexer) -> Option<(&Parameter, &mut Content)> {
        let position = self.position(at).ok()?;
        self.entries.get(position).zip(self.contents.get_mut(position))
    }

    /// The entry at an address, for changes of its description.
    fn redefined(&mut self, at: Multiplexer) -> Option<(&mut Parameter, &mut Content)> {
        let position = self.position(at).ok()?;
        Arc::make_mut(&mut self.entries).get_mut(position).zip(self.contents.get_mut(position))
    }

    fn position(&self, at: Multiplexer) -> Result<usize, AbortCode> {
        let (first, keys) = self.section(key(at));
        let found = keys.binary_search(&key(at)).map(|n| first + n).map_err(|n| first + n);
        found.map_err(|insertion| {
            let neighbours = [insertion.checked_sub(1), Some(insertion)];
            let mut indexes = neighbours.into_iter().flatten().filter_map(|n| self.entries.get(n));
            match indexes.any(|entry| entry.at.index == at.index) {
                true => AbortCode::NO_SUB_INDEX,
                false => AbortCode::NO_OBJECT,
            }
        })
    }

    /// The keys in the section of a key, and the position of the first key of the section.
    fn section(&self, key: u32) -> (usize, &[u32]) {
        let section = (key >> SECTION) as usize;
        let bounds = self.sections.get(section).zip(self.sections.get(section + 1));
        let slice = bounds.and_then(|(&first, &end)| {
            let first = usize::from(first);
            Some((first, self.keys.get(first..usize::from(end))?))
        });
        slice.unwrap_or((0, &self.keys))
    }

    /// The number at an address; `None` if there is none.
    pub fn number(&self, index: u16, sub: u8) -> Option<u64> {
        match self.entry(Multiplexer::new(index, sub)).ok()?.content {
            Content::Number(number) => Some(*number),
            Content::Bytes(_) => None,
        }
    }

    /// The number at an address; 0 if there is none, as 0 switches most features off.
    pub fn number_or_zero(&self, index: u16, sub: u8) -> u64 {
        self.number(index, sub).unwrap_or(0)
    }

    /// Sets a number, regardless of its access type; surplus bits are cut off.
    pub(crate) fn set_number(&mut self, index: u16, sub: u8, number: u64) {
        if let Some((entry, content)) = self.entry_mut(Multiplexer::new(index, sub)) {
            *content = entry.fitted(Content::Number(number));
        }
    }

    /// Sets a value whose length and range were checked.
    pub(crate) fn set(&mut self, at: Multiplexer, content: Content) {
        if let Some((_, held)) = self.entry_mut(at) {
            *held = content;
        }
    }

    /// All entries.
    pub(crate) fn entries(&self) -> impl ExactSizeIterator<Item = Held<'_>> {
        self.entries.iter().zip(&self.contents).map(|(parameter, content)| Held { parameter, content })
    }

    /// All entries, with values that the caller may change.
    pub(crate) fn entries_mut(&mut self) -> impl Iterator<Item = (&Parameter, &mut Content)> {
        self.entries.iter().zip(&mut self.contents)
    }
}

/// Number of low bits in which the keys of one section may differ: sixteen indexes and the sub-index.
const SECTION: u32 = 8 + 4;
const SECTIONS: u32 = 1 << (16 - 4);

const fn key(at: Multiplexer) -> u32 {
    (at.index.0 as u32) << 8 | at.sub.0 as u32
}

impl Parameter {
    /// The constant part of an entry; `None` for a type without values.
    fn new(at: Multiplexer, entry: &Entry) -> Option<Self> {
        let default = match (&entry.default, entry.data_type.bytes()) {
            (Some(Setting::NodeIdPlus(offset)), Some(_)) => Default::NodeIdPlus(*offset),
            (Some(Setting::Fixed(value)), Some(_)) => Default::Fixed(Content::Number(value.to_raw().unwrap_or(0))),
            (_, Some(_)) => Default::Fixed(Content::Number(0)),
            (Some(Setting::Fixed(value)), None) => {
                Default::Fixed(Content::Bytes(value.encode(entry.data_type).unwrap_or_default()))
            }
            (_, None) => Default::Fixed(Content::Bytes(Vec::new())),
        };
        entry.data_type.class()?;
        let limit = |setting: &Option<Setting>| setting.as_ref().and_then(Setting::fixed).and_then(Value::as_number);
        Some(Self {
            at,
            data_type: entry.data_type,
            readable: entry.access.is_readable(),
            writable: entry.access.is_writable(),
            tpdo_mappable: entry.pdo_mappable && entry.access.allows_tpdo(),
            rpdo_mappable: entry.pdo_mappable && entry.access.allows_rpdo(),
            low: limit(&entry.low_limit),
            high: limit(&entry.high_limit),
            default,
        })
    }

    /// The delivered value.
    pub(crate) fn default_content(&self, node: NodeId) -> Content {
        match &self.default {
            Default::Fixed(content) => self.fitted(content.clone()),
            Default::NodeIdPlus(offset) => Content::Number(u64::from(offset.wrapping_add(u32::from(node.raw())))),
        }
    }

    /// The bits of the delivered number, without the node-ID; 0 for a string.
    pub(crate) const fn default_bits(&self) -> u64 {
        match &self.default {
            Default::Fixed(Content::Number(number)) => *number,
            Default::NodeIdPlus(offset) => *offset as u64,
            Default::Fixed(Content::Bytes(_)) => 0,
        }
    }

    /// Cuts a number to the length of the data type.
    fn fitted(&self, content: Content) -> Content {
        match (content, self.data_type.bits()) {
            (Content::Number(number), Some(bits)) => Content::Number(number & mask(bits)),
            (content, _) => content,
        }
    }

    /// The length of values in bytes; `None` if it is not fixed.
    pub fn size(&self) -> Option<usize> {
        self.data_type.bytes()
    }

    /// Checks the length of a value.
    ///
    /// # Errors
    /// The abort code for too few or too many bytes.
    pub fn check_length(&self, len: usize) -> Result<(), AbortCode> {
        match self.size() {
            Some(size) if len > size => Err(AbortCode::LENGTH_TOO_HIGH),
            Some(size) if len < size => Err(AbortCode::LENGTH_TOO_LOW),
            None if len > LONGEST => Err(AbortCode::OUT_OF_MEMORY),
            _ => Ok(()),
        }
    }

    /// Maximum number of bytes of a value.
    pub fn longest(&self) -> usize {
        self.size().unwrap_or(LONGEST)
    }

    /// Checks a number against the limits of the device description.
    ///
    /// # Errors
    /// The abort code for a value that is too high or too low.
    pub(crate) fn check_range(&self, raw: u64) -> Result<(), AbortCode> {
        let value = Value::from_raw(self.data_type, raw).and_then(|value| value.as_number());
        let Some(value) = value else { return Ok(()) };
        if self.high.is_some_and(|high| value > high) {
            return Err(AbortCode::VALUE_TOO_HIGH);
        }
        if self.low.is_some_and(|low| value < low) {
            return Err(AbortCode::VALUE_TOO_LOW);
        }
        Ok(())
    }

    /// Compares two values of this type; `None` for a type without order.
    pub fn compare(&self, one: u64, other: u64) -> Option<std::cmp::Ordering> {
        let number = |raw| Value::from_raw(self.data_type, raw).and_then(|value| value.as_number());
        Some(number(one)?.cmp(&number(other)?))
    }

    /// Decodes the bytes of a value, little-endian.
    pub fn decode(&self, bytes: &[u8]) -> Content {
        match self.size() {
            Some(size) => {
                let number = bytes.iter().take(size.min(8)).rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte));
                Content::Number(number)
            }
            None => Content::Bytes(bytes.to_vec()),
        }
    }
}

/// A mask of the lower `bits` bits.
pub(super) const fn mask(bits: u32) -> u64 {
    if bits >= 64 { u64::MAX } else { (1 << bits) - 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::object;

    fn parameters() -> Parameters {
        Parameters::new(Model::by_id("kuebler-sendix-58x8").unwrap(), NodeId::new(63).unwrap())
    }

    #[test]
    fn missing_objects_and_missing_sub_indexes_differ() {
        let parameters = parameters();
        let find = |index, sub| parameters.entry(Multiplexer::new(index, sub)).map(|entry| entry.at.sub.0);
        assert_eq!(find(object::TPDO_COMMUNICATION_PARAMETER, 5), Ok(5));
        assert_eq!(find(object::TPDO_COMMUNICATION_PARAMETER, 4), Err(AbortCode::NO_SUB_INDEX));
        assert_eq!(find(object::DEVICE_TYPE, 1), Err(AbortCode::NO_SUB_INDEX));
        for index in [0x0000, 0x1004, 0x5000, 0xFFFF] {
            assert_eq!(find(index, 0), Err(AbortCode::NO_OBJECT), "{index:04X}");
        }
    }

    #[test]
    fn defaults_follow_the_node_id() {
        assert_eq!(parameters().number(object::TPDO_COMMUNICATION_PARAMETER, 1), Some(0x1BF));
        assert_eq!(parameters().number(object::IDENTITY, 1), Some(0x13));
        let name = parameters()
            .entry(Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0))
            .map(|entry| entry.content.clone());
        assert_eq!(name, Ok(Content::Bytes(b"Kuebler Sendix Encoder".to_vec())));
    }

    #[test]
    fn lengths_and_limits() {
        let parameters = parameters();
        let entry = |index| parameters.entry(Multiplexer::new(index, 0)).unwrap();
        assert_eq!(entry(object::PRODUCER_HEARTBEAT_TIME).check_length(1), Err(AbortCode::LENGTH_TOO_LOW));
        assert_eq!(entry(object::PRODUCER_HEARTBEAT_TIME).check_length(4), Err(AbortCode::LENGTH_TOO_HIGH));
        assert_eq!(entry(0x2100).check_range(9), Err(AbortCode::VALUE_TOO_HIGH));
        assert_eq!(entry(0x2101).check_range(0), Err(AbortCode::VALUE_TOO_LOW));
        assert_eq!(entry(0x2101).check_range(127), Ok(()));
    }
}
