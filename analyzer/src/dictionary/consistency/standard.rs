//! Object codes, data types and access types that differ from CiA 301, 302 and the device profile.

use super::Check;
use crate::dictionary::names::object_name;
use crate::dictionary::object::{Access, Entry, Object, ObjectCode};
use crate::dictionary::rules::standard as rules;
use crate::identity::{Multiplexer, SubIndex};
use crate::object;

pub(super) fn check(check: &mut Check<'_>) {
    let profile = check.description.device_profile();
    for object in check.description.dictionary.objects() {
        code(check, object, profile);
        for entry in object.entries() {
            // In the short form (`CompactSubObj`) one entry stands for all.
            if entry.sub.0 > 1 && entry.line == object.line {
                continue;
            }
            entry_types(check, object, entry, profile);
            mappable(check, object, entry);
        }
    }
}

/// Whether CiA 301 allows an entry of the communication profile to be mapped.
const fn is_mappable(at: Multiplexer) -> bool {
    matches!(
        (at.index.0, at.sub.0),
        (object::ERROR_REGISTER | object::MANUFACTURER_STATUS_REGISTER | object::HIGH_RESOLUTION_TIME_STAMP, 0)
            // The streams of the OS prompt, and the COB-IDs of SDOs.
            | (0x1026, 1..=3)
            | (0x1200..=0x12FF, 1..=2)
    )
}

fn mappable(check: &mut Check<'_>, object: &Object, entry: &Entry) {
    let at = Multiplexer { index: object.index, sub: entry.sub };
    if entry.pdo_mappable && matches!(at.index.0, 0x1000..=0x1EFF) && !is_mappable(at) {
        check.report(at, "PDOMapping", &rules::MAPPING, "PDOMapping=0 in the communication profile", "1");
    }
}

/// Whether the entry is a COB-ID of the first SDO server, which the predefined connection set fixes.
const fn is_predefined_sdo(at: Multiplexer) -> bool {
    at.index.0 == object::SDO_SERVER_PARAMETER && matches!(at.sub.0, 1 | 2)
}

/// Whether CiA 301 lists this access for an entry that is otherwise rw: most of them may be fixed.
const fn is_alternative(at: Multiplexer, access: Access) -> bool {
    let at = (at.index.0, at.sub.0);
    match access {
        Access::Const | Access::Ro => matches!(
            at,
            (object::COB_ID_SYNC | object::COB_ID_EMCY | object::SYNCHRONOUS_COUNTER_OVERFLOW, 0)
                | (object::GUARD_TIME | object::LIFE_TIME_FACTOR | object::HIGH_RESOLUTION_TIME_STAMP, 0)
                | (0x1028 | object::ERROR_BEHAVIOR, 1..)
                | (0x1201..=0x127F, 1..=2)
                | (0x1280..=0x12FF, 1..=3)
                | (0x1400..=0x15FF, 1..=3 | 5)
                | (0x1600..=0x17FF | 0x1A00..=0x1BFF, _)
                | (0x1800..=0x19FF, 1..=3 | 5 | 6)
        ),
        Access::Wo => matches!(at, (object::HIGH_RESOLUTION_TIME_STAMP, 0) | (0x1023 | 0x1025, 1)),
        _ => false,
    }
}

fn code(check: &mut Check<'_>, object: &Object, profile: Option<u16>) {
    let at = Multiplexer { index: object.index, sub: SubIndex(0) };
    let Some(standard) = object_name(at, profile).map(|name| name.object) else { return };
    // ARRAY and RECORD look the same on the bus, and early versions of the standards differ here. An ARRAY has no room
    // for different data types, and the identity was a RECORD from its beginning.
    let types = || standard.entries.iter().filter(|entry| entry.first > 0).filter_map(|entry| entry.data_type);
    let is_record = object.index.0 == object::IDENTITY || types().any(|data_type| Some(data_type) != types().next());
    let is_wrong = standard.code.is_single() != object.code.is_single()
        || (is_record
            && standard.standard == "CiA 301"
            && standard.code == ObjectCode::RECORD
            && object.code == ObjectCode::ARRAY);
    if is_wrong {
        let expected = "the object code of the standard";
        let found = format!("{} instead of {}", object.code, standard.code);
        check.report_object(object, "ObjectType", &rules::OBJECT_CODE, expected, &found);
    }
}

fn entry_types(check: &mut Check<'_>, object: &Object, entry: &Entry, profile: Option<u16>) {
    let at = Multiplexer { index: object.index, sub: entry.sub };
    let name = object_name(at, profile).filter(|name| name.object.code.is_single() == object.code.is_single());
    let Some(standard) = name.and_then(|name| name.entry) else { return };
    if let Some(data_type) = standard.data_type.filter(|&data_type| data_type != entry.data_type) {
        let expected = "the data type of the standard";
        let found = format!("{} instead of {data_type}", entry.data_type);
        check.report(at, "DataType", &rules::DATA_TYPE, expected, &found);
    }
    let standard_access = if is_predefined_sdo(at) { Some(Access::Ro) } else { standard.access };
    let Some(access) = standard_access.filter(|_| !is_alternative(at, entry.access)) else { return };
    let rule = match (access, entry.access) {
        (Access::Ro, Access::Ro | Access::Const) | (Access::Rw, Access::Rw | Access::Rwr | Access::Rww) => return,
        (Access::Wo, Access::Wo | Access::Rw) => return,
        // Many parameters are allowed to be fixed.
        (Access::Rw, Access::Ro | Access::Const) => &rules::ACCESS_LESS,
        _ => &rules::ACCESS,
    };
    let expected = "the access type of the standard";
    let found = format!("{} instead of {access}", entry.access);
    check.report(at, "AccessType", rule, expected, &found);
}
