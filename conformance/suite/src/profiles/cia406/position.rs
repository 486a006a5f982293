//! Position, scaling, code sequence and preset (6000h to 6004h, 6500h).

use super::number;
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Check, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_traces::Duration;

pub(super) const OPERATING_PARAMETERS: Multiplexer = Multiplexer::new(encoder::OPERATING_PARAMETERS, 0);
pub(super) const UNITS_PER_REVOLUTION: Multiplexer = Multiplexer::new(encoder::UNITS_PER_REVOLUTION, 0);
pub(super) const RANGE: Multiplexer = Multiplexer::new(encoder::TOTAL_MEASURING_RANGE, 0);
pub(super) const PRESET: Multiplexer = Multiplexer::new(encoder::PRESET_VALUE, 0);
pub(super) const POSITION: Multiplexer = Multiplexer::new(encoder::POSITION_VALUE, 0);
pub(super) const OFFSET: Multiplexer = Multiplexer::new(encoder::OFFSET_VALUE, 0);
pub(super) const OPERATING_STATUS: Multiplexer = Multiplexer::new(encoder::OPERATING_STATUS, 0);
pub(super) const CODE_SEQUENCE: u32 = 1;
pub(super) const SCALING: u32 = 4;

/// Maximum difference of a position at rest, in units: the last bit of the sensor trembles.
pub(super) const TREMBLE: u32 = 2;

/// The position of a shaft at rest.
pub(super) fn position_at_rest(bench: &mut Bench<'_>) -> Result<u32, Stop> {
    /// The times between the readings: unequal, so that a regular vibration does not look like rest.
    const PAUSES: [u64; 4] = [7, 17, 5, 21];
    still(bench, &PAUSES.map(Duration::from_millis))
}

/// The last of several positions, between which these times pass; inconclusive if they are not the same.
fn still(bench: &mut Bench<'_>, pauses: &[Duration]) -> Result<u32, Stop> {
    let first = bench.read_number(POSITION)?;
    let (mut least, mut most, mut last) = (first, first, first);
    let mut whole = Duration::ZERO;
    for &pause in pauses {
        bench.listen(pause)?;
        whole = whole + pause;
        last = bench.read_number(POSITION)?;
        (least, most) = (least.min(last), most.max(last));
        demand(most - least <= TREMBLE, || {
            let breach = Breach::new(POSITION, format!("the shaft is at rest for {whole}"));
            breach.expected(number(first)).found(number(last)).explained_by_motion()
        })
        .or_inconclusive()?;
    }
    Ok(last)
}

/// Judges a comparison of positions, which holds only for a shaft at rest. A failure counts only if the shaft does not
/// move in the time that the case has taken: a slow shaft seems to be at rest for a moment, and is elsewhere after a
/// reset.
pub(super) fn at_rest(bench: &mut Bench<'_>, check: Check) -> Judged {
    const READINGS: u64 = 20;
    if check.is_err() {
        // What the device itself does wrong after a preset must be over.
        bench.listen(Duration::from_millis(200))?;
        let pause = Duration(bench.time_of_case().nanos() / READINGS).max(Duration::from_millis(5));
        still(bench, &[pause; READINGS as usize])?;
    }
    bench.check(check.map_err(|breach| Box::new(breach.explained_by_motion())))
}

/// Sets the bits `with` of 6000h, and clears the bits `without`.
pub(super) fn operate(bench: &mut Bench<'_>, with: u32, without: u32) -> Result<u32, Stop> {
    let value = bench.read_number(OPERATING_PARAMETERS)? & !without | with;
    let value = u16::try_from(value).unwrap_or(u16::MAX);
    bench.write(OPERATING_PARAMETERS, &value.to_le_bytes())?;
    Ok(u32::from(value))
}

/// Sets a range that every encoder supports: 256 units per revolution, 16 revolutions.
pub(super) fn small_range(bench: &mut Bench<'_>) -> Result<u32, Stop> {
    const RANGE_UNITS: u32 = 4_096;
    needs_revolutions(bench)?;
    operate(bench, SCALING, CODE_SEQUENCE)?;
    bench.write(UNITS_PER_REVOLUTION, &256_u32.to_le_bytes())?;
    bench.write(RANGE, &RANGE_UNITS.to_le_bytes())?;
    Ok(RANGE_UNITS)
}

pub(super) fn is_near(a: u32, b: u32, range: u32) -> bool {
    let difference = a.abs_diff(b);
    // Positions that are further apart than the range are not neighbours across its end.
    difference <= TREMBLE || difference <= range && range - difference <= TREMBLE
}

/// The shorter way from one position to another.
pub(super) fn shorter(from: u32, to: u32, range: u32) -> i64 {
    let range = i64::from(range);
    let way = (i64::from(to) - i64::from(from)).rem_euclid(range);
    if way > range / 2 { way - range } else { way }
}

