//! Error behaviour (1029h): what a communication error does to the NMT state.

use super::heartbeat_consumer::entry;
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::Duration;

const BEHAVIOUR: Multiplexer = Multiplexer::new(0x1029, 1);
const WATCHED: Multiplexer = Multiplexer::new(0x1016, 1);
const CONSUMER_MS: u16 = 200;
const UNTIL_LOST: Duration = Duration::from_millis(600);

/// With that behaviour, lets a watched node fall silent while the device is in `from`, and demands that it then is in
/// `to`.
fn lost(bench: &mut Bench<'_>, behaviour: u8, from: State, to: State) -> Judged {
    bench.expect_emergencies();
    let Some(node) = bench.vacant_neighbour() else {
        let reason = Reason::new("a node-ID beside that of the device is free", "one", "none");
        return Err(Stop::NotApplicable(reason));
    };
    bench.write(BEHAVIOUR, &[behaviour])?;
    bench.show_state()?;
    bench.write(WATCHED, &entry(node, CONSUMER_MS))?;
    bench.reach(from)?;
    let beat = ErrorControl::heartbeat(State::OPERATIONAL).to_frame(error_control::CAN_ID_BASE + u16::from(node));
    bench.send(&beat)?;
    bench.listen(Duration::from_millis(50))?;
    bench.expect_state(from, "a heartbeat of the watched node").or_inconclusive()?;
    bench.listen(UNTIL_LOST)?;
    bench.expect_state(to, &format!("the loss of a watched node with 1029h:01 = {behaviour}"))
}

/// With 1029h:01 = 0 an operational device that loses a watched node becomes pre-operational.
#[case(id = "301/error-behaviour/pre-operational", clause = "CiA 301 7.5.2.32", confidence = Derived, level = Must,
       needs = [ErrorBehaviour, HeartbeatConsumer, VisibleState], catches = [ErrorBehaviourIgnored])]
fn pre_operational(bench: &mut Bench<'_>) -> Judged {
    lost(bench, 0, State::OPERATIONAL, State::PRE_OPERATIONAL)
}

/// With 1029h:01 = 1 a device that loses a watched node stays in its state.
#[case(id = "301/error-behaviour/no-change", clause = "CiA 301 7.5.2.32", confidence = Derived, level = Must,
       needs = [ErrorBehaviour, HeartbeatConsumer, VisibleState], catches = [ErrorBehaviourAlwaysLeaves])]
fn no_change(bench: &mut Bench<'_>) -> Judged {
    lost(bench, 1, State::OPERATIONAL, State::OPERATIONAL)
}

/// With 1029h:01 = 2 a device that loses a watched node becomes stopped.
#[case(id = "301/error-behaviour/stopped", clause = "CiA 301 7.5.2.32", confidence = Derived, level = Must,
       needs = [ErrorBehaviour, HeartbeatConsumer, VisibleState], catches = [ErrorBehaviourIgnored])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    lost(bench, 2, State::OPERATIONAL, State::STOPPED)
}

/// With 1029h:01 = 0 a stopped device that loses a watched node stays stopped: only operational is left.
#[case(id = "301/error-behaviour/only-operational", clause = "CiA 301 7.5.2.32", confidence = Derived, level = Must,
       needs = [ErrorBehaviour, HeartbeatConsumer, VisibleState], catches = [ErrorBehaviourLeavesStopped])]
fn only_operational(bench: &mut Bench<'_>) -> Judged {
    lost(bench, 0, State::STOPPED, State::STOPPED)
}

/// 1029h takes 0, 1 and 2; reserved values are refused with abort 0609 0030h or 0609 0031h.
#[case(id = "301/error-behaviour/reserved", clause = "CiA 301 7.5.2.32", confidence = Derived, level = Must,
       needs = [ErrorBehaviour], catches = [ErrorBehaviourUnchecked])]
fn reserved(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(BEHAVIOUR)?;
    for value in [3_u8, 127, 255] {
        let attempt = bench.download(BEHAVIOUR, &[value])?;
        let strict = [AbortCode::INVALID_VALUE, AbortCode::VALUE_TOO_HIGH];
        bench.check(attempt.refused_with(&strict, &[AbortCode::GENERAL]))?;
    }
    bench.expect_unchanged(BEHAVIOUR, &before)?;
    for value in [0_u8, 1, 2] {
        bench.download(BEHAVIOUR, &[value])?.expect_confirmation()?;
    }
    Ok(())
}
