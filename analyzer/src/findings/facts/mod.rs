//! Facts about the nodes of a bus that several rules need.

mod beats;
mod errors;
mod heartbeats;
mod node;
mod operands;
mod pace;
mod presence;
mod requests;
mod streams;
mod tpdos;

pub use beats::Reasons;
pub use errors::{Errors, Raised};
pub use heartbeats::Heartbeats;
pub use node::{NodeFacts, Obedience};
pub use operands::Operand;
pub use pace::Odd;
pub use presence::{Orders, Outage, Presence, Sign};
pub use requests::{Pending, RequestEvent, Requests};
pub use streams::{Cut, Reset, Stream, StreamEvent, Streams};
pub use tpdos::{AllParameters, Parameters, TPDOS};

use self::streams::Restart;
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

/// The facts about all nodes of a bus.
#[derive(Default)]
pub struct Facts {
    nodes: PerNode<NodeFacts>,
    /// Time of the last LSS or LMT message after which slaves may reset themselves.
    pub layer_setting: Option<Timestamp>,
    /// Number of nodes that have sent a message.
    pub present: u8,
    /// Whether an SDO client has sent a request.
    pub has_sdo_client: bool,
    /// The communication parameters of TPDOs, after the frame.
    pub tpdos: AllParameters,
    /// The heartbeats and their periods, after the frame.
    pub heartbeats: Heartbeats,
    /// The unanswered SDO requests, after the frame.
    pub requests: Requests,
    /// The present errors of the nodes, after the frame.
    pub errors: Errors,
    /// The TPDOs as they are learned from their frames, after the frame.
    pub streams: Streams,
    /// The presence of the nodes, before the frame.
    pub presence: Presence,
    /// The facts about the frame that several rules need.
    pub news: News,
}

/// Facts about a frame that several rules need: computed once for all rules.
#[derive(Default)]
pub struct News {
    /// Whether the frame is an NMT command that changes the state of a node, so that periodic messages may begin anew.
    pub begins_anew: bool,
    /// Whether the frame is a TPDO of which any parameter is known.
    pub is_known_tpdo: bool,
    /// The unusual event of a TPDO that the frame shows.
    pub stream: StreamEvent,
    /// The TPDOs that begin anew after the frame.
    restart: Option<Restart>,
    /// Whether the concerned node has sent the frame.
    pub is_from_node: bool,
    /// The outage of the node that ends with this frame.
    pub returned: Option<Outage>,
    /// The interval that ends with a heartbeat.
    pub heartbeat: Option<Interval>,
    /// The effect of an SDO message on the unanswered requests.
    pub request: RequestEvent,
    /// The errors that end with an EMCY.
    pub ended_errors: Vec<(EmcyCode, Raised)>,
    /// The values in the frame of objects of the node's device profile.
    pub operands: Vec<Operand>,
    /// The device profile that defines the objects in `operands`.
    pub profile: Option<u16>,
}

/// Whether a request stores or restores parameters.
fn stores(request: Request) -> bool {
    let Request::InitiateDownload { multiplexer, payload } = request else { return false };
    match multiplexer.index.0 {
        object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS => true,
        // Some devices store through other objects too, with the same signatures.
        0x2000..=0x5FFF => payload.value().is_some_and(|value| matches!(value, b"save" | b"load")),
        _ => false,
    }
}

/// The TPDOs that begin anew with a frame.
fn restart(decoded: &Decoded, begins_anew: bool, bus: &Bus) -> Option<Restart> {
    match decoded.message {
        Message::Nmt(nmt) => begins_anew.then_some(Restart { node: nmt.node, number: None, reset: Reset::Command }),
        _ if decoded.service == Service::BootUp => {
            Some(Restart { node: decoded.node?.raw(), number: None, reset: Reset::BootUp })
        }
        _ if decoded.ends_transfer() => {
            let transfer = bus.transfer(decoded.channel?)?;
            let is_written = transfer.direction == Direction::Download && transfer.outcome == Outcome::Complete;
            let number = tpdos::concerned(transfer.multiplexer).filter(|_| is_written)?;
            Some(Restart { node: decoded.node?.raw(), number: Some(number), reset: Reset::Parameters })
        }
        _ => None,
    }
}

impl Facts {
    /// The facts about a node.
    pub fn node(&self, id: NodeId) -> &NodeFacts {
        &self.nodes[id]
    }

