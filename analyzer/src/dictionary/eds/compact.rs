//! The short forms of CiA 306: `CompactSubObj` for arrays, `CompactPDO` for PDO parameters.

use super::fields::{Fields, setting};
use crate::dictionary::data_type::DataType;
use crate::dictionary::description::DeviceInfo;
use crate::dictionary::object::{Access, Entry, Object, ObjectCode, ObjectDictionary, Setting};
use crate::dictionary::place::Place;
use crate::dictionary::problem::Problems;
use crate::dictionary::rules;
use crate::dictionary::source::{FieldName, Source};
use crate::dictionary::value::Value;
use crate::identity::{Index, SubIndex};
use crate::object;

/// Adds sub-index 0 and `count` entries like the template; `[xxxxName]`, `[xxxxValue]` and `[xxxxDenotation]` give the
/// differing names and values.
pub(super) fn expand(object: &mut Object, template: &Entry, count: u8, source: &Source<'_>, problems: &mut Problems) {
    let mut number_of_entries = Entry::new(0, "NrOfObjects", DataType::UNSIGNED8, Access::Ro);
    number_of_entries.default = Some(Setting::Fixed(Value::Unsigned(count.into())));
    object.insert(number_of_entries);
    for sub in 1..=count {
        let name = format!("{}{sub}", template.name);
        object.insert(Entry { sub: SubIndex(sub), name, ..template.clone() });
    }
    let is_dcf = source.is_dcf();
    for (sub, text, _) in beside(object.index, "Name", count, source, problems) {
        if let Some(entry) = object.entry_mut(SubIndex(sub)) {
            entry.name = text.to_owned();
        }
    }
    for (sub, text, place) in beside(object.index, "Value", count, source, problems) {
        let value = setting(text, template.data_type, place, problems);
        if let Some(entry) = object.entry_mut(SubIndex(sub)) {
            *(if is_dcf { &mut entry.configured } else { &mut entry.default }) = value;
        }
    }
    for (sub, text, _) in beside(object.index, "Denotation", count, source, problems) {
        if let Some(entry) = object.entry_mut(SubIndex(sub)) {
            entry.denotation = Some(text.to_owned());
        }
    }
}

/// The fields `1=…`, `2=…` of a section such as `[1003Name]`: each with its sub-index, value and place.
fn beside<'d>(
    index: Index,
    kind: &str,
    count: u8,
    source: &'d Source<'_>,
    problems: &mut Problems,
) -> Vec<(u8, &'d str, Place<'d>)> {
    let Some(section) = source.section(&format!("{:04X}{kind}", index.0)) else { return Vec::new() };
    let mut found = Vec::new();
    for field in section.fields() {
        if field.name().eq_ignore_ascii_case(FieldName::NrOfEntries.text()) {
            continue;
        }
        match field.name().parse().ok().filter(|sub| (1..=count).contains(sub)) {
            Some(sub) => found.push((sub, field.value(), field.place())),
            None => {
                let expected = "a sub-index from 1 to CompactSubObj";
                problems.report(field.place_of_name(), &rules::list::BESIDE_KEY, expected, field.name());
            }
        }
    }
    let mut fields = Fields { section, problems };
    let announced = fields.number(FieldName::NrOfEntries, u32::MAX);
    if announced.is_some_and(|announced| announced as usize != found.len()) {
        let entries = format!("{} entries", found.len());
        fields.report(FieldName::NrOfEntries, &rules::list::BESIDE, "the number of entries", &entries);
    }
    found
}

/// Adds the PDO parameters that a file with `CompactPDO` leaves out: bit n-1 of the mask is sub-index n of the
/// communication parameters.
pub(super) fn add_pdos(device: &DeviceInfo, dictionary: &mut ObjectDictionary) {
    if device.compact_pdo == 0 {
        return;
    }
    let directions = [
        (device.rpdos, object::RPDO_COMMUNICATION_PARAMETER, object::RPDO_MAPPING_PARAMETER, "RPDO", 0x200),
        (device.tpdos, object::TPDO_COMMUNICATION_PARAMETER, object::TPDO_MAPPING_PARAMETER, "TPDO", 0x180),
    ];
    for (pdos, communication, mapping, name, cob_id) in directions {
        for number in 0..pdos.min(512) {
            if dictionary.object(Index(communication + number)).is_none() {
                dictionary.insert(communication_parameter(
                    communication + number,
                    name,
                    device.compact_pdo,
                    number,
                    cob_id,
                ));
            }
            if dictionary.object(Index(mapping + number)).is_none() {
                dictionary.insert(mapping_parameter(mapping + number, name));
            }
        }
    }
}

fn communication_parameter(index: u16, pdo: &str, mask: u8, number: u16, cob_id: u32) -> Object {
    const ENTRIES: [(u8, &str, DataType); 6] = [
        (1, "COB-ID", DataType::UNSIGNED32),
        (2, "Transmission type", DataType::UNSIGNED8),
        (3, "Inhibit time", DataType::UNSIGNED16),
        (4, "Compatibility entry", DataType::UNSIGNED8),
        (5, "Event timer", DataType::UNSIGNED16),
        (6, "SYNC start value", DataType::UNSIGNED8),
    ];
    let mut object = Object::new(index, format!("{pdo} communication parameter"), ObjectCode::RECORD);
    let mut highest = 0;
    for (sub, name, data_type) in ENTRIES {
        if mask >> (sub - 1) & 1 == 0 {
            continue;
        }
        highest = sub;
        let mut entry = Entry::new(sub, name, data_type, Access::Rw);
        // Only the first four PDOs have a COB-ID in the predefined connection set.
        entry.default = match sub {
            1 if number < 4 => Some(Setting::NodeIdPlus(cob_id + 0x100 * u32::from(number))),
            1 => Some(Setting::Fixed(Value::Unsigned(0x8000_0000))),
            _ => None,
        };
        object.insert(entry);
    }
    object.insert(highest_sub_index(highest, Access::Ro));
    object
}

fn mapping_parameter(index: u16, pdo: &str) -> Object {
    let mut object = Object::new(index, format!("{pdo} mapping parameter"), ObjectCode::RECORD);
    object.insert(highest_sub_index(0, Access::Rw));
    for sub in 1..=64 {
        object.insert(Entry::new(sub, format!("Application object {sub}"), DataType::UNSIGNED32, Access::Rw));
    }
    object
}

fn highest_sub_index(highest: u8, access: Access) -> Entry {
    let mut entry = Entry::new(0, "Highest sub-index supported", DataType::UNSIGNED8, access);
    entry.default = Some(Setting::Fixed(Value::Unsigned(highest.into())));
    entry
}
