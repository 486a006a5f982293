//! Differences of limits, defaults and configured values.

use super::kind::kinds;
use super::{ChangeKind, Comparison, Fact, Subject};
use crate::PdoNumber;
use crate::dictionary::data_type::{DataClass, DataType};
use crate::dictionary::names::object_name;
use crate::dictionary::object::{Entry, Setting};
use crate::dictionary::value::Value;
use crate::identity::Multiplexer;
use crate::object;
use std::cmp::Ordering;

kinds! {
    /// the limits are narrower
    ///
    /// A DCF with a value that was allowed is refused: abort 0609 0031h (too high) or 0609 0032h (too low).
    NARROWER: Breaking "limit/narrower";

    /// the limits are wider
    ///
    /// Every value that was allowed still is.
    WIDER: Harmless "limit/wider";

    /// the limit is written in another form
    ///
    /// One limit is a number, the other a formula with the node-ID; the node-ID decides which is narrower.
    LIMIT: Notable "limit/changed";

    /// the default COB-ID has changed
    ///
    /// Nodes that are configured for the old CAN-ID receive nothing, and the new one may be in use.
    COB_ID: Breaking "default/cob-id";

    /// the device type has changed
    ///
    /// A master that expects the old one in 1F84h does not start the device.
    DEVICE_TYPE: Breaking "default/device-type";

    /// the identity has changed
    ///
    /// A master that expects the old vendor-ID or product code (1F85h, 1F86h) does not start the device, and a tool does not
    /// find the description for it.
    IDENTITY: Breaking "default/identity";

    /// the default has changed
    ///
    /// A device that is restored or was never configured behaves differently; so does a device whose DCF leaves the
    /// entry out.
    DEFAULT: Notable "default/changed";

    /// the count in sub-index 0 has changed
    ///
    /// It follows from the sub-indexes that are new or gone.
    COUNT: Harmless "default/count";

    /// the configured value has changed
    ///
    /// The next download sets it.
    CONFIGURED: Notable "configured/changed";

    /// the configured COB-ID has changed
    ///
    /// Nodes that are configured for the old CAN-ID receive nothing until they are configured for the new one too.
    CONFIGURED_COB_ID: Breaking "configured/cob-id";
}

pub(super) fn compare(comparison: &mut Comparison<'_>, at: Multiplexer, old: &Entry, new: &Entry, is_single: bool) {
    limits(comparison, at, old, new);
    if comparison.told.contains(&at) {
        return;
    }
    let is_cob_id = is_cob_id(at);
    // The COB-ID of a PDO is reported with the PDO; a difference left here has no consequence on the bus.
    let is_of_pdo = PdoNumber::of_communication_index(at.index.0).is_some();
    let fact = |setting: &Option<Setting>| {
        setting.clone().map(|setting| if is_cob_id { Fact::CobId(setting) } else { Fact::Setting(setting) })
    };
    let (default, configured): (&ChangeKind, &ChangeKind) = match (at.index.0, at.sub.0) {
        _ if is_cob_id && !is_of_pdo => (&COB_ID, &CONFIGURED_COB_ID),
        (object::DEVICE_TYPE, 0) => (&DEVICE_TYPE, &CONFIGURED),
        (object::IDENTITY, 1 | 2) => (&IDENTITY, &CONFIGURED),
        (_, 0) if !is_single && !new.access.is_writable() => (&COUNT, &CONFIGURED),
        _ => (&DEFAULT, &CONFIGURED),
    };
    let subject = Subject::Entry(at);
    comparison.changed(default, subject, fact(&old.default), fact(&new.default));
    comparison.changed(configured, subject, fact(&old.configured), fact(&new.configured));
}

/// Whether the standard defines a COB-ID at the address.
fn is_cob_id(at: Multiplexer) -> bool {
    let name = object_name(at, None);
    let own = name.and_then(|name| name.entry.map(|entry| entry.name).filter(|name| !name.is_empty()));
    own.or(name.map(|name| name.object.name)).is_some_and(|name| name.starts_with("COB-ID"))
}

fn limits(comparison: &mut Comparison<'_>, at: Multiplexer, old: &Entry, new: &Entry) {
    for high in [false, true] {
        let of = |entry: &Entry| if high { entry.high_limit.clone() } else { entry.low_limit.clone() };
        let (before, after) = (of(old), of(new));
        // If the type has changed, only limits in the file are compared: a change of the type's own limits is reported
        // as a change of the type.
        let bound = |entry: &Entry| of(entry).or_else(|| extreme(entry.data_type, high));
        let (old_bound, new_bound) =
            if old.data_type == new.data_type { (bound(old), bound(new)) } else { (before.clone(), after.clone()) };
        let kind: &ChangeKind = match (&old_bound, &new_bound) {
            (None, None) => continue,
            (None, Some(_)) if old.data_type == new.data_type => &NARROWER,
            (Some(_), None) if old.data_type == new.data_type => &WIDER,
            (None, _) | (_, None) => continue,
            (Some(old), Some(new)) => match order(old, new) {
                Some(Ordering::Equal) => continue,
                Some(Ordering::Less) => {
                    if high {
                        &WIDER
                    } else {
                        &NARROWER
                    }
                }
                Some(Ordering::Greater) => {
                    if high {
                        &NARROWER
                    } else {
                        &WIDER
                    }
                }
                None => &LIMIT,
            },
        };
        comparison.report(kind, Subject::Entry(at), before.map(Fact::Setting), after.map(Fact::Setting));
    }
}

fn order(old: &Setting, new: &Setting) -> Option<Ordering> {
    match (old, new) {
        (Setting::NodeIdPlus(old), Setting::NodeIdPlus(new)) => Some(old.cmp(new)),
        (Setting::Fixed(old), Setting::Fixed(new)) => match (old.as_number(), new.as_number()) {
            (Some(old), Some(new)) => Some(old.cmp(&new)),
            _ if old == new => Some(Ordering::Equal),
            _ => real(old)?.partial_cmp(&real(new)?),
        },
        _ => None,
    }
}

fn real(value: &Value) -> Option<f64> {
    match value {
        Value::Real32(value) => Some(f64::from(*value)),
        Value::Real64(value) => Some(*value),
        // After a change from or to a REAL type, one of the two limits is an integer.
        _ => value.as_number().map(|number| number as f64),
    }
}

/// The lowest or highest value of an integer type, which is the limit if the file gives none.
fn extreme(data_type: DataType, high: bool) -> Option<Setting> {
    let bits = data_type.bits()?;
    let all_ones = u64::MAX >> 64u32.checked_sub(bits)?;
    let raw = match (data_type.class()?, high) {
        (DataClass::Boolean | DataClass::Unsigned, true) => all_ones,
        (DataClass::Boolean | DataClass::Unsigned, false) => 0,
        (DataClass::Integer, true) => all_ones >> 1,
        (DataClass::Integer, false) => all_ones ^ all_ones >> 1,
        _ => return None,
    };
    Value::from_raw(data_type, raw).map(Setting::Fixed)
}