    /// Handles the next frame before the rules see it; returns the node whose TPDO parameters may have changed.
    pub(super) fn follow(&mut self, record: &Record, decoded: &Decoded, bus: &Bus) -> Option<NodeId> {
        let now = record.timestamp;
        let begins_anew = matches!(decoded.message, Message::Nmt(nmt) if !self.is_repeated(nmt));
        if matches!(decoded.service, Service::Nmt | Service::BootUp | Service::Sdo) {
            self.news.restart = restart(decoded, begins_anew, bus);
            self.keep_silent(now);
        }
        let reconfigured = self.tpdos.frame(decoded, bus);
        let is_from_node = decoded.is_from_node();
        // Nearly always `None` replaces `None`, and the test is cheaper than the write.
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
        // Most frames are no SDO messages, so there is nothing to reset.
        if !matches!(news.request, RequestEvent::None) {
            news.request = RequestEvent::None;
        }
        news.stream = StreamEvent::Usual;
        match decoded.service {
            Service::Sync => _ = self.streams.frame(record, decoded),
            Service::Pdo => {
                news.stream = self.streams.frame(record, decoded);
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
                let absent = decoded.node.is_some_and(|node| self.nodes[node].is_absent());
                news.request = self.requests.frame(record, decoded, absent);
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

    /// The outage of a node: a silence that is longer than its heartbeat or guarding allows, without an explanation.
    #[cold]
    pub(crate) fn outage(&self, node: NodeId, now: Timestamp) -> Option<Outage> {
        let period = self.heartbeats.of(node).period();
        self.presence.outage(node, now, &self.nodes[node], period, self.layer_setting)
    }

    /// Tells that frames may be missing here, or the clock has stepped.
    pub(super) fn interrupted(&mut self, now: Timestamp) {
        let last = NodeId::all().filter_map(|node| self.nodes[node].last_seen).max();
        self.news.restart = Some(Restart { node: 0, number: None, reset: Reset::Gap });
        self.keep_silent(last.unwrap_or(now));
        self.news.restart = None;
        self.presence.interrupted(now);
        self.heartbeats.interrupted();
        self.requests.interrupted();
        self.streams.interrupted();
    }

    /// Whether a node lives, and must send its PDOs.
    pub(crate) fn must_send(&self, node: NodeId, now: Timestamp) -> bool {
        let facts = &self.nodes[node];
        facts.operational && !facts.is_storing(now) && self.outage(node, now).is_none()
    }

    /// Keeps the TPDOs that are silent although their nodes must send them, before they begin anew and are forgotten.
    fn keep_silent(&mut self, now: Timestamp) {
        let Some(restart) = self.news.restart else { return };
        for node in NodeId::all().filter(|node| restart.node == 0 || restart.node == node.raw()) {
            if let Some(until) = self.nodes[node].last_seen.filter(|_| self.must_send(node, now)) {
                self.streams.cut_off(node, restart, until, |number| self.tpdos.of(node, number));
            }
        }
    }

    /// Handles the frame after the rules have seen it.
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
        if let Some(restart) = self.news.restart.take() {
            self.streams.restart(restart);
        }
        let Some(node) = decoded.node else { return };
        if self.news.is_from_node {
            self.presence.heard(node);
            let facts = &mut self.nodes[node];
            if let Message::ErrorControl(message) = decoded.message {
                facts.shown(message.state, now);
            }
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
            facts.booted(now);
            self.moved(bus);
        }
        if decoded.ends_transfer() {
            self.transferred(now, node, decoded, bus);
        }
    }

    /// A node has booted; its time from reset to boot-up is noted, if it was present before.
    fn restarted(&mut self, node: NodeId, now: Timestamp) {
        const LONGEST: Duration = Duration::from_secs(60);
        let took = self.nodes[node].pending_reset.map(|reset| now.since(reset));
        if let Some(took) = took.filter(|took| *took <= LONGEST && self.news.returned.is_none()) {
            self.presence.restarted(node, took);
        }
    }

    /// A node has booted with a new node-ID, so no message will come with the old node-ID. If no message tells the old
    /// node-ID, it is that of the only node that was reset and has been silent since.
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

    /// Whether an NMT command repeats the last command to its nodes, so that it changes nothing: some masters repeat
    /// commands again and again.
    fn is_repeated(&self, nmt: Nmt) -> bool {
        let resets = nmt.command.is_reset();
        let mut present = self.nodes.named(nmt.node).map(|(_, facts)| facts).filter(|facts| facts.first_seen.is_some());
        !resets
            && present.all(|facts| {
                let obeyed = |at| facts.last_boot_up.is_none_or(|boot_up| boot_up < at);
                let left = facts.obedience == Obedience::Left;
                !left && facts.command.is_some_and(|(last, at)| last == nmt.command && obeyed(at))
            })
    }

    fn commanded(&mut self, now: Timestamp, command: Command, node: u8) {
        let resets = command.is_reset();
        for (_, facts) in self.nodes.named_mut(node) {
            let repeats = facts.command.is_some_and(|(last, _)| last == command);
            if !repeats || facts.obedience == Obedience::Left {
                facts.obedience = Obedience::Open;
            }
            facts.command = Some((command, now));
            facts.operational = command == Command::START;
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
        // Some devices store through other objects too, with the same signatures.
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
