//! The values of communication parameters that a device must refuse (CiA 301, 7.5.2).

use super::codes::{self, CodeSet};
use super::expected_values::ExpectedValues;
use crate::Knowledge;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer};

type Refusal = (CodeSet, &'static str);

/// Abort codes for mapping errors.
const MAPPING: CodeSet = codes::REFUSED.or(codes::NO_OBJECT).or(codes::NO_SUB_INDEX).or(codes::TOO_LONG);

/// Maximum number of bits in a PDO.
const LONGEST_PDO: u64 = 64;

/// The reason why the value must be refused; `None` if it need not be.
pub(super) fn refusal(
    at: Multiplexer,
    raw: u64,
    knowledge: &Knowledge,
    expected_values: &ExpectedValues,
) -> Option<Refusal> {
    match (at.index.0, at.sub.0) {
        (0x1400..=0x15FF | 0x1800..=0x19FF, 1) => pdo_identifier(at, raw, knowledge, expected_values),
        (0x1400..=0x15FF, 2) if (241..=253).contains(&raw) => Some((codes::REFUSED, "a reserved transmission type")),
        (0x1800..=0x19FF, 2) if (241..=251).contains(&raw) => Some((codes::REFUSED, "a reserved transmission type")),
        (0x1800..=0x19FF, 6) => sync_start(at, raw, knowledge, expected_values),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, 0) => mapping_count(at, raw, knowledge, expected_values),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, _) => mapping_entry(at, raw, knowledge, expected_values),
        (object::COB_ID_SYNC | object::COB_ID_TIME, 0)
            if CobId(raw as u32 & 0x7FF).is_restricted() && at.index.0 == object::COB_ID_SYNC =>
        {
            Some((codes::REFUSED, "a restricted CAN-ID"))
        }
        (object::COB_ID_EMCY, 0) if CobId(raw as u32).is_valid() && CobId(raw as u32).is_restricted() => {
            Some((codes::REFUSED, "a restricted CAN-ID"))
        }
        (object::COB_ID_SYNC, 0) => in_use(at, raw, PRODUCES, knowledge, expected_values),
        (object::COB_ID_TIME, 0) => in_use(at, raw, PRODUCES | CONSUMES, knowledge, expected_values),
        (object::COB_ID_EMCY, 0) => while_valid(at, raw, knowledge, expected_values),
        (0x1201..=0x127F, 1 | 2) => while_valid(at, raw, knowledge, expected_values),
        (object::PREDEFINED_ERROR_FIELD, 0) if raw != 0 => {
            Some((codes::REFUSED, "only 0 can be written to the error history"))
        }
        (object::STORE_PARAMETERS, 1..) if raw != SAVE => Some((codes::REFUSED, "not the signature that stores")),
        (object::RESTORE_DEFAULT_PARAMETERS, 1..) if raw != LOAD => {
            Some((codes::REFUSED, "not the signature that restores"))
        }
        (object::CONSUMER_HEARTBEAT_TIME, 1..) => consumer(at, raw, knowledge, expected_values),
        (object::SYNCHRONOUS_COUNTER_OVERFLOW, 0) if raw == 1 || raw > 240 => {
            Some((codes::REFUSED, "a reserved value of the SYNC counter"))
        }
        (object::SYNCHRONOUS_COUNTER_OVERFLOW, 0) => {
            let (period, counter) = (
                expected_values.number(knowledge, object::COMMUNICATION_CYCLE_PERIOD, 0)?,
                expected_values.number(knowledge, object::SYNCHRONOUS_COUNTER_OVERFLOW, 0)?,
            );
            let changes = period != 0 && counter != raw;
            changes.then_some((codes::REFUSED, "the SYNC counter changes only while 1006h is 0"))
        }
        (object::ERROR_BEHAVIOR, 1..) if (3..0x80).contains(&raw) => {
            Some((codes::REFUSED, "a reserved behaviour on errors"))
        }
        _ => None,
    }
}

/// The signature "save", little-endian.
const SAVE: u64 = 0x6576_6173;
/// The signature "load", little-endian.
const LOAD: u64 = 0x6461_6F6C;

/// Bit 30 of 1005h and 1012h: the device produces SYNC or TIME.
const PRODUCES: u32 = 1 << 30;
/// Bit 31 of 1012h: the device consumes TIME.
const CONSUMES: u32 = 1 << 31;

/// Refuses another identifier of SYNC or TIME while it is produced or consumed.
fn in_use(
    at: Multiplexer,
    raw: u64,
    flags: u32,
    knowledge: &Knowledge,
    expected_values: &ExpectedValues,
) -> Option<Refusal> {
    let (old, new) = (CobId(expected_values.number(knowledge, at.index.0, at.sub.0)? as u32), CobId(raw as u32));
    let changes = old.0 & new.0 & flags != 0 && old.can_id() != new.can_id();
    changes.then_some((codes::REFUSED, "the CAN-ID changes only while it is not in use"))
}

