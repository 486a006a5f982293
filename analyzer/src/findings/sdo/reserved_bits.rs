use super::unanswered::is_misplaced_answer;
use crate::findings::effect::{Effect, SETTLE};
use crate::findings::facts::RequestEvent;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::Message;
use crate::wire::Fields;
use crate::wire::sdo::{Request, Response};
use canvass_macros::rule;

/// Effects: transfers that one side takes for expedited ones, and the other for segmented ones.
const EFFECTS: &[Effect] =
    &[Effect::on(&["sdo/unfinished", "sdo/protocol-violation", "sdo/unanswered"]).of_same_node().spanning(SETTLE)];

/// an SDO message has reserved bits set
///
/// The command byte has bits set that CiA 301 reserves; or it gives a number of unused bytes, or a value, without the
/// bits that make the transfer an expedited one with a size. Each command byte of each side is one finding. Before a
/// transfer on the channel has begun in the capture, the answer must show that the frame is a request. Reserved bytes after
/// the command byte that are not 0 are an information: many clients leave the bytes of an earlier message there.
///
/// # Why
/// The two sides read the message differently: where bit e is missing, one side has sent a value that the other takes
/// for the announcement of segments. A device with stricter firmware refuses such messages.
///
/// # What to do
/// Correct the sender. A value of 1, 2, 3 or 4 bytes is written with the command byte 2Fh, 2Bh, 27h or 23h and read with
/// 40h; its answers have 4Fh, 4Bh, 47h or 43h, and 60h (CiA 301, 7.2.4.3).
#[rule(id = "sdo/reserved-bits", severity = Warning, rank = Transfer, services = [Sdo], leads_to = EFFECTS)]
struct ReservedBits {
    channels: Vec<Channel>,
}

#[derive(Default)]
struct Channel {
    /// Whether a transfer has begun in the capture, so that frames are known to be requests and answers.
    begun: bool,
    /// A frame that may be a request with reserved bits, or a segment of a transfer from before the capture.
    held: Option<Box<(Seen, Fault)>>,
}

/// The fault of a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Fault {
    /// Reserved bits of the command byte are set; the number has these bits.
    Bits(u8),
    /// The field for the number of unused bytes is not 0, although the message has no expedited value with a size.
    Unused,
    /// Bytes 4 to 7 are not 0, although the message has neither a value nor a size.
    Value,
    /// Reserved bytes after the command byte are not 0.
    Bytes,
}

/// The fault of an initiate message with `nnes` in its lower bits.
fn of_initiate(command: u8, payload: &[u8]) -> Option<Fault> {
    let (expedited, sized, unused) = (command & 0b10 != 0, command & 0b1 != 0, command & 0b1100);
    let value = payload.get(4..8).is_some_and(|bytes| bytes.iter().any(|byte| *byte != 0));
    if command & 0x10 != 0 {
        Some(Fault::Bits(0x10))
    } else if unused != 0 && !(expedited && sized) {
        Some(Fault::Unused)
    } else {
        (!expedited && !sized && value).then_some(Fault::Value)
    }
}

/// The bits of the command byte that are reserved in block transfers.
const fn of_block(command: u8) -> u8 {
    match (command >> 5, command & 0b11) {
        (5, 0) => 0x18,
        (5, _) => 0x1C,
        (_, 1 | 3) => 0x02,
        _ => 0x18,
    }
}

/// The fault of a message of the client or the server.
fn fault(message: &Message, payload: &[u8]) -> Option<Fault> {
    let command = *payload.first()?;
    let reserved = match message {
        Message::SdoRequest(Request::Unknown { .. } | Request::DownloadSegment(_))
        | Message::SdoResponse(Response::Unknown { .. } | Response::UploadSegment(_)) => 0,
        Message::SdoRequest(Request::InitiateDownload { .. })
        | Message::SdoResponse(Response::InitiateUpload { .. }) => return of_initiate(command, payload),
        Message::SdoRequest(Request::UploadSegment { .. }) | Message::SdoResponse(Response::DownloadSegment { .. }) => {
            0x0F
        }
        Message::SdoRequest(Request::InitiateUpload { .. } | Request::Abort(_))
        | Message::SdoResponse(Response::InitiateDownload { .. } | Response::Abort(_)) => 0x1F,
        Message::SdoRequest(_) | Message::SdoResponse(_) => of_block(command),
        _ => 0,
    };
    let set = command & reserved;
    let of_bits = (set != 0).then_some(Fault::Bits(set));
    of_bits.or_else(|| reserved_bytes(message, payload).then_some(Fault::Bytes))
}

