//! Stored values take effect after a reset, and are not only read back.

use super::heartbeat_consumer::entry;
use crate::bench::Bench;
use crate::bench::state::HEARTBEAT_TIME;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record};

const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
const WATCHED: Multiplexer = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1);
const PERIOD_MS: u16 = 100;
const PERIOD: Duration = Duration::from_millis(100);
const CONSUMER_MS: u16 = 300;

/// The behaviour of the device after the reset.
struct AfterReset {
    /// Number of heartbeats within ten periods; `None` if the stored time was lost.
    heartbeats: Option<usize>,
    /// The state after a monitored node fell silent; `None` if the stored entry was lost, or the state did not show.
    after_loss: Option<Option<State>>,
}

/// A stored heartbeat time and a stored entry of the heartbeat consumer take effect after a reset, without being
/// written again. The case stores the old values again afterwards.
#[case(id = "301/store/acts", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [Store, Heartbeat], touches = [Nvm], catches = [StoredConfigurationIdle, HeartbeatConsumerForgetsStored, HeartbeatLostOnStateChange,
                                                            ErrorBehaviourIgnored])]
fn acts(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    let watched = match bench.vacant_neighbour() {
        Some(node) if bench.can_write(WATCHED)? => Some((node, bench.read(WATCHED)?)),
        _ => None,
    };
    let own = bench.read(HEARTBEAT_TIME)?;
    bench.write(HEARTBEAT_TIME, &PERIOD_MS.to_le_bytes())?;
    if let Some((node, _)) = watched {
        bench.write(WATCHED, &entry(node, CONSUMER_MS))?;
    }
    bench.write(STORE, b"save")?;
    bench.note("1010h was written twice: the device's non-volatile memory has done two more cycles");
    let seen = after_reset(bench, watched.as_ref().map(|(node, _)| *node));
    // The device gets its old values back, whether the check passed or not.
    bench.download(HEARTBEAT_TIME, &own)?;
    if let Some((_, before)) = &watched {
        bench.download(WATCHED, before)?;
    }
    bench.write(STORE, b"save")?;
    judge(bench, &seen?)
}

fn after_reset(bench: &mut Bench<'_>, node: Option<u8>) -> Result<AfterReset, Stop> {
    bench.reset(Command::RESET_NODE)?;
    let is_stored = bench.upload(HEARTBEAT_TIME)?.outcome == Outcome::Uploaded(PERIOD_MS.to_le_bytes().to_vec());
    let heard = bench.listen(PERIOD.times(10))?;
    let heartbeats = is_stored.then(|| states(bench, &heard).len());
    let mut seen = AfterReset { heartbeats, after_loss: None };
    let Some(node) = node.filter(|_| heartbeats.is_some_and(|count| count > 0)) else { return Ok(seen) };
    if bench.upload(WATCHED)?.outcome != Outcome::Uploaded(entry(node, CONSUMER_MS).to_vec()) {
        return Ok(seen);
    }
    let leaves = super::error_behaviour::after_a_loss(bench)?;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    let beat = ErrorControl::heartbeat(State::OPERATIONAL).to_frame(error_control::CAN_ID_BASE + u16::from(node));
    bench.send(&beat)?;
    let heard = bench.listen(Duration::from_millis(u64::from(CONSUMER_MS) * 3))?;
    let left = states(bench, &heard).into_iter().find(|state| *state != State::OPERATIONAL);
    seen.after_loss = leaves.map(|_| left);
    Ok(seen)
}

fn states(bench: &Bench<'_>, heard: &[Record]) -> Vec<State> {
    let own = heard.iter().filter(|record| bench.is_error_control(&record.frame));
    own.filter_map(|record| Some(ErrorControl::read(record.data()).ok()?.state)).collect()
}

fn judge(bench: &mut Bench<'_>, seen: &AfterReset) -> Judged {
    let Some(count) = seen.heartbeats else {
        let reason = Reason::new("1017h is stored by 1010h:01", "its value after reset node", "another one");
        return Err(Stop::NotApplicable(reason));
    };
    bench.check(demand(count > 4, || {
        Breach::new(Service::Heartbeat, "a stored heartbeat time takes effect after a reset, in ten periods")
            .expected(Allowed::Count { least: 5, most: None })
            .found(Observation::Count(count as u64))
    }))?;
    bench.check(demand(seen.after_loss != Some(None), || {
        let breach = Breach::new(WATCHED, "a stored entry of 1016h monitors its node after a reset");
        breach.expected("the device leaves operational").found(Observation::State(State::OPERATIONAL))
    }))
}
