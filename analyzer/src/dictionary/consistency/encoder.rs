//! Encoders (CiA 406): type, resolution and scaling agree.

use super::Check;
use crate::dictionary::names::ENCODER_PROFILE;
use crate::dictionary::rules::standard as rules;
use crate::identity::Multiplexer;
use crate::object;

/// The encoder types of CiA 406 in the high word of 1000h.
const SINGLE_TURN: u64 = 1;
const MULTI_TURN: u64 = 2;

pub(super) fn check(check: &mut Check<'_>) {
    if check.description.device_profile() != Some(ENCODER_PROFILE) {
        return;
    }
    let kind = check.default(object::DEVICE_TYPE, 0).map(|device_type| device_type >> 16);
    // Of a linear encoder 6501h is the measuring step, which says nothing about its range.
    if !matches!(kind, Some(SINGLE_TURN | MULTI_TURN)) {
        return;
    }
    let (steps, revolutions) = (check.default(0x6501, 0), check.default(0x6502, 0));
    if let Some(number) = revolutions.filter(|&number| (number > 1) != (kind == Some(MULTI_TURN))) {
        let expected = match kind {
            Some(MULTI_TURN) => "more than one revolution of a multi-turn encoder",
            _ => "one revolution of a single-turn encoder",
        };
        check.report(Multiplexer::new(0x6502, 0), "DefaultValue", &rules::REVOLUTIONS, expected, &number.to_string());
    }
    let Some(steps) = steps else { return };
    if let Some(units) = check.default(0x6001, 0).filter(|&units| units > steps) {
        let expected = "measuring units up to the steps of a revolution (6501h)";
        check.report(Multiplexer::new(0x6001, 0), "DefaultValue", &rules::UNITS, expected, &units.to_string());
    }
    let Some(positions) = revolutions.and_then(|revolutions| steps.checked_mul(revolutions)) else { return };
    measuring_range(check, positions);
}

fn measuring_range(check: &mut Check<'_>, positions: u64) {
    let at = Multiplexer::new(0x6002, 0);
    if let Some(range) = check.default(at.index.0, at.sub.0).filter(|&range| range > positions) {
        let expected = "a measuring range up to the steps of all revolutions (6501h times 6502h)";
        check.report(at, "DefaultValue", &rules::MEASURING_RANGE, expected, &format!("{range} of {positions}"));
    }
}
