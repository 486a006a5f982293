//! Preset (6003h) and offset (6509h). After each case the zero point is where it was before.

use super::number;
use super::position::{OFFSET, POSITION, PRESET, at_rest, is_near, position_at_rest};
use super::zero_point::positions;
use crate::bench::Bench;
use crate::bench::objects::EVENT_TIMER;
use crate::case;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::client::Outcome;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{Duration, Record};

const SAVE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
const TPDO: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 1);
const TPDO_1: Subject = Subject::Pdo { transmit: true, number: 1 };
const FIRST_ENTRY: Multiplexer = Multiplexer::new(object::TPDO_MAPPING_PARAMETER, 1);

/// Number of positions in the encoder's current configuration, at most 2^32 - 1.
pub(super) fn range_now(bench: &mut Bench<'_>) -> Result<u32, Stop> {
    Ok(u32::try_from(positions(bench)?).unwrap_or(u32::MAX))
}

/// Sets another position of a shaft at rest, and returns the earlier one. After the case the zero point is put back by
/// the reset that reverses unstored changes, and if that does not help, by [`Bench::put_back_zero_point`].
pub(super) fn preset(bench: &mut Bench<'_>, wanted: u32) -> Result<u32, Stop> {
    let before = position_at_rest(bench)?;
    bench.download(PRESET, &wanted.to_le_bytes())?.expect_confirmation()?;
    Ok(before)
}

/// A position far from the current one.
fn elsewhere(bench: &mut Bench<'_>) -> Result<(u32, u32), Stop> {
    let range = range_now(bench)?;
    let position = position_at_rest(bench)?;
    Ok(((position.wrapping_add(range / 3)) % range, range))
}

/// 6509h is the shift of the position by the preset: 6004h is the position without preset plus 6509h.
#[case(id = "406/preset/offset", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, VolatilePreset], touches = [Preset], catches = [OffsetSignWrong, OffsetNotReported])]
fn offset(bench: &mut Bench<'_>) -> Judged {
    let (wanted, range) = elsewhere(bench)?;
    let old = i64::from(bench.read_number(OFFSET)? as i32);
    let before = preset(bench, wanted)?;
    let shift = i64::from(wanted) - i64::from(before) + old;
    let expected = shift.rem_euclid(range.into()) as u32;
    let offset = bench.read_number(OFFSET)? as i32;
    let found = i64::from(offset).rem_euclid(range.into()) as u32;
    let check = demand(is_near(found, expected, range), || {
        let duty = "6509h is the shift of the position by the preset";
        let breach = Breach::new(OFFSET, duty).expected(format!("{shift}, modulo {range}"));
        breach.found(Observation::Value(offset.to_le_bytes().to_vec())).told(format!("{offset}"))
    });
    at_rest(bench, check)
}

/// 6004h shows the preset as soon as it is confirmed, without a jump in between.
#[case(id = "406/preset/at-once", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, VolatilePreset], touches = [Preset], catches = [PresetGlitch])]
fn at_once(bench: &mut Bench<'_>) -> Judged {
    let (wanted, range) = elsewhere(bench)?;
    preset(bench, wanted)?;
    for _ in 0..10 {
        let position = bench.read_number(POSITION)?;
        let check = demand(is_near(position, wanted, range), || {
            let breach = Breach::new(POSITION, "after a preset 6004h has its value immediately");
            breach.expected(number(wanted)).found(number(position))
        });
        at_rest(bench, check)?;
    }
    Ok(())
}

/// A TPDO that carries the position also shows the preset, beginning with the first TPDO after it.
#[case(id = "406/preset/tpdo", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, EventTimer, VolatilePreset], touches = [Preset], catches = [TpdoPositionWithoutPreset, TpdoPositionLate])]
fn tpdo(bench: &mut Bench<'_>) -> Judged {
    const PERIOD_MS: u16 = 100;
    if bench.read_number(FIRST_ENTRY)? != 0x6004_0020 {
        let reason = Reason::new("TPDO 1 begins with the position", "1A00h:01 = 60040020h", "another mapping");
        return Err(Stop::NotApplicable(reason));
    }
    let (wanted, range) = elsewhere(bench)?;
    let cob_id = (CobId(bench.read_number(TPDO)?).can_id() & 0x7FF) as u16;
    bench.write(EVENT_TIMER, &PERIOD_MS.to_le_bytes())?;
    bench.command(Command::START)?;
    bench.listen(Duration::from_millis(250))?;
    preset(bench, wanted)?;
    bench.drain()?;
    let heard: Vec<Record> = bench.listen(Duration::from_millis(150))?;
    let first = heard.iter().find(|record| record.frame.cob_id() == Some(cob_id));
    let Some(first) = first else {
        let reason = Reason::new("TPDO 1 is sent", "one every 100 ms", "none in 150 ms");
        return Err(Stop::Inconclusive(reason));
    };
    let position = crate::bench::sdo::number(first.data());
    let check = demand(is_near(position, wanted, range), || {
        let breach = Breach::new(TPDO_1, "the first TPDO after a preset carries the preset");
        breach.expected(number(wanted)).found(number(position))
    });
    at_rest(bench, check)
}

/// A preset that was not stored is lost at reset node.
///
/// Some devices store a preset immediately, as their manuals say.
#[case(id = "406/preset/volatile", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, VolatilePreset], touches = [Preset], catches = [PresetPersists])]
fn volatile(bench: &mut Bench<'_>) -> Judged {
    let (wanted, range) = elsewhere(bench)?;
    let before = preset(bench, wanted)?;
    bench.reset(Command::RESET_NODE)?;
    let position = position_at_rest(bench)?;
    let check = demand(is_near(position, before, range), || {
        let duty = "a preset that was not stored is lost at reset node";
        Breach::new(POSITION, duty).expected(number(before)).found(number(position))
    });
    at_rest(bench, check)
}

/// A preset that 1010h stored is restored after reset node.
#[case(id = "406/preset/stored", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Store], touches = [Nvm, Preset], catches = [PresetLostAfterSave])]
fn stored(bench: &mut Bench<'_>) -> Judged {
    let (wanted, range) = elsewhere(bench)?;
    preset(bench, wanted)?;
    save(bench)?;
    bench.reset(Command::RESET_NODE)?;
    let position = position_at_rest(bench)?;
    let check = demand(is_near(position, wanted, range), || {
        let duty = "a stored preset is restored after reset node";
        Breach::new(POSITION, duty).expected(number(wanted)).found(number(position))
    });
    at_rest(bench, check)
}

fn save(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let attempt = bench.download(SAVE, b"save")?;
    bench.listen(Duration::from_millis(100))?;
    match attempt.outcome {
        Outcome::Downloaded => Ok(()),
        _ => attempt.expect_confirmation().or_inconclusive(),
    }
}
