//! Mandatory objects, objects that require others, and the value ranges of standard objects.

use super::Check;
use crate::dictionary::place::Place;
use crate::dictionary::rules::{Rule, standard as rules};
use crate::identity::{Index, Multiplexer, SubIndex};
use crate::object;
use std::ops::RangeInclusive;

/// Objects that every CANopen device has.
const MANDATORY: [(u16, &Rule); 3] = [
    (object::DEVICE_TYPE, &rules::MANDATORY),
    (object::ERROR_REGISTER, &rules::MANDATORY),
    (object::IDENTITY, &rules::IDENTITY_MISSING),
];

/// An object, and the objects that it requires.
const COMPANIONS: [(u16, &[u16]); 7] = [
    (object::SYNCHRONOUS_WINDOW_LENGTH, &[object::COB_ID_SYNC]),
    (object::GUARD_TIME, &[object::LIFE_TIME_FACTOR]),
    (object::LIFE_TIME_FACTOR, &[object::GUARD_TIME]),
    (object::RESTORE_DEFAULT_PARAMETERS, &[object::STORE_PARAMETERS]),
    (object::INHIBIT_TIME_EMCY, &[object::COB_ID_EMCY]),
    (object::SYNCHRONOUS_COUNTER_OVERFLOW, &[object::COB_ID_SYNC]),
    (object::COMMUNICATION_CYCLE_PERIOD, &[object::COB_ID_SYNC]),
];

/// The values that CiA 301 allows as default.
struct Allowed {
    /// First and last index.
    indexes: (u16, u16),
    subs: RangeInclusive<u8>,
    /// The allowed values.
    values: &'static [RangeInclusive<u64>],
}

const fn allowed(first: u16, last: u16, subs: RangeInclusive<u8>, values: &'static [RangeInclusive<u64>]) -> Allowed {
    Allowed { indexes: (first, last), subs, values }
}

const RANGES: [Allowed; 9] = [
    // The first SDO server has no node-ID of a client.
    allowed(object::SDO_SERVER_PARAMETER, object::SDO_SERVER_PARAMETER, 0..=0, &[2..=2]),
    allowed(object::CONSUMER_HEARTBEAT_TIME, object::CONSUMER_HEARTBEAT_TIME, 1..=127, &[0..=0x00FF_FFFF]),
    allowed(object::SYNCHRONOUS_COUNTER_OVERFLOW, object::SYNCHRONOUS_COUNTER_OVERFLOW, 0..=0, &[0..=240]),
    allowed(object::ERROR_BEHAVIOR, object::ERROR_BEHAVIOR, 1..=1, &[0..=2]),
    allowed(0x1200, 0x127F, 3..=3, &[0..=127]),
    allowed(0x1280, 0x12FF, 3..=3, &[0..=127]),
    // 254 and 255 are multiplex PDOs.
    allowed(0x1600, 0x17FF, 0..=0, &[0..=64, 254..=255]),
    allowed(0x1800, 0x19FF, 6..=6, &[0..=240]),
    allowed(0x1A00, 0x1BFF, 0..=0, &[0..=64, 254..=255]),
];

pub(super) fn check(check: &mut Check<'_>) {
    for (index, rule) in MANDATORY {
        if check.object(Index(index)).is_none() {
            let section = format!("{index:04X}");
            let place = Place { section: &section, ..Place::default() };
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
    synchronous_pdos(check);
    ranges(check);
}

/// SYNC is mandatory for synchronous PDOs; one PDO is reported.
fn synchronous_pdos(check: &mut Check<'_>) {
    if check.object(Index(object::COB_ID_SYNC)).is_some() {
        return;
    }
    let parameters = [object::RPDO_COMMUNICATION_PARAMETER, object::TPDO_COMMUNICATION_PARAMETER];
    let of = |first: u16| {
        check.objects(first, first + 0x1FF).map(|object| Multiplexer { index: object.index, sub: SubIndex(2) })
    };
    let pdos: Vec<Multiplexer> = parameters.into_iter().flat_map(of).collect();
    // Up to 240 a SYNC sends the PDO or makes it take effect; 252 is for remote requests, answered after a SYNC.
    let is_synchronous = |at: &Multiplexer| matches!(check.effective_number(*at), Some((0..=240 | 252, _)));
    if let Some(at) = pdos.into_iter().find(is_synchronous) {
        let field = check.effective_number(at).map_or("", |(_, field)| field);
        check.report(at, field, &rules::COMPANION, "1005h (COB-ID SYNC) with synchronous PDOs", "no 1005h");
    }
}

fn ranges(check: &mut Check<'_>) {
    for Allowed { indexes: (first, last), subs, values } in RANGES {
        for object in check.objects(first, last) {
            for entry in object.entries().iter().filter(|entry| subs.contains(&entry.sub.0)) {
                let at = Multiplexer { index: object.index, sub: entry.sub };
                let default = check.default(at.index.0, at.sub.0);
                if let Some(default) = default.filter(|default| !values.iter().any(|range| range.contains(default))) {
                    let found = default.to_string();
                    check.report(at, "DefaultValue", &rules::RANGE, "a value that CiA 301 allows", &found);
                }
            }
        }
    }
}
