//! The communication parameters of TPDOs, as the trace itself has shown them.
//!
//! A description says only what the defaults are; most machines set these parameters before a capture begins, so that
//! nothing is concluded from defaults.

use crate::NodeId;
use crate::findings::Context;
use crate::message::Service;
use crate::network::Event;
use canvass_traces::Duration;

/// The services that parameters are followed by.
pub const SERVICES: &[Service] = &[Service::Pdo, Service::Sdo, Service::BootUp, Service::Nmt, Service::Sync];

/// TPDOs 1 to 8 of a node; further ones are rare, and not judged.
pub const TPDOS: usize = 8;

/// What is known of one TPDO.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Parameters {
    /// Sub-index 2.
    pub transmission_type: Option<u8>,
    /// Sub-index 3; `None` where it is 0 or not known.
    pub inhibit: Option<Duration>,
    /// Sub-index 5; `None` where it is 0 or not known.
    pub event_timer: Option<Duration>,
}

/// The parameters of all TPDOs of a bus.
pub struct AllParameters {
    nodes: Box<[[Parameters; TPDOS]]>,
}

impl Default for AllParameters {
    fn default() -> Self {
        Self { nodes: vec![[Parameters::default(); TPDOS]; 128].into() }
    }
}

impl AllParameters {
    /// Takes a frame; returns the node whose parameters may have changed.
    pub fn frame(&mut self, context: &Context<'_>) -> Option<NodeId> {
        let node = context.node()?;
        let transferred = context.decoded.event == Some(Event::TransferEnded)
            && context.decoded.object.is_some_and(|object| matches!(object.index.0, 0x1800..=0x19FF | 0x6200));
        if transferred || context.decoded.service == Service::BootUp {
            self.read(node, context);
            return Some(node);
        }
        None
    }

    fn read(&mut self, node: NodeId, context: &Context<'_>) {
        let rows = &mut self.nodes[usize::from(node.raw())];
        *rows = Default::default();
        let Some(known) = context.scene.bus.node(node) else { return };
        for (object, value) in known.parameters() {
            let Some(n @ 0..TPDOS) = usize::from(object.index.0).checked_sub(0x1800) else { continue };
            let nonzero = |unit: Duration| (value > 0).then(|| unit.times(u64::from(value & 0xFFFF)));
            match object.sub.0 {
                2 => rows[n].transmission_type = Some(value as u8),
                3 => rows[n].inhibit = nonzero(Duration::from_micros(100)),
                5 => rows[n].event_timer = nonzero(Duration::from_millis(1)),
                _ => {}
            }
        }
    }

    /// The parameters of a TPDO, by its number from 1; nothing is known of those beyond [`TPDOS`].
    pub fn of(&self, node: NodeId, number: u16) -> Parameters {
        let row = usize::from(number).checked_sub(1);
        let row = row.and_then(|row| self.nodes[usize::from(node.raw())].get(row));
        row.copied().unwrap_or_default()
    }
}
