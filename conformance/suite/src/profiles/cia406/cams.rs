//! Cams (6300h to 6337h): state bits that are set while the position lies between two limits.
//!
//! The shaft is at rest: the limits are moved around the position, which has the same effect on the cam.

use super::position::position_at_rest;
use super::preset::range_now;
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_bus::observation::Observation;

/// The cams of the first position channel, one bit for each.
const STATE: Multiplexer = Multiplexer::new(encoder::CAM_STATE, 1);
const ENABLE: Multiplexer = Multiplexer::new(encoder::CAM_ENABLE, 1);
const POLARITY: Multiplexer = Multiplexer::new(encoder::CAM_POLARITY, 1);
const LOW: Multiplexer = Multiplexer::new(encoder::CAM_LOW_LIMIT, 1);
const HIGH: Multiplexer = Multiplexer::new(encoder::CAM_HIGH_LIMIT, 1);
const HYSTERESIS: Multiplexer = Multiplexer::new(encoder::CAM_HYSTERESIS, 1);
const FIRST: u32 = 1;
/// Distance of the limits from the position.
const MARGIN: u32 = 200;

/// Configures cam 1, active and not inverted, around or beside the position; the low limit first, if possible.
fn set(bench: &mut Bench<'_>, low: u32, high: u32) -> Result<(), Stop> {
    // Between the two writes the low limit must not be above the high one.
    bench.write(LOW, &0_u32.to_le_bytes())?;
    bench.write(HIGH, &high.to_le_bytes())?;
    bench.write(LOW, &low.to_le_bytes())
}

fn prepare(bench: &mut Bench<'_>) -> Result<u32, Stop> {
    let range = range_now(bench)?;
    let position = position_at_rest(bench)?;
    if position < 4 * MARGIN || position > range.saturating_sub(4 * MARGIN) {
        let expected = format!("{} to {}", 4 * MARGIN, range.saturating_sub(4 * MARGIN));
        let reason = Reason::new("the position has room on both sides", expected, position.to_string());
        return Err(Stop::NotApplicable(reason));
    }
    if bench.has(HYSTERESIS)? {
        bench.write(HYSTERESIS, &0_u16.to_le_bytes())?;
    }
    bench.write(POLARITY, &[0])?;
    bench.write(ENABLE, &[FIRST as u8])?;
    Ok(position)
}

fn is_set(bench: &mut Bench<'_>) -> Result<bool, Stop> {
    Ok(bench.read_number(STATE)? & FIRST != 0)
}

fn expect(bench: &mut Bench<'_>, set: bool, where_: &str) -> Judged {
    let found = is_set(bench)?;
    let shown = |set: bool| Observation::named(if set { "bit 0 set" } else { "bit 0 clear" });
    bench.check(demand(found == set, || {
        Breach::new(STATE, format!("6300h:01 shows the state of a cam {where_}"))
            .expected(shown(set))
            .found(shown(found))
    }))
}

/// The state of an enabled cam is set exactly while the position lies between its limits. The state of a disabled cam
/// is never set.
#[case(id = "406/cams/limits", clause = "CiA 406", confidence = Unknown, level = Must, needs = super::needs[Encoder, Cams],
       catches = [CamStuck, CamHighLimitIgnored, CamEnableIgnored])]
fn limits(bench: &mut Bench<'_>) -> Judged {
    let position = prepare(bench)?;
    set(bench, position - MARGIN, position + MARGIN)?;
    expect(bench, true, "whose limits lie around the position")?;
    set(bench, position + MARGIN, position + 2 * MARGIN)?;
    expect(bench, false, "that lies above the position")?;
    set(bench, position - 2 * MARGIN, position - MARGIN)?;
    expect(bench, false, "that lies below the position")?;
    set(bench, position - MARGIN, position + MARGIN)?;
    bench.write(ENABLE, &[0])?;
    expect(bench, false, "that is disabled")
}

/// The polarity inverts the state of a cam.
#[case(id = "406/cams/polarity", clause = "CiA 406", confidence = Unknown, level = Must, needs = super::needs[Encoder, Cams],
       catches = [CamPolarityIgnored])]
fn polarity(bench: &mut Bench<'_>) -> Judged {
    let position = prepare(bench)?;
    set(bench, position - MARGIN, position + MARGIN)?;
    bench.write(POLARITY, &[FIRST as u8])?;
    expect(bench, false, "with inverted polarity whose limits lie around the position")?;
    set(bench, position + MARGIN, position + 2 * MARGIN)?;
    expect(bench, true, "with inverted polarity that lies above the position")
}

/// The hysteresis extends an active cam: the cam ends only when the position exceeds its limit by more than the
/// hysteresis.
#[case(id = "406/cams/hysteresis", clause = "CiA 406", confidence = Unknown, level = Must, needs = super::needs[Encoder, Cams],
       catches = [CamHysteresisIgnored])]
fn hysteresis(bench: &mut Bench<'_>) -> Judged {
    let position = prepare(bench)?;
    if !bench.has(HYSTERESIS)? {
        return Err(Stop::NotApplicable(Reason::new("the cam has a hysteresis", "6330h:01", "none")));
    }
    set(bench, position - 2 * MARGIN, position + MARGIN)?;
    bench.write(HYSTERESIS, &(MARGIN as u16).to_le_bytes())?;
    expect(bench, true, "whose limits lie around the position")?;
    // The position is now beyond the high limit, but by less than the hysteresis.
    bench.write(HIGH, &(position - MARGIN / 2).to_le_bytes())?;
    expect(bench, true, "that the position has left by less than the hysteresis")?;
    bench.write(HIGH, &(position - MARGIN - MARGIN / 2).to_le_bytes())?;
    expect(bench, false, "that the position has left by more than the hysteresis")
}
