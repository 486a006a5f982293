use super::name;
use crate::findings::rule::CaptureRule;
use crate::findings::sink::{Report, Sink};
use crate::findings::source::SourceQuality;
use canvass_macros::rule;
use canvass_traces::Duration;

/// the clock of the capture steps back
///
/// A frame is older than the one before it in the same file, by more than reordering explains.
///
/// # Why
/// Times around such a place are unreliable: the clock of the recording machine was set, several recordings were
/// joined, or the tool does not sort frames by time.
///
/// # What to do
/// Record with a monotonic clock or with the time stamps of the interface; keep time synchronisation off while
/// recording.
#[rule(id = "capture/clock-steps", severity = Warning, rank = Detail, of = capture)]
struct ClockSteps {
    /// minimum length of the largest backward step
    #[threshold(ms = 20)]
    least: Duration,
}

impl CaptureRule for ClockSteps {
    fn check(&self, at: usize, source: &SourceQuality<'_>, sink: &mut Sink<'_>) {
        let steps = &source.quality.steps;
        let Some(first) = steps.first.filter(|_| steps.largest >= self.least) else { return };
        let report = Report::at(first.time).source(at).place(first.time, first.place);
        sink.report(report, || {
            let (count, largest) = (steps.count, steps.largest);
            match count {
                1 => format!("{}: the clock steps back by {largest}", name(source)),
                _ => format!("{}: the clock steps back {count} times, by at most {largest}", name(source)),
            }
        });
    }
}
