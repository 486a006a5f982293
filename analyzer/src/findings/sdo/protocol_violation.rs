use crate::findings::effect::{Effect, SOON};
use crate::findings::facts::RequestEvent;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::Message;
use crate::network::sdo::Violation;
use crate::wire::sdo::{Request, Response};
use canvass_macros::rule;

/// Effects: the other side gives up.
const EFFECTS: &[Effect] =
    &[Effect::on(&["sdo/aborted", "sdo/unfinished", "sdo/retries"]).of_same_node().spanning(SOON)];

/// a rule of the SDO protocol is broken
///
/// An SDO message violates the protocol: a toggle bit that does not alternate, an answer for another object, more or
/// fewer bytes than announced, a wrong CRC or sequence number in a block transfer, an unknown command, or an answer
/// without a request. Transfers that began before the capture are not judged.
///
/// # Why
/// Data may be lost, duplicated or belong to another object. Some clients and servers do not detect this.
///
/// # What to do
/// The finding names the side that violated the protocol: client (600h + node-ID) or server (580h + node-ID). If a CRC
/// is wrong, the sender calculates it otherwise than CiA 301 demands (start value 0, without the unused bytes of the
/// last segment), or bytes were lost. A wrong sequence number or toggle bit means a lost or duplicated frame, a wrong
/// size a fault of the sender. Only an answer without a request, or for another object, points to a second client on
/// this channel, a second device with the same node-ID, or a client that gave up too early.
#[rule(id = "sdo/protocol-violation", severity = Error, rank = Transfer, services = [Sdo], leads_to = EFFECTS)]
struct ProtocolViolation {
    /// The channels on which the beginning of a transfer was seen.
    begun: Vec<bool>,
}

impl Rule for ProtocolViolation {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(channel) = context.decoded.channel else { return };
        let at = usize::from(channel.0);
        if self.begun.len() <= at {
            self.begun.resize(at + 1, false);
        }
        self.begun[at] |= begins(context.message());
        let Some(violation) = context.decoded.violation else { return };
        // A late answer has a finding of its own.
        if violation == Violation::Unexpected && matches!(context.news().request, RequestEvent::AnsweredLate { .. }) {
            return;
        }
        if violation == Violation::Unexpected && !self.begun[at] && !is_unsolicited(context) {
            return;
        }
        // The kind of violation, and the side that commits it: the direction of the frame shows the side.
        let client = matches!(context.message(), Message::SdoRequest(_) | Message::SdoBlockDownload(_));
        let detail = kind(violation) << 1 | u64::from(client);
        let report = Report::at(context.now()).node(context.node()).detail(detail);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || {
            let side = if client { "client" } else { "server" };
            let object = context.decoded.object.map(|object| format!(" ({object})")).unwrap_or_default();
            match violation {
                Violation::Unexpected if repeats(context) => format!("the {side} repeats its answer{object}"),
                Violation::Unexpected => {
                    format!("{} {side} that does not belong here{object}", what(context.message()))
                }
                Violation::Multiplexer(_) => {
                    let transfer = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel));
                    let asked = transfer.map(|transfer| format!(", asked was {}", transfer.multiplexer));
                    format!("{side}: {violation}{}", asked.unwrap_or_default())
                }
                other => format!("{side}: {other}{object}"),
            }
        });
    }

    fn interrupted(&mut self) {
        self.begun.fill(false);
    }
}

/// Whether the frame is the same as the last one with this CAN-ID: the server answers one request more than once.
fn repeats(context: &Context<'_>) -> bool {
    let is_answer = matches!(context.message(), Message::SdoResponse(response) if response.multiplexer().is_some());
    is_answer && context.previous.is_some_and(|before| before.record.frame == context.record.frame)
}

const fn kind(violation: Violation) -> u64 {
    match violation {
        Violation::Toggle => 1,
        Violation::Multiplexer(_) => 2,
        Violation::Size { .. } => 3,
        Violation::Crc { .. } => 4,
        Violation::Sequence { .. } => 5,
        Violation::Unexpected => 6,
    }
}

const fn what(message: &Message) -> &'static str {
    match message {
        Message::SdoRequest(Request::Unknown { .. }) | Message::SdoResponse(Response::Unknown { .. }) => {
            "an unknown command of the"
        }
        Message::SdoResponse(_) => "an answer of the",
        _ => "a message of the",
    }
}

/// Whether a message begins a transfer.
const fn begins(message: &Message) -> bool {
    matches!(
        message,
        Message::SdoRequest(
            Request::InitiateDownload { .. }
                | Request::InitiateUpload { .. }
                | Request::InitiateBlockDownload { .. }
                | Request::InitiateBlockUpload { .. }
        )
    )
}

/// Whether the message answers a request that was never seen, long after the capture began, although the capture
/// contains clients' requests.
fn is_unsolicited(context: &Context<'_>) -> bool {
    let begins = matches!(
        context.message(),
        Message::SdoResponse(Response::InitiateUpload { .. } | Response::InitiateDownload { .. })
    );
    let later = context.now().since(context.scene.start).nanos() > 1_000_000_000;
    begins && later && context.scene.facts.has_sdo_client
}
