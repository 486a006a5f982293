//! The zero point of an encoder: the object that moves it (6003h) and the objects that show it (6004h, 6509h, 600Ch).

use super::draw_wire::{ANGLE, TURN, ZERO_POINT};
use super::position::{OFFSET, OPERATING_PARAMETERS, POSITION, PRESET, RANGE, SCALING, is_linear};
use crate::bench::objects::candidate;
use crate::bench::{Bench, Candidate, Profile, Registered};
use crate::verdict::Stop;
use crate::zero_point::Objects;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;
use canvass_analyzer::object::{self, Acting};
use canvass_analyzer::profiles::cia406::{NUMBER, objects as encoder};

const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);
const RAW_POSITION: Multiplexer = Multiplexer::new(encoder::POSITION_RAW_VALUE, 0);
const SINGLE_TURN: Multiplexer = Multiplexer::new(encoder::SINGLE_TURN_RESOLUTION, 0);
const REVOLUTIONS: Multiplexer = Multiplexer::new(encoder::NUMBER_OF_REVOLUTIONS, 0);

/// The profile CiA 406.
struct Encoders;

inventory::submit!(Registered(&Encoders));

impl Profile for Encoders {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn zero_point(&self, bench: &mut Bench<'_>) -> Result<Option<Objects>, Stop> {
        if bench.read_number(DEVICE_TYPE)? & 0xFFFF != u32::from(NUMBER) {
            return Ok(None);
        }
        if !bench.has(POSITION)? || !bench.has(PRESET)? {
            return inclinometer(bench);
        }
        let mut known = |at| bench.has(at).map(|there| there.then_some(at));
        let (offset, raw) = (known(OFFSET)?, known(RAW_POSITION)?);
        let range = positions(bench)?;
        Ok(Some(Objects { preset: PRESET, takes_position: true, position: POSITION, offset, raw, range }))
    }

    fn scratch(&self) -> &'static [Candidate] {
        const SCRATCH: [Candidate; 2] = [
            candidate(encoder::WORK_AREA_LOW_LIMIT, 0, DataType::INTEGER32, [16, 32]),
            candidate(encoder::CYCLIC_TIMER, 0, DataType::UNSIGNED16, [100, 200]),
        ];
        &SCRATCH
    }

    fn application_scratch(&self) -> &'static [Candidate] {
        const SCRATCH: [Candidate; 3] = [
            candidate(encoder::WORK_AREA_HIGH_LIMIT, 0, DataType::INTEGER32, [1_000, 2_000]),
            candidate(encoder::WORK_AREA_HIGH_LIMIT, 1, DataType::UNSIGNED32, [1_000, 2_000]),
            candidate(encoder::WORK_AREA_LOW_LIMIT, 0, DataType::INTEGER32, [16, 32]),
        ];
        &SCRATCH
    }

    fn is_parameter(&self, at: Multiplexer) -> bool {
        matches!(
            at.index.0,
            encoder::OPERATING_PARAMETERS..=encoder::TOTAL_MEASURING_RANGE
                | encoder::CYCLIC_TIMER
                | encoder::WORK_AREA_LOW_LIMIT..=encoder::WORK_AREA_HIGH_LIMIT
        )
    }

    fn is_scaling(&self, at: Multiplexer) -> bool {
        matches!(at, SINGLE_TURN | REVOLUTIONS)
    }
}

/// The inclinometer of Kübler's draw-wire encoders: 3010h shows whether the angle counts from a configured zero.
fn inclinometer(bench: &mut Bench<'_>) -> Result<Option<Objects>, Stop> {
    let is_there = bench.acting(ZERO_POINT) == Some(Acting::MovesZeroPoint) && bench.has(ANGLE)?;
    let (preset, position, offset, raw) = (ZERO_POINT, ANGLE, Some(ZERO_POINT), None);
    let range = TURN.unsigned_abs();
    Ok(is_there.then_some(Objects { preset, takes_position: false, position, offset, raw, range }))
}

/// Number of positions in the encoder's current configuration, at most 2^32.
///
/// With scaling the number is 6002h, where 0 stands for 2^32. Without scaling it is 6501h times 6502h; on a linear
/// encoder 6501h is the measuring step in nanometres, and only 6002h gives the number.
pub(super) fn positions(bench: &mut Bench<'_>) -> Result<u64, Stop> {
    const MOST: u64 = 1 << 32;
    let is_scaled = bench.read_number(OPERATING_PARAMETERS)? & SCALING != 0;
    if is_scaled || is_linear(bench)? {
        let range = u64::from(bench.read_number(RANGE)?);
        return Ok(if range == 0 { MOST } else { range });
    }
    let steps = u64::from(bench.read_number(SINGLE_TURN)?) * u64::from(bench.read_number(REVOLUTIONS)?.max(1));
    Ok(steps.min(MOST))
}
