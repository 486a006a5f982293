//! Measuring units per revolution (6001h) and total measuring range (6002h).

use super::number;
use super::position::{
    CODE_SEQUENCE, OFFSET, POSITION, RANGE, SCALING, UNITS_PER_REVOLUTION, at_rest, is_near, operate, position_at_rest,
    small_range,
};
use super::preset::preset;
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Reason, Stop, demand, observed};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;

const SINGLE_TURN: Multiplexer = Multiplexer::new(encoder::SINGLE_TURN_RESOLUTION, 0);
const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);

/// The device refuses 6001h = 0 or corrects the value, and still answers in either case.
#[case(id = "406/scaling/zero-units", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [UnitsZeroWedges])]
fn zero_units(bench: &mut Bench<'_>) -> Judged {
    operate(bench, SCALING, 0)?;
    let attempt = bench.download(UNITS_PER_REVOLUTION, &0_u32.to_le_bytes())?;
    for at in [POSITION, DEVICE_TYPE] {
        let alive = bench.upload(at)?;
        bench.check(demand(!alive.is_silent(), || {
            let duty = format!("after 6001h = 0 ({}) the device answers", attempt.outcome);
            Breach::new(at, duty).expected("a response").found(Observation::Silence)
        }))?;
    }
    Ok(())
}

/// A measuring range of less than one revolution is refused, for both objects: 6001h above 6002h, 6002h below 6001h.
/// The old value stays.
#[case(id = "406/scaling/units-above-range", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [UnitsAboveRangeAccepted])]
fn units_above_range(bench: &mut Bench<'_>) -> Judged {
    let range = small_range(bench)?;
    bench.each([(UNITS_PER_REVOLUTION, range + 1), (RANGE, 128)], |bench, (at, value)| {
        let before = bench.read(at)?;
        let attempt = bench.download(at, &value.to_le_bytes())?;
        demand(attempt.abort().is_some(), || {
            let breach = Breach::new(at, format!("{at} = {value}, less than one revolution, is refused"));
            breach.expected("an abort").found(observed(&attempt.outcome)).told(attempt.outcome.to_string())
        })?;
        bench.expect_unchanged(at, &before)
    })
}

/// With scaling on, the position is the position of the sensor multiplied by 6001h, divided by the steps of a
/// revolution (6501h), within the range 6002h.
#[case(id = "406/scaling/proportional", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder], catches = [ScaledPositionStands])]
fn proportional(bench: &mut Bench<'_>) -> Judged {
    small_range(bench)?;
    operate(bench, 0, SCALING)?;
    let steps = u64::from(bench.read_number(SINGLE_TURN)?);
    let offsets = [bench.read_number(OFFSET)?, u32::from(steps == 0)];
    let physical = u64::from(position_at_rest(bench)?);
    operate(bench, SCALING, 0)?;
    // If scaling changes the offset, or the steps of a revolution, the two positions can't be compared.
    if offsets != [0, 0] || bench.read_number(OFFSET)? != 0 {
        let reason = Reason::new("the position has no offset", "6509h = 0", "another one");
        return Err(Stop::NotApplicable(reason));
    }
    bench.each([(256_u32, 4_096_u32), (1_000, 16_000)], |bench, (units, range)| {
        bench.write(UNITS_PER_REVOLUTION, &256_u32.to_le_bytes())?;
        bench.write(RANGE, &range.to_le_bytes())?;
        bench.write(UNITS_PER_REVOLUTION, &units.to_le_bytes())?;
        let position = position_at_rest(bench)?;
        let expected = u32::try_from(physical * u64::from(units) / steps % u64::from(range)).unwrap_or(0);
        let check = demand(is_near(position, expected, range), || {
            let duty = format!(
                "with {units} units and {steps} steps per revolution, {physical} steps are position {expected}"
            );
            let stays = u64::from(position).abs_diff(physical) <= 1;
            let found = if stays { Observation::named("the position without scaling") } else { number(position) };
            Breach::new(POSITION, duty).expected(number(expected)).found(found).told(position.to_string())
        });
        at_rest(bench, check)
    })
}

/// While scaling is on, 6001h and 6002h accept their current values.
#[case(id = "406/scaling/own-values", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder], catches = [ScalingRefused])]
fn own_values(bench: &mut Bench<'_>) -> Judged {
    operate(bench, SCALING, 0)?;
    bench.each([UNITS_PER_REVOLUTION, RANGE], |bench, at| {
        if !bench.can_write(at)? {
            return Ok(());
        }
        let own = bench.read(at)?;
        let attempt = bench.download(at, &own)?.under("with its current value");
        bench.check(attempt.refused(Situation::Confirmed))
    })
}

