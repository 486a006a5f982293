use crate::findings::Context;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::wire::error_frame::ErrorFrame;
use canvass_macros::rule;

/// Bits of byte 1: receive or transmit error passive.
const PASSIVE: u8 = 0x10 | 0x20;

/// the recorder's controller went error passive
///
/// An error frame reports that an error counter of the recording controller has passed 127: the controller no longer
/// signals errors.
///
/// # Why
/// This number of consecutive errors means that hardly any frame gets through: wrong bit rate, broken wire, missing
/// termination, or no other node that acknowledges.
///
/// # What to do
/// Check bit rate, wiring and termination. If only transmission fails, the recorder was alone on the bus.
#[rule(id = "capture/error-passive", severity = Error, rank = State, services = [ErrorFrame])]
struct ErrorPassive;

impl Rule for ErrorPassive {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(error) = ErrorFrame::of(&context.record.frame) else { return };
        if error.class.0 & 0x004 == 0 || error.detail[1] & PASSIVE == 0 {
            return;
        }
        let report = Report::at(context.now()).detail(u64::from(error.detail[1] & PASSIVE));
        sink.report(report.evidence(context.evidence()), || {
            let states: Vec<_> = error.controller().collect();
            let counters = error.counters().map(|(tx, rx)| format!(", counters: transmit {tx}, receive {rx}"));
            format!("controller: {}{}", states.join(", "), counters.unwrap_or_default())
        });
    }
}