/// Whether a reserved byte after the command byte is not 0.
fn reserved_bytes(message: &Message, payload: &[u8]) -> bool {
    let layout = match message {
        Message::SdoRequest(request) => request.layout(),
        Message::SdoResponse(response) => response.layout(),
        _ => return false,
    };
    // Without its indication the size is reserved, too.
    let has_no_size = matches!(
        message,
        Message::SdoRequest(Request::InitiateBlockDownload { size: None, .. })
            | Message::SdoResponse(Response::InitiateBlockUpload { size: None, .. })
    );
    if has_no_size && payload.iter().skip(4).any(|byte| *byte != 0) {
        return true;
    }
    let reserved = layout.fields.iter().filter(|field| field.is_reserved() && field.first >= 8);
    reserved.filter_map(|field| field.within(payload.len())?.get(payload)).any(|value| value != 0)
}

impl Rule for ReservedBits {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(channel) = context.decoded.channel else { return };
        let at = usize::from(channel.0);
        if self.channels.len() <= at {
            self.channels.resize_with(at + 1, Channel::default);
        }
        // An answer on the CAN-ID of requests is right in itself: the rule sdo/unanswered reports its CAN-ID.
        if let RequestEvent::GivenUp(pending) = &context.news().request
            && is_misplaced_answer(pending, context)
        {
            return;
        }
        let channel = &mut self.channels[at];
        let fault = fault(context.message(), context.record.frame.data());
        let object = match context.message() {
            Message::SdoRequest(request) => request.multiplexer(),
            Message::SdoResponse(response) => response.multiplexer(),
            _ => None,
        };
        let is_answer = matches!(context.message(), Message::SdoResponse(_));
        let held = if is_answer { channel.held.take().map(|held| *held) } else { None };
        if let Some((seen, held)) = held.filter(|(seen, _)| object.is_some() && seen.decoded.object == object) {
            channel.begun = true;
            tell(&seen, held, context, sink);
        }
        channel.begun |= !is_answer && object.is_some() && fault.is_none();
        let Some(fault) = fault else { return };
        if channel.begun {
            tell(&context.seen(), fault, context, sink);
        } else if !is_answer {
            channel.held = Some(Box::new((context.seen(), fault)));
        }
    }

    fn interrupted(&mut self) {
        self.channels.clear();
    }
}

#[cold]
fn tell(seen: &Seen, fault: Fault, context: &Context<'_>, sink: &mut Sink<'_>) {
    let client = matches!(seen.decoded.message, Message::SdoRequest(_));
    let command = seen.record.frame.bytes()[0];
    let is_bytes = fault == Fault::Bytes;
    let detail = u64::from(is_bytes) << 9 | u64::from(command) << 1 | u64::from(client);
    let report = Report::at(seen.time()).node(context.node()).detail(detail);
    let report = if is_bytes { report.severity(Severity::Info) } else { report };
    sink.report(report.evidence(seen.evidence()), || {
        let side = if client { "client" } else { "server" };
        let object = seen.decoded.object.map(|object| format!(" ({object})")).unwrap_or_default();
        match fault {
            Fault::Bits(set) => {
                let right = command & !set;
                format!("{side}: command byte {command:02X}h has reserved bits set, {right:02X}h is right{object}")
            }
            Fault::Unused => {
                format!("{side}: command byte {command:02X}h counts unused bytes, but announces no value{object}")
            }
            Fault::Bytes => format!("{side}: {command:02X}h, and reserved bytes after it are not 0{object}"),
            Fault::Value => {
                format!("{side}: command byte {command:02X}h announces no value, but bytes 4 to 7 are not 0{object}")
            }
        }
    });
}
