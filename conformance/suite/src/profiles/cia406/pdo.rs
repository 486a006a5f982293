//! The times at which an encoder sends its position.

use super::position::position_at_rest;
use crate::bench::Bench;
use crate::bench::objects::{EVENT_TIMER, TRANSMISSION_TYPE};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{Duration, Record};

const TPDO: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 1);
const TPDO_1: Subject = Subject::Pdo { transmit: true, number: 1 };
const CYCLIC_TIMER: Multiplexer = Multiplexer::new(encoder::CYCLIC_TIMER, 0);
const POSITION: Multiplexer = Multiplexer::new(encoder::POSITION_VALUE, 0);

fn event_driven(bench: &mut Bench<'_>) -> Result<u16, Stop> {
    let transmission_type = bench.read_number(TRANSMISSION_TYPE)?;
    if transmission_type < 254 {
        let actual = format!("transmission type {transmission_type}");
        let reason = Reason::new("TPDO 1 is event-driven", "transmission type 254 or 255", actual);
        return Err(Stop::NotApplicable(reason));
    }
    Ok((CobId(bench.read_number(TPDO)?).can_id() & 0x7FF) as u16)
}

fn count(heard: &[Record], cob_id: u16) -> u64 {
    heard.iter().filter(|record| record.frame.cob_id() == Some(cob_id)).count() as u64
}

/// The device sends the event-driven TPDO 1 when it becomes operational, without waiting for the event timer.
#[case(id = "406/tpdo/sent-on-start", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, EventTimer], catches = [FirstPositionMissing])]
fn sent_on_start(bench: &mut Bench<'_>) -> Judged {
    let cob_id = event_driven(bench)?;
    bench.write(EVENT_TIMER, &5_000_u16.to_le_bytes())?;
    bench.command(Command::START)?;
    let heard = bench.listen(bench.timing().silence)?;
    bench.check(demand(count(&heard, cob_id) > 0, || {
        let breach = Breach::new(TPDO_1, "TPDO 1 is sent when the device becomes operational");
        breach.expected(Allowed::Count { least: 1, most: None }).found(Observation::Silence)
    }))
}

/// The cyclic timer 6200h makes the device send TPDO 1 periodically; 0 ends this.
#[case(id = "406/cyclic-timer/off", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, EventTimer], catches = [CyclicTimerNotStopped])]
fn cyclic_timer_off(bench: &mut Bench<'_>) -> Judged {
    if !bench.has(CYCLIC_TIMER)? {
        return Err(Stop::NotApplicable(Reason::new("the encoder has a cyclic timer", "6200h", "none")));
    }
    let cob_id = event_driven(bench)?;
    bench.write(CYCLIC_TIMER, &50_u16.to_le_bytes())?;
    bench.command(Command::START)?;
    let running = bench.listen(Duration::from_millis(520))?;
    demand(count(&running, cob_id) >= 9, || {
        let breach = Breach::new(TPDO_1, "with 6200h = 50 TPDO 1 comes every 50 ms, for 520 ms");
        breach.expected(Allowed::Count { least: 9, most: None }).found(Observation::Count(count(&running, cob_id)))
    })
    .or_inconclusive()?;
    bench.write(CYCLIC_TIMER, &0_u16.to_le_bytes())?;
    bench.listen(bench.timing().reaction)?;
    // With a turning shaft the encoder would send TPDOs on change.
    position_at_rest(bench)?;
    let heard = bench.listen(Duration::from_millis(500))?;
    position_at_rest(bench)?;
    // A trembling position sends a TPDO on each change: only what repeats the data before comes from a timer.
    let sent: Vec<&Record> = heard.iter().filter(|record| record.frame.cob_id() == Some(cob_id)).collect();
    let repeated = sent.windows(2).filter(|pair| matches!(pair, [a, b] if a.frame == b.frame)).count() as u64;
    let others = sent.len() as u64 - repeated;
    if repeated <= 2 && others > 3 {
        let reason = Reason::new("the position does not change for 500 ms", "at most 3 changes", others.to_string());
        return Err(Stop::Inconclusive(reason));
    }
    bench.check(demand(repeated <= 2, || {
        let breach = Breach::new(TPDO_1, "with 6200h = 0 TPDO 1 is not sent again with the same data, for 500 ms");
        let found = Observation::Count(repeated);
        breach.expected(Allowed::Count { least: 0, most: Some(2) }).found(found)
    }))
}

/// 6200h follows the event timer of TPDO 1: both are the same timer.
#[case(id = "406/cyclic-timer/follows-event-timer", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, EventTimer], catches = [EventTimerNotInCyclicTimer])]
fn follows_event_timer(bench: &mut Bench<'_>) -> Judged {
    if !bench.has(CYCLIC_TIMER)? {
        return Err(Stop::NotApplicable(Reason::new("the encoder has a cyclic timer", "6200h", "none")));
    }
    bench.write(EVENT_TIMER, &70_u16.to_le_bytes())?;
    let read = bench.read(CYCLIC_TIMER)?;
    bench.check(demand(read == 70_u16.to_le_bytes(), || {
        let breach = Breach::new(CYCLIC_TIMER, "6200h follows 1800h:05 = 70");
        breach.expected(Observation::Value(70_u16.to_le_bytes().to_vec())).found(Observation::Value(read.clone()))
    }))
}

/// The position can't be written.
#[case(id = "406/position/read-only", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [PositionWritable])]
fn read_only(bench: &mut Bench<'_>) -> Judged {
    let value = bench.read(POSITION)?;
    let attempt = bench.download(POSITION, &value)?;
    bench.check(attempt.refused(Situation::ReadOnly))
}
