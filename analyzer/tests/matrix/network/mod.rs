//! Healthy networks: what their nodes, masters and clients send.

mod description;
mod dialogue;
mod layer_setting;
mod operation;
mod spec;
mod start;

use super::draw::Draw;
use super::plan::{MS, Plan, SECOND};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
pub use spec::{Base, Known, NodeSpec, PdoSpec};

/// The length of a capture in nanoseconds.
pub const LENGTH: u64 = 40 * SECOND;
/// The node-ID of a master that has one.
pub const MASTER: u8 = 127;

/// What the operation of a network has beside its usual traffic.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Events {
    /// Nothing that anybody has to be told.
    None,
    /// EMCY messages, refused and given-up transfers, error frames, a fail-safe command.
    Some,
}

/// A network and its plan.
pub struct Network {
    /// The kind of the network.
    pub base: Base,
    /// The nodes.
    pub nodes: Vec<NodeSpec>,
    /// What is sent.
    pub plan: Plan,
    known: Known,
    draw: Draw,
    /// The interval of SYNC in nanoseconds; 0 without SYNC.
    sync: u64,
    /// Whether SYNC has a counter.
    counts: bool,
}

impl Network {
    /// The network of this base, seed and name. `first` is the lowest possible node-ID.
    pub fn new(base: Base, known: Known, events: Events, mut draw: Draw) -> Self {
        let nodes = spec::nodes(base, &mut draw);
        let has_sync = nodes.iter().flat_map(|node| &node.pdos).any(|pdo| pdo.trigger.is_synchronous());
        let sync = if has_sync { draw.of(&[20, 50, 100]) * MS } else { 0 };
        // Forty nodes at a SYNC of 20 ms would fill the bus.
        let sync = sync.max(if has_sync { nodes.len() as u64 * 5 * MS } else { 0 });
        let counts = draw.chance(25);
        let mut network = Self { base, nodes, plan: Plan::default(), known, draw, sync, counts };
        let started = network.start();
        network.operate(&started, events);
        network
    }

    /// The descriptions that the diagnosis is given.
    pub fn descriptions(&self) -> Vec<(NodeId, KnownDevice)> {
        let described = self.nodes.iter().filter(|_| self.known == Known::Described);
        described.filter_map(|node| Some((NodeId::new(node.id)?, description::of(node)?))).collect()
    }
}