/// Refuses another identifier while the old identifier is valid. Bit 31 marks an identifier as invalid.
fn while_valid(at: Multiplexer, raw: u64, knowledge: &Knowledge, expected_values: &ExpectedValues) -> Option<Refusal> {
    let (old, new) = (CobId(expected_values.number(knowledge, at.index.0, at.sub.0)? as u32), CobId(raw as u32));
    let changes = old.is_valid() && new.is_valid() && old.can_id() != new.can_id();
    changes.then_some((codes::REFUSED, "the CAN-ID changes only while it is invalid"))
}

fn sync_start(at: Multiplexer, raw: u64, knowledge: &Knowledge, expected_values: &ExpectedValues) -> Option<Refusal> {
    let cob_id = CobId(expected_values.number(knowledge, at.index.0, 1)? as u32);
    let changes = cob_id.is_valid() && expected_values.number(knowledge, at.index.0, 6)? != raw;
    changes.then_some((codes::REFUSED, "the SYNC start value changes only while the PDO is invalid"))
}

/// Additional abort codes with which a mapping may be refused.
pub(super) fn mapping_codes(at: Multiplexer) -> CodeSet {
    match at.index.0 {
        0x1600..=0x17FF | 0x1A00..=0x1BFF => MAPPING,
        _ => CodeSet::NONE,
    }
}

fn pdo_identifier(
    at: Multiplexer,
    raw: u64,
    knowledge: &Knowledge,
    expected_values: &ExpectedValues,
) -> Option<Refusal> {
    let new = CobId(raw as u32);
    if new.is_valid() && new.is_restricted() {
        return Some((codes::REFUSED, "a restricted CAN-ID"));
    }
    let old = CobId(expected_values.number(knowledge, at.index.0, 1)? as u32);
    let changes =
        old.is_valid() && new.is_valid() && (old.can_id() != new.can_id() || old.is_extended() != new.is_extended());
    changes.then_some((codes::REFUSED, "the CAN-ID changes only while the PDO is invalid"))
}

fn mapping_count(
    at: Multiplexer,
    raw: u64,
    knowledge: &Knowledge,
    expected_values: &ExpectedValues,
) -> Option<Refusal> {
    if raw == 0 || raw > 8 {
        // Values above 64 are reserved, or belong to a multiplexed PDO.
        return (65..254).contains(&raw).then_some((MAPPING, "more than 64 mapped objects"));
    }
    let mut bits = 0;
    for sub in 1..=raw as u8 {
        let entry = expected_values.number(knowledge, at.index.0, sub)?;
        bits += entry & 0xFF;
        let mapped = Multiplexer::new((entry >> 16) as u16, (entry >> 8) as u8);
        let transmits = (0x1A00..=0x1BFF).contains(&at.index.0);
        match knowledge.entry(mapped) {
            _ if entry == 0 => return Some((MAPPING, "an empty entry is mapped")),
            _ if mapped.index.0 < 0x20 && transmits => return Some((MAPPING, "a dummy is mapped into a TPDO")),
            _ if mapped.index.0 < 0x20 => {}
            None if knowledge.is_described() => return Some((MAPPING, "a mapped object does not exist")),
            Some(known) if transmits && !known.tpdo_mappable => {
                return Some((MAPPING, "a mapped object can't be mapped"));
            }
            Some(known) if known.size.is_some_and(|size| entry & 0xFF > size as u64 * 8) => {
                return Some((MAPPING, "more bits are mapped than the object has"));
            }
            _ => {}
        }
    }
    (bits > LONGEST_PDO).then_some((MAPPING, "mapped objects of more than 64 bits"))
}

fn mapping_entry(
    at: Multiplexer,
    raw: u64,
    knowledge: &Knowledge,
    expected_values: &ExpectedValues,
) -> Option<Refusal> {
    let count = expected_values.number(knowledge, at.index.0, 0)?;
    let in_use = (1..=64).contains(&count) && u64::from(at.sub.0) <= count;
    // Writing the current value again changes nothing.
    let changes = expected_values.number(knowledge, at.index.0, at.sub.0) != Some(raw);
    (in_use && changes).then_some((MAPPING, "mapping entries change only while sub-index 0 is 0"))
}

/// Refuses a second heartbeat consumer time for the same node (abort 0604 0043h).
fn consumer(at: Multiplexer, raw: u64, knowledge: &Knowledge, expected_values: &ExpectedValues) -> Option<Refusal> {
    const DOUBLE: CodeSet = CodeSet::of(&[AbortCode::PARAMETER_INCOMPATIBLE]).or(codes::REFUSED);
    let (node, time) = (raw >> 16 & 0xFF, raw & 0xFFFF);
    if !(1..=127).contains(&node) || time == 0 {
        return None;
    }
    let twice = knowledge
        .entries()
        .iter()
        .filter(|known| known.at.index.0 == object::CONSUMER_HEARTBEAT_TIME && known.at.sub.0 > 0)
        .any(|known| {
            let other = expected_values.number(knowledge, object::CONSUMER_HEARTBEAT_TIME, known.at.sub.0).unwrap_or(0);
            known.at.sub != at.sub && other >> 16 & 0xFF == node && other & 0xFFFF != 0
        });
    twice.then_some((DOUBLE, "another entry already monitors the node"))
}
