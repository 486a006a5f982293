//! The position of an encoder (CiA 406): whatever scaling was accepted, it lies in the measuring range.

use super::expected_values::ExpectedValues;
use crate::Knowledge;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object::encoder;

const POSITION: Multiplexer = Multiplexer::new(encoder::POSITION_VALUE, 0);
/// Bit of 6000h: 6001h and 6002h scale the position.
const SCALING: u64 = 1 << 2;

/// What was expected instead of that value, and what came, if the object is the position and lies outside of its range.
pub(super) fn misplaced(
    value: &[u8],
    entry: usize,
    knowledge: &Knowledge,
    expected_values: &ExpectedValues,
) -> Option<(String, String)> {
    let acts = |index| !knowledge.services.acts_when_stored.contains(&Multiplexer::new(index, 0));
    if knowledge.entries().get(entry)?.at != POSITION || value.len() > 4 || !acts(encoder::TOTAL_MEASURING_RANGE) {
        return None;
    }
    let position = value.iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte));
    let scaled = expected_values.number(knowledge, encoder::OPERATING_PARAMETERS, 0)? & SCALING != 0;
    // 0 stands for 2^32.
    let range =
        expected_values.number(knowledge, encoder::TOTAL_MEASURING_RANGE, 0).filter(|&range| scaled && range > 0)?;
    let wrong = position >= range;
    wrong.then(|| (format!("6004h from 0 to {} (6002h - 1)", range - 1), format!("{position}")))
}
