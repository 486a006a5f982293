//! `DeviceInfo`, from the objects with identity and capabilities of the device.

use super::Facts;
use crate::dictionary::description::DeviceInfo;
use crate::dictionary::object::ObjectDictionary;
use crate::identity::Multiplexer;
use crate::object;
use crate::wire::pdo::MappingEntry;

pub(super) fn describe(facts: &Facts<'_>, dictionary: &ObjectDictionary, bit_rate: Option<u16>) -> DeviceInfo {
    let identity = |sub| {
        let number = facts.survey.number(Multiplexer::new(object::IDENTITY, sub));
        number.and_then(|number| u32::try_from(number).ok())
    };
    let count = |first: u16| {
        let pdos = dictionary.objects().iter().filter(|object| (first..first + 0x200).contains(&object.index.0));
        u16::try_from(pdos.count()).unwrap_or(u16::MAX)
    };
    DeviceInfo {
        vendor_number: identity(1),
        product_name: name(facts),
        product_number: identity(2),
        revision_number: identity(3),
        bit_rates: bit_rate.into_iter().collect(),
        simple_boot_up_slave: true,
        granularity: granularity(facts),
        rpdos: count(object::RPDO_COMMUNICATION_PARAMETER),
        tpdos: count(object::TPDO_COMMUNICATION_PARAMETER),
        ..DeviceInfo::default()
    }
}

/// The manufacturer's device name, reduced to characters that a file can hold.
fn name(facts: &Facts<'_>) -> String {
    let name = facts.survey.value(Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0)).unwrap_or_default();
    let name: String = name.iter().filter(|byte| matches!(byte, b' '..=b'~')).map(|&byte| char::from(byte)).collect();
    name.trim().to_owned()
}

/// The granularity of the current mappings: bytes, or single bits.
fn granularity(facts: &Facts<'_>) -> u8 {
    let mapping = facts.survey.answers().map(|(at, _)| at);
    let mut mapping = mapping.filter(|at| crate::object::is_pdo_mapping(at.index.0) && at.sub.0 > 0);
    let in_bytes = mapping.all(|at| {
        let entry = facts.survey.number(at).and_then(|raw| u32::try_from(raw).ok());
        entry.is_none_or(|entry| MappingEntry(entry).bits().is_multiple_of(8))
    });
    if in_bytes { 8 } else { 1 }
}
