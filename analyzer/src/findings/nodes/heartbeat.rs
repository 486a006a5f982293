//! The heartbeats of all nodes of a bus, and their periods: told by 1017h, or learned.

use crate::NodeId;
use crate::findings::rhythm::{Interval, Rhythm};
use crate::findings::{Context, NodeFacts};
use crate::message::{Message, Service};
use crate::network::Event;
use crate::network::sdo::Outcome;
use canvass_traces::Duration;

/// The services that heartbeats are followed by.
pub const SERVICES: &[Service] = &[Service::Heartbeat, Service::BootUp, Service::Nmt, Service::Sdo, Service::Lss];

/// Follows the heartbeats of all nodes.
pub struct Heartbeats {
    nodes: Box<[Rhythm]>,
}

impl Default for Heartbeats {
    fn default() -> Self {
        Self { nodes: vec![Rhythm::default(); 128].into() }
    }
}

impl Heartbeats {
    /// Some devices are silent for seconds while they write their memory.
    const STORING: Duration = Duration::from_secs(5);

    /// Takes a frame; returns the interval if it ends one.
    pub fn frame(&mut self, context: &Context<'_>) -> Option<Interval> {
        match (context.decoded.service, context.message()) {
            (Service::Nmt, Message::Nmt(nmt)) => {
                // A state change may shift the beat, a reset ends it.
                let all = nmt.node == 0;
                let named = self.nodes.iter_mut().enumerate().filter(|(id, _)| all || usize::from(nmt.node) == *id);
                named.for_each(|(_, rhythm)| rhythm.pause());
                None
            }
            (Service::BootUp, _) => {
                self.rhythm(context.node()?).restart();
                // What was stored is in force again.
                let told = self.told(context, context.node()?);
                self.rhythm(context.node()?).tell(told);
                None
            }
            (Service::Sdo, _) => {
                self.configured(context);
                None
            }
            (Service::Heartbeat, Message::ErrorControl(_)) => self.beat(context),
            // A node whose LSS state changes may reset itself.
            (Service::Lss, _) => {
                self.interrupted();
                None
            }
            _ => None,
        }
    }

    fn beat(&mut self, context: &Context<'_>) -> Option<Interval> {
        let node = context.node()?;
        let facts = context.scene.facts.node(node);
        if NodeFacts::is_recent(facts.last_store, context.now(), Self::STORING) {
            self.rhythm(node).pause();
        }
        self.rhythm(node).beat(context.now())
    }

    /// The heartbeat time was read or written: from now on it counts.
    fn configured(&mut self, context: &Context<'_>) {
        if context.decoded.event != Some(Event::TransferEnded) {
            return;
        }
        let Some(node) = context.node() else { return };
        let Some(transfer) = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel)) else {
            return;
        };
        if transfer.multiplexer.index.0 == 0x1017 && transfer.outcome == Outcome::Complete {
            let told = self.told(context, node);
            let rhythm = self.rhythm(node);
            rhythm.restart();
            rhythm.tell(told);
        }
    }

    /// The producer time, as far as the trace itself has shown it: a description only says what the default is.
    fn told(&self, context: &Context<'_>, node: NodeId) -> Option<Duration> {
        let node = context.scene.bus.node(node)?;
        let (_, time) = node.parameters().find(|(object, _)| object.index.0 == 0x1017)?;
        (time > 0).then(|| Duration::from_millis(u64::from(time & 0xFFFF)))
    }

    /// The next beats end no intervals.
    pub fn interrupted(&mut self) {
        self.nodes.iter_mut().for_each(Rhythm::pause);
    }

    /// The rhythm of a node.
    pub fn rhythm(&mut self, node: NodeId) -> &mut Rhythm {
        &mut self.nodes[usize::from(node.raw())]
    }

    /// All nodes with their rhythms.
    pub fn all(&self) -> impl Iterator<Item = (NodeId, &Rhythm)> {
        NodeId::all().zip(self.nodes.iter().skip(1))
    }
}