/// Whether the high word of 1000h names a linear encoder, absolute (8) or cyclic (9).
pub(super) fn is_linear(bench: &mut Bench<'_>) -> Result<bool, Stop> {
    Ok(matches!(bench.read_number(Multiplexer::new(object::DEVICE_TYPE, 0))? >> 16, 8 | 9))
}

/// Linear encoders have no revolutions, and no configurable units per revolution.
fn needs_revolutions(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if is_linear(bench)? {
        let reason = Reason::new("the encoder is rotary", "another high word of 1000h", "8 or 9: linear");
        return Err(Stop::NotApplicable(reason));
    }
    Ok(())
}

/// Writing a preset at rest sets the position to its value.
#[case(id = "406/preset/position", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, VolatilePreset], touches = [Preset], catches = [PresetIgnored])]
fn preset(bench: &mut Bench<'_>) -> Judged {
    let range = small_range(bench)?;
    let wanted = (position_at_rest(bench)? + 1_000) % range;
    super::preset::preset(bench, wanted)?;
    let position = bench.read_number(POSITION)?;
    let check = demand(is_near(position, wanted, range), || {
        let breach = Breach::new(POSITION, "after a preset 6004h has its value");
        breach.expected(number(wanted)).found(number(position))
    });
    at_rest(bench, check)
}

/// A preset outside the measuring range is refused.
#[case(id = "406/preset/out-of-range", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, VolatilePreset], touches = [Preset], catches = [PresetOutOfRangeAccepted])]
fn preset_out_of_range(bench: &mut Bench<'_>) -> Judged {
    let range = small_range(bench)?;
    let attempt = bench.download(PRESET, &range.to_le_bytes())?;
    bench.check(attempt.refused(Situation::InvalidValue))
}

/// The code sequence, bit 0 of 6000h, reverses the direction in which the position counts.
#[case(id = "406/operating-parameters/code-sequence", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [CodeSequenceIgnored])]
fn code_sequence(bench: &mut Bench<'_>) -> Judged {
    let range = small_range(bench)?;
    let before = position_at_rest(bench)?;
    // Above its range a position has no mirror image.
    expect_below(before, range)?;
    operate(bench, CODE_SEQUENCE, 0)?;
    let after = position_at_rest(bench)?;
    // At 0 and in the middle both directions show the same.
    if is_near(before, (range - before) % range, range) {
        let reason = Reason::new(
            "the shaft is at a place where the two directions give different positions",
            "neither 0 nor half the range",
            format!("{before}"),
        );
        return Err(Stop::NotApplicable(reason));
    }
    let check = demand(!is_near(before, after, range), || {
        let duty = "with reversed code sequence the same place of the shaft has another position";
        Breach::new(POSITION, duty).expected(format!("not {before}")).found(number(after))
    });
    at_rest(bench, check)
}

fn expect_below(position: u32, range: u32) -> Check {
    demand(position < range, || {
        let breach = Breach::new(POSITION, "with scaling on 6004h stays below 6002h");
        breach.expected(format!("below {range}")).found(number(position))
    })
}

/// With scaling on, the position stays below the measuring range 6002h and counts 6001h units per revolution.
#[case(id = "406/scaling/range", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [ScalingIgnored])]
fn scaling(bench: &mut Bench<'_>) -> Judged {
    let range = small_range(bench)?;
    let position = position_at_rest(bench)?;
    bench.check(expect_below(position, range))?;
    // An offset from a stored preset would shift the following positions.
    if bench.read_number(OFFSET)? != 0 {
        return Ok(());
    }
    // With half the units per revolution the position is halved; the range then spans twice the revolutions, so the
    // position is known only within half of it.
    bench.write(UNITS_PER_REVOLUTION, &128_u32.to_le_bytes())?;
    let half = position_at_rest(bench)?;
    let check = demand(is_near(half % (range / 2), position / 2, range / 2), || {
        let expected = format!("{} or {}", position / 2, position / 2 + range / 2);
        let breach = Breach::new(POSITION, "half the units per revolution give half the position");
        breach.expected(expected).found(number(half))
    });
    at_rest(bench, check)
}

/// The operating status 6500h shows the settings of 6000h.
#[case(id = "406/operating-status/follows", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [OperatingStatusStuck])]
fn status(bench: &mut Bench<'_>) -> Judged {
    let settings = [(SCALING, CODE_SEQUENCE), (CODE_SEQUENCE | SCALING, 0), (0, CODE_SEQUENCE | SCALING)];
    bench.each(settings, |bench, (with, without)| {
        let written = operate(bench, with, without)?;
        let mask = CODE_SEQUENCE | SCALING;
        let status = bench.read_number(OPERATING_STATUS)?;
        bench.check(demand(status & mask == written & mask, || {
            let duty = format!("bits 0 and 2 of 6500h are those of 6000h, {written:04X}h");
            Breach::new(OPERATING_STATUS, duty).expected(number(written & mask)).found(number(status & mask))
        }))
    })
}
