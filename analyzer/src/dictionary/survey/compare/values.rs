//! Compares values with data types, limits and defaults.

use super::{Answer, Comparison, MismatchKind, Side, Weight};
use crate::dictionary::difference::{Fact, Subject};
use crate::dictionary::names::is_cob_id;
use crate::dictionary::object::{Access, Entry, Object, Setting};
use crate::dictionary::value::{Value, ValueError};
use crate::identity::{Multiplexer, NodeId};
use crate::object;

pub(super) fn compare(comparison: &mut Comparison<'_>, object: &Object, entry: &Entry, bytes: &[u8]) {
    let at = Multiplexer { index: object.index, sub: entry.sub };
    let (kind, found) = match Value::decode(entry.data_type, bytes) {
        Ok(value) => {
            limits(comparison, at, entry, &value);
            return default(comparison, object, entry, &value);
        }
        // A manufacturer-specific data type.
        Err(ValueError::NoValue(_)) => return,
        Err(ValueError::Length { .. } | ValueError::OddLength { .. }) => {
            (MismatchKind::Length, Side::Length(bytes.len()))
        }
        Err(_) => (MismatchKind::NoValue, Side::Answer(Answer::Value(bytes.to_vec()))),
    };
    let described = Side::Fact(Fact::DataType(entry.data_type));
    comparison.report(kind, Weight::Differs, Subject::Entry(at), described, found);
}

fn limits(comparison: &mut Comparison<'_>, at: Multiplexer, entry: &Entry, value: &Value) {
    let node = comparison.node;
    let limit = |limit: &Option<Setting>| limit.as_ref().map(|limit| limit.resolve(entry.data_type, node));
    let (low, high) = (limit(&entry.low_limit), limit(&entry.high_limit));
    let below = low.as_ref().is_some_and(|low| is_less(value, low));
    let above = high.as_ref().is_some_and(|high| is_less(high, value));
    if below || above {
        let found = Side::Fact(Fact::Setting(Setting::Fixed(value.clone())));
        comparison.report(MismatchKind::Limits, Weight::Differs, Subject::Entry(at), Side::Limits(low, high), found);
    }
}

fn is_less(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Real32(one), Value::Real32(other)) => one < other,
        (Value::Real64(one), Value::Real64(other)) => one < other,
        _ => one.as_number().zip(other.as_number()).is_some_and(|(one, other)| one < other),
    }
}

fn default(comparison: &mut Comparison<'_>, object: &Object, entry: &Entry, value: &Value) {
    let at = Multiplexer { index: object.index, sub: entry.sub };
    if comparison.told.contains(&at) {
        return;
    }
    let Some(described) = entry.start_value(comparison.node) else { return };
    let Some((kind, weight)) = weighed(object, entry) else { return };
    if described != *value && !is_shortened(at, &described, value) {
        let fact = |value: Value| {
            let setting = Setting::Fixed(value);
            Side::Fact(if is_cob_id(at) { Fact::CobId(setting) } else { Fact::Setting(setting) })
        };
        comparison.report(kind, weight, Subject::Entry(at), fact(described), fact(value.clone()));
    }
}

/// Whether two names differ only in length: devices fill names with blanks or zeros, and files leave these out.
fn is_shortened(at: Multiplexer, described: &Value, found: &Value) -> bool {
    let (Value::VisibleString(described), Value::VisibleString(found)) = (described, found) else { return false };
    let is_filler = |byte: &&u8| **byte == 0 || byte.is_ascii_whitespace();
    let trimmed = |bytes: &[u8]| bytes.len() - bytes.iter().rev().take_while(is_filler).count();
    let same = described.get(..trimmed(described)) == found.get(..trimmed(found));
    matches!(at.index.0, 0x1008..=0x100A) && (described.is_empty() || same)
}

/// The kind of a difference from the default; `None` if such a difference means nothing.
fn weighed(object: &Object, entry: &Entry) -> Option<(MismatchKind, Weight)> {
    let at = Multiplexer { index: object.index, sub: entry.sub };
    let kind = match (at.index.0, at.sub.0) {
        // Errors, time and serial number are specific to the device.
        (0x1001..=0x1003 | object::HIGH_RESOLUTION_TIME_STAMP, _) | (object::IDENTITY, 4) => return None,
        (object::IDENTITY, 1..=3) if is_open(entry) => return None,
        (object::DEVICE_TYPE | object::MANUFACTURER_DEVICE_NAME, _) | (object::IDENTITY, 1 | 2) => {
            MismatchKind::Identity
        }
        (object::MANUFACTURER_HARDWARE_VERSION | object::MANUFACTURER_SOFTWARE_VERSION, _) | (object::IDENTITY, 3) => {
            MismatchKind::Release
        }
        _ if entry.configured.is_some() => MismatchKind::Configured,
        _ if !entry.access.is_writable() && entry.pdo_mappable => return None,
        _ if is_cob_id(at) => MismatchKind::CobId,
        (_, 0) if !object.code.is_single() && !entry.access.is_writable() => MismatchKind::Count,
        _ if entry.access == Access::Const => MismatchKind::Constant,
        // The values read tell the capabilities of the device.
        (object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS, _) => MismatchKind::State,
        _ if entry.access.is_writable() => MismatchKind::Setting,
        (0x1004..=0x1FFF, _) => MismatchKind::Constant,
        _ => MismatchKind::State,
    };
    let weight = match kind {
        MismatchKind::State => Weight::MayBeState,
        MismatchKind::Setting => Weight::MayBeConfiguration,
        MismatchKind::CobId if entry.access.is_writable() => Weight::MayBeConfiguration,
        _ => Weight::Differs,
    };
    Some((kind, weight))
}

/// Whether the file leaves this part of the identity open, by the value 0.
fn is_open(entry: &Entry) -> bool {
    entry.start_value(NodeId::MIN).and_then(|value| value.to_raw()) == Some(0)
}
