//! Error behaviour (1029h): the effect of a communication error on the NMT state.

use super::heartbeat_consumer::entry;
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

const BEHAVIOUR: Multiplexer = Multiplexer::new(object::ERROR_BEHAVIOR, 1);
const WATCHED: Multiplexer = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1);
const CONSUMER_MS: u16 = 200;
const UNTIL_LOST: Duration = Duration::from_millis(600);

/// The state that an operational device enters when it loses its master or a monitored node: pre-operational by
/// default, and the tester sets this default if 1029h:01 can be written; `None` if the device keeps its state or has
/// its own behaviour.
pub(super) fn after_a_loss(bench: &mut Bench<'_>) -> Result<Option<State>, Stop> {
    if bench.can_write(BEHAVIOUR)? {
        bench.write(BEHAVIOUR, &[0])?;
        return Ok(Some(State::PRE_OPERATIONAL));
    }
    Ok(match bench.upload(BEHAVIOUR)?.outcome {
        Outcome::Uploaded(value) => match value.as_slice() {
            [0] => Some(State::PRE_OPERATIONAL),
            [2] => Some(State::STOPPED),
            _ => None,
        },
        _ => Some(State::PRE_OPERATIONAL),
    })
}

/// With this behaviour, makes a monitored node fall silent while the device is in `from`, and requires that the device
/// is then in `to`.
fn lost(bench: &mut Bench<'_>, behaviour: u8, from: State, to: State) -> Judged {
    bench.expect_emergencies();
    let Some(node) = bench.vacant_neighbour() else {
        let reason = Reason::new("a neighbouring node-ID is free", "one", "none");
        return Err(Stop::NotApplicable(reason));
    };
    bench.write_confirmed(BEHAVIOUR, &[behaviour])?;
    bench.show_state()?;
    bench.write(WATCHED, &entry(node, CONSUMER_MS))?;
    bench.reach(from)?;
    let beat = ErrorControl::heartbeat(State::OPERATIONAL).to_frame(error_control::CAN_ID_BASE + u16::from(node));
    bench.send(&beat)?;
    bench.require_state(from)?;
    bench.listen(UNTIL_LOST)?;
    let found = bench.state()?.map_or(Observation::Silence, Observation::State);
    bench.check(demand(found == Observation::State(to), || {
        let duty =
            format!("the device is {to} after the loss of a monitored node in {from} with 1029h:01 = {behaviour}");
        Breach::new(BEHAVIOUR, duty).expected(Observation::State(to)).found(found)
    }))
}

/// With 1029h:01 = 0 an operational device enters pre-operational when it loses a monitored node.
#[case(id = "301/error-behaviour/pre-operational", clause = "CiA 301 7.5.2.32", confidence = Cited, level = Must,
       needs = [ErrorBehaviour, HeartbeatConsumer, VisibleState], catches = [ErrorBehaviourIgnored])]
fn pre_operational(bench: &mut Bench<'_>) -> Judged {
    lost(bench, 0, State::OPERATIONAL, State::PRE_OPERATIONAL)
}

/// With 1029h:01 = 1 a device stays in its NMT state when it loses a monitored node.
#[case(id = "301/error-behaviour/no-change", clause = "CiA 301 7.5.2.32", confidence = Cited, level = Must,
       needs = [ErrorBehaviour, HeartbeatConsumer, VisibleState], catches = [ErrorBehaviourAlwaysLeaves])]
fn no_change(bench: &mut Bench<'_>) -> Judged {
    lost(bench, 1, State::OPERATIONAL, State::OPERATIONAL)
}

/// With 1029h:01 = 2 a device enters stopped when it loses a monitored node.
#[case(id = "301/error-behaviour/stopped", clause = "CiA 301 7.5.2.32", confidence = Cited, level = Must,
       needs = [ErrorBehaviour, HeartbeatConsumer, VisibleState], catches = [ErrorBehaviourIgnored])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    lost(bench, 2, State::OPERATIONAL, State::STOPPED)
}

/// With 1029h:01 = 0 a stopped device stays stopped when it loses a monitored node: only an operational device changes
/// its state.
#[case(id = "301/error-behaviour/only-operational", clause = "CiA 301 7.5.2.32", confidence = Cited, level = Must,
       needs = [ErrorBehaviour, HeartbeatConsumer, VisibleState], catches = [ErrorBehaviourLeavesStopped])]
fn only_operational(bench: &mut Bench<'_>) -> Judged {
    lost(bench, 0, State::STOPPED, State::STOPPED)
}

/// 1029h accepts 0, 1 and 2. The reserved values 3 to 127 are refused with abort 0609 0030h or 0609 0031h; values above
/// 127 are specific to the manufacturer.
#[case(id = "301/error-behaviour/reserved", clause = "CiA 301 7.5.2.32", confidence = Cited, level = Should,
       needs = [ErrorBehaviour], catches = [SdoRangeWrongCode, ErrorBehaviourUnchecked])]
fn reserved(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(BEHAVIOUR)?;
    bench.each([3_u8, 64, 127], |bench, value| {
        let attempt = bench.download(BEHAVIOUR, &[value])?;
        bench.check(attempt.refused(Situation::InvalidValue))
    })?;
    bench.expect_unchanged(BEHAVIOUR, &before)?;
    bench.each([0_u8, 1, 2], |bench, value| {
        let attempt = bench.download(BEHAVIOUR, &[value])?;
        bench.check(attempt.expect_confirmation())
    })
}
