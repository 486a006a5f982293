//! The heartbeats of all nodes of a bus, and their periods: from 1017h, or learned.

use super::NodeFacts;
use crate::findings::rhythm::{Interval, Rhythm};
use crate::message::{Message, Service};
use crate::network::sdo::Outcome;
use crate::network::{Bus, Decoded};
use crate::object;
use crate::wire::lss;
use crate::{NodeId, PerNode};
use canvass_traces::{Duration, Timestamp};

/// Follows the heartbeats of all nodes.
#[derive(Default)]
pub struct Heartbeats {
    nodes: PerNode<Rhythm>,
    /// Whether LSS has configured a slave that is not yet back in waiting state.
    configured_by_lss: bool,
}

impl Heartbeats {
    /// Handles a heartbeat of the node that `facts` describes; returns the interval that ends with the heartbeat.
    pub fn beat(&mut self, now: Timestamp, decoded: &Decoded, facts: &NodeFacts) -> Option<Interval> {
        let (Message::ErrorControl(_), Some(node)) = (decoded.message, decoded.node) else { return None };
        let rhythm = self.rhythm(node);
        if facts.is_storing(now) {
            rhythm.pause();
        }
        rhythm.beat(now)
    }

    /// Handles any other frame. `changes_state`: the frame is an NMT command that changes the state of a node.
    pub fn other(&mut self, decoded: &Decoded, changes_state: bool, bus: &Bus) {
        match (decoded.service, decoded.message) {
            // A reset interrupts the heartbeat; another change of state may restart its period.
            (Service::Nmt, Message::Nmt(nmt)) if nmt.command.is_reset() => self.pause(nmt.node),
            (Service::Nmt, Message::Nmt(nmt)) if changes_state => {
                self.nodes.named_mut(nmt.node).for_each(|(_, rhythm)| rhythm.shift());
            }
            (Service::BootUp, _) => {
                // Stored parameters are in force again.
                if let Some(node) = decoded.node {
                    self.restart(node, bus);
                }
            }
            (Service::Sdo, _) => self.configured(decoded, bus),
            // The message may be a heartbeat that came just after a guarding request.
            (Service::Guarding, Message::ErrorControl(_)) => self.pause(decoded.node.map_or(0, NodeId::raw)),
            // A node that returns to waiting with another configuration may reset itself.
            (Service::Lss, Message::LssRequest(request)) => match request {
                lss::Request::ConfigureNodeId { .. } | lss::Request::ConfigureBitTiming { .. } => {
                    self.configured_by_lss = true;
                }
                lss::Request::ActivateBitTiming { .. } => self.interrupted(),
                lss::Request::SwitchGlobal { mode: 0 } if std::mem::take(&mut self.configured_by_lss) => {
                    self.interrupted();
                }
                _ => {}
            },
            (Service::Lmt, Message::LmtRequest(_)) => self.interrupted(),
            _ => {}
        }
    }

    /// Takes over the heartbeat time when it is read or written.
    fn configured(&mut self, decoded: &Decoded, bus: &Bus) {
        if !decoded.ends_transfer() {
            return;
        }
        let Some(transfer) = decoded.channel.and_then(|channel| bus.transfer(channel)) else { return };
        if transfer.multiplexer.index.0 == object::PRODUCER_HEARTBEAT_TIME
            && transfer.outcome == Outcome::Complete
            && let Some(node) = decoded.node
        {
            self.restart(node, bus);
        }
    }

    /// Forgets the learned period of a node, and takes over its heartbeat time if the trace itself has shown it: a
    /// description gives only the default.
    fn restart(&mut self, id: NodeId, bus: &Bus) {
        let mut parameters = bus.node(id).into_iter().flat_map(|node| node.parameters());
        let time = parameters
            .find(|(object, _)| object.index.0 == object::PRODUCER_HEARTBEAT_TIME)
            .map(|(_, time)| time & 0xFFFF);
        let told = time.filter(|&time| time > 0).map(|time| Duration::from_millis(u64::from(time)));
        let rhythm = self.rhythm(id);
        rhythm.restart();
        rhythm.tell(told);
    }

    /// Starts the intervals of a node, or of all nodes if `node` is 0, anew: the next heartbeat ends no interval.
    fn pause(&mut self, node: u8) {
        self.nodes.named_mut(node).for_each(|(_, rhythm)| rhythm.pause());
    }

    /// Starts the intervals of all nodes anew: the next heartbeats end no intervals.
    pub fn interrupted(&mut self) {
        self.nodes.values_mut().for_each(Rhythm::pause);
    }

    /// The rhythm of a node, to change.
    fn rhythm(&mut self, node: NodeId) -> &mut Rhythm {
        &mut self.nodes[node]
    }

    /// The rhythm of a node.
    pub fn of(&self, node: NodeId) -> &Rhythm {
        &self.nodes[node]
    }

    /// The rhythms of all nodes.
    pub fn all(&self) -> impl Iterator<Item = (NodeId, &Rhythm)> {
        self.nodes.iter()
    }
}
