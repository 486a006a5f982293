use crate::findings::sink::{Report, Sink};
use canvass_macros::rule;
use canvass_traces::{Place, Timestamp};

/// frames are in the capture twice
///
/// A frame is followed by the same frame sooner than a bus of 1 Mbit/s can transmit it again, or within a millisecond
/// with the other direction. Such copies count as frames, but no rule evaluates them.
///
/// # Why
/// Many interfaces return the frames that they have sent. If such copies were taken for frames of the bus, they would
/// look like a second sender of SYNC, of a heartbeat or of an answer.
///
/// # What to do
/// Nothing is wrong with the bus. Switch off the loop-back of the recording interface, or record with one that does not
/// send.
#[rule(id = "capture/copies", severity = Info, rank = Detail, of = nothing)]
pub struct Copies;

/// Reports the number of copies on a bus, and the place of the first one.
pub fn tell(copies: u64, time: Timestamp, place: Place, sink: &mut Sink<'_>) {
    let report = Report::at(time).place(time, place);
    sink.report(report, || format!("{copies} frames were recorded twice, the first here"));
}
