use crate::PerNode;
use crate::findings::effect::{Effect, SETTLE, SOON};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::{Message, Service};
use crate::wire::sdo::Request;
use canvass_macros::rule;
use canvass_traces::Duration;

/// EMCY codes of a node whose receive buffer was full when it started: overrun, communication.
const OF_RECEPTION: &[u64] = &[0x8110, 0x8100];

/// Effects: reactions of the client, answers that come from the node's queue, and an overrun of that queue.
const EFFECTS: &[Effect] = &[
    Effect::on(&["sdo/aborted", "sdo/retries", "sdo/late", "sdo/unanswered", "sdo/protocol-violation"])
        .of_same_node()
        .spanning(SETTLE),
    Effect::on(&["emcy/raised"]).of_same_node().with_codes(OF_RECEPTION).during(Duration::ZERO, SOON),
];

/// an SDO client asks a node that has not booted yet
///
/// Requests are sent to a node before its first boot-up message, or between a reset command and the boot-up message
/// after it, and are not answered before the boot-up. Neither the node's silence nor an answer that comes after the
/// boot-up is reported as a fault of the node.
///
/// # Why
/// A node has no SDO server before it has booted. The client runs into its timeout, or the node answers the queued
/// requests later, when the client does not expect them any more.
///
/// # What to do
/// Let the client wait for the boot-up message of the node, as CiA 302-2 describes it, and repeat the request then.
#[rule(id = "sdo/too-early", severity = Warning, rank = Transfer, services = [Sdo, BootUp], leads_to = EFFECTS)]
struct TooEarly {
    /// The first request to each node that can't answer, and the number of requests.
    early: PerNode<Option<Box<(Seen, u64)>>>,
}

impl Rule for TooEarly {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        match context.message() {
            _ if context.decoded.service == Service::BootUp => self.booted(context, sink),
            Message::SdoRequest(Request::Abort(_)) => {}
            Message::SdoRequest(_) if context.scene.facts.node(node).is_absent() => {
                self.early[node].get_or_insert_with(|| Box::new((context.seen(), 0))).1 += 1;
            }
            // A node that answers is present, even without a boot-up message.
            Message::SdoResponse(_) => self.early[node] = None,
            _ => {}
        }
    }

    fn interrupted(&mut self) {
        self.early.reset();
    }
}

impl TooEarly {
    fn booted(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some((node, early)) = context.node().and_then(|node| Some((node, self.early[node].take()?))) else {
            return;
        };
        let (first, times) = *early;
        let facts = context.scene.facts.node(node);
        let reset = facts.pending_reset.filter(|reset| *reset <= first.time());
        if reset.is_none() && facts.first_seen.is_some() {
            return;
        }
        let report = Report::at(first.time()).until(context.now()).node(node).times(times).measure(times);
        sink.report(report.evidence(first.evidence()).evidence(context.evidence()), || {
            let ahead = context.now().since(first.time());
            let about = first.decoded.object.map(|object| format!(" for {object}")).unwrap_or_default();
            let more = if times > 1 { format!(", the first of {times}") } else { String::new() };
            match reset {
                Some(reset) => {
                    let after = first.time().since(reset);
                    format!("a request{about} {after} after the reset and {ahead} before the boot-up message{more}")
                }
                None => format!("a request{about} {ahead} before the node's first boot-up message{more}"),
            }
        });
    }
}
