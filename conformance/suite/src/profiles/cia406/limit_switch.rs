//! Limit switches: manufacturer objects that bits 12 and 13 of 6000h enable and whose states 6500h shows. Only devices
//! with these names in their description are judged.

use super::number;
use super::position::{OPERATING_STATUS, POSITION, operate, position_at_rest};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Check, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_device::profiles::cia406::shows_limit_switches;

const LIMIT_MIN: Multiplexer = Multiplexer::new(0x2104, 0);
const LIMIT_MAX: Multiplexer = Multiplexer::new(0x2105, 0);
const BELOW: u32 = 1 << 12;
const ABOVE: u32 = 1 << 13;
/// Distance from the position at which its last bits don't matter.
const MARGIN: u32 = 100;

fn needs_limit_switches(bench: &Bench<'_>) -> Result<(), Stop> {
    if bench.target().description.as_ref().is_some_and(shows_limit_switches) {
        return Ok(());
    }
    let reason = Reason::new(
        "the device has limit switches",
        "2104h and 2105h described as limit switches",
        "other objects or none",
    );
    Err(Stop::NotApplicable(reason))
}

/// The bits of 6500h with these limits.
fn status(bench: &mut Bench<'_>, low: u32, high: u32) -> Result<u32, Stop> {
    bench.write(LIMIT_MIN, &low.to_le_bytes())?;
    bench.write(LIMIT_MAX, &high.to_le_bytes())?;
    Ok(bench.read_number(OPERATING_STATUS)? & (BELOW | ABOVE))
}

fn expect(found: u32, expected: u32, when: &str) -> Check {
    demand(found == expected, || {
        let breach = Breach::new(OPERATING_STATUS, format!("{OPERATING_STATUS} {when}"));
        breach.expected(number(expected)).found(number(found)).told(format!("{found:04X}h"))
    })
}

/// Bit 12 of 6500h is set below the minimum limit, bit 13 above the maximum limit, each only if 6000h enables its limit
/// switch.
#[case(id = "406/limit-switch/bits", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, Description], catches = [LimitSwitchesSwapped])]
fn bits(bench: &mut Bench<'_>) -> Judged {
    needs_limit_switches(bench)?;
    let position = position_at_rest(bench)?;
    let (Some(less), Some(more)) = (position.checked_sub(MARGIN), position.checked_add(MARGIN)) else {
        let reason = Reason::new("there is room beside the position", format!("{MARGIN} units"), format!("{position}"));
        return Err(Stop::NotApplicable(reason));
    };
    operate(bench, 0, BELOW | ABOVE)?;
    let off = status(bench, more, less)?;
    bench.check(expect(off, 0, "with both limit switches off"))?;
    operate(bench, BELOW | ABOVE, 0)?;
    let places = [
        (less, more, 0, "between the limits"),
        (more, more, BELOW, "below limit switch min"),
        (less, less, ABOVE, "above limit switch max"),
    ];
    bench.each(places, |bench, (low, high, expected, when)| {
        let found = status(bench, low, high)?;
        bench.check(expect(found, expected, when))
    })
}

/// A limit switch is not active at the limit itself.
#[case(id = "406/limit-switch/limit", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, Description], catches = [LimitSwitchInclusive])]
fn limit(bench: &mut Bench<'_>) -> Judged {
    needs_limit_switches(bench)?;
    let position = position_at_rest(bench)?;
    operate(bench, BELOW | ABOVE, 0)?;
    let found = status(bench, position, position)?;
    let after = bench.read_number(POSITION)?;
    demand(after == position, || {
        Breach::new(POSITION, "the position stands still").expected(number(position)).found(number(after))
    })
    .or_inconclusive()?;
    bench.check(expect(found, 0, "on both limits"))
}
