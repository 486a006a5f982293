use super::exchange::{Sender, own_command, sender, words};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::Message;
use crate::wire::lss::Request;
use crate::wire::{lmt, lss};
use canvass_macros::rule;

/// an LSS or LMT request has a value that no standard defines
///
/// A request on 7E5h switches to a state other than 0 and 1 (CiA 305, 6.3.2), or it is a Fastscan of a number or bit that no
/// LSS address has. Or the message is an answer: a slave sends with the CAN-ID of the master. Other unknown command
/// specifiers are an information, because a manufacturer may use them.
///
/// # Why
/// No slave acts on the request. A slave that sends on 7E5h disturbs the master, and other slaves take its answer for a
/// request.
///
/// # What to do
/// Check the software of the master. In the capture of a disturbed bus, see the error frames first.
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

/// The severity and the text of a request's fault; `None` if the request is defined.
fn fault(context: &Context<'_>) -> Option<(Severity, &'static str)> {
    let command = own_command(context);
    let warning = |text| Some((Severity::Warning, text));
    match context.message() {
        Message::LssRequest(Request::Unknown { .. }) | Message::LmtRequest(lmt::Request::Unknown { .. }) => {
            if is_answer(command) {
                warning("is an answer: a slave sends with the master's CAN-ID")
            } else {
                Some((Severity::Info, "is not defined"))
            }
        }
        Message::LssRequest(Request::SwitchGlobal { mode: 2.. })
        | Message::LmtRequest(lmt::Request::SwitchGlobal { mode: 2.. }) => warning("switches to an undefined state"),
        Message::LssRequest(Request::Fastscan { bit_check, sub, next, .. }) => {
            let is_bit = *bit_check < BITS || *bit_check == BEGINS_SCAN;
            let is_number = |number: u8| usize::from(number) < lss::Part::ALL.len();
            let is_defined = is_bit && is_number(*sub) && is_number(*next);
            if is_defined { None } else { warning("scans a number or bit that no LSS address has") }
        }
        _ => None,
    }
}

impl Rule for UndefinedRequest {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if sender(context.message()) != Some(Sender::Master) {
            return;
        }
        let Some((severity, what)) = fault(context) else { return };
        let report = Report::at(context.now()).detail(u64::from(own_command(context))).severity(severity);
        let report = report.evidence(context.evidence());
        sink.report(report, || {
            format!("the request {:02X}h {what}: {}", own_command(context), words(context.message()))
        });
    }
}
