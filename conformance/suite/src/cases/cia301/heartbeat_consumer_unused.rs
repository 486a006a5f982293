//! Entries of the heartbeat consumer (1016h) that are not used.

use super::heartbeat_consumer::{beat, consequence, entry, neighbour, operational, signs, unnoticed};
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_traces::Duration;

const WATCHED: Multiplexer = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1);

/// An entry with a node-ID and the time 0 is not used: heartbeats of that node do not start monitoring, and the device
/// reports no loss of it.
#[case(id = "301/heartbeat-consumer/time-zero", clause = "CiA 301 7.5.2.19", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerTimeZero])]
fn time_zero(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    let node = neighbour(bench)?;
    consequence(bench)?;
    let attempt = bench.download(WATCHED, &entry(node, 0))?;
    attempt.refused(Situation::Confirmed).or_inconclusive()?;
    operational(bench)?;
    bench.each(["first", "second"], |bench, which| {
        beat(bench, node)?;
        let signs = signs(bench, Duration::from_millis(500))?;
        let duty = format!("a node whose entry has the time 0 is not reported as lost after its {which} heartbeat");
        bench.check(unnoticed(WATCHED, duty, &signs))
    })
}
