use super::name;
use crate::findings::Severity;
use crate::findings::diagnosis::SourceQuality;
use crate::findings::rule::{Also, Definition, Metadata, Threshold, Thresholds};
use crate::findings::sink::{Report, Sink};
use canvass_traces::Duration;

pub const RULE: Definition = Definition { metadata: &METADATA, services: &[], also: Also::Nothing, make: None };

static METADATA: Metadata = Metadata {
    id: "capture/gaps",
    severity: Severity::Info,
    title: "nothing was recorded for a long time",
    what: "For a time that is far longer than what was usual before, no frame of any node was recorded.",
    why: "Either the bus was silent (no supply, a broken wire, bus-off), or recording was paused. Where several nodes \
          fall silent together, no rule blames one of them.",
    advice: "Find out whether the machine was switched off at that time. If it was not, look at the frames before the \
             gap: the last thing that happened is the best clue.",
    thresholds: &[Threshold { name: "least", default: 3000, unit: "ms", meaning: "a gap is at least as long" }],
};

pub fn check(at: usize, source: &SourceQuality<'_>, thresholds: &Thresholds, sink: &mut Sink<'_>) {
    let least = Duration::from_millis(thresholds.get(&METADATA, "least"));
    let gaps = &source.quality.gaps;
    let Some(largest) = gaps.largest.filter(|gap| gap.length >= least) else { return };
    let end = largest.end;
    sink.report(Report::at(end.time).source(at).place(end.time, end.place), || {
        let (length, usual) = (largest.length, largest.usual);
        let name = name(source);
        format!("{name}: nothing was recorded for {length} before this frame; 99 of 100 pauses were below {usual}")
    });
}
