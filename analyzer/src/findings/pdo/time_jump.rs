use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::Message;
use crate::wire::time::TimeOfDay;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// the time in TIME jumps
///
/// Between two TIME messages the time of day has advanced by more or less than the clock of the capture.
///
/// # Why
/// Devices that log events or synchronise clocks adopt the jump.
///
/// # What to do
/// The producer's clock was set, or there are two producers. A step of one hour indicates a producer that sends local
/// time.
#[rule(id = "pdo/time-jump", severity = Warning, rank = Detail, services = [Time])]
struct TimeJump {
    /// a smaller difference counts as drift
    #[threshold(ms = 1000)]
    most: Duration,
    last: Option<(u64, Timestamp)>,
}

impl Rule for TimeJump {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Message::Time(time) = context.message() else { return };
        let said = u64::from(time.days) * u64::from(TimeOfDay::DAY) + u64::from(time.milliseconds());
        let Some((before, at)) = self.last.replace((said, context.now())) else { return };
        let passed = context.now().since(at);
        let off = (i128::from(said) - i128::from(before)) * 1_000_000 - i128::from(passed.nanos());
        let jump = Duration(u64::try_from(off.unsigned_abs()).unwrap_or(u64::MAX));
        if jump > self.most + context.scene.slack() {
            let report = Report::at(context.now()).measure(jump.nanos());
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            sink.report(report, || {
                let way = if off > 0 { "ahead" } else { "back" };
                // The overflow of a counter of milliseconds with 32 bits.
                const WRAPPED: u64 = (1 << 32) * 1_000_000;
                let wrapped = jump.nanos().abs_diff(WRAPPED) <= self.most.nanos();
                let why = if wrapped { ": 2^32 ms, the producer's counter of milliseconds has wrapped" } else { "" };
                format!("TIME jumps {way} by {jump}{why}")
            });
        }
    }

    fn interrupted(&mut self) {
        self.last = None;
    }
}
