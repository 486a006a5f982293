//! The scaling bit (6000h bit 2), without which 6001h and 6002h have no effect.

use super::number;
use super::position::{OFFSET, POSITION, SCALING, UNITS_PER_REVOLUTION, at_rest, is_near, operate, position_at_rest};
use super::preset::range_now;
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, demand};
use canvass_bus::client::Outcome;

/// While scaling is off, 6001h has no effect on the position, whether it can be written or not.
#[case(id = "406/scaling/off", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [ScalingAlwaysOn])]
fn off(bench: &mut Bench<'_>) -> Judged {
    operate(bench, 0, SCALING)?;
    let range = range_now(bench)?;
    let before = position_at_rest(bench)?;
    let offset = bench.read_number(OFFSET)?;
    let units = bench.read_number(UNITS_PER_REVOLUTION)?;
    // Some devices refuse the value now; then it can't have an effect.
    let attempt = bench.download(UNITS_PER_REVOLUTION, &(units / 2).max(1).to_le_bytes())?;
    let taken = attempt.outcome == Outcome::Downloaded;
    let after = position_at_rest(bench)?;
    let check = demand(is_near(before, after, range), || {
        let written = if taken { "taken" } else { "refused" };
        let duty = format!("with scaling off, 6001h = {} ({written}) does not move the position", units / 2);
        Breach::new(POSITION, duty).expected(format!("{before} (offset {offset})")).found(number(after))
    });
    at_rest(bench, check)
}
