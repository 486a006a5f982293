//! What the nodes of a bus have done, as many rules want to know it.

mod errors;
mod heartbeats;
mod node;
mod operands;
mod presence;
mod requests;
mod tpdos;

pub use errors::{Errors, Raised};
pub use heartbeats::Heartbeats;
pub use node::NodeFacts;
pub use operands::Operand;
pub use presence::{Orders, Outage, Presence, Sign};
pub use requests::{Pending, RequestEvent, Requests};
pub use tpdos::{AllParameters, Parameters, TPDOS};

use super::rhythm::Interval;
use crate::message::{Message, PdoNumber, Service};
use crate::network::sdo::{Direction, Outcome};
use crate::network::{Bus, Decoded, Event};
use crate::object;
use crate::wire::emcy::EmcyCode;
use crate::wire::lss;
use crate::wire::nmt::{Command, Nmt};
use crate::wire::sdo::Request;
use crate::{NodeId, PerNode};
use canvass_traces::{Duration, Record, Timestamp};

/// What all nodes of a bus have done so far.
#[derive(Default)]
pub struct Facts {
    nodes: PerNode<NodeFacts>,
    /// When the LSS or LMT master last said something that may make slaves reset themselves.
    pub layer_setting: Option<Timestamp>,
    /// How many nodes have sent something.
    pub present: u8,
    /// Whether a request of an SDO client was seen.
    pub has_sdo_client: bool,
    /// The communication parameters of TPDOs, after the frame.
    pub tpdos: AllParameters,
    /// The heartbeats and their periods, after the frame.
    pub heartbeats: Heartbeats,
    /// The SDO requests that wait for an answer, after the frame.
    pub requests: Requests,
    /// The errors that nodes have reported and not taken back, after the frame.
    pub errors: Errors,
    /// Which nodes are there, before the frame.
    pub presence: Presence,
    /// What the frame means to several rules.
    pub news: News,
}

/// What a frame means to several rules: worked out once for all of them.
#[derive(Default)]
pub struct News {
    /// Whether it is an NMT command that changes the state of some node, so that what was periodic may begin anew.
    pub begins_anew: bool,
    /// Whether it is a TPDO of whose parameters something is known.
    pub is_known_tpdo: bool,
    /// Whether the node that it is about has sent it.
    pub is_from_node: bool,
    /// The silence of its node that it ends, if it was an outage.
    pub returned: Option<Outage>,
    /// Of a heartbeat: the interval that it ends.
    pub heartbeat: Option<Interval>,
    /// Of an SDO message: what it does to the requests that wait.
    pub request: RequestEvent,
    /// Of an EMCY: the errors that it says are gone.
    pub ended_errors: Vec<(EmcyCode, Raised)>,
    /// The values of objects of its node's device profile in it.
    pub operands: Vec<Operand>,
    /// The profile whose values these are.
    pub profile: Option<u16>,
}

/// Whether a request asks to store or restore parameters.
fn stores(request: Request) -> bool {
    let Request::InitiateDownload { multiplexer, payload } = request else { return false };
    match multiplexer.index.0 {
        object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS => true,
        // Some devices store other objects too, by the same signatures.
        0x2000..=0x5FFF => payload.value().is_some_and(|value| matches!(value, b"save" | b"load")),
        _ => false,
    }
}

impl Facts {
    /// What a node has done.
    pub fn node(&self, id: NodeId) -> &NodeFacts {
        &self.nodes[id]
    }

