//! The cyclic timer (6200h).

use crate::bench::Bench;
use crate::bench::objects::EVENT_TIMER;
use crate::case;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_bus::observation::Observation;

const CYCLIC_TIMER: Multiplexer = Multiplexer::new(0x6200, 0);

/// 6200h and the event timer of TPDO 1 are the same: what is written to one is read from the other.
#[case(id = "406/cyclic-timer/event-timer", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = [Encoder, EventTimer], catches = [CyclicTimerNotLinked])]
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
