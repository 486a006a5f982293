//! A model of the device's RPDOs: the frames of the fuzzer that write objects, and the values that they write.

use super::expected_values::ExpectedValues;
use super::nmt::Slave;
use super::{Served, pdo_rules};
use crate::Knowledge;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_traces::{Frame, Timestamp};

/// Applies a data frame of the fuzzer that belongs to no other service. `writing`: an object is being written, so that
/// the configuration may differ from the expected configuration.
pub(super) fn received(
    now: Timestamp,
    frame: &Frame,
    can_id: u16,
    writing: bool,
    nmt: &Slave,
    expected_values: &mut ExpectedValues,
    knowledge: &Knowledge,
) {
    let mut own = None;
    for &index in &knowledge.rpdos {
        match expected_values.number(knowledge, index, 1).map(|raw| CobId(raw as u32)) {
            Some(cob_id) if !cob_id.is_valid() || cob_id.can_id() != u32::from(can_id) => {}
            // The frame may belong to any of several RPDOs, or to none.
            Some(_) if own.is_none() => own = Some(index),
            _ => return expected_values.forget_outputs(),
        }
    }
    let Some(index) = own else {
        if writing || !knowledge.is_described() {
            expected_values.forget_outputs();
        }
        return;
    };
    match nmt.serves_pdo(now) {
        Served::No if !writing => {}
        Served::Yes if !writing => {
            expected_values.forget_outputs();
            write(index, frame, expected_values, knowledge);
        }
        _ => expected_values.forget_outputs(),
    }
}

/// Records the values that an RPDO writes at once into its mapped objects, as far as they are certain.
fn write(index: u16, frame: &Frame, expected_values: &mut ExpectedValues, knowledge: &Knowledge) {
    let event_driven = expected_values.number(knowledge, index, 2).is_some_and(|kind| kind >= 254);
    let mapping = index + 0x200;
    let Some(count @ 1..=8) = expected_values.number(knowledge, mapping, 0) else { return };
    let entries: Option<Vec<u64>> =
        (1..=count as u8).map(|sub| expected_values.number(knowledge, mapping, sub)).collect();
    let Some(entries) = entries.filter(|_| event_driven) else { return };
    let bits: u64 = entries.iter().map(|entry| entry & 0xFF).sum();
    if bits != frame.len() as u64 * 8 {
        return;
    }
    let data = u64::from_le_bytes(frame.bytes());
    let mut offset = 0;
    for entry in entries {
        let (at, len) = (Multiplexer::new((entry >> 16) as u16, (entry >> 8) as u8), entry & 0xFF);
        let value = data >> offset & u64::MAX.checked_shr(64 - len as u32).unwrap_or(0);
        offset += len;
        let Some(position) = knowledge.position(at) else { continue };
        let known = knowledge.entries().get(position);
        let taken = known.is_some_and(|known| {
            known.writable && known.size.is_some_and(|size| size as u64 * 8 == len) && known.in_limits(value)
        });
        if taken && pdo_rules::refusal(at, value, knowledge, expected_values).is_none() {
            expected_values.read(knowledge, position, value);
        }
    }
}
