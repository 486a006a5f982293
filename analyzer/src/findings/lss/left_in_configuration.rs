use super::exchange::{Sender, is_leave, sender};
use crate::NodeId;
use crate::findings::effect::{Effect, SETTLE, SOON};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, Service};
use crate::wire::lmt;
use crate::wire::lss::{Request, Response};
use canvass_macros::rule;
use canvass_traces::Duration;

/// Effects: a slave in configuration state may do nothing else.
const EFFECTS: &[Effect] = &[
    Effect::on(&["nodes/lost", "nodes/no-boot-up", "nodes/heartbeat-ended", "sdo/unanswered", "sdo/aborted"])
        .of_same_node()
        .during(SOON, SETTLE),
    Effect::on(&["nodes/consumer-time"]).of_origin().during(SOON, SETTLE),
];

/// an LSS or LMT slave is left in configuration state
///
/// The master has switched slaves to configuration state, one by its address or by Fastscan or all, and does not switch them back to
/// waiting until the capture ends, or for a long time. A boot-up of the node also ends the state. The node is known if
/// its node-ID was inquired. If it continues to send messages, or is not known, the severity is info.
///
/// # Why
/// Some devices do nothing else while they are in configuration state, others keep the new node-ID waiting until they
/// leave it. The next LSS master configures this slave together with the one that it means.
///
/// # What to do
/// Send switch state global with mode 0 (04h 00h) after each configuration, also after one that failed.
#[rule(id = "lss/left-in-configuration", severity = Warning, rank = State, services = [Lss, Lmt, BootUp], leads_to = EFFECTS)]
struct LeftInConfiguration {
    /// time without LSS messages after which a slave counts as left in configuration state
    #[threshold(ms = 5000)]
    wait: Duration,
    state: Option<Configuring>,
    /// Whether the last request is the last one of a Fastscan, whose answer switches the slave.
    ends_scan: bool,
}

/// Whether a Fastscan request confirms the whole LSS address: the slave that answers it enters configuration state.
/// The request checks all bits of the serial number, and the next number is none after it (CiA 305, Fastscan).
const fn ends_scan(request: Request) -> bool {
    matches!(request, Request::Fastscan { bit_check: 0, sub, next, .. } if sub == 3 && next < sub)
}

/// Slaves in configuration state.
struct Configuring {
    /// The message that switched the slaves to configuration.
    switched: Seen,
    /// The last LSS message.
    last: Seen,
    /// The node-ID, as far as it is known.
    node: Option<NodeId>,
    /// The node-ID that the slave gets.
    next: Option<NodeId>,
}

impl Configuring {
    /// Whether the boot-up of a node shows that the slave has left the state: after a start it waits. A slave of which no
    /// node-ID is known may be any node.
    fn ends_with(&self, node: Option<NodeId>) -> bool {
        self.node.is_none() || node.is_some() && (node == self.node || node == self.next)
    }
}

impl LeftInConfiguration {
    fn flush(&mut self, left: bool, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(Configuring { switched, last, node, .. }) = self.state.take() else { return };
        let silence = scene.now.since(last.time());
        if silence <= self.wait {
            return;
        }
        let report = Report::at(switched.time()).until(scene.now).node(node).evidence(switched.evidence());
        let report = report.evidence(Some(last.evidence()).filter(|_| last.time() > switched.time()));
        let seen = node.and_then(|node| scene.facts.node(node).last_seen);
        let is_silent = seen.is_some_and(|seen| scene.now.since(seen) > self.wait);
        let report = if is_silent { report } else { report.severity(Severity::Info) };
        sink.report(report, || {
            let end = if left { "back to waiting only" } else { "not back to waiting" };
            let since = if left { "after the LSS message before" } else { "ago came the last LSS message" };
            format!("switched to configuration state, and {end}: {silence} {since}")
        });
    }
}

impl Rule for LeftInConfiguration {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if sender(context.message()) == Some(Sender::Master) && is_leave(context.message()) {
            return self.flush(true, context.scene, sink);
        }
        if context.decoded.service == Service::BootUp {
            self.state.take_if(|state| state.ends_with(context.node()));
            return;
        }
        if let Message::LssRequest(request) = *context.message() {
            self.ends_scan = ends_scan(request);
        }
        match *context.message() {
            Message::LssResponse(Response::Identified) if !self.ends_scan => {}
            Message::LssRequest(Request::SwitchGlobal { mode: 1 })
            // A slave of LMT does not confirm that it was addressed.
            | Message::LmtRequest(
                lmt::Request::SwitchGlobal { mode: 1 }
                | lmt::Request::SwitchSelective { part: lmt::Part::SerialNumber, .. },
            )
            | Message::LssResponse(Response::Switched | Response::Identified) => {
                let (switched, last) = (context.seen(), context.seen());
                self.state = Some(Configuring { switched, last, node: None, next: None });
            }
            Message::LssRequest(Request::ConfigureNodeId { node_id: next })
            | Message::LmtRequest(lmt::Request::ConfigureNodeId { node_id: next }) => {
                if let Some(state) = &mut self.state {
                    state.next = NodeId::new(next);
                }
            }
            Message::LssResponse(Response::NodeId(node)) => {
                if let Some(state) = &mut self.state {
                    state.node = NodeId::new(node).or(state.node);
                }
            }
            _ => {}
        }
        if let Some(state) = &mut self.state {
            state.last = context.seen();
        }
    }

    fn interrupted(&mut self) {
        self.state = None;
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        self.flush(false, scene, sink);
    }
}
