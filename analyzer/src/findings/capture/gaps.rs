use super::name;
use crate::findings::rule::CaptureRule;
use crate::findings::sink::{Report, Sink};
use crate::findings::source::SourceQuality;
use canvass_macros::rule;
use canvass_traces::Duration;

/// nothing was recorded for a long time
///
/// For a time that is far longer than what was usual before, no frame of any node was recorded.
///
/// # Why
/// Either the bus was silent (no supply, a broken wire, bus-off), or recording was paused. Where several nodes fall
/// silent together, no rule blames one of them.
///
/// # What to do
/// Find out whether the machine was switched off at that time. If it was not, look at the frames before the gap: the
/// last thing that happened is the best clue.
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
