use super::name;
use crate::findings::Severity;
use crate::findings::diagnosis::SourceQuality;
use crate::findings::rule::{Also, Definition, Metadata, Threshold, Thresholds};
use crate::findings::sink::{Report, Sink};
use canvass_traces::Duration;

pub const RULE: Definition = Definition { metadata: &METADATA, services: &[], also: Also::Nothing, make: None };

static METADATA: Metadata = Metadata {
    id: "capture/clock-steps",
    severity: Severity::Warning,
    title: "the clock of the capture steps back",
    what: "A frame is older than the one before it in the same file, by more than reordering explains.",
    why: "Times are not to be trusted around such a place: the clock of the recording machine was set, several \
          recordings were joined, or the tool sorts frames by something else.",
    advice: "Record with a monotonic clock or with the time stamps of the interface; keep time synchronisation off \
             while recording.",
    thresholds: &[Threshold { name: "least", default: 1, unit: "ms", meaning: "the largest step must be as long" }],
};

pub fn check(at: usize, source: &SourceQuality<'_>, thresholds: &Thresholds, sink: &mut Sink<'_>) {
    let steps = &source.quality.steps;
    let least = Duration::from_millis(thresholds.get(&METADATA, "least"));
    let Some(first) = steps.first.filter(|_| steps.largest >= least) else { return };
    let report = Report::at(first.time).source(at).place(first.time, first.place);
    sink.report(report, || {
        let (count, largest) = (steps.count, steps.largest);
        match count {
            1 => format!("{}: the clock steps back by {largest}", name(source)),
            _ => format!("{}: the clock steps back {count} times, by at most {largest}", name(source)),
        }
    });
}
