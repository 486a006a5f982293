//! Objects that every device has, objects that go together, and the ranges of standard objects.

use super::Check;
use crate::dictionary::problem::Place;
use crate::dictionary::rules::{Rule, standard as rules};
use crate::identity::{Index, Multiplexer};
use std::ops::RangeInclusive;

/// What every CANopen device has.
const MANDATORY: [(u16, &Rule); 3] =
    [(0x1000, &rules::MANDATORY), (0x1001, &rules::MANDATORY), (0x1018, &rules::IDENTITY_MISSING)];

/// An object, and those that it makes no sense without.
const COMPANIONS: [(u16, &[u16]); 7] = [
    (0x1007, &[0x1005]),
    (0x100C, &[0x100D]),
    (0x100D, &[0x100C]),
    (0x1011, &[0x1010]),
    (0x1015, &[0x1014]),
    (0x1019, &[0x1005]),
    (0x1006, &[0x1005]),
];

/// The values that CiA 301 allows: first index, last index, sub-index.
const RANGES: [(u16, u16, u8, RangeInclusive<u64>); 6] = [
    (0x1019, 0x1019, 0, 0..=240),
    (0x1029, 0x1029, 1, 0..=2),
    (0x1200, 0x127F, 3, 0..=127),
    (0x1280, 0x12FF, 3, 0..=127),
    (0x1800, 0x19FF, 6, 0..=240),
    (0x1016, 0x1016, 1, 0..=0x00FF_FFFF),
];

pub(super) fn check(check: &mut Check<'_>) {
    for (index, rule) in MANDATORY {
        if check.object(Index(index)).is_none() {
            let section = format!("{index:04X}");
            let place = Place { line: 0, section: &section, field: "" };
            check.problems.report(place, rule, "an object that every device has", "none");
        }
    }
    for (index, needed) in COMPANIONS {
        let missing = needed.iter().find(|&&needed| check.object(Index(needed)).is_none());
        if let (Some(_), Some(missing)) = (check.object(Index(index)), missing) {
            let found = format!("no {missing:04X}h");
            check.report(Multiplexer::new(index, 0), "", &rules::COMPANION, "the object that it belongs to", &found);
        }
    }
    for (first, last, sub, range) in RANGES {
        for object in check.objects(first, last) {
            let at = Multiplexer::new(object.index.0, sub);
            let default = check.default(at.index.0, at.sub.0);
            if let Some(default) = default.filter(|default| !range.contains(default)) {
                let found = default.to_string();
                check.report(at, "DefaultValue", &rules::RANGE, "a value that CiA 301 allows", &found);
            }
        }
    }
}
