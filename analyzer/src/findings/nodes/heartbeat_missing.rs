use crate::findings::effect::{Effect, SOON};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Seen, Thresholds};
use canvass_macros::rule;

/// Effects: consumers that miss the heartbeat.
const EFFECTS: &[Effect] = &[
    Effect::on(&["nodes/consumer-time"]).of_origin().during(SOON, SOON),
    Effect::on(&["nodes/consumer-time"]).of_origin().spanning(SOON),
];

/// heartbeats are missing
///
/// The time between two heartbeats is so long that at least one heartbeat is missing. The period is the value of 1017h
/// if the capture shows it, otherwise the period that the node has kept before. Pauses around NMT commands, resets and
/// stores are not counted, and neither are pauses of all nodes together.
///
/// # Why
/// Consumers declare the node lost and react, often by stopping the machine.
///
/// # What to do
/// Check the other messages of the node in the meantime: if there are none, the node was disconnected or hung; if all
/// others came, its heartbeat task is starved. Look for a boot-up shortly after.
#[rule(id = "nodes/heartbeat-missing", severity = Error, rank = State, services = [Heartbeat], leads_to = EFFECTS)]
struct HeartbeatMissing {
    /// beyond this share of the period a heartbeat counts as missing
    #[threshold(percent = 180)]
    percent: Percent,
}

/// The share of the period beyond which a heartbeat counts as missing.
pub fn percent(thresholds: &Thresholds) -> Percent {
    HeartbeatMissing::new(thresholds).percent
}

impl Rule for HeartbeatMissing {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(interval) = context.news().heartbeat.filter(|_| context.news().returned.is_none()) else { return };
        let Some(period) = interval.misses(self.percent, context.scene.slack()) else { return };
        let begin = context.previous.map_or(context.now(), Seen::time);
        let report = Report::at(begin).until(context.now()).node(context.node()).measure(interval.length.nanos());
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || {
            let missed = (interval.length.nanos() + period.nanos() / 2) / period.nanos().max(1) - 1;
            format!("no heartbeat for {}, but its period is {period}: {missed} missing", interval.length)
        });
    }
}
