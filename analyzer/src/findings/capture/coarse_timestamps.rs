use super::name;
use crate::findings::context::is_coarse;
use crate::findings::rule::CaptureRule;
use crate::findings::sink::{Report, Sink};
use crate::findings::source::SourceQuality;
use canvass_macros::rule;
use canvass_traces::Duration;

/// the times of the capture are coarse
///
/// All times are multiples of a millisecond or a longer step, and many frames have the same time as the frame before
/// them, so that only a coarse clock explains them.
///
/// # Why
/// Response times, jitter and the bit rate can't be derived from such times. Rules that measure intervals allow for two
/// steps of the clock.
///
/// # What to do
/// If timing matters, record in a format and with an interface that have a resolution of microseconds.
#[rule(id = "capture/coarse-timestamps", severity = Info, rank = Detail, of = capture)]
struct CoarseTimestamps {
    /// this resolution, or a coarser one, is reported
    #[threshold(ms = 1)]
    resolution: Duration,
    /// least number of frames for a report
    #[threshold(count = 20)]
    frames: u64,
}

impl CaptureRule for CoarseTimestamps {
    fn check(&self, at: usize, source: &SourceQuality<'_>, sink: &mut Sink<'_>) {
        let frames = source.quality.frames.total();
        let enough = frames >= self.frames && is_coarse(source.quality);
        let Some(resolution) = source.quality.resolution.get().filter(|unit| enough && *unit >= self.resolution) else {
            return;
        };
        let time = source.quality.first.unwrap_or_default();
        sink.report(Report::at(time).source(at), || format!("{}: times are multiples of {resolution}", name(source)));
    }
}
