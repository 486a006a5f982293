use super::name;
use crate::findings::Severity;
use crate::findings::diagnosis::SourceQuality;
use crate::findings::rule::{Also, Definition, Metadata, Thresholds};
use crate::findings::sink::{Report, Sink};

pub const RULE: Definition = Definition { metadata: &METADATA, services: &[], also: Also::Nothing, make: None };

static METADATA: Metadata = Metadata {
    id: "capture/dropped",
    severity: Severity::Warning,
    title: "the recorder lost frames",
    what: "The capture holds the recorder's own word that it could not keep up and lost frames: a drop count of \
           candump, or of the packets of a pcapng file.",
    why: "Frames that were on the bus are not in the capture. A missing answer or heartbeat near such a place proves \
          nothing against a node.",
    advice: "Record again with a larger receive buffer, on a faster machine, or with a filter in the interface.",
    thresholds: &[],
};

pub fn check(at: usize, source: &SourceQuality<'_>, _: &Thresholds, sink: &mut Sink<'_>) {
    let dropped = source.quality.damages.dropped;
    if dropped > 0 {
        let time = source.quality.first.unwrap_or_default();
        sink.report(Report::at(time).source(at), || format!("{}: {dropped} frames lost by the recorder", name(source)));
    }
}
