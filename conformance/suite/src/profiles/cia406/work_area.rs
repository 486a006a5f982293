//! Work area: state (6400h) and limits (6401h, 6402h) of channel 1.

use super::number;
use super::position::{POSITION, position_at_rest};
use super::preset::range_now;
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;

const STATE: Multiplexer = Multiplexer::new(encoder::WORK_AREA_STATE, 1);
const LOW: Multiplexer = Multiplexer::new(encoder::WORK_AREA_LOW_LIMIT, 1);
const HIGH: Multiplexer = Multiplexer::new(encoder::WORK_AREA_HIGH_LIMIT, 1);
const ALL: u32 = 0b111;
const OUT_OF_RANGE: u32 = 1 << 0;
const OVERFLOW: u32 = 1 << 1;
const UNDERFLOW: u32 = 1 << 2;
/// Distance between the position and a limit, so that a trembling position stays on its side.
const DISTANCE: u32 = 100;

/// Sets both limits, in an order in which the low one is never above the high one.
fn limit(bench: &mut Bench<'_>, low: u32, high: u32) -> Result<(), Stop> {
    if low > bench.read_number(HIGH)? {
        bench.write(HIGH, &high.to_le_bytes())?;
        return bench.write(LOW, &low.to_le_bytes());
    }
    bench.write(LOW, &low.to_le_bytes())?;
    bench.write(HIGH, &high.to_le_bytes())
}

fn expect_state(bench: &mut Bench<'_>, where_it_is: &str, mask: u32, expected: u32) -> Judged {
    let position = bench.read_number(POSITION)?;
    let state = bench.read_number(STATE)?;
    bench.check(demand(state & mask == expected, || {
        let duty = format!("6400h:01 tells that position {position} is {where_it_is}");
        let breach = Breach::new(STATE, duty).expected(number(expected)).found(number(state & mask));
        breach.told(format!("{:03b} in binary", state & mask))
    }))
}

/// The position at rest. The case is not applicable if it is near an end of its range.
fn middle(bench: &mut Bench<'_>) -> Result<u32, Stop> {
    let (range, position) = (range_now(bench)?, position_at_rest(bench)?);
    let far = position > 4 * DISTANCE && position < range.saturating_sub(4 * DISTANCE);
    if far {
        return Ok(position);
    }
    let expected = format!("{} to {}", 4 * DISTANCE, range.saturating_sub(4 * DISTANCE));
    let duty = "the shaft stands away from the ends of the range";
    Err(Stop::NotApplicable(Reason::new(duty, expected, format!("{position}"))))
}

/// No bit of 6400h is set while the position lies between the limits.
#[case(id = "406/work-area/inside", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, WorkArea], catches = [WorkAreaInverted])]
fn inside(bench: &mut Bench<'_>) -> Judged {
    let position = middle(bench)?;
    limit(bench, position - DISTANCE, position + DISTANCE)?;
    expect_state(bench, "inside the work area", ALL, 0)
}

/// A position above the high limit 6402h sets the overflow bit, bit 1 of 6400h.
#[case(id = "406/work-area/overflow", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, WorkArea], catches = [WorkAreaBitsSwapped, WorkAreaStuck])]
fn overflow(bench: &mut Bench<'_>) -> Judged {
    let position = middle(bench)?;
    limit(bench, 0, position - DISTANCE)?;
    expect_state(bench, "above the high limit", ALL & !OUT_OF_RANGE, OVERFLOW)
}

/// A position below the low limit 6401h sets the underflow bit, bit 2 of 6400h.
#[case(id = "406/work-area/underflow", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, WorkArea], catches = [WorkAreaBitsSwapped, WorkAreaStuck])]
fn underflow(bench: &mut Bench<'_>) -> Judged {
    let position = middle(bench)?;
    limit(bench, position + DISTANCE, position + 2 * DISTANCE)?;
    expect_state(bench, "below the low limit", ALL & !OUT_OF_RANGE, UNDERFLOW)
}

/// A low limit above the high limit is refused.
#[case(id = "406/work-area/limits-swapped", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, WorkArea], catches = [WorkAreaLimitsSwappedAccepted, LimitsSwappedWrongCode])]
fn swapped(bench: &mut Bench<'_>) -> Judged {
    let position = middle(bench)?;
    limit(bench, position - DISTANCE, position + DISTANCE)?;
    let attempt = bench.download(LOW, &(position + 2 * DISTANCE).to_le_bytes())?;
    bench.check(attempt.refused(Situation::MaximumBelowMinimum))
}

/// The case only records whether bit 0 of 6400h is set while the position lies above or below the limits, because
/// manuals differ.
#[case(id = "406/work-area/outside", clause = "CiA 406", confidence = Unknown, level = Open,
       needs = super::needs[Encoder, WorkArea], catches = [WorkAreaInverted, WorkAreaOutsideOneSided])]
fn outside(bench: &mut Bench<'_>) -> Judged {
    let position = middle(bench)?;
    bench.each([(0, position - DISTANCE), (position + DISTANCE, position + 2 * DISTANCE)], |bench, (low, high)| {
        limit(bench, low, high)?;
        expect_state(bench, "outside the work area", OUT_OF_RANGE, OUT_OF_RANGE)
    })
}

/// A maximum below its minimum is refused with abort 0609 0036h, and the old limit stays.
#[case(id = "301/sdo/download/maximum-below-minimum", clause = "CiA 301 7.2.4.3.17", confidence = Cited,
       level = Should, needs = super::needs[WorkArea], catches = [WorkAreaLimitsSwappedAccepted, LimitsSwappedWrongCode])]
fn maximum_below_minimum(bench: &mut Bench<'_>) -> Judged {
    let (low, high) =
        (Multiplexer::new(encoder::WORK_AREA_LOW_LIMIT, 1), Multiplexer::new(encoder::WORK_AREA_HIGH_LIMIT, 1));
    if !bench.can_write(low)? || !bench.can_write(high)? {
        let reason = Reason::new("both limits of the work area can be written", "6401h and 6402h", "read-only");
        return Err(Stop::NotApplicable(reason));
    }
    bench.write(high, &2_000_u32.to_le_bytes())?;
    bench.write(low, &1_000_u32.to_le_bytes())?;
    let before = bench.read(high)?;
    let mut attempt = bench.download(high, &999_u32.to_le_bytes())?;
    attempt.what = "high limit below the low limit".to_owned();
    bench.check(attempt.refused(Situation::MaximumBelowMinimum))?;
    bench.expect_unchanged(high, &before)
}
