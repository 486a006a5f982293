//! Object codes, data types and access types that differ from CiA 301, 302 and the device profile.

use super::Check;
use crate::dictionary::names::object_name;
use crate::dictionary::object::{Access, Entry, Object};
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

/// CiA 301 allows mapping of the error register, the status register and the high resolution time stamp.
fn mappable(check: &mut Check<'_>, object: &Object, entry: &Entry) {
    let at = Multiplexer { index: object.index, sub: entry.sub };
    if entry.pdo_mappable
        && matches!(at.index.0, 0x1000..=0x1EFF)
        && !matches!(
            at.index.0,
            object::ERROR_REGISTER | object::MANUFACTURER_STATUS_REGISTER | object::HIGH_RESOLUTION_TIME_STAMP
        )
    {
        check.report(at, "PDOMapping", &rules::MAPPING, "PDOMapping=0 in the communication profile", "1");
    }
}

fn code(check: &mut Check<'_>, object: &Object, profile: Option<u16>) {
    let at = Multiplexer { index: object.index, sub: SubIndex(0) };
    let Some(standard) = object_name(at, profile).map(|name| name.object) else { return };
    // ARRAY and RECORD look the same on the bus, and early versions of the standards differ here.
    if standard.code.is_single() != object.code.is_single() {
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
    // The COB-IDs of the first SDO server are fixed to the predefined connection set; the COB-IDs of other servers are
    // not.
    let standard_access = if at.index.0 == object::SDO_SERVER_PARAMETER { Some(Access::Ro) } else { standard.access };
    let Some(access) = standard_access else { return };
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
