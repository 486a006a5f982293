//! The heartbeats of all nodes of a bus, and their periods: told by 1017h, or learned.

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
    /// LSS has configured a slave, which is not yet back in waiting state.
    configured_by_lss: bool,
}

impl Heartbeats {
    /// Takes a heartbeat; returns the interval if it ends one. `facts` are those of its node.
    pub fn beat(&mut self, now: Timestamp, decoded: &Decoded, facts: &NodeFacts) -> Option<Interval> {
        let (Message::ErrorControl(_), Some(node)) = (decoded.message, decoded.node) else { return None };
        let rhythm = self.rhythm(node);
        if facts.is_storing(now) {
            rhythm.pause();
        }
        rhythm.beat(now)
    }

    /// Takes any other frame. `changes_state`: it is an NMT command that changes the state of some node.
    pub fn other(&mut self, decoded: &Decoded, changes_state: bool, bus: &Bus) {
        match (decoded.service, decoded.message) {
            // A reset ends the beat, another change of state may let it begin anew.
            (Service::Nmt, Message::Nmt(nmt)) if nmt.command.is_reset() => self.pause(nmt.node),
            (Service::Nmt, Message::Nmt(nmt)) if changes_state => {
                self.nodes.named_mut(nmt.node).for_each(|(_, rhythm)| rhythm.shift());
            }
            (Service::BootUp, _) => {
                // What was stored is in force again.
                if let Some(node) = decoded.node {
                    self.restart(node, bus);
                }
            }
            (Service::Sdo, _) => self.configured(decoded, bus),
            // It may be a heartbeat that came just when the node was asked.
            (Service::Guarding, Message::ErrorControl(_)) => self.pause(decoded.node.map_or(0, NodeId::raw)),
            // A node that goes back to waiting with another configuration may reset itself.
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

    /// The heartbeat time was read or written: from now on it counts.
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

    /// Forgets what was learned of a node, and takes its producer time as far as the trace itself has shown it: a
    /// description only says what the default is.
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

    /// The next beat of a node, or of all where it is 0, ends no interval.
    fn pause(&mut self, node: u8) {
        self.nodes.named_mut(node).for_each(|(_, rhythm)| rhythm.pause());
    }

    /// The next beats end no intervals.
    pub fn interrupted(&mut self) {
        self.nodes.values_mut().for_each(Rhythm::pause);
    }

    /// The rhythm of a node.
    fn rhythm(&mut self, node: NodeId) -> &mut Rhythm {
        &mut self.nodes[node]
    }

    /// The rhythm of a node, to look at.
    pub fn of(&self, node: NodeId) -> &Rhythm {
        &self.nodes[node]
    }

    /// All nodes with their rhythms.
    pub fn all(&self) -> impl Iterator<Item = (NodeId, &Rhythm)> {
        self.nodes.iter()
    }
}
