//! `DeviceInfo` and the identity object, error control, and arrays.

use super::{Check, elements};
use crate::dictionary::object::ObjectCode;
use crate::dictionary::problem::{Place, ProblemKind, Severity};
use crate::identity::{Index, Multiplexer};

pub(super) fn check(check: &mut Check<'_>) {
    numbers(check);
    error_control(check);
    arrays(check);
}

/// The numbers in `DeviceInfo` are the defaults of 1018h.
fn numbers(check: &mut Check<'_>) {
    let device = &check.description.device;
    let numbers = [(1, device.vendor_number), (2, device.product_number), (3, device.revision_number)];
    for (sub, number) in numbers {
        let (Some(default), Some(number)) = (check.default(0x1018, sub), number) else { continue };
        if default != u64::from(number) {
            let expected = "the number that DeviceInfo has";
            let found = format!("{default:X}h instead of {number:X}h");
            let at = Multiplexer::new(0x1018, sub);
            check.report(at, "DefaultValue", Severity::Warning, ProblemKind::Value, expected, &found);
        }
    }
}

/// A device has the heartbeat, or node guarding with both of its objects.
fn error_control(check: &mut Check<'_>) {
    let has = |index| check.object(Index(index)).is_some();
    let (heartbeat, guarding) = (has(0x1017), has(0x100C) && has(0x100D));
    if !heartbeat && !guarding {
        let place = Place { line: 0, section: "1017", field: "" };
        let expected = "producer heartbeat time, or guard time and life time factor";
        check.problems.report(place, Severity::Warning, ProblemKind::MissingSection, expected, "none");
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
                check.report(at, "DataType", Severity::Warning, ProblemKind::Value, expected, &found);
            }
            if u16::from(entry.sub.0) != number {
                let expected = "an array without gaps";
                check.report(at, "", Severity::Info, ProblemKind::Count, expected, &at.to_string());
                break;
            }
        }
    }
}
