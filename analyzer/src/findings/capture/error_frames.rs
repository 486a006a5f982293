use crate::findings::Context;
use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::wire::error_frame::ErrorFrame;
use canvass_macros::rule;

/// Error classes for errors on the bus: transmit timeout, protocol, transceiver, no acknowledgement, bus error.
const ERRORS: u32 = 0x001 | 0x008 | 0x010 | 0x020 | 0x080;
/// Error class for the controller's state.
const CONTROLLER: u32 = 0x004;
/// Bits of byte 1: receive and transmit warning level.
const WARNING: u8 = 0x04 | 0x08;

/// Effects: errors make a node error passive.
const EFFECTS: &[Effect] = &[Effect::on(&["capture/error-passive"])];

/// the recorder's controller reports errors on the bus
///
/// The capture contains error frames: a violation of the protocol (bit, stuff, form or CRC error), a missing
/// acknowledgement, a transmit timeout, or an error counter that has reached the warning level. A lost arbitration is
/// no error.
///
/// # Why
/// A good bus has no error frames. They are caused by wrong termination, long stubs, bad shields, two bit rates on one
/// bus, or two senders of one CAN-ID. Frames are repeated and delayed until a controller gives up.
///
/// # What to do
/// Switch the supply off and measure 60 ohms between the wires. Check at which frames the errors occur: errors always
/// in the data of one CAN-ID indicate two senders of it, random errors indicate the wiring, a missing acknowledgement
/// indicates a recorder that was alone on the bus or at another bit rate.
#[rule(id = "capture/error-frames", severity = Warning, rank = State, services = [ErrorFrame], leads_to = EFFECTS)]
struct ErrorFrames;

/// Whether the frame reports an error on the bus.
pub fn is_error(error: &ErrorFrame) -> bool {
    let warning = error.class.0 & CONTROLLER != 0 && error.detail[1] & WARNING != 0;
    // Other tools record only that there was an error, without any class.
    error.class.0 & ERRORS != 0 || warning || error.class.0 == 0
}

impl Rule for ErrorFrames {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(error) = ErrorFrame::of(&context.record.frame) else { return };
        if !is_error(&error) {
            return;
        }
        let report = Report::at(context.now()).detail(u64::from(error.class.0)).evidence(context.evidence());
        sink.report(report, || format!("{error}"));
    }
}
