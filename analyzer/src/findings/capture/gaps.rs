use super::name;
use crate::findings::rule::CaptureRule;
use crate::findings::sink::{Report, Sink};
use crate::findings::source::SourceQuality;
use canvass_macros::rule;
use canvass_traces::Duration;

/// nothing was recorded for a long time
///
/// No frame of any node was recorded for a time that is far longer than the usual pauses before it.
///
/// # Why
/// Either the bus was silent (no supply, a broken wire, bus-off), or recording was paused. If several nodes fall silent
/// together, no rule blames a single node.
///
/// # What to do
/// Find out whether the machine was switched off at that time. If not, check the last frames before the gap.
#[rule(id = "capture/gaps", severity = Info, rank = Detail, of = capture)]
struct Gaps {
    /// least length of a gap
    #[threshold(ms = 3000)]
    least: Duration,
}

impl CaptureRule for Gaps {
    fn check(&self, at: usize, source: &SourceQuality<'_>, sink: &mut Sink<'_>) {
        let gaps = &source.quality.gaps;
        let Some(largest) = gaps.largest.filter(|gap| gap.length >= self.least) else { return };
        let end = largest.end;
        sink.report(Report::at(end.time).source(at).place(end.time, end.place), || {
            let (length, usual) = (largest.length, largest.usual);
            let name = name(source);
            format!("{name}: nothing was recorded for {length} before this frame; 99 of 100 pauses were below {usual}")
        });
    }
}
