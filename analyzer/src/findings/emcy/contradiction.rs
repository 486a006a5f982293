use crate::dictionary::names::ErrorName;
use crate::findings::Context;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::message::Message;
use canvass_macros::rule;

/// error code and error register contradict each other
///
/// An EMCY with an error code has an error register of 0, or an error register without the bit of the code's class:
/// current (2xxxh), voltage (3xxxh), temperature (4xxxh), communication (8110h to 82xxh). Two cases are not reported: a
/// missing bit 0, which is common, and 8100h without the communication bit, which devices older than that bit send.
///
/// # Why
/// A master that evaluates the register concludes that the error is gone, or that it is another error.
///
/// # What to do
/// The device's firmware is faulty (CiA 301, 1001h and emergency error codes).
#[rule(id = "emcy/contradiction", severity = Warning, rank = Detail, services = [Emcy])]
struct Contradiction;

impl Rule for Contradiction {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Message::Emcy(emcy) = context.message() else { return };
        let (Some(code), Some(register)) = (emcy.code(), emcy.register()) else { return };
        let old = code.0 == 0x8100;
        let lacking = if old { 0 } else { code.register_bits() & !register.0 };
        if !code.is_reset() && (register.0 == 0 || lacking != 0) {
            let report =
                Report::at(context.now()).node(context.node()).detail(u64::from(code.0)).kind(u64::from(code.0));
            sink.report(report.evidence(context.evidence()), || {
                let profile = context.node().and_then(|node| context.scene.bus.node(node)?.profile(node));
                let code = ErrorName { code, profile };
                format!("code {code}, but the error register is {:02X}h", register.0)
            });
        }
    }
}
