//! Draw-wire encoders with two redundant channels (6020h twice in TPDO 1) and an inclinometer (5000h), such as Kübler's
//! C100 and D125.

use crate::bench::Bench;
use crate::bench::objects::TPDO_FIRST_ENTRY;
use crate::case;
use crate::verdict::{Allowed, Breach, Check, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::pdo::MappingEntry;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{Duration, Record};

const TPDO_1: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 1);
const TPDO_2: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER + 1, 1);
const TIMER_1: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 5);
const TIMER_2: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER + 1, 5);
const DIRECTION: Multiplexer = Multiplexer::new(0x3003, 0);
const ANGLE_RANGE: Multiplexer = Multiplexer::new(0x3004, 0);
const REDUNDANT: Multiplexer = Multiplexer::new(0x3005, 0);
pub(super) const ZERO_POINT: Multiplexer = Multiplexer::new(0x3010, 0);
pub(super) const ANGLE: Multiplexer = Multiplexer::new(0x5000, 0);
/// 360 degrees, in hundredths of a degree.
pub(super) const TURN: i64 = 36_000;
/// 2 degrees, in hundredths of a degree: a housing may shake.
const TREMBLE: i64 = 200;

/// Both channels in each TPDO within a second.
fn channels(bench: &mut Bench<'_>, tpdo: Multiplexer, timer: Multiplexer, bits: u8) -> Result<Vec<[u64; 2]>, Stop> {
    let cob_id = (CobId(bench.read_number(tpdo)?).can_id() & 0x7FF) as u16;
    bench.write(timer, &50_u16.to_le_bytes())?;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    let heard: Vec<Record> = bench.listen(Duration::from_secs(1))?;
    let own = heard.iter().filter(|record| record.frame.cob_id() == Some(cob_id));
    let width = usize::from(bits / 8);
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte));
    let found: Vec<[u64; 2]> = own
        .filter_map(|record| Some([number(record.data().get(..width)?), number(record.data().get(width..2 * width)?)]))
        .collect();
    demand(found.len() >= 10, || {
        let breach = Breach::new(Subject::CanId(cob_id.into()), "the TPDO with both channels is sent every 50 ms");
        breach.expected(Allowed::Count { least: 10, most: None }).found(Observation::Count(found.len() as u64))
    })
    .or_inconclusive()?;
    Ok(found)
}

fn width(bench: &mut Bench<'_>) -> Result<u8, Stop> {
    Ok(MappingEntry(bench.read_number(TPDO_FIRST_ENTRY)?).bits())
}

/// The second channel of the position counts down while the first one counts up: the sum of both is constant.
#[case(id = "406/redundant-channels/sum", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[RedundantChannels], catches = [RedundantChannelDrift])]
fn sum(bench: &mut Bench<'_>) -> Judged {
    let bits = width(bench)?;
    let channels = channels(bench, TPDO_1, TIMER_1, bits)?;
    bench.check(expect_constant_sum(&channels))
}

/// While the wire moves, the second channel of the position counts down as the first one counts up.
#[case(id = "406/redundant-channels/opposite", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[RedundantChannels, TurningShaft], catches = [RedundantChannelNotNegated])]
fn opposite(bench: &mut Bench<'_>) -> Judged {
    let bits = width(bench)?;
    let channels = channels(bench, TPDO_1, TIMER_1, bits)?;
    bench.check(expect_constant_sum(&channels))
}

fn expect_constant_sum(channels: &[[u64; 2]]) -> Check {
    let sums = channels.iter().map(|[a, b]| a + b);
    let (least, most) = (sums.clone().min().unwrap_or(0), sums.max().unwrap_or(0));
    // The device reads both channels one after the other.
    demand(most - least <= 20, || {
        let breach = Breach::new(Subject::Pdo { transmit: true, number: 1 }, "the sum of both channels is constant");
        let found = Observation::named("a sum of both channels that changes");
        breach.expected(format!("{least} always")).found(found).told(format!("{least} to {most}"))
    })
}

/// The angle in hundredths of a degree, between -180 and 180 degrees.
fn angle(bench: &mut Bench<'_>) -> Result<i64, Stop> {
    Ok(signed(bench.read_number(ANGLE)?.into()))
}

/// An angle as the device would show it, INTEGER16.
fn degrees(angle: i64) -> Observation {
    Observation::Value((angle as i16).to_le_bytes().to_vec())
}

fn signed(raw: u64) -> i64 {
    let raw = i64::from(raw as u16 as i16);
    // In a range of 0 to 360 degrees the upper half does not fit into 16 bits with sign.
    let turn = if raw < -TURN / 2 { raw + 65_536 } else { raw }.rem_euclid(TURN);
    if turn > TURN / 2 { turn - TURN } else { turn }
}

