//! Objects with the same content in different forms: resolutions and ranges (6501h, 6502h, 650Ah), positions of
//! different width (6004h, 6008h), and the position by SDO and by PDO.

use super::number;
use super::position::{
    OFFSET, POSITION, PRESET, RANGE, UNITS_PER_REVOLUTION, at_rest, is_near, position_at_rest, shorter, small_range,
};
use super::preset::preset;
use super::speed::Course;
use crate::bench::Bench;
use crate::bench::pdo::TPDO;
use crate::case;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Duration;

const SINGLE_TURN: Multiplexer = Multiplexer::new(encoder::SINGLE_TURN_RESOLUTION, 0);
const REVOLUTIONS: Multiplexer = Multiplexer::new(encoder::NUMBER_OF_REVOLUTIONS, 0);
const LOWEST: Multiplexer = Multiplexer::new(encoder::MODULE_IDENTIFICATION, 2);
const HIGHEST: Multiplexer = Multiplexer::new(encoder::MODULE_IDENTIFICATION, 3);
const TPDO_2: Subject = Subject::Pdo { transmit: true, number: 2 };
const HIGH_PRECISION: Multiplexer = Multiplexer::new(encoder::HIGH_PRECISION_POSITION, 0);

/// If 650Ah holds the lowest and the highest position, the number of positions in that range is 6501h multiplied by
/// 6502h.
///
/// 650Ah is signed: a highest position of 7FFF FFFFh represents every larger range.
#[case(id = "406/resolution/consistent", clause = "CiA 406", confidence = Unknown, level = Must, needs = super::needs[Encoder],
       catches = [RevolutionsZero, HighestPositionWrong])]
fn resolution(bench: &mut Bench<'_>) -> Judged {
    if !bench.has(LOWEST)? || !bench.has(HIGHEST)? {
        let reason = Reason::new("the encoder names its lowest and highest position", "650Ah:02 and 03", "none");
        return Err(Stop::NotApplicable(reason));
    }
    let (low, high) = (bench.read_number(LOWEST)? as i32, bench.read_number(HIGHEST)? as i32);
    let steps = u64::from(bench.read_number(SINGLE_TURN)?) * u64::from(bench.read_number(REVOLUTIONS)?);
    if high == i32::MAX {
        return bench.check(demand(steps > u64::from(i32::MAX as u32), || {
            let duty = "a highest position of 7FFFFFFFh represents a larger range";
            Breach::new(HIGHEST, duty).expected("6501h * 6502h of 2147483648 or more").found(number(steps))
        }));
    }
    if high == 0 && low == 0 {
        return Err(Stop::NotApplicable(Reason::new("650Ah names a range", "a highest position", "0 to 0")));
    }
    let named = i64::from(high) - i64::from(low) + 1;
    bench.check(demand(i64::try_from(steps).is_ok_and(|steps| steps == named), || {
        let duty = "the number of positions from 650Ah:02 to 650Ah:03 is 6501h * 6502h";
        let breach = Breach::new(HIGHEST, duty).expected(number(steps));
        breach.found(Observation::Value(high.to_le_bytes().to_vec())).told(named.to_string())
    }))
}

/// The high-precision position 6008h shows the same place as 6004h, in the same units or multiplied by a power of two.
#[case(id = "406/position/high-precision", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, HighPrecision, VolatilePreset], touches = [Preset],
       catches = [HighPrecisionWithoutPreset])]
fn high_precision(bench: &mut Bench<'_>) -> Judged {
    let range = small_range(bench)?;
    let before = position_at_rest(bench)?;
    preset(bench, (before + range / 3) % range)?;
    let position = position_at_rest(bench)?;
    let bytes = bench.upload(HIGH_PRECISION)?.value()?;
    let wide = bytes.iter().take(8).rev().fold(0_u64, |value, &byte| value << 8 | u64::from(byte));
    let fits = |shift: u32| u32::try_from(wide >> shift).is_ok_and(|found| is_near(found, position, range));
    let check = demand((0..=32).any(fits), || {
        let duty = "6008h shows the same place as 6004h";
        let breach = Breach::new(HIGH_PRECISION, duty);
        breach.expected(format!("{position}, or that times a power of two")).found(Observation::Value(bytes.clone()))
    });
    at_rest(bench, check)
}

