use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::{Message, PdoNumber, Service};
use crate::network::Cause;
use crate::wire::error_control::State;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a node sends PDOs although it is not operational
///
/// A node sends a TPDO after a command to stop or to enter pre-operational, or between two heartbeats that show another
/// state than operational. After its boot-up a node may start by itself: it is not reported until a heartbeat shows its
/// state.
///
/// # Why
/// PDOs exist in operational only (CiA 301). Values that are sent in other states may be invalid, but consumers use
/// them.
///
/// # What to do
/// If an NMT command stopped the node, the node did not obey: check its heartbeats. Otherwise its firmware is faulty,
/// or another node sends with the same CAN-ID.
#[rule(
    id = "nodes/pdo-outside-operational",
    severity = Error,
    rank = ProcessData,
    services = [Pdo, Nmt, Heartbeat, Guarding, BootUp]
)]
struct PdoOutsideOperational {
    /// grace time for PDOs that were still queued
    #[threshold(ms = 100)]
    grace: Duration,
    nodes: PerNode<Watched>,
}

#[derive(Default)]
struct Watched {
    /// Time of the command by which the node should have left operational.
    commanded: Option<Timestamp>,
    /// A PDO after a heartbeat with a state other than operational; the next heartbeat proves the fault.
    suspect: Option<Seen>,
    /// Number of PDOs after the command.
    despite: u8,
}

impl PdoOutsideOperational {
    fn pdo(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let Some((state, cause)) = context.scene.bus.node(node).and_then(|node| node.state) else { return };
        if state != State::OPERATIONAL && state != State::BOOT_UP {
            self.outside((node, state, cause), context, sink);
        }
    }

    #[cold]
    fn outside(&mut self, (node, state, cause): (NodeId, State, Cause), context: &Context<'_>, sink: &mut Sink<'_>) {
        let watched = &mut self.nodes[node];
        match cause {
            Cause::ErrorControl if watched.suspect.is_none() => watched.suspect = Some(context.seen()),
            Cause::Command => {
                let since = watched.commanded.filter(|since| context.now().since(*since) > self.grace);
                if since.is_none() {
                    return;
                }
                watched.despite = watched.despite.saturating_add(1);
                if watched.despite >= 2 {
                    let report = Report::at(context.now()).node(node).evidence(context.evidence());
                    sink.report(report, || format!("a PDO although the node was commanded to be {state}"));
                }
            }
            _ => {}
        }
    }

    /// Handles error control after a PDO of a node that seemed not to be operational.
    #[cold]
    fn shown(&mut self, node: NodeId, state: State, context: &Context<'_>, sink: &mut Sink<'_>) {
        let suspect = self.nodes[node].suspect.take();
        let outside = matches!(state, State::PRE_OPERATIONAL | State::STOPPED);
        if let Some(pdo) = suspect.filter(|_| outside && context.decoded.service != Service::BootUp) {
            let before = context.previous.map(Seen::evidence);
            let report = Report::at(pdo.time()).node(node).evidence(before);
            let report = report.evidence(pdo.evidence()).evidence(context.evidence());
            sink.report(report, || format!("a PDO between two heartbeats with the state {state}"));
        }
    }
}

impl Rule for PdoOutsideOperational {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match context.message() {
            Message::Pdo(PdoNumber::Transmit(_)) => self.pdo(context, sink),
            Message::Nmt(nmt) if context.begins_anew() => {
                for (_, watched) in self.nodes.named_mut(nmt.node) {
                    *watched = Watched { commanded: Some(context.now()), ..Watched::default() };
                }
            }
            Message::ErrorControl(message) => {
                let Some(node) = context.node() else { return };
                if self.nodes[node].suspect.is_some() {
                    self.shown(node, message.state, context, sink);
                }
            }
            _ => {}
        }
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
    }
}
