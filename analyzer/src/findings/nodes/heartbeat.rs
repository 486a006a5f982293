//! The heartbeats of all nodes of a bus, and their periods: told by 1017h, or learned.

use crate::NodeId;
use crate::findings::Context;
use crate::findings::rhythm::{Interval, Rhythm};
use crate::message::{Message, Service};
use crate::network::Event;
use crate::network::sdo::Outcome;
use crate::wire::lss;
use canvass_traces::Duration;

/// The services that heartbeats are followed by.
pub const SERVICES: &[Service] =
    &[Service::Heartbeat, Service::BootUp, Service::Nmt, Service::Sdo, Service::Lss, Service::Lmt];

/// Follows the heartbeats of all nodes.
pub struct Heartbeats {
    nodes: Box<[Rhythm]>,
    /// LSS has configured a slave, which is not yet back in waiting state.
    configured_by_lss: bool,
}

impl Default for Heartbeats {
    fn default() -> Self {
        Self { nodes: vec![Rhythm::default(); 128].into(), configured_by_lss: false }
    }
}

impl Heartbeats {
    /// Takes a frame; returns the interval if it ends one.
    pub fn frame(&mut self, context: &Context<'_>) -> Option<Interval> {
        match (context.decoded.service, context.message()) {
            (Service::Nmt, Message::Nmt(nmt)) if context.scene.facts.is_repeated(*nmt) => None,
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
            // A node that goes back to waiting with another configuration may reset itself.
            (Service::Lss, Message::LssRequest(request)) => {
                match request {
                    lss::Request::ConfigureNodeId { .. } | lss::Request::ConfigureBitTiming { .. } => {
                        self.configured_by_lss = true;
                    }
                    lss::Request::ActivateBitTiming { .. } => self.interrupted(),
                    lss::Request::SwitchGlobal { mode: 0 } if std::mem::take(&mut self.configured_by_lss) => {
                        self.interrupted();
                    }
                    _ => {}
                }
                None
            }
            (Service::Lmt, Message::LmtRequest(_)) => {
                self.interrupted();
                None
            }
            _ => None,
        }
    }

    fn beat(&mut self, context: &Context<'_>) -> Option<Interval> {
        let node = context.node()?;
        let facts = context.scene.facts.node(node);
        if facts.is_storing(context.now()) {
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
