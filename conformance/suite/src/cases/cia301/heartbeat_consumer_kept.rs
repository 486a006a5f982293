//! Events after which the device still monitors a node (1016h), and events after which it does not.

use super::heartbeat_consumer::{
    CONSUMER_TIME, beat, consequence, entry, neighbour, noticed, operational, signs, signs_since, unnoticed, watch,
};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::object::{CONSUMER_HEARTBEAT_TIME, ERROR_BEHAVIOR, PRODUCER_HEARTBEAT_TIME};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;

const WATCHED: Multiplexer = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1);

/// Writes to other objects do not affect the monitoring of a node: the device detects the loss of the node after the
/// consumer heartbeat time.
#[case(id = "301/heartbeat-consumer/beside-writes", clause = "CiA 301 7.2.8.3.2.2", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer, ScratchObject], catches = [HeartbeatConsumerRestartedByWrites])]
fn beside_writes(bench: &mut Bench<'_>) -> Judged {
    // Objects that determine how a loss shows keep their values.
    let is_apart = |index| !matches!(index, CONSUMER_HEARTBEAT_TIME | PRODUCER_HEARTBEAT_TIME | ERROR_BEHAVIOR);
    let mut scratches = bench.scratch_objects()?;
    scratches.retain(|scratch| is_apart(scratch.multiplexer.index.0));
    if scratches.is_empty() {
        let reason = Reason::new("a parameter that does not affect monitoring can be written", "one", "none");
        return Err(Stop::NotApplicable(reason));
    }
    let watch = watch(bench)?;
    beat(bench, watch.node)?;
    let begun = bench.now();
    for scratch in scratches.iter().take(2) {
        bench.write(scratch.multiplexer, &scratch.other)?;
    }
    let signs = signs_since(bench, begun, CONSUMER_TIME.times(4))?;
    noticed(WATCHED, &watch, &signs)
}

/// Heartbeats also count while the device is stopped: if the first heartbeat of a monitored node arrives then, the
/// device detects the loss of the node once the device is operational and the node is silent.
#[case(id = "301/heartbeat-consumer/stopped", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Should,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerDeafWhenStopped])]
fn heard_in_stopped(bench: &mut Bench<'_>) -> Judged {
    let watch = watch(bench)?;
    let reaction = bench.timing().reaction;
    // The device is operational long before it misses the node: in stopped the loss would change nothing.
    let time = CONSUMER_TIME.times(5).max(reaction.times(4));
    let milliseconds = u16::try_from(time.nanos() / 1_000_000).unwrap_or(u16::MAX);
    bench.write(WATCHED, &entry(watch.node, milliseconds))?;
    bench.command(Command::STOP)?;
    bench.listen(reaction)?;
    beat(bench, watch.node)?;
    let heard = bench.now();
    bench.listen(reaction)?;
    operational(bench)?;
    let took = bench.now().since(heard);
    demand(took < time, || {
        let breach = Breach::new(
            WATCHED,
            format!("the device is operational within {time}, before it detects the loss of the node"),
        );
        breach.expected(format!("less than {time}")).found(Observation::Time(took))
    })
    .or_inconclusive()?;
    let missed = signs(bench, time.times(2))?;
    let unheard = match noticed(WATCHED, &watch, &missed) {
        Err(Stop::Breach(breach)) => breach,
        judged => return judged,
    };
    // The result proves that the device ignores heartbeats in stopped only if it misses nodes at all.
    beat(bench, watch.node)?;
    let lost = signs(bench, time.times(2))?;
    if let Err(Stop::Breach(_)) = noticed(WATCHED, &watch, &lost) {
        let reason = Reason::new(
            "the device reports the loss of a node that it monitors in operational",
            "a visible loss",
            lost.text(),
        );
        return Err(Stop::NotApplicable(reason));
    }
    let found = format!("{}; the node's heartbeat came while the device was stopped, and none since", missed.text());
    bench.check(Err(Box::new(unheard.told(found))))
}

/// Reset communication removes an entry of 1016h that was not stored: the device no longer monitors its node.
#[case(id = "301/heartbeat-consumer/reset", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerOutlivesReset])]
fn reset(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    let node = neighbour(bench)?;
    consequence(bench)?;
    let own = entry(node, 200);
    let before = bench.read(WATCHED)?;
    bench.write(WATCHED, &own)?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    let now = bench.read(WATCHED)?;
    if now == own && bench.stores_by_itself()? {
        let reason =
            Reason::new("a reset restores the power-on value of 1016h:01", "another value", "the written value");
        return Err(Stop::NotApplicable(reason));
    }
    demand(now != own, || {
        let breach =
            Breach::new(WATCHED, "an entry that was not stored has its power-on value after reset communication");
        breach.expected(Observation::Value(before)).found(Observation::Value(now))
    })?;
    consequence(bench)?;
    operational(bench)?;
    let begun = bench.now();
    beat(bench, node)?;
    let signs = signs_since(bench, begun, CONSUMER_TIME.times(4))?;
    bench.check(unnoticed(WATCHED, "a node that 1016h no longer contains is not reported as lost", &signs))
}
