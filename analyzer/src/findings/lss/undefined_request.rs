use super::exchange::{Sender, own_command, sender, words};
use crate::findings::Context;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::message::Message;
use crate::wire::lss::Request;
use crate::wire::{lmt, lss};
use canvass_macros::rule;

/// an LSS or LMT request has a value that no standard defines
///
/// A request on 7E5h has a command specifier that neither CiA 305 nor CiA DS-205 defines, switches to a state other than 0
/// and 1, or is a Fastscan of a number or bit that no address has. A command specifier of an answer on 7E5h shows that a
/// slave sends with the CAN-ID of the master.
///
/// # Why
/// No slave acts on the request. A slave that sends on 7E5h disturbs the master, and other slaves take its answer for a
/// request.
///
/// # What to do
/// Look at the software of the master; in captures of a disturbed bus, at the error frames.
#[rule(id = "lss/undefined-request", severity = Warning, rank = Detail, services = [Lss, Lmt])]
struct UndefinedRequest;

/// Number of the bits in a number of an LSS address.
const BITS: u8 = 32;
/// The value of Fastscan's BitCheck that begins a scan (CiA 305).
const BEGINS_SCAN: u8 = 128;

/// Whether only an answer has this command specifier.
const fn is_answer(command: u8) -> bool {
    matches!(command, 0x09 | 0x44 | 0x4F | 0x50)
}

/// What is undefined in a request.
fn fault(context: &Context<'_>) -> Option<&'static str> {
    let command = own_command(context);
    match context.message() {
        Message::LssRequest(Request::Unknown { .. }) | Message::LmtRequest(lmt::Request::Unknown { .. }) => {
            Some(if is_answer(command) {
                "is an answer: a slave sends with the master's CAN-ID"
            } else {
                "is not defined"
            })
        }
        Message::LssRequest(Request::SwitchGlobal { mode: 2.. })
        | Message::LmtRequest(lmt::Request::SwitchGlobal { mode: 2.. }) => {
            Some("switches to a state that is not defined")
        }
        Message::LssRequest(Request::Fastscan { bit_check, sub, next, .. }) => {
            let is_bit = *bit_check < BITS || *bit_check == BEGINS_SCAN;
            let is_number = |number: u8| usize::from(number) < lss::Part::ALL.len();
            (!is_bit || !is_number(*sub) || !is_number(*next)).then_some("scans a number or bit that no address has")
        }
        _ => None,
    }
}

impl Rule for UndefinedRequest {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if sender(context.message()) != Some(Sender::Master) {
            return;
        }
        let Some(what) = fault(context) else { return };
        let report = Report::at(context.now()).detail(u64::from(own_command(context))).evidence(context.evidence());
        sink.report(report, || {
            format!("the request {:02X}h {what}: {}", own_command(context), words(context.message()))
        });
    }
}
