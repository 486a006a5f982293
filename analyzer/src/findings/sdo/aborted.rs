use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::Message;
use crate::network::sdo::{Direction, Side};
use crate::object;
use crate::wire::sdo::{Abort, AbortCode, Request, Response};
use canvass_macros::rule;

/// an SDO transfer was aborted
///
/// Client or server aborts a transfer. Each object, abort code and side has its own finding. The severity is info if
/// the server refuses a read because the object or sub-index does not exist, or because its error history (1003h) is
/// empty: clients explore a device in this way.
///
/// # Why
/// A value was not written or not read: the configuration of the device differs from the one that the master assumes.
///
/// # What to do
/// The abort code tells the reason. 0601 0002h and 0609 00xxh indicate a wrong configuration, 0800 002xh a temporary
/// state of the device, 0503 0000h and 0504 xxxxh a protocol error.
#[rule(id = "sdo/aborted", severity = Warning, rank = Transfer, services = [Sdo])]
struct Aborted;

impl Rule for Aborted {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (side, Abort { multiplexer, code }) = match context.message() {
            Message::SdoRequest(Request::Abort(abort)) => (Side::Client, *abort),
            Message::SdoResponse(Response::Abort(abort)) => (Side::Server, *abort),
            _ => return,
        };
        let transfer = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel));
        let transfer = transfer.filter(|transfer| transfer.multiplexer == multiplexer);
        let direction = transfer.map(|transfer| transfer.direction);
        let absent = matches!(code, AbortCode::NO_OBJECT | AbortCode::NO_SUB_INDEX);
        // Reading an empty error history is refused.
        let empty = multiplexer.index.0 == object::PREDEFINED_ERROR_FIELD && code == AbortCode::NO_DATA;
        let looks = direction == Some(Direction::Upload) && side == Side::Server && (absent || empty);
        let address = u64::from(multiplexer.index.0) << 8 | u64::from(multiplexer.sub.0);
        let detail = address << 33 | u64::from(code.0) << 1 | u64::from(side == Side::Client);
        let report = Report::at(context.now()).node(context.node()).detail(detail);
        let kind = u64::from(code.0) << 1 | u64::from(side == Side::Client);
        let report = report.kind(kind).object(multiplexer);
        let report = if looks { report.severity(Severity::Info) } else { report };
        sink.report(report.evidence(context.evidence()), || {
            let direction = direction.map(|direction| format!("{direction} of ")).unwrap_or_default();
            format!("{direction}{multiplexer} aborted by the {side}: {code}")
        });
    }
}
