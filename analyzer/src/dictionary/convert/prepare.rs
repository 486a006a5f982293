//! Prepares a description for every format.

use crate::PdoNumber;
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::loss::{Loss, LossKind, Losses};
use crate::dictionary::object::{Access, Entry, Object, Setting};
use crate::dictionary::value::Value;
use crate::identity::SubIndex;

/// Adds to the dictionary everything that the file left out. Afterwards `CompactPDO` has no effect, and the count of a
/// mapping described by `CompactSubObj` is the number of mapped objects, not of entries.
pub(super) fn expand(description: &mut DeviceDescription) -> Vec<Loss> {
    let mut losses = Losses::default();
    description.device.compact_pdo = 0;
    let objects: Vec<Object> = description.dictionary.objects().iter().filter(|it| is_compact(it)).cloned().collect();
    for mut object in objects {
        let mapped = |value: fn(&Entry) -> &Option<Setting>| {
            let is_mapped =
                |entry: &&Entry| value(entry).as_ref().and_then(Setting::fixed).and_then(Value::to_raw) > Some(0);
            object.entries().iter().skip(1).take_while(is_mapped).count() as u64
        };
        let (default, configured) = (mapped(|entry| &entry.default), mapped(|entry| &entry.configured));
        let is_writable = object.entries().iter().any(|entry| entry.access.is_writable());
        let Some(count) = object.entry_mut(SubIndex(0)) else { continue };
        let before = count.default.as_ref().map(ToString::to_string).unwrap_or_default();
        let kind = LossKind::Changed(format!("{default}, the number of mapped objects"));
        count.default = Some(Setting::Fixed(Value::Unsigned(default)));
        count.configured = (configured > 0).then_some(Setting::Fixed(Value::Unsigned(configured)));
        if is_writable {
            count.access = Access::Rw;
        }
        losses.add(object.line, format!("{}:00 the count of CompactSubObj", object.index), &before, kind);
        description.dictionary.insert(object);
    }
    losses.0
}

/// Whether the object is a mapping in compact form: no line of the file describes its sub-index 0.
fn is_compact(object: &Object) -> bool {
    let is_mapping = PdoNumber::of_mapping_index(object.index.0).is_some();
    is_mapping && object.line != 0 && object.entry(SubIndex(0)).is_some_and(|count| count.line == 0)
}

/// Removes node-ID, configured values and other data of one device. An EDS or XDD describes a device type, which has
/// none of them.
pub(super) fn without_configuration(description: &mut DeviceDescription) -> Vec<Loss> {
    let mut losses = Losses::default();
    if description.commissioning.take().is_some() {
        losses.no_place(0, "[DeviceComissioning]", "node-ID, bit rate and names");
    }
    if !description.connected_modules.is_empty() {
        losses.no_place(0, "[ConnectedModules]", &format!("{} modules", description.connected_modules.len()));
        description.connected_modules.clear();
    }
    if let Some(last) = description.file.last_eds.take() {
        losses.no_place(0, "[FileInfo] LastEDS", &last);
    }
    let objects: Vec<Object> = description.dictionary.objects().to_vec();
    for mut object in objects {
        let entries: Vec<Entry> = object.entries().to_vec();
        for mut entry in entries {
            let place = |field: &str| format!("{}:{:02X} {field}", object.index, entry.sub.0);
            if let Some(value) = &entry.configured {
                losses.no_place(entry.line, place("ParameterValue"), &value.to_string());
            }
            if let Some(denotation) = &entry.denotation {
                losses.no_place(entry.line, place("Denotation"), denotation);
            }
            (entry.configured, entry.denotation) = (None, None);
            object.insert(entry);
        }
        description.dictionary.insert(object);
    }
    losses.0
}
