//! The raw position: 600Ch of the profile, and 2160h of Kübler's Sendix encoders with its inverse and checksum.

use super::number;
use super::position::{at_rest, position_at_rest};
use super::preset::range_now;
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::sdo::crc16;
use canvass_traces::Duration;

const RAW_POSITION: Multiplexer = Multiplexer::new(encoder::POSITION_RAW_VALUE, 0);
const RAW_DATA: Multiplexer = Multiplexer::new(0x2160, 0);
const INVERSE: Multiplexer = Multiplexer::new(0x2161, 0);
const CHECKSUM: Multiplexer = Multiplexer::new(0x2162, 0);
/// The start value of the checksum.
const START: u16 = 0x1021;

/// The raw position 600Ch comes from the sensor: a preset does not change it.
#[case(id = "406/raw-position/preset", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, RawPosition, VolatilePreset], touches = [Preset], catches = [RawPositionFollowsPreset])]
fn preset(bench: &mut Bench<'_>) -> Judged {
    let range = range_now(bench)?;
    let wanted = position_at_rest(bench)?.wrapping_add(range / 3) % range;
    let raw = bench.read_number(RAW_POSITION)?;
    super::preset::preset(bench, wanted)?;
    let after = bench.read_number(RAW_POSITION)?;
    let check = demand(after.abs_diff(raw) <= 64, || {
        Breach::new(RAW_POSITION, "a preset does not change the raw position 600Ch")
            .expected(number(raw))
            .found(number(after))
    });
    at_rest(bench, check)
}

/// Number of times that a case reads objects of one raw position, until the shaft has stood still meanwhile.
const TRIES: usize = 20;

fn too_fast() -> Stop {
    let reason = Reason::new(
        "the raw position hardly changes while its inverse and its checksum are read",
        "at most one reading in which it stays the same",
        format!("another raw position in {TRIES} readings"),
    );
    Stop::Inconclusive(reason)
}

/// 2161h is the bitwise inverse of the raw position 2160h, as the manufacturer's manual says.
#[case(id = "406/raw-position/inverse", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, RawData], catches = [RawInverseWrong])]
fn inverse(bench: &mut Bench<'_>) -> Judged {
    /// At the end of its range the position jumps by more.
    const MOST: u32 = 1 << 20;
    for _ in 0..TRIES {
        let before = bench.read_number(RAW_DATA)?;
        let inverse = bench.read_number(INVERSE)?;
        let moved = bench.read_number(RAW_DATA)?.abs_diff(before);
        if moved > MOST {
            continue;
        }
        return bench.check(demand((!inverse).abs_diff(before) <= moved + 64, || {
            let breach = Breach::new(INVERSE, "2161h is the inverse of 2160h").expected(number(!before));
            breach.found(number(inverse)).told(format!("{inverse:08X}h"))
        }));
    }
    Err(too_fast())
}

/// 2162h is the CRC-16 (polynomial 1021h, start value 1021h) of the raw position 2160h, as the manufacturer's manual
/// says.
#[case(id = "406/raw-position/checksum", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, RawData], catches = [RawCrcStartWrong])]
fn checksum(bench: &mut Bench<'_>) -> Judged {
    let mut wrong = Vec::new();
    for _ in 0..TRIES {
        let before = bench.read_number(RAW_DATA)?;
        let checksum = bench.read_number(CHECKSUM)?;
        // A trembling position would falsify the comparison.
        if bench.read_number(RAW_DATA)? != before {
            continue;
        }
        let expected = u32::from(crc16(START, &before.to_le_bytes()));
        if expected == checksum {
            return Ok(());
        }
        wrong.push((expected, checksum));
    }
    // The position may have trembled to and fro during a single reading.
    let [.., _, _, _, (expected, found)] = wrong[..] else { return Err(too_fast()) };
    let breach = Breach::new(CHECKSUM, "2162h is the CRC of 2160h").expected(number(expected));
    bench.check(Err(Box::new(breach.found(number(found)).told(format!("{found:04X}h")))))
}

/// While the shaft turns, the raw position 600Ch changes together with the position 6004h.
#[case(id = "406/raw-position/moves", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, RawPosition, TurningShaft], catches = [RawPositionStands])]
fn moves(bench: &mut Bench<'_>) -> Judged {
    const POSITION: Multiplexer = Multiplexer::new(encoder::POSITION_VALUE, 0);
    let before = (bench.read_number(POSITION)?, bench.read_number(RAW_POSITION)?);
    bench.listen(Duration::from_millis(500))?;
    let after = (bench.read_number(POSITION)?, bench.read_number(RAW_POSITION)?);
    demand(before.0 != after.0, || {
        let breach = Breach::new(POSITION, "6004h changes while the shaft turns").expected("another value");
        breach.found(number(after.0))
    })
    .or_inconclusive()?;
    bench.check(demand(before.1 != after.1, || {
        let breach = Breach::new(RAW_POSITION, "600Ch changes while the shaft turns").expected("another value");
        breach.found(number(after.1))
    }))
}
