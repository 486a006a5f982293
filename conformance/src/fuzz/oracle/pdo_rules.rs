//! Which values of communication parameters a device must refuse (CiA 301, 7.5.2).

use super::belief::Belief;
use super::codes::{self, CodeSet};
use crate::fuzz::Knowledge;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer};

type Refusal = (CodeSet, &'static str);

/// Mapping errors have codes of their own.
const MAPPING: CodeSet = codes::REFUSED.or(codes::NO_OBJECT).or(codes::NO_SUB_INDEX).or(codes::TOO_LONG);

/// The most bits that a PDO can carry.
const LONGEST_PDO: u64 = 64;

/// Why that value must be refused, if it must.
pub(super) fn refusal(at: Multiplexer, raw: u64, knowledge: &Knowledge, belief: &Belief) -> Option<Refusal> {
    match (at.index.0, at.sub.0) {
        (0x1400..=0x15FF | 0x1800..=0x19FF, 1) => pdo_identifier(at, raw, knowledge, belief),
        (0x1400..=0x15FF, 2) if (241..=253).contains(&raw) => Some((codes::REFUSED, "a reserved transmission type")),
        (0x1800..=0x19FF, 2) if (241..=251).contains(&raw) => Some((codes::REFUSED, "a reserved transmission type")),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, 0) => mapping_count(at, raw, knowledge, belief),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, _) => mapping_entry(at, knowledge, belief),
        (0x1005 | 0x1012, 0) if CobId(raw as u32 & 0x7FF).is_restricted() && at.index.0 == 0x1005 => {
            Some((codes::REFUSED, "a restricted CAN-ID"))
        }
        (0x1014, 0) if CobId(raw as u32).is_valid() && CobId(raw as u32).is_restricted() => {
            Some((codes::REFUSED, "a restricted CAN-ID"))
        }
        (0x1016, 1..) => consumer(at, raw, knowledge, belief),
        (0x1019, 0) if raw == 1 || raw > 240 => Some((codes::REFUSED, "a reserved value of the SYNC counter")),
        _ => None,
    }
}

/// Codes with which a mapping may be refused beside the usual ones.
pub(super) fn mapping_codes(at: Multiplexer) -> CodeSet {
    match at.index.0 {
        0x1600..=0x17FF | 0x1A00..=0x1BFF => MAPPING,
        _ => CodeSet::NONE,
    }
}

fn pdo_identifier(at: Multiplexer, raw: u64, knowledge: &Knowledge, belief: &Belief) -> Option<Refusal> {
    let new = CobId(raw as u32);
    if new.is_valid() && new.is_restricted() {
        return Some((codes::REFUSED, "a restricted CAN-ID"));
    }
    let old = CobId(belief.number(knowledge, at.index.0, 1)? as u32);
    let changes =
        old.is_valid() && new.is_valid() && (old.can_id() != new.can_id() || old.is_extended() != new.is_extended());
    changes.then_some((codes::REFUSED, "the CAN-ID changes only while the PDO is invalid"))
}

fn mapping_count(at: Multiplexer, raw: u64, knowledge: &Knowledge, belief: &Belief) -> Option<Refusal> {
    if raw == 0 || raw > 8 {
        // Above 64 the value is a reserved one, or that of a multiplexed PDO.
        return (65..254).contains(&raw).then_some((MAPPING, "more than 64 mapped objects"));
    }
    let mut bits = 0;
    for sub in 1..=raw as u8 {
        let entry = belief.number(knowledge, at.index.0, sub)?;
        bits += entry & 0xFF;
        let mapped = Multiplexer::new((entry >> 16) as u16, (entry >> 8) as u8);
        if mapped.index.0 < 0x20 {
            continue;
        }
        match knowledge.entry(mapped) {
            None if knowledge.is_described() => return Some((MAPPING, "a mapped object does not exist")),
            Some(known) if (0x1A00..=0x1BFF).contains(&at.index.0) && !known.tpdo_mappable => {
                return Some((MAPPING, "a mapped object can't be mapped"));
            }
            _ => {}
        }
    }
    (bits > LONGEST_PDO).then_some((MAPPING, "mapped objects of more than 64 bits"))
}

fn mapping_entry(at: Multiplexer, knowledge: &Knowledge, belief: &Belief) -> Option<Refusal> {
    let count = belief.number(knowledge, at.index.0, 0)?;
    let in_use = (1..=64).contains(&count) && u64::from(at.sub.0) <= count;
    in_use.then_some((MAPPING, "mapping entries change only while sub-index 0 is 0"))
}

/// Two times for one node (abort 0604 0043h).
fn consumer(at: Multiplexer, raw: u64, knowledge: &Knowledge, belief: &Belief) -> Option<Refusal> {
    const DOUBLE: CodeSet = CodeSet::of(&[AbortCode::PARAMETER_INCOMPATIBLE]).or(codes::REFUSED);
    let (node, time) = (raw >> 16 & 0xFF, raw & 0xFFFF);
    if !(1..=127).contains(&node) || time == 0 {
        return None;
    }
    let twice =
        knowledge.entries().iter().filter(|known| known.at.index.0 == 0x1016 && known.at.sub.0 > 0).any(|known| {
            let other = belief.number(knowledge, 0x1016, known.at.sub.0).unwrap_or(0);
            known.at.sub != at.sub && other >> 16 & 0xFF == node && other & 0xFFFF != 0
        });
    twice.then_some((DOUBLE, "the node is watched already"))
}
