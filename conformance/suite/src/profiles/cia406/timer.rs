//! The cyclic timer (6200h).

use crate::bench::Bench;
use crate::bench::objects::EVENT_TIMER;
use crate::bench::pdo::TPDO;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

const CYCLIC_TIMER: Multiplexer = Multiplexer::new(encoder::CYCLIC_TIMER, 0);

/// 6200h and the event timer of TPDO 1 are the same timer: a value written to one is read from the other.
#[case(id = "406/cyclic-timer/event-timer", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, EventTimer], catches = [CyclicTimerNotLinked])]
fn event_timer(bench: &mut Bench<'_>) -> Judged {
    if !bench.has(CYCLIC_TIMER)? {
        let reason = Reason::new("the encoder has a cyclic timer", "6200h", "none");
        return Err(Stop::NotApplicable(reason));
    }
    bench.each([(CYCLIC_TIMER, EVENT_TIMER, 100_u16), (EVENT_TIMER, CYCLIC_TIMER, 250)], |bench, (to, from, time)| {
        bench.write(to, &time.to_le_bytes())?;
        let read = bench.read(from)?;
        bench.check(demand(read == time.to_le_bytes(), || {
            let breach = Breach::new(from, format!("{from} follows {to}"));
            breach.expected(Observation::Value(time.to_le_bytes().to_vec())).found(Observation::Value(read.clone()))
        }))
    })
}

/// An operational encoder sends TPDO 1 with the period of 6200h, if that is its only timer and its transmission type is
/// event-driven. A new period takes effect without a restart.
#[case(id = "406/cyclic-timer/period", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Tpdo], touches = [Nvm], catches = [CyclicTimerIdle])]
fn period(bench: &mut Bench<'_>) -> Judged {
    if !bench.can_write(CYCLIC_TIMER)? {
        let reason = Reason::new("the encoder has a cyclic timer", "6200h", "none that can be written");
        return Err(Stop::NotApplicable(reason));
    }
    let transmission_type = bench.read_number(TPDO.parameter(2))?;
    let cob_id = bench.pdo_cob_id(TPDO)?;
    if transmission_type < 254 || !cob_id.is_valid() {
        let actual = format!("type {transmission_type}, COB-ID {:08X}h", cob_id.0);
        return Err(Stop::NotApplicable(Reason::new("TPDO 1 is delivered event-driven", "type 254 or 255", actual)));
    }
    let can_id = (cob_id.can_id() & 0x7FF) as u16;
    bench.write(CYCLIC_TIMER, &100_u16.to_le_bytes())?;
    bench.command(Command::START)?;
    bench.listen(Duration::from_millis(200))?;
    bench.each([100_u16, 50], |bench, milliseconds| {
        bench.write(CYCLIC_TIMER, &milliseconds.to_le_bytes())?;
        // The current period may still be the old one.
        bench.listen(Duration::from_millis(200))?;
        let heard = bench.frames_of(can_id, Duration::from_secs(2))?.len() as u64;
        let right = 2_000 / u64::from(milliseconds);
        // A changing position may cause further TPDOs.
        bench.check(demand(heard >= right * 9 / 10, || {
            Breach::new(
                CYCLIC_TIMER,
                format!("the device sends TPDO 1 every {milliseconds} ms by 6200h, counted for 2 s"),
            )
            .expected(Allowed::Count { least: right * 9 / 10, most: None })
            .found(Observation::Count(heard))
        }))
    })
}
