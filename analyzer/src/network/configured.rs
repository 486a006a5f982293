//! Node-IDs and bit rates set by writing manufacturer-specific objects; they take effect at the next start.

use super::bus::Bus;
use super::event::Event;
use crate::{Multiplexer, NodeId};
use canvass_traces::Duration;

/// The settings of a device after its next start, with the written object.
#[derive(Clone, Copy, Default)]
pub struct Pending {
    node_id: Option<(NodeId, Multiplexer)>,
    /// The bit rate in bit/s, if the code is known.
    bit_rate: Option<(Option<u32>, Multiplexer)>,
}

/// Handles a number written to an object of a node.
pub fn written(bus: &mut Bus, id: NodeId, object: Multiplexer, value: Option<u32>) {
    let node = bus.node_mut(id);
    let Some(device) = node.device.as_deref() else { return };
    let settings = &device.manual.settings;
    if settings.node_id == Some(object) {
        let set = value.and_then(|raw| u8::try_from(raw).ok()).and_then(NodeId::new);
        node.pending.node_id = set.map(|set| (set, object));
    } else if settings.bit_rate == Some(object) {
        let rate = value.and_then(|code| settings.bit_rate_of(code));
        node.pending.bit_rate = Some((rate, object));
    }
}

/// Handles the start of a node. If this node-ID was assigned by writing an object, returns the former node and the
/// object. Settings that did not take effect were not stored, and are dropped.
pub fn started(bus: &mut Bus, id: NodeId) -> Option<(NodeId, Multiplexer)> {
    let given = |from: NodeId| {
        let (to, object) = bus.node(from)?.pending.node_id?;
        (to == id && from != id).then_some((from, object))
    };
    let given = NodeId::all().find_map(given);
    let before = given.map_or(id, |(from, _)| from);
    let pending = std::mem::take(&mut bus.node_mut(before).pending);
    if let Some((bit_rate, _)) = pending.bit_rate {
        bus.events.push(Event::BitRateChanged { node: Some(id), bit_rate, delay: Duration::ZERO });
    }
    given
}
