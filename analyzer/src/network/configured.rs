//! Node-IDs and bit rates that are set by writing objects of the manufacturer, and take effect at the next start.

use super::bus::Bus;
use super::event::Event;
use crate::{Multiplexer, NodeId};
use canvass_traces::Duration;

/// What a device will use after its next start, with the object that was written.
#[derive(Clone, Copy, Default)]
pub struct Pending {
    node_id: Option<(NodeId, Multiplexer)>,
    /// In bit/s, where the code is known.
    bit_rate: Option<(Option<u32>, Multiplexer)>,
}

/// An object of a node was written with that number.
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

/// A node has started: the node that it was before, if another one was given this node-ID, with the object that did it.
/// What did not take effect by now was not stored, and is forgotten.
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