    /// Takes the next frame before the rules see it, and returns the node whose TPDO parameters may have changed.
    pub(super) fn follow(&mut self, record: &Record, decoded: &Decoded, bus: &Bus) -> Option<NodeId> {
        let now = record.timestamp;
        let begins_anew = matches!(decoded.message, Message::Nmt(nmt) if !self.is_repeated(nmt));
        let reconfigured = self.tpdos.frame(decoded, bus);
        let is_from_node = decoded.is_from_node();
        // Nearly always there is nothing to take away, nor to put there.
        if self.news.returned.is_some() {
            self.news.returned = None;
        }
        if let Some(node) = decoded.node.filter(|_| is_from_node)
            && self.was_long_silent(node, now)
        {
            self.news.returned = self.outage(node, now);
        }
        let news = &mut self.news;
        news.is_from_node = is_from_node;
        (news.begins_anew, news.is_known_tpdo, news.heartbeat) = (begins_anew, false, None);
        // Most frames are no SDO messages: nothing to take away.
        if !matches!(news.request, RequestEvent::None) {
            news.request = RequestEvent::None;
        }
        match decoded.service {
            Service::Pdo => {
                if let (Some(node), Message::Pdo(PdoNumber::Transmit(number))) = (decoded.node, decoded.message) {
                    news.is_known_tpdo = self.tpdos.of(node, number).is_known();
                }
            }
            Service::Heartbeat => {
                let facts = decoded.node.map(|node| &self.nodes[node]);
                news.heartbeat = facts.and_then(|facts| self.heartbeats.beat(now, decoded, facts));
                if let (Some(node), Some(interval)) = (decoded.node, news.heartbeat) {
                    self.presence.beat(node, interval.expected);
                }
            }
            Service::Emcy => news.ended_errors = self.errors.frame(record, decoded),
            Service::Sdo | Service::BootUp | Service::Nmt => {
                if decoded.service == Service::BootUp {
                    self.errors.frame(record, decoded);
                }
                news.request = self.requests.frame(record, decoded);
                self.heartbeats.other(decoded, begins_anew, bus);
            }
            Service::Guarding | Service::Lss | Service::Lmt => self.heartbeats.other(decoded, begins_anew, bus),
            _ => {}
        }
        news.profile = operands::collect(record, decoded, bus, &mut news.operands);
        reconfigured
    }

    /// Whether a frame of a node ends a silence that may have been an outage.
    #[inline]
    fn was_long_silent(&self, node: NodeId, now: Timestamp) -> bool {
        self.nodes[node].last_seen.is_some_and(|since| self.presence.is_long(node, now.since(since)))
    }

    /// The silence of a node, if it is longer than its heartbeat or guarding allows and nothing explains it.
    #[cold]
    pub fn outage(&self, node: NodeId, now: Timestamp) -> Option<Outage> {
        let period = self.heartbeats.of(node).period();
        self.presence.outage(node, now, &self.nodes[node], period, self.layer_setting)
    }

    /// Frames may be missing here, or the clock has stepped.
    pub(super) fn interrupted(&mut self, now: Timestamp) {
        self.presence.interrupted(now);
        self.heartbeats.interrupted();
        self.requests.interrupted();
    }

    /// Takes the frame after the rules have seen it.
    pub(super) fn note(&mut self, record: &Record, decoded: &Decoded, bus: &Bus) {
        let now = record.timestamp;
        match decoded.message {
            Message::Nmt(nmt) => {
                self.commanded(now, nmt.command, nmt.node);
                self.presence.commanded(now, nmt);
            }
            Message::GuardingRequest => {
                if let Some(node) = decoded.node {
                    self.presence.guarded(now, node);
                }
            }
            Message::LssRequest(lss::Request::SwitchGlobal { .. } | lss::Request::ActivateBitTiming { .. }) => {
                self.layer_setting = Some(now);
            }
            Message::LmtRequest(_) => self.layer_setting = Some(now),
            Message::SdoRequest(request) => {
                self.has_sdo_client = true;
                if let (Some(node), true) = (decoded.node, stores(request)) {
                    self.nodes[node].last_store = Some(now);
                }
            }
            Message::SdoBlockDownload(_) => self.has_sdo_client = true,
            _ => {}
        }
        let Some(node) = decoded.node else { return };
        if self.news.is_from_node {
            self.presence.heard(node);
            let facts = &mut self.nodes[node];
            facts.is_slave |= matches!(decoded.service, Service::Sdo | Service::Pdo | Service::Emcy);
            if let (Some(_), Some(last)) = (facts.pending_reset, facts.last_seen) {
                facts.longest_pause = facts.longest_pause.max(now.since(last));
            }
            (facts.last_seen, facts.last_id) = (Some(now), record.frame.cob_id());
            if facts.first_seen.replace(facts.first_seen.unwrap_or(now)).is_none() {
                self.present = self.present.saturating_add(1);
            }
        }
        if decoded.service == Service::BootUp {
            self.restarted(node, now);
            let facts = &mut self.nodes[node];
            (facts.last_boot_up, facts.pending_reset, facts.has_moved) = (Some(now), None, false);
            self.moved(bus);
        }
        if decoded.ends_transfer() {
            self.transferred(now, node, decoded, bus);
        }
    }

