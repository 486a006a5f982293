use crate::findings::rule::{Also, Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::Service;
use crate::wire::error_frame::ErrorFrame;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::ErrorFrame],
    also: Also::Nothing,
    make: Some(|_| Box::new(Overrun)),
};

static METADATA: Metadata = Metadata {
    id: "capture/overrun",
    severity: Severity::Warning,
    title: "the recorder's controller lost frames",
    what: "An error frame says that the receive or transmit buffer of the controller that recorded has overflowed.",
    why: "Frames that were on the bus are not in the capture. A missing answer or heartbeat near such a place proves \
          nothing against a node.",
    advice: "Record again with an interface that has larger buffers, or with less load on the recording machine.",
    thresholds: &[],
};

/// Overflow of the receive or transmit buffer, in byte 1.
const OVERFLOW: u8 = 0x01 | 0x02;

struct Overrun;

impl Rule for Overrun {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(error) = ErrorFrame::of(&context.record.frame) else { return };
        if error.class.0 & 0x004 != 0 && error.detail[1] & OVERFLOW != 0 {
            let which = if error.detail[1] & 0x01 != 0 { "receive" } else { "transmit" };
            let report = Report::at(context.now()).detail(u64::from(error.detail[1] & OVERFLOW));
            sink.report(report.evidence(context.evidence()), || format!("{which} buffer of the controller overflowed"));
        }
    }
}