/// An angle far enough from 0 and 180 degrees to tell its sign.
fn tilted(bench: &mut Bench<'_>) -> Result<i64, Stop> {
    let angle = angle(bench)?;
    if angle.abs() < 2 * TREMBLE || angle.abs() > TURN / 2 - 2 * TREMBLE {
        let actual = format!("{angle} hundredths of a degree");
        let reason = Reason::new("the housing is tilted", "4 to 176 degrees", actual);
        return Err(Stop::NotApplicable(reason));
    }
    Ok(angle)
}

/// 3003h reverses the direction in which the angle counts.
#[case(id = "406/inclinometer/direction", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Inclinometer], catches = [AngleDirectionIgnored])]
fn direction(bench: &mut Bench<'_>) -> Judged {
    bench.write(DIRECTION, &[1])?;
    let clockwise = tilted(bench)?;
    bench.write(DIRECTION, &[0])?;
    let other = angle(bench)?;
    bench.check(demand((clockwise + other).abs() <= TREMBLE, || {
        let breach = Breach::new(ANGLE, "3003h reverses the direction of the angle").expected(degrees(-clockwise));
        breach.found(degrees(other))
    }))
}

/// With 3004h = 1 the angle ranges from -180 to 180 degrees, with 0 from 0 to 360 degrees.
#[case(id = "406/inclinometer/range", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Inclinometer], catches = [AngleRangeIgnored])]
fn range(bench: &mut Bench<'_>) -> Judged {
    let positive = tilted(bench)? > 0;
    // The direction towards negative angles, which the two ranges show differently.
    let now = bench.read_number(DIRECTION)?;
    if positive {
        bench.write(DIRECTION, &[u8::from(now == 0)])?;
    }
    bench.each([(1_u8, 0x8000_u32), (0, 0)], |bench, (code, least)| {
        bench.write(ANGLE_RANGE, &[code])?;
        let raw = bench.read_number(ANGLE)? & 0xFFFF;
        let fits = if code == 1 { raw >= least && raw >= 0xB9B0 } else { raw < TURN as u32 };
        bench.check(demand(fits, || {
            let expected = if code == 1 { "a negative number of 16 bits" } else { "0 to 35999" };
            let breach = Breach::new(ANGLE, format!("5000h shows a negative angle in the range of 3004h = {code}"));
            breach.expected(expected).found(Observation::Number(raw.into()))
        }))
    })
}

/// With 3005h = 1 the second angle counts opposite to the first one, with 0 in the same direction.
#[case(id = "406/inclinometer/redundant-angle", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Inclinometer], catches = [RedundantAngleSame])]
fn redundant_angle(bench: &mut Bench<'_>) -> Judged {
    tilted(bench)?;
    bench.each([(0_u8, 1), (1, -1)], |bench, (code, sign)| {
        bench.command(Command::ENTER_PRE_OPERATIONAL)?;
        bench.listen(bench.timing().reaction)?;
        bench.write(REDUNDANT, &[code])?;
        let Some([first, second]) = channels(bench, TPDO_2, TIMER_2, 16)?.last().copied() else { return Ok(()) };
        let (first, second) = (signed(first), signed(second));
        bench.check(demand((second - sign * first).abs() <= TREMBLE, || {
            let duty = format!("with 3005h = {code} the second angle fits the first, {first}");
            let breach = Breach::new(Subject::Pdo { transmit: true, number: 2 }, duty);
            breach.expected(degrees(sign * first)).found(degrees(second))
        }))
    })
}

/// 3010h = 1 sets the current angle to zero, 0 reverts this.
#[case(id = "406/inclinometer/zero-point", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Inclinometer], touches = [Preset], catches = [ZeroPointIgnored])]
fn zero_point(bench: &mut Bench<'_>) -> Judged {
    if bench.read_number(ZERO_POINT)? != 0 {
        let reason = Reason::new("no zero point is set", "3010h = 0", "1");
        return Err(Stop::NotApplicable(reason));
    }
    tilted(bench)?;
    bench.write(ZERO_POINT, &[1])?;
    let zero = angle(bench);
    // Unlike a preset, 0 reverses the change exactly.
    bench.with_leave_to_move(|bench| bench.write(ZERO_POINT, &[0]))?;
    let zero = zero?;
    bench.check(demand(zero.abs() <= TREMBLE, || {
        Breach::new(ANGLE, "3010h = 1 sets the angle to zero").expected(degrees(0)).found(degrees(zero))
    }))
}
