use crate::findings::Context;
use crate::findings::effect::{Effect, SETTLE};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::wire::error_frame::ErrorFrame;
use canvass_macros::rule;

const BUS_OFF: u32 = 0x040;

/// Effects: the errors that lead to bus-off, or follow from it.
const EFFECTS: &[Effect] = &[Effect::on(&["capture/error-frames", "capture/error-passive"]).during(SETTLE, SETTLE)];

/// the recorder's controller went bus-off
///
/// An error frame reports that the recording controller has left the bus, because its transmit error counter has passed
/// 255.
///
/// # Why
/// Until the controller is restarted, it neither sends nor records. The other nodes may have continued to communicate.
///
/// # What to do
/// Check bit rate and wiring, and whether two senders use one CAN-ID. In a capture of a master, check which frame it
/// was sending.
#[rule(id = "capture/bus-off", severity = Error, rank = Loss, services = [ErrorFrame], leads_to = EFFECTS)]
struct BusOff;

impl Rule for BusOff {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if ErrorFrame::of(&context.record.frame).is_some_and(|error| error.class.0 & BUS_OFF != 0) {
            let report = Report::at(context.now()).evidence(context.evidence());
            sink.report(report, || "the controller is off the bus".to_owned());
        }
    }
}