/// While scaling is on, 6001h accepts a half, a quarter and an eighth of the steps of a revolution, as long as the
/// value does not exceed the measuring range, and reads back as written. Then 6002h accepts a half and a quarter of its
/// range.
#[case(id = "406/scaling/fewer-units", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder], catches = [UnitsFewerRefused, RangeSmallerRefused, ScalingRefused])]
fn fewer_units(bench: &mut Bench<'_>) -> Judged {
    operate(bench, SCALING, 0)?;
    if !bench.can_write(UNITS_PER_REVOLUTION)? || bench.read_number(DEVICE_TYPE)? >> 16 > 2 {
        let reason = Reason::new("the units per revolution of a rotary encoder can be set", "a writable 6001h", "none");
        return Err(Stop::NotApplicable(reason));
    }
    let (steps, range) = (bench.read_number(SINGLE_TURN)?, bench.read_number(RANGE)?);
    let parts = [2, 4, 8].map(|part| steps / part).into_iter().filter(|&units| units >= 16 && units <= range);
    let taken: Vec<u32> = parts.filter(|&units| bench.is_within_limits(UNITS_PER_REVOLUTION, units.into())).collect();
    bench.each(taken, |bench, units| {
        let value = units.to_le_bytes();
        let attempt = bench.download(UNITS_PER_REVOLUTION, &value)?.under("with fewer units than there are steps");
        attempt.refused(Situation::Confirmed)?;
        // Some devices activate the value only when it is stored.
        let now = bench.read_number(UNITS_PER_REVOLUTION)?;
        if now != units {
            bench.note(format!("6001h reads as {now} after {units} was written"));
        }
        Ok(())
    })?;
    smaller_range(bench, range)
}

/// Requires that 6002h accepts a half and a quarter of its range, if these contain a revolution.
fn smaller_range(bench: &mut Bench<'_>, range: u32) -> Judged {
    if !bench.can_write(RANGE)? || !range.is_power_of_two() {
        return Ok(());
    }
    let units = bench.read_number(UNITS_PER_REVOLUTION)?;
    let parts = [2, 4].map(|part| range / part).into_iter().filter(|&part| part >= units.saturating_mul(2));
    let taken: Vec<u32> = parts.filter(|&part| bench.is_within_limits(RANGE, part.into())).collect();
    bench.each(taken, |bench, part| {
        let attempt = bench.download(RANGE, &part.to_le_bytes())?.under("with a part of its current range");
        bench.check(attempt.refused(Situation::Confirmed))
    })
}

/// The device refuses 6002h = 0, or treats it as 2^32: the position accepts any preset.
#[case(id = "406/scaling/zero-range", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, VolatilePreset], touches = [Preset], catches = [RangeZeroStops])]
fn zero_range(bench: &mut Bench<'_>) -> Judged {
    const WANTED: u32 = 0x8000_1234;
    operate(bench, SCALING, 0)?;
    if bench.download(RANGE, &0_u32.to_le_bytes())?.outcome != Outcome::Downloaded {
        return Ok(());
    }
    preset(bench, WANTED)?;
    let position = bench.read_number(POSITION)?;
    bench.check(demand(position.abs_diff(WANTED) <= 2, || {
        let duty = "with 6002h = 0 the position has 32 bits";
        Breach::new(POSITION, duty).expected(number(WANTED)).found(number(position))
    }))
}

/// At the same place of the shaft the positions in both code sequences, without the offset 6509h, add up to the
/// measuring range.
#[case(id = "406/scaling/mirrored", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [CodeSequenceIgnored])]
fn mirrored(bench: &mut Bench<'_>) -> Judged {
    small_range(bench)?;
    bench.write(UNITS_PER_REVOLUTION, &2_048_u32.to_le_bytes())?;
    mirror(bench, 4_096)
}

/// The device observes a measuring range that is no power of two: in both code sequences the position stays below it,
/// and the two positions add up to it.
#[case(id = "406/scaling/range-not-binary", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [WrapAtPowerOfTwo, ScalingOverflow])]
fn not_binary(bench: &mut Bench<'_>) -> Judged {
    const UNITS: u32 = 600;
    const UNITS_IN_RANGE: u32 = 2_400;
    small_range(bench)?;
    bench.write(UNITS_PER_REVOLUTION, &UNITS.to_le_bytes())?;
    bench.write(RANGE, &UNITS_IN_RANGE.to_le_bytes())?;
    mirror(bench, UNITS_IN_RANGE)
}

fn mirror(bench: &mut Bench<'_>, range: u32) -> Judged {
    let mut seen = [0_i64; 2];
    for (slot, (with, without)) in seen.iter_mut().zip([(SCALING, CODE_SEQUENCE), (SCALING | CODE_SEQUENCE, 0)]) {
        operate(bench, with, without)?;
        let position = position_at_rest(bench)?;
        demand(position < range, || {
            let breach = Breach::new(POSITION, "6004h stays below 6002h").expected(format!("below {range}"));
            breach.found(number(position))
        })?;
        let offset = bench.read_number(OFFSET)? as i32;
        *slot = (i64::from(position) - i64::from(offset)).rem_euclid(range.into());
    }
    let [up, down] = seen;
    let sum = u32::try_from((up + down).rem_euclid(range.into())).unwrap_or(u32::MAX);
    let check = demand(is_near(sum, 0, range), || {
        let duty = format!("the positions in both code sequences add up to 6002h = {range}");
        let expected = (i64::from(range) - up).rem_euclid(range.into());
        let breach = Breach::new(POSITION, duty).expected(format!("{up} and {expected}"));
        breach.found(Observation::named("positions that do not add up to 6002h")).told(format!("{up} and {down}"))
    });
    at_rest(bench, check)
}
