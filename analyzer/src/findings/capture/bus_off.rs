use crate::findings::rule::{Also, Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::Service;
use crate::wire::error_frame::ErrorFrame;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::ErrorFrame],
    also: Also::Nothing,
    make: Some(|_| Box::new(BusOff)),
};

static METADATA: Metadata = Metadata {
    id: "capture/bus-off",
    severity: Severity::Error,
    title: "the recorder's controller went bus-off",
    what: "An error frame says that the controller that recorded has left the bus, because its transmit error counter \
           has passed 255.",
    why: "Until it is restarted, it neither sends nor records. The other nodes may have gone on without it.",
    advice: "Check bit rate, wiring, and whether two senders use one CAN-ID. In a capture of a master, look at which \
             frame it was sending.",
    thresholds: &[],
};

const BUS_OFF: u32 = 0x040;

struct BusOff;

impl Rule for BusOff {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if ErrorFrame::of(&context.record.frame).is_some_and(|error| error.class.0 & BUS_OFF != 0) {
            let report = Report::at(context.now()).evidence(context.evidence());
            sink.report(report, || "the controller is off the bus".to_owned());
        }
    }
}
