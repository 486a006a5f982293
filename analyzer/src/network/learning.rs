//! COB-IDs and mappings learned from descriptions and from the SDO traffic of the trace itself.

use super::bus::Bus;
use super::cob_ids::{Source, Use};
use super::node::Shown;
use super::sdo::{Channel, ChannelIndex, Direction, Outcome};
use crate::dictionary::DeviceDescription;
use crate::message::PdoNumber;
use crate::{CobId, Multiplexer, NodeId};

/// Takes the COB-IDs of a description.
pub fn from_description(bus: &mut Bus, node: NodeId, description: &DeviceDescription) {
    for (object, entry) in description.dictionary.entries() {
        let value = entry.start_value(node).and_then(|value| value.to_raw());
        if let Some(value) = value.and_then(|value| u32::try_from(value).ok()) {
            assign(bus, node, object, value, Source::Description);
        }
    }
}

/// Takes what a transfer has shown to be in the server's dictionary, whether it was read or written.
pub fn from_transfer(bus: &mut Bus, index: ChannelIndex) {
    let Some(channel) = bus.channels.get(usize::from(index.0)) else { return };
    let server = channel.server;
    let Some(transfer) = channel.transfer() else { return };
    if transfer.outcome != Outcome::Complete || !is_communication_parameter(transfer.multiplexer) {
        return;
    }
    let object = transfer.multiplexer;
    let shown = match transfer.direction {
        Direction::Upload => Shown::Read,
        Direction::Download => Shown::Written,
    };
    match (object.index.0, object.sub.0, shown, transfer.data()) {
        // All parameters, or those of communication.
        (0x1010, 1..=2, Shown::Written, b"save") => return bus.node_mut(server).store(),
        (0x1011, 1..=2, Shown::Written, b"load") => return bus.node_mut(server).restore_defaults(),
        _ => {}
    }
    let Some(value) = number(transfer.data()) else { return };
    bus.node_mut(server).learn(object, value, shown);
    assign(bus, server, object, value, Source::Trace);
}

/// After its boot-up a node has its stored parameters again: COB-IDs and mappings that were changed and not stored
/// are gone, and so are its transfers.
pub fn after_boot_up(bus: &mut Bus, node: NodeId) {
    for channel in bus.channels.iter_mut().filter(|channel| channel.server == node) {
        channel.reset();
    }
    let state = bus.node_mut(node);
    state.restart();
    let description = state.description.clone();
    let parameters: Vec<_> = state.parameters().collect();
    bus.cob_ids.reset(node);
    if let Some(description) = description {
        from_description(bus, node, &description);
    }
    for (object, value) in parameters {
        assign(bus, node, object, value, Source::Trace);
    }
}

fn is_communication_parameter(object: Multiplexer) -> bool {
    matches!(object.index.0, 0x1000..=0x1FFF)
}

/// A value of 1 to 4 bytes.
fn number(data: &[u8]) -> Option<u32> {
    let mut bytes = [0; 4];
    bytes.get_mut(..data.len())?.copy_from_slice(data);
    (!data.is_empty()).then(|| u32::from_le_bytes(bytes))
}

/// Gives a COB-ID parameter's CAN-ID its use.
fn assign(bus: &mut Bus, node: NodeId, object: Multiplexer, value: u32, source: Source) {
    let Some(used) = used_by(bus, node, object) else { return };
    let cob_id = CobId(value);
    // Bit 31 of 1005h and 1012h does not mean that there is no SYNC or TIME.
    let exists = cob_id.is_valid() || matches!(used, Use::Sync | Use::Time);
    if !exists || cob_id.is_extended() {
        if source == Source::Trace {
            bus.cob_ids.release(used, None);
        }
        return;
    }
    bus.cob_ids.assign(cob_id.can_id(), used, source);
    if !matches!(used, Use::Sync | Use::Time) || source == Source::Trace {
        bus.cob_ids.release(used, Some(cob_id.can_id()));
    }
}

/// What the CAN-ID in that object is used for; `None` for any other object.
fn used_by(bus: &mut Bus, node: NodeId, object: Multiplexer) -> Option<Use> {
    match (object.index.0, object.sub.0) {
        (0x1005, 0) => Some(Use::Sync),
        (0x1012, 0) => Some(Use::Time),
        (0x1014, 0) => Some(Use::Emcy(node)),
        (index @ 0x1200..=0x127F, sub @ 1..=2) => {
            let channel = server_channel(bus, node, index - 0x1200)?;
            Some(if sub == 1 { Use::SdoRequest(channel) } else { Use::SdoResponse(channel) })
        }
        (index @ 0x1400..=0x15FF, 1) => Some(Use::Pdo(node, PdoNumber::Receive(index - 0x1400 + 1))),
        (index @ 0x1800..=0x19FF, 1) => Some(Use::Pdo(node, PdoNumber::Transmit(index - 0x1800 + 1))),
        _ => None,
    }
}

/// The channel of a node's n-th SDO server; beyond the first they are made when they are first seen.
fn server_channel(bus: &mut Bus, node: NodeId, n: u16) -> Option<ChannelIndex> {
    if n == 0 {
        return Some(ChannelIndex::predefined(node));
    }
    // One further channel for each node and server is all that a trace can ever need: 127 * 127.
    let known = bus.further_channels.iter().find(|row| (row.0, row.1) == (node, n)).map(|row| row.2);
    known.or_else(|| {
        let index = ChannelIndex(u16::try_from(bus.channels.len()).ok()?);
        bus.channels.push(Channel::new(node));
        bus.further_channels.push((node, n, index));
        Some(index)
    })
}
