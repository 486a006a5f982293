use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Seen};
use canvass_macros::rule;
use canvass_traces::Duration;

/// a heartbeat comes late
///
/// A heartbeat comes later than one and a half of its period, but no heartbeat is missing. The period is the value of
/// 1017h if the capture shows it, otherwise the period that the node has kept before. Pauses around NMT commands,
/// resets and stores are not counted.
///
/// # Why
/// A consumer that waits for one and a half or two periods is about to declare the node lost. The node, or the bus, is
/// too busy to send in time.
///
/// # What to do
/// Check the bus load at that time, and the other messages of the node. If a heartbeat time is below 20 ms, lengthen
/// it.
#[rule(id = "nodes/heartbeat-late", severity = Warning, rank = Detail, services = [Heartbeat])]
struct HeartbeatLate {
    /// an interval beyond this share of the period is late
    #[threshold(percent = 150)]
    percent: Percent,
    #[from(super::heartbeat_missing::percent)]
    missing: Percent,
    /// a smaller delay is not reported
    #[threshold(ms = 10)]
    least: Duration,
}

impl Rule for HeartbeatLate {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(interval) = context.news().heartbeat else { return };
        let slack = context.scene.slack() + self.least;
        let Some(period) = interval.exceeds(self.percent, slack) else { return };
        if interval.misses(self.missing, context.scene.slack()).is_some() {
            return;
        }
        let report = Report::at(context.now()).node(context.node()).measure(interval.length.nanos());
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("a heartbeat after {}, but its period is {period}", interval.length));
    }
}
