use crate::findings::Severity;
use crate::findings::rule::{Also, Definition, Metadata};
use crate::findings::sink::{Report, Sink};
use canvass_traces::{Place, Timestamp};

pub const RULE: Definition = Definition { metadata: &METADATA, services: &[], also: Also::Nothing, make: None };

static METADATA: Metadata = Metadata {
    id: "capture/copies",
    severity: Severity::Info,
    title: "frames are in the capture twice",
    what: "A frame is followed by the same frame sooner than a bus of 1 Mbit/s could carry it again, or within a \
           millisecond with the other direction. Such copies are counted as frames; no rule looks at them.",
    why: "Many interfaces give back what they have sent. Taken for frames of the bus, copies look like a second sender: \
          of SYNC, of a heartbeat, of an answer.",
    advice: "Nothing is wrong with the bus. Switch off the loop-back of the recording interface, or record with one that \
             does not send.",
    thresholds: &[],
};

/// Says how many copies there were on a bus, and where the first one stands.
pub fn tell(copies: u64, time: Timestamp, place: Place, sink: &mut Sink<'_>) {
    let report = Report::at(time).place(time, place);
    sink.report(report, || format!("{copies} frames were recorded twice, the first here"));
}
