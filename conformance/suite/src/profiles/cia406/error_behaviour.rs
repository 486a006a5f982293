//! Error behaviour of the profile (1029h:02): the effect of a sensor error on the NMT state.
//!
//! Without opening a device, the tester can only provoke a temperature beyond its limits.

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::sdo::Request;
use canvass_traces::Duration;

const BEHAVIOUR: Multiplexer = Multiplexer::new(object::ERROR_BEHAVIOR, 2);
const HIGH_LIMIT: Multiplexer = Multiplexer::new(0x2120, 3);
/// 0 °C in the notation of 2120h.
const FREEZING: u8 = 0x40;

/// With this behaviour, makes the temperature leave its limits while the device is operational, and requires that the
/// device is then in `to`.
fn overheated(bench: &mut Bench<'_>, behaviour: u8, to: State) -> Judged {
    if !bench.can_write(BEHAVIOUR)? {
        return Err(Stop::NotApplicable(Reason::new("1029h has an entry for the profile", "1029h:02", "none")));
    }
    bench.expect_emergencies();
    bench.write(BEHAVIOUR, &[behaviour])?;
    let usual = bench.read(HIGH_LIMIT)?;
    bench.write(HIGH_LIMIT, &usual)?;
    bench.reach(State::OPERATIONAL)?;
    // A device that becomes stopped does not get to confirm the write.
    bench.send_request(&Request::download(HIGH_LIMIT, &[FREEZING]))?;
    bench.listen(Duration::from_millis(300))?;
    bench.expect_state(to, &format!("a temperature beyond its limit with 1029h:02 = {behaviour}"))
}

/// With 1029h:02 = 0 an operational encoder enters pre-operational when its sensor reports an error.
#[case(id = "406/error-behaviour/pre-operational", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, TemperatureLimit, VisibleState], catches = [ProfileErrorIgnored])]
fn pre_operational(bench: &mut Bench<'_>) -> Judged {
    overheated(bench, 0, State::PRE_OPERATIONAL)
}

/// With 1029h:02 = 1 an encoder stays in its NMT state when its sensor reports an error.
#[case(id = "406/error-behaviour/no-change", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, TemperatureLimit, VisibleState], catches = [ProfileErrorAlwaysLeaves])]
fn no_change(bench: &mut Bench<'_>) -> Judged {
    overheated(bench, 1, State::OPERATIONAL)
}

/// With 1029h:02 = 2 an encoder enters stopped when its sensor reports an error.
#[case(id = "406/error-behaviour/stopped", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, TemperatureLimit, VisibleState], catches = [ProfileErrorIgnored])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    overheated(bench, 2, State::STOPPED)
}
