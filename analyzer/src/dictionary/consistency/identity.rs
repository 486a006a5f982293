//! `DeviceInfo` and the identity object, error control, and arrays.

use super::{Check, elements};
use crate::dictionary::data_type::DataType;
use crate::dictionary::names::object_name;
use crate::dictionary::object::{ObjectCode, Setting};
use crate::dictionary::place::Place;
use crate::dictionary::rules;
use crate::dictionary::value::Value;
use crate::identity::{Index, Multiplexer};
use crate::object;

pub(super) fn check(check: &mut Check<'_>) {
    numbers(check);
    error_control(check);
    layer_setting(check);
    arrays(check);
    entries(check);
}

/// The numbers in `DeviceInfo` must be the defaults of 1018h.
fn numbers(check: &mut Check<'_>) {
    let device = &check.description.device;
    let numbers = [(1, device.vendor_number), (2, device.product_number), (3, device.revision_number)];
    for (sub, number) in numbers {
        let (Some(default), Some(number)) = (check.default(object::IDENTITY, sub), number) else { continue };
        if default != u64::from(number) {
            let expected = "the number that DeviceInfo has";
            let found = format!("{default:X}h instead of {number:X}h");
            let at = Multiplexer::new(object::IDENTITY, sub);
            check.report(at, "DefaultValue", &rules::file::IDENTITY, expected, &found);
        }
    }
}

/// A device needs the heartbeat, or node guarding with both of its objects.
fn error_control(check: &mut Check<'_>) {
    let has = |index| check.object(Index(index)).is_some();
    let (heartbeat, guarding) =
        (has(object::PRODUCER_HEARTBEAT_TIME), has(object::GUARD_TIME) && has(object::LIFE_TIME_FACTOR));
    if !heartbeat && !guarding {
        let place = Place { section: "1017", ..Place::default() };
        let expected = "producer heartbeat time, or guard time and life time factor";
        check.problems.report(place, &rules::file::ERROR_CONTROL, expected, "none");
    }
}

/// LSS addresses a device by all four numbers of its identity.
fn layer_setting(check: &mut Check<'_>) {
    let has = |sub| check.description.dictionary.entry(Multiplexer::new(object::IDENTITY, sub)).is_ok();
    if check.description.device.lss_supported
        && check.object(Index(object::IDENTITY)).is_some()
        && let Some(missing) = (1..=4).find(|&sub| !has(sub))
    {
        let expected = "1018h with sub-indexes 1 to 4, since LSS_Supported=1";
        let at = Multiplexer::new(object::IDENTITY, missing);
        check.report(at, "", &rules::file::LSS, expected, &format!("no {at}"));
    }
}

/// Sub-index 0 is a byte; visible strings have visible characters.
fn entries(check: &mut Check<'_>) {
    let profile = check.description.device_profile();
    for (at, entry) in check.description.dictionary.entries() {
        let counts = at.sub.0 == 0 && check.object(at.index).is_some_and(|object| !object.code.is_single());
        // Objects of a standard are compared with the standard in `consistency::standard`.
        let is_standard = || object_name(at, profile).is_some_and(|name| name.entry.is_some());
        if counts && entry.data_type != DataType::UNSIGNED8 && !is_standard() {
            let found = entry.data_type.to_string();
            check.report(at, "DataType", &rules::entry::SUB_0, "UNSIGNED8 in sub-index 0", &found);
        }
        if let Some(Value::VisibleString(text)) = entry.default.as_ref().and_then(Setting::fixed)
            && text.iter().any(|byte| !matches!(byte, b' '..=b'~'))
        {
            let found = String::from_utf8_lossy(text);
            check.report(at, "DefaultValue", &rules::entry::STRING, "characters from 20h to 7Eh", &found);
        }
    }
}

/// The elements of an array have one data type and no gaps.
fn arrays(check: &mut Check<'_>) {
    for object in check.description.dictionary.objects().iter().filter(|object| object.code == ObjectCode::ARRAY) {
        let Some(first) = elements(object).next() else { continue };
        for (number, entry) in (1u16..).zip(elements(object)) {
            let at = Multiplexer { index: object.index, sub: entry.sub };
            if entry.data_type != first.data_type {
                let expected = "one data type in an array";
                let found = entry.data_type.to_string();
                check.report(at, "DataType", &rules::entry::ARRAY_TYPE, expected, &found);
            }
            if u16::from(entry.sub.0) != number {
                let expected = "an array without gaps";
                check.report(at, "", &rules::entry::ARRAY_GAP, expected, &at.to_string());
                break;
            }
        }
    }
}
