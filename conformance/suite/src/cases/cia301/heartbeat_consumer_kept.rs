//! What watching a node (1016h) outlives, and what not.

use super::heartbeat_consumer::{
    CONSUMER_TIME, beat, consequence, entry, neighbour, noticed, operational, signs_since, unnoticed, watch,
};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::object::{CONSUMER_HEARTBEAT_TIME, ERROR_BEHAVIOR, PRODUCER_HEARTBEAT_TIME};
use canvass_analyzer::wire::nmt::Command;

const WATCHED: Multiplexer = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1);

/// A node is watched while other objects are written too: it is missed after the consumer heartbeat time.
#[case(id = "301/heartbeat-consumer/beside-writes", clause = "CiA 301 7.2.8.3.2.2", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer, ScratchObject], catches = [HeartbeatConsumerRestartedByWrites])]
fn beside_writes(bench: &mut Bench<'_>) -> Judged {
    // What says how a loss shows stays as it is.
    let is_apart = |index| !matches!(index, CONSUMER_HEARTBEAT_TIME | PRODUCER_HEARTBEAT_TIME | ERROR_BEHAVIOR);
    let mut scratches = bench.scratch_objects()?;
    scratches.retain(|scratch| is_apart(scratch.multiplexer.index.0));
    if scratches.is_empty() {
        let reason = Reason::new("a parameter of something else can be written", "one", "none");
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

/// An entry that was not stored is gone after reset communication, and with it what it watched.
#[case(id = "301/heartbeat-consumer/reset", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerOutlivesReset])]
fn reset(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    let node = neighbour(bench)?;
    consequence(bench)?;
    let own = entry(node, 200);
    bench.write(WATCHED, &own)?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    if bench.read(WATCHED)? == own {
        let reason = Reason::new("a reset brings the power-on value of 1016h:01", "another value", "the one written");
        return Err(Stop::NotApplicable(reason));
    }
    consequence(bench)?;
    operational(bench)?;
    let begun = bench.now();
    beat(bench, node)?;
    let signs = signs_since(bench, begun, CONSUMER_TIME.times(4))?;
    bench.check(unnoticed(WATCHED, "a node that 1016h does not name any more is not missed", &signs))
}