    /// A node has started: how long it takes after a reset is known, if it was there before that.
    fn restarted(&mut self, node: NodeId, now: Timestamp) {
        const LONGEST: Duration = Duration::from_secs(60);
        let took = self.nodes[node].pending_reset.map(|reset| now.since(reset));
        if let Some(took) = took.filter(|took| *took <= LONGEST && self.news.returned.is_none()) {
            self.presence.restarted(node, took);
        }
    }

    /// A node has started with a new node-ID: the one that it had before will not come back. Where nothing tells which
    /// that is, it is the only one that was reset and is silent since.
    fn moved(&mut self, bus: &Bus) {
        let from = bus.events().iter().find_map(|event| match event {
            Event::NodeIdChanged { from, .. } => Some(*from),
            _ => None,
        });
        let Some(from) = from else { return };
        let was_there = |node: &NodeId| self.node(*node).last_seen.is_some();
        let mut silent = NodeId::all().filter(was_there).filter(|node| self.node(*node).is_silent_since_reset());
        let only = silent.next().filter(|_| silent.next().is_none());
        if let Some(from) = from.or(only) {
            self.nodes[from].has_moved = true;
        }
    }

    /// Whether an NMT command repeats what the nodes that it names were told last, so that it changes nothing: some
    /// masters send it again and again.
    fn is_repeated(&self, nmt: Nmt) -> bool {
        let resets = nmt.command.is_reset();
        let mut present = self.nodes.named(nmt.node).map(|(_, facts)| facts).filter(|facts| facts.first_seen.is_some());
        !resets
            && present.all(|facts| {
                let obeyed = |at| facts.last_boot_up.is_none_or(|boot_up| boot_up < at);
                facts.command.is_some_and(|(last, at)| last == nmt.command && obeyed(at))
            })
    }

    fn commanded(&mut self, now: Timestamp, command: Command, node: u8) {
        let resets = command.is_reset();
        for (_, facts) in self.nodes.named_mut(node) {
            facts.command = Some((command, now));
            facts.is_slave |= node != 0;
            if resets {
                (facts.pending_reset, facts.longest_pause) = (Some(now), Duration::ZERO);
            }
        }
    }

    fn transferred(&mut self, now: Timestamp, node: NodeId, decoded: &Decoded, bus: &Bus) {
        let Some(transfer) = decoded.channel.and_then(|channel| bus.transfer(channel)) else { return };
        if transfer.direction != Direction::Download {
            return;
        }
        let facts = &mut self.nodes[node];
        // Some devices store other objects too, by the same signatures.
        let signed = matches!(transfer.data(), b"save" | b"load");
        match transfer.multiplexer.index.0 {
            object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS => facts.last_store = Some(now),
            0x2000..=0x5FFF if signed => facts.last_store = Some(now),
            object::PROGRAM_DATA | object::PROGRAM_CONTROL => facts.last_program_control = Some(now),
            _ => {}
        }
        if transfer.outcome == Outcome::Complete {
            facts.last_download = Some(now);
        }
    }
}