/// If the second TPDO is synchronous as delivered and carries the position, it follows SYNC with the current position.
#[case(id = "406/tpdo/second-synchronous", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Sync], catches = [SecondTpdoMissing])]
fn second_synchronous(bench: &mut Bench<'_>) -> Judged {
    let second = TPDO.numbered(2);
    let unlike = |actual: String| {
        let duty = "TPDO 2 is synchronous and carries the position";
        Stop::NotApplicable(Reason::new(duty, "transmission type 1, and 6004h as the first object", actual))
    };
    if !bench.has(second.parameter(2))? || !bench.has(second.entry(1))? {
        return Err(unlike("there is no TPDO 2".to_owned()));
    }
    let (kind, entry) = (bench.read_number(second.parameter(2))?, bench.read_number(second.entry(1))?);
    let cob_id = bench.pdo_cob_id(second)?;
    if kind != 1 || entry != 0x6004_0020 || !cob_id.is_valid() {
        return Err(unlike(format!("type {kind}, mapping {entry:08X}h, COB-ID {cob_id}")));
    }
    let can_id = (cob_id.can_id() & 0x7FF) as u16;
    let sync = bench.sync_id()?;
    bench.command(Command::START)?;
    bench.listen(Duration::from_millis(100))?;
    let position = position_at_rest(bench)?;
    bench.drain()?;
    bench.send_bytes(sync, &[])?;
    let span = bench.shortly();
    let heard = bench.frames_of(can_id, span)?;
    let Some(first) = heard.first() else {
        let breach = Breach::new(TPDO_2, format!("TPDO 2 follows SYNC within {span}"));
        return bench.check(Err(Box::new(breach.expected("a TPDO").found(Observation::Silence))));
    };
    let found = crate::bench::sdo::number(first.data());
    let check = demand(is_near(found, position, u32::MAX), || {
        let breach = Breach::new(TPDO_2, "TPDO 2 carries the current position");
        breach.expected(number(position)).found(number(found))
    });
    at_rest(bench, check)
}

/// When the scaling changes after a preset, the position stays inside the new range, and 6509h changes with it: the
/// position without offset is that of the shaft. The case notes whether the preset survives the change. The preset lies
/// in the upper half of the range, which is no part of the new range.
#[case(id = "406/preset/scaling-changed", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, VolatilePreset], touches = [Preset], catches = [ScalingIgnored])]
fn scaling_changed(bench: &mut Bench<'_>) -> Judged {
    let range = small_range(bench)?;
    let before = position_at_rest(bench)?;
    let shaft = without_offset(bench, before, range)?;
    let upper = range / 8;
    preset(bench, if is_near(before, 6 * upper, range) { 5 * upper } else { 6 * upper })?;
    let set = position_at_rest(bench)?;
    bench.write(UNITS_PER_REVOLUTION, &128_u32.to_le_bytes())?;
    bench.write(RANGE, &(range / 2).to_le_bytes())?;
    let position = position_at_rest(bench)?;
    let offset = bench.read_number(OFFSET)? as i32;
    bench.note(format!("preset to {set}; with half the range the position is {position}, the offset {offset}"));
    demand(position < range / 2, || {
        let breach = Breach::new(POSITION, "the position lies within a new range");
        breach.expected(format!("below {}", range / 2)).found(number(position))
    })?;
    let found = without_offset(bench, position, range / 2)?;
    let check = demand(is_near(found, shaft / 2, range / 2), || {
        let duty = "6004h without 6509h is the place of the shaft in the new units";
        let breach = Breach::new(OFFSET, duty).expected(number(shaft / 2));
        breach.found(number(found)).told(format!("{position} - {offset}"))
    });
    at_rest(bench, check)
}

/// The position without the offset 6509h, within the range.
fn without_offset(bench: &mut Bench<'_>, position: u32, range: u32) -> Result<u32, Stop> {
    let offset = i64::from(bench.read_number(OFFSET)? as i32);
    Ok((i64::from(position) - offset).rem_euclid(range.into()) as u32)
}

/// A preset takes effect while the shaft turns, without a jump larger than the motion, and the position then continues
/// to count.
#[case(id = "406/preset/moving", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, VolatilePreset, TurningShaft], touches = [Preset], catches = [PresetGlitch, PresetStopsCounting])]
fn moving(bench: &mut Bench<'_>) -> Judged {
    if super::needs::keeps_presets(bench) {
        let actual = "it stores presets immediately, as its manual says";
        let reason = Reason::new("a reset reverts the preset", "an encoder that does not store presets", actual);
        return Err(Stop::NotApplicable(reason));
    }
    // In 50 ms the position counts by at least two.
    let course = Course::measure(bench)?.at_least(40.0)?;
    let range = super::preset::range_now(bench)?;
    let per_ms = (course.speed.abs() + course.error) / 1_000.0;
    let wanted = range / 2;
    bench.download(PRESET, &wanted.to_le_bytes())?.expect_confirmation()?;
    let set = bench.now();
    let mut positions = Vec::new();
    for _ in 0..20 {
        let position = bench.read_number(POSITION)?;
        positions.push(position);
        // The maximum movement of the shaft since the preset, with the time of a reading and a tenth more.
        let most = per_ms * (bench.now().since(set).as_millis() + 5.0) * 1.1 + 4.0;
        let away = shorter(wanted, position, range).unsigned_abs() as f64;
        if away > most {
            let duty = "after a preset the position differs by no more than the motion since";
            let breach = Breach::new(POSITION, duty).expected(format!("{wanted} ± {most:.0}")).found(number(position));
            bench.check(Err(Box::new(breach.explained_by_motion())))?;
            break;
        }
        bench.listen(Duration::from_millis(5))?;
    }
    let stands = positions.windows(10).any(|ten| ten.iter().all(|position| Some(position) == ten.first()));
    bench.check(demand(!stands, || {
        let breach = Breach::new(POSITION, "after a preset the position continues to count");
        let breach = breach.expected("another position in 50 ms").found(Observation::named("always the same"));
        breach.explained_by_motion()
    }))
}
