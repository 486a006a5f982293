use crate::NodeId;
use crate::findings::effect::{Effect, SOON};
use crate::findings::facts::RequestEvent;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::Service;
use crate::network::Event;
use crate::network::sdo::{Direction, Transfer};
use crate::wire::nmt::Command;
use crate::wire::sdo::{REQUEST_BASE, RESPONSE_BASE};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// Effects: messages that concern a transfer which neither side continues.
const EFFECTS: &[Effect] = &[Effect::on(&["sdo/protocol-violation", "sdo/aborted"]).of_same_node().spanning(SOON)];

/// an SDO transfer is begun and never finished
///
/// The server has answered the first request of a segmented or block transfer, and then the client begins another
/// transfer on the channel, or sends nothing more until the capture ends, without a last segment or an abort. Requests
/// that the server does not answer are reported by sdo/unanswered, and transfers that a reset ends are none.
///
/// # Why
/// Of a value that is written only a part has arrived: what the device has of it is not defined. Of a value that is read
/// the client has a part at most. The server may refuse other requests until its own timeout is over.
///
/// # What to do
/// Look for the reason in the client: a timeout of the whole transfer, a buffer that is too small, or a client that
/// takes the announcement of segments for the value. It must abort a transfer that it does not finish.
#[rule(id = "sdo/unfinished", severity = Warning, rank = Transfer, services = [Sdo], leads_to = EFFECTS)]
struct Unfinished {
    /// least silence at the end of the capture after which an open transfer counts as abandoned
    #[threshold(ms = 2000)]
    wait: Duration,
    /// Whether frames may be missing since the last message, and the time since which no frame is missing.
    gap: bool,
    whole_since: Option<Timestamp>,
}

/// The progress of a transfer, in words.
fn progress(transfer: &Transfer) -> String {
    let done = match transfer.direction {
        Direction::Upload => "read",
        Direction::Download => "written",
    };
    let done = &match unconfirmed(transfer) {
        0 => done.to_owned(),
        bytes => format!("{done} and confirmed, {bytes} more in a block without confirmation"),
    };
    match (transfer.length(), transfer.announced) {
        (length, Some(announced)) if length >= announced.into() => {
            format!("all {length} bytes {done}, but without a last segment")
        }
        (length, Some(announced)) => format!("{length} of {announced} bytes {done}"),
        (1, None) => format!("1 byte {done}"),
        (length, None) => format!("{length} bytes {done}"),
    }
}

/// The number of bytes that were sent in a block, and not confirmed. Padding of the last segment does not count, as far as
/// the length is known.
fn unconfirmed(transfer: &Transfer) -> u64 {
    let bytes = u64::from(transfer.unconfirmed);
    transfer.announced.map_or(bytes, |announced| bytes.min(u64::from(announced).saturating_sub(transfer.length())))
}

fn detail(transfer: &Transfer) -> u64 {
    let object = transfer.multiplexer;
    let download = u64::from(transfer.direction == Direction::Download);
    u64::from(object.index.0) << 9 | u64::from(object.sub.0) << 1 | download
}

fn report<'e>(node: NodeId, transfer: &Transfer) -> Report<'e> {
    let report = Report::at(transfer.started).until(transfer.latest).node(node);
    report.detail(detail(transfer)).object(transfer.multiplexer)
}

/// The last frames of a transfer on the node's default channel.
fn last_frames<'a>(node: NodeId, transfer: &Transfer, scene: &Scene<'a>) -> [Option<&'a Seen>; 2] {
    let of = |id: u16| {
        let seen = scene.latest.get(id + u16::from(node.raw()))?;
        let belongs = seen.decoded.service == Service::Sdo && seen.decoded.node == Some(node);
        Some(seen).filter(|seen| belongs && seen.time() >= transfer.started && seen.time() <= transfer.latest)
    };
    let mut frames = [REQUEST_BASE, RESPONSE_BASE].map(of);
    frames.sort_by_key(|frame| frame.map(Seen::time));
    frames
}

/// Whether a command has ended the transfer.
fn was_reset(node: NodeId, transfer: &Transfer, scene: &Scene<'_>) -> bool {
    scene.facts.node(node).command.is_some_and(|(command, at)| {
        at >= transfer.latest && matches!(command, Command::RESET_NODE | Command::RESET_COMMUNICATION | Command::STOP)
    })
}

impl Unfinished {
    /// Whether the end of the transfer may have been in frames that are missing, or a command has ended it.
    fn is_excused(&self, node: NodeId, transfer: &Transfer, scene: &Scene<'_>) -> bool {
        self.whole_since.is_some_and(|since| transfer.latest < since) || was_reset(node, transfer, scene)
    }
}

impl Rule for Unfinished {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if std::mem::take(&mut self.gap) {
            self.whole_since = Some(context.now());
        }
        let (Some(node), Some(channel)) = (context.node(), context.decoded.channel) else { return };
        let is_left = |event: &Event| matches!(event, Event::TransferLeft(left) if *left == channel);
        let unanswered = matches!(context.news().request, RequestEvent::GivenUp(_) | RequestEvent::Repeated);
        if unanswered || !context.scene.bus.events().iter().any(is_left) {
            return;
        }
        let left = context.scene.bus.left_transfer(channel).filter(|left| left.is_answered);
        let Some(transfer) = left.filter(|left| !self.is_excused(node, left, context.scene)) else { return };
        let report = report(node, transfer).evidence(context.previous.map(Seen::evidence));
        sink.report(report.evidence(context.evidence()), || {
            let (direction, object) = (transfer.direction, transfer.multiplexer);
            let later = context.now().since(transfer.latest);
            format!("{direction} of {object} left with {}: another transfer begins {later} later", progress(transfer))
        });
    }

    fn interrupted(&mut self) {
        self.gap = true;
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, transfer) in scene.bus.open_transfers() {
            if self.gap || self.is_excused(node, transfer, scene) {
                continue;
            }
            let silence = scene.now.since(transfer.latest);
            let pending =
                |(_, pending): (_, &crate::findings::facts::Pending)| pending.request.decoded.node == Some(node);
            if silence <= self.wait || !transfer.is_answered || scene.facts.requests.open().any(pending) {
                continue;
            }
            let [first, last] = last_frames(node, transfer, scene);
            let report = report(node, transfer).evidence(first.map(Seen::evidence)).evidence(last.map(Seen::evidence));
            sink.report(report, || {
                let (direction, object) = (transfer.direction, transfer.multiplexer);
                format!("{direction} of {object} left with {}: nothing follows for {silence}", progress(transfer))
            });
        }
    }
}
