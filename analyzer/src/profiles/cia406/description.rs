//! Checks of encoder descriptions: type, resolution and scaling must agree.

use super::{description_rules as rules, objects};
use crate::dictionary::consistency::{Check, OfProfile};
use crate::dictionary::{Access, Rule, Setting};
use crate::identity::Multiplexer;
use crate::object;

/// The encoder types of CiA 406 in the high word of 1000h.
const SINGLE_TURN: u64 = 1;
const MULTI_TURN: u64 = 2;

inventory::submit! { OfProfile { profile: super::NUMBER, check } }

fn check(check: &mut Check<'_>) {
    let kind = check.default(object::DEVICE_TYPE, 0).map(|device_type| device_type >> 16);
    // For a linear encoder 6501h is the measuring step, which says nothing about its range.
    if !matches!(kind, Some(SINGLE_TURN | MULTI_TURN)) {
        return;
    }
    let (steps, revolutions) =
        (check.default(objects::SINGLE_TURN_RESOLUTION, 0), check.default(objects::NUMBER_OF_REVOLUTIONS, 0));
    if let Some(number) = revolutions.filter(|&number| (number > 1) != (kind == Some(MULTI_TURN))) {
        let expected = match kind {
            Some(MULTI_TURN) => "more than one revolution of a multi-turn encoder",
            _ => "one revolution of a single-turn encoder",
        };
        check.report(
            Multiplexer::new(objects::NUMBER_OF_REVOLUTIONS, 0),
            "DefaultValue",
            &rules::REVOLUTIONS,
            expected,
            &number.to_string(),
        );
    }
    let positions = steps.zip(revolutions).and_then(|(steps, revolutions)| steps.checked_mul(revolutions));
    // A description covers a family of encoders: the default values of 6501h and 6502h, read from one encoder, limit no
    // other encoder.
    let is_of_all =
        [objects::SINGLE_TURN_RESOLUTION, objects::NUMBER_OF_REVOLUTIONS].map(|index| is_const(check, index));
    if let Some(most) = steps {
        let expected = "measuring units up to the steps of a revolution (6501h)";
        at_most(check, objects::UNITS_PER_REVOLUTION, Most { most, is_of_all: is_of_all[0] }, &rules::UNITS, expected);
    }
    if let Some(most) = positions {
        let expected = "a measuring range up to the steps of all revolutions (6501h times 6502h)";
        let most = Most { most, is_of_all: is_of_all == [true; 2] };
        at_most(check, objects::TOTAL_MEASURING_RANGE, most, &rules::MEASURING_RANGE, expected);
    }
    // Scaled values go up to the measuring range, by default the device's own resolution.
    if let Some(most) =
        check.default(objects::TOTAL_MEASURING_RANGE, 0).or(positions).and_then(|range| range.checked_sub(1))
    {
        let most = Most { most, is_of_all: is_const(check, objects::TOTAL_MEASURING_RANGE) };
        at_most(
            check,
            objects::PRESET_VALUE,
            most,
            &rules::PRESET,
            "a preset value below the total measuring range (6002h)",
        );
    }
}

/// An upper bound.
#[derive(Clone, Copy)]
struct Most {
    most: u64,
    /// Whether the bound holds for all devices of the description, with any settings.
    is_of_all: bool,
}

fn is_const(check: &Check<'_>, index: u16) -> bool {
    let entry = check.description.dictionary.entry(Multiplexer::new(index, 0));
    entry.is_ok_and(|entry| entry.access == Access::Const)
}

/// Checks that the default does not exceed the bound; if the bound holds for all devices, also the highest allowed
/// value.
fn at_most(check: &mut Check<'_>, index: u16, bound: Most, rule: &'static Rule, expected: &'static str) {
    let at = Multiplexer::new(index, 0);
    let Most { most, is_of_all } = bound;
    let limit = high_limit(check, at).filter(|_| is_of_all);
    for (field, value) in [("DefaultValue", check.default(index, 0)), ("HighLimit", limit)] {
        if let Some(value) = value.filter(|&value| value > most) {
            check.report(at, field, rule, expected, &format!("{value}, above the maximum {most}"));
        }
    }
}

/// The high limit, if it is below the maximum of the data type.
fn high_limit(check: &Check<'_>, at: Multiplexer) -> Option<u64> {
    let entry = check.description.dictionary.entry(at).ok()?;
    let limit = u64::try_from(entry.high_limit.as_ref().and_then(Setting::fixed)?.as_number()?).ok()?;
    let bits = entry.data_type.bits()?;
    let is_of_type = |unused: u32| limit == u64::MAX >> (64 - bits.min(64) + unused);
    // The limit may also be the maximum of the type with the other sign.
    (!is_of_type(0) && !is_of_type(1)).then_some(limit)
}
