use super::name;
use crate::findings::rule::CaptureRule;
use crate::findings::sink::{Report, Sink};
use crate::findings::source::SourceQuality;
use canvass_macros::rule;

/// the recorder lost frames
///
/// The recorder itself reports in the capture that it was too slow and lost frames: by a drop count of candump, or of
/// the packets of a pcapng file.
///
/// # Why
/// Frames that were on the bus are not in the capture. A missing answer or heartbeat near such a place proves nothing
/// against a node.
///
/// # What to do
/// Record again with a larger receive buffer, on a faster machine, or with a filter in the interface.
#[rule(id = "capture/dropped", severity = Warning, rank = Detail, of = capture)]
struct Dropped;

impl CaptureRule for Dropped {
    fn check(&self, at: usize, source: &SourceQuality<'_>, sink: &mut Sink<'_>) {
        let dropped = source.quality.damages.dropped;
        if dropped > 0 {
            let time = source.quality.first.unwrap_or_default();
            sink.report(Report::at(time).source(at), || {
                format!("{}: {dropped} frames lost by the recorder", name(source))
            });
        }
    }
}
