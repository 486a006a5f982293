use crate::findings::Context;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::wire::error_frame::ErrorFrame;
use canvass_macros::rule;

/// Bits of byte 1: overflow of the receive or transmit buffer.
const OVERFLOW: u8 = 0x01 | 0x02;

/// the recorder's controller lost frames
///
/// An error frame reports that the receive or transmit buffer of the recording controller has overflowed.
///
/// # Why
/// Frames that were on the bus are not in the capture. A missing answer or heartbeat near such a place proves nothing
/// against a node.
///
/// # What to do
/// Record again with an interface that has larger buffers, or with less load on the recording machine.
#[rule(id = "capture/overrun", severity = Warning, rank = Detail, services = [ErrorFrame])]
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
