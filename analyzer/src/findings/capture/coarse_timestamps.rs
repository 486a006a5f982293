use super::name;
use crate::findings::Severity;
use crate::findings::context::is_coarse;
use crate::findings::diagnosis::SourceQuality;
use crate::findings::rule::{Also, Definition, Metadata, Threshold, Thresholds};
use crate::findings::sink::{Report, Sink};
use canvass_traces::Duration;

pub const RULE: Definition = Definition { metadata: &METADATA, services: &[], also: Also::Nothing, make: None };

static METADATA: Metadata = Metadata {
    id: "capture/coarse-timestamps",
    severity: Severity::Info,
    title: "the times of the capture are coarse",
    what: "All times are multiples of a whole millisecond or more, and so many frames have the same time as the frame \
           before them that it is the clock that is coarse.",
    why: "Response times, jitter and the bit rate can't be told from such times. Rules that measure intervals allow \
          for two steps of the clock.",
    advice: "If timing matters, record in a format and with an interface that keep microseconds.",
    thresholds: &[
        Threshold { name: "resolution", default: 1, unit: "ms", meaning: "as coarse as this, or coarser" },
        Threshold { name: "frames", default: 20, unit: "", meaning: "so many frames are needed to say it" },
    ],
};

pub fn check(at: usize, source: &SourceQuality<'_>, thresholds: &Thresholds, sink: &mut Sink<'_>) {
    let coarse = Duration::from_millis(thresholds.get(&METADATA, "resolution"));
    let frames = source.quality.frames.total();
    let enough = frames >= thresholds.get(&METADATA, "frames") && is_coarse(source.quality);
    let Some(resolution) = source.quality.resolution.get().filter(|unit| enough && *unit >= coarse) else { return };
    let time = source.quality.first.unwrap_or_default();
    sink.report(Report::at(time).source(at), || format!("{}: times are multiples of {resolution}", name(source)));
}
