//! Defaults: the values read for parameters and constants. Measured values and states have none.

use super::Facts;
use crate::PdoNumber;
use crate::dictionary::data_type::DataType;
use crate::dictionary::names::{Role, known_profile, with_role};
use crate::dictionary::object::{Access, Setting};
use crate::dictionary::value::Value;
use crate::identity::{CobId, Multiplexer};
use crate::object;
use crate::wire::sdo::{REQUEST_BASE, RESPONSE_BASE};

/// The default, if the value read can be one.
pub(super) fn default(facts: &Facts<'_>, at: Multiplexer, data_type: DataType, counts: bool) -> Option<Setting> {
    let is_known = counts || is_parameter(facts, at);
    let bytes = facts.survey.value(at).filter(|_| is_known)?;
    let value = Value::decode(data_type, bytes).ok()?;
    match &value {
        Value::VisibleString(text) if !text.iter().all(|byte| matches!(byte, b' '..=b'~')) => None,
        Value::Domain(_) | Value::OctetString(_) => None,
        Value::Unsigned(raw) => Some(with_node_id(facts, at, *raw)),
        _ => Some(Setting::Fixed(value)),
    }
}

/// Whether the value of the entry is a setting, made by the manufacturer or by a configuration.
fn is_parameter(facts: &Facts<'_>, at: Multiplexer) -> bool {
    let standard = facts.standard(at).and_then(|name| name.entry).and_then(|entry| entry.access);
    match (at.index.0, at.sub.0) {
        // Errors, storage capabilities, time and serial number are specific to the device.
        (
            0x1001..=0x1003
            | object::STORE_PARAMETERS
            | object::RESTORE_DEFAULT_PARAMETERS
            | object::HIGH_RESOLUTION_TIME_STAMP,
            _,
        )
        | (object::IDENTITY, 4) => false,
        (0x1000..=0x1FFF, _) => standard.is_some(),
        _ => is_constant(facts, at) || standard.is_some_and(Access::is_writable),
    }
}

/// Whether the device's profile says that construction determines the value.
fn is_constant(facts: &Facts<'_>, at: Multiplexer) -> bool {
    let profile = facts.profile.and_then(known_profile);
    profile.is_some_and(|profile| with_role(profile, Role::Constant).any(|index| index == at.index))
}

/// The value as a formula with the node-ID, for a COB-ID of the predefined connection set, and for any other COB-ID of
/// a PDO that ends in the node-ID.
fn with_node_id(facts: &Facts<'_>, at: Multiplexer, raw: u64) -> Setting {
    let node = u32::from(facts.node.raw());
    match u32::try_from(raw).map(CobId) {
        Ok(cob_id) if !cob_id.is_extended() && follows(at, cob_id.can_id(), node) => {
            Setting::NodeIdPlus(cob_id.0 - node)
        }
        _ => Setting::Fixed(Value::Unsigned(raw)),
    }
}

fn follows(at: Multiplexer, can_id: u32, node: u32) -> bool {
    let base = match (at.index.0, at.sub.0) {
        (object::COB_ID_EMCY, 0) => 0x80,
        (object::SDO_SERVER_PARAMETER, 1) => u32::from(REQUEST_BASE),
        (object::SDO_SERVER_PARAMETER, 2) => u32::from(RESPONSE_BASE),
        (index, 1) if PdoNumber::of_communication_index(index).is_some() => {
            return can_id & 0x7F == node && (0x180..0x580).contains(&(can_id - node));
        }
        _ => return false,
    };
    can_id == base + node
}
