//! Compares the mappings of PDOs.

use super::{Comparison, MismatchKind, Side, Weight};
use crate::PdoNumber;
use crate::dictionary::difference::{Fact, Subject, mapping};
use crate::dictionary::object::Object;
use crate::identity::{Multiplexer, SubIndex};
use crate::wire::pdo::MappingEntry;
use std::collections::BTreeSet;

pub(super) fn compare(comparison: &mut Comparison<'_>) {
    for object in comparison.description.dictionary.objects() {
        let Some(pdo) = PdoNumber::of_mapping_index(object.index.0) else { continue };
        let Some(found) = found(comparison, object) else { continue };
        let described = mapping(comparison.description, pdo);
        let own: BTreeSet<u32> = described.iter().flatten().map(|entry| entry.0).collect();
        // An inconsistency of the description itself is no difference to the device.
        let others: BTreeSet<u32> = found.iter().map(|entry| entry.0).filter(|entry| !own.contains(entry)).collect();
        for entry in others {
            mappable(comparison, pdo, MappingEntry(entry));
        }
        let Some(described) = described else { continue };
        // Other differences, such as a missing entry, are reported for the device's entries.
        comparison.told.extend((0..=64).map(|sub| Multiplexer { index: object.index, sub: SubIndex(sub) }));
        if described != found {
            let weight = match object.entries().iter().any(|entry| entry.access.is_writable()) {
                true => Weight::MayBeConfiguration,
                false => Weight::Differs,
            };
            let is_configured = object.entries().iter().any(|entry| entry.configured.is_some());
            let weight = if is_configured { Weight::Differs } else { weight };
            let [described, found] = [described, found].map(|entries| Side::Fact(Fact::Mapping(entries)));
            comparison.report(MismatchKind::Mapping, weight, Subject::Pdo(pdo), described, found);
        }
    }
}

/// The mapping of a PDO in the device; `None` if it could not be read completely, or the PDO has no layout.
fn found(comparison: &Comparison<'_>, object: &Object) -> Option<Vec<MappingEntry>> {
    let count = comparison.survey.count(object.index).filter(|&count| count <= 64)?;
    let at = |sub| Multiplexer { index: object.index, sub: SubIndex(sub) };
    (1..=count).map(|sub| u32::try_from(comparison.survey.number(at(sub))?).ok().map(MappingEntry)).collect()
}

/// Checks that the description allows mapping of the objects that the device has mapped.
fn mappable(comparison: &mut Comparison<'_>, pdo: PdoNumber, mapped: MappingEntry) {
    // An empty entry, or a gap.
    if mapped.0 == 0 || mapped.object().index.0 < 0x20 {
        return;
    }
    let Ok(entry) = comparison.description.dictionary.entry(mapped.object()) else { return };
    let fits = match pdo {
        PdoNumber::Transmit(_) => entry.access.allows_tpdo(),
        PdoNumber::Receive(_) => entry.access.allows_rpdo(),
    };
    let bits = entry.data_type.bits().and_then(|bits| u8::try_from(bits).ok());
    let described = match bits.filter(|&bits| bits != mapped.bits()) {
        _ if !entry.pdo_mappable => Side::NotMappable,
        _ if !fits => Side::Fact(Fact::Access(entry.access)),
        Some(bits) => Side::Fact(Fact::Mapping(vec![MappingEntry::new(mapped.object(), bits)])),
        None => return,
    };
    let found = Side::Fact(Fact::Mapping(vec![mapped]));
    comparison.report(MismatchKind::Unmappable, Weight::Differs, Subject::Pdo(pdo), described, found);
}
