//! Learns COB-IDs and mappings from descriptions and from the SDO traffic of the trace itself.

use super::bus::Bus;
use super::cob_ids::{self, Source, Use};
use super::event::{Event, Move};
use super::layer_setting::Before;
use super::node::{Node, Shown};
use super::number::number;
use super::scaling::is_scaling_parameter;
use super::sdo::{Channel, ChannelIndex, Direction, Outcome};
use super::{configured, recognition};
use crate::dictionary::names::{self, Role};
use crate::dictionary::{DeviceDescription, KnownDevice};
use crate::message::PdoNumber;
use crate::object;
use crate::wire::pdo::MappingEntry;
use crate::wire::srdo::{self, Half};
use crate::{CobId, Multiplexer, NodeId};
use std::sync::Arc;

/// Takes over the COB-IDs of a description.
pub(crate) fn from_description(bus: &mut Bus, node: NodeId, description: &DeviceDescription) {
    for (object, entry) in description.dictionary.entries() {
        let value = entry.start_value(node).and_then(|value| value.to_raw());
        if let Some(value) = value.and_then(|value| u32::try_from(value).ok()) {
            learn_cob_id(bus, node, object, value, Source::Description);
        }
    }
}

/// Takes over the value of a transfer, read or written, as the value of the server's object.
pub(crate) fn from_transfer(bus: &mut Bus, index: ChannelIndex) {
    let Some(channel) = bus.channels.get(usize::from(index.0)) else { return };
    let server = channel.server;
    let Some(transfer) = channel.transfer() else { return };
    if transfer.outcome != Outcome::Complete {
        return;
    }
    let object = transfer.multiplexer;
    transferred(bus, server, object);
    let Some(transfer) = bus.channels.get(usize::from(index.0)).and_then(Channel::transfer) else { return };
    let is_download = transfer.direction == Direction::Download;
    let is_setting = matches!(object.index.0, 0x2000..=0x5FFF | object::NODE_ID) && is_download;
    if is_setting {
        let value = number(transfer.data());
        configured::written(bus, server, object, value);
    }
    let is_condition = || bus.node(server).is_some_and(|node| node.is_condition(object));
    if (is_setting || !is_learned(object)) && !is_condition() {
        return;
    }
    let Some(transfer) = bus.channels.get(usize::from(index.0)).and_then(Channel::transfer) else { return };
    let shown = match transfer.direction {
        Direction::Upload => Shown::Read,
        Direction::Download => Shown::Written,
    };
    match (object.index.0, object.sub.0, shown, transfer.data()) {
        // Sub-index 1 stores all parameters, 2 the communication parameters, 3 the application parameters.
        (object::STORE_PARAMETERS, sub @ 1..=3, Shown::Written, b"save") => return bus.node_mut(server).store(sub),
        (object::RESTORE_DEFAULT_PARAMETERS, 1..=2, Shown::Written, b"load") => {
            return bus.node_mut(server).restore_defaults();
        }
        _ => {}
    }
    let value = number(transfer.data());
    if shown == Shown::Read && bus.candidates.want(object) {
        let data = transfer.data().to_vec();
        recognise(bus, server, object, &data);
    }
    let Some(value) = value else { return };
    // The COB-IDs of the first SDO server are fixed: only a download moves them, not an upload.
    if object.index.0 == object::SDO_SERVER_PARAMETER && shown == Shown::Read {
        return;
    }
    learn(bus, server, object, value, shown);
    learn_cob_id(bus, server, object, value, Source::Trace);
}

/// Handles the value of an object that a node has shown.
fn recognise(bus: &mut Bus, id: NodeId, object: Multiplexer, data: &[u8]) {
    let candidates = bus.candidates.get();
    if !candidates.iter().any(|candidate| candidate.facts.iter().any(|fact| fact.0 == object)) {
        return;
    }
    bus.node_mut(id).identity.insert(object, data[..data.len().min(recognition::LONGEST)].to_vec());
    by_identity(bus, id);
}

/// Handles the transfer of an object, which shows that the node has the object.
fn transferred(bus: &mut Bus, id: NodeId, object: Multiplexer) {
    if bus.candidates.exist() {
        let node = bus.node_mut(id);
        if node.is_ambiguous() && node.traits.transferred(object) {
            by_identity(bus, id);
        }
    }
}

/// Handles a TPDO of a node whose model is unknown.
pub(crate) fn received(bus: &mut Bus, id: NodeId, tpdo: u16, length: usize) {
    if bus.candidates.exist() && bus.node_mut(id).traits.received(tpdo, length) {
        by_identity(bus, id);
    }
}

/// Looks for the model of a node that has shown objects of its identity.
fn by_identity(bus: &mut Bus, id: NodeId) {
    if bus.node_mut(id).identity.is_empty() {
        return;
    }
    let candidates = bus.candidates.get();
    let node = bus.node_mut(id);
    // A device that the user has named is not doubted.
    if node.device.is_some() && node.recognition.is_none() {
        return;
    }
    let Some((place, recognition)) = recognition::recognise(&candidates, &node.identity, &node.traits) else { return };
    let before = node.recognition.replace(recognition);
    if before.map(|before| before.model) != node.recognition.as_ref().map(|now| Arc::clone(&now.model))
        && let Some(candidate) = candidates.get(place)
    {
        after_recognition(bus, id, &candidate.device);
    }
}

fn learn(bus: &mut Bus, server: NodeId, object: Multiplexer, value: u32, shown: Shown) {
    let pdo = PdoNumber::of_mapping_index(object.index.0);
    let room = bus.room.clone();
    let node = bus.node_mut(server);
    if !node.has_shown(object) && !room.take(Node::PARAMETER) {
        return;
    }
    let before = pdo.map(|pdo| node.mapping(server, pdo));
    let lays_out = node.learn(object, value, shown);
    let after = pdo.map(|pdo| node.mapping(server, pdo));
    bus.turn += u64::from(lays_out);
    if let Some(pdo) = pdo
        && before != after
    {
        bus.events.push(Event::MappingChanged(server, pdo));
    }
}

/// Sets the use of a COB-ID parameter's CAN-ID. If the use had another CAN-ID, reports the move as an event.
fn learn_cob_id(bus: &mut Bus, node: NodeId, object: Multiplexer, value: u32, source: Source) {
    if srdo::of_communication_index(object.index.0).is_some() && object.sub.0 == 1 {
        return learn_srdo_direction(bus, node, object, source);
    }
    let Some(used) = used_by(bus, node, object) else { return };
    let from = bus.cob_ids.place(used);
    assign(bus, used, value, source);
    let to = bus.cob_ids.place(used);
    if from != to {
        bus.events.push(Event::CobIdMoved(Move { used, from, to, source }));
    }
}

/// Handles the direction of an SRDO, on which the use of its two CAN-IDs depends: sets the use of both again.
fn learn_srdo_direction(bus: &mut Bus, node: NodeId, object: Multiplexer, source: Source) {
    for sub in 5..=6 {
        let cob_id = Multiplexer::new(object.index.0, sub);
        if let Some(value) = bus.node_mut(node).parameter(node, cob_id) {
            learn_cob_id(bus, node, cob_id, value, source);
        }
    }
}

/// Handles a boot-up: the node has its stored parameters again. COB-IDs and mappings that were not stored are lost, and
/// so are the transfers.
pub fn after_boot_up(bus: &mut Bus, node: NodeId) {
    let channels: Vec<ChannelIndex> = bus.channels_of(node).collect();
    for index in channels {
        if bus.channels.get_mut(usize::from(index.0)).is_some_and(Channel::reset) {
            bus.events.push(Event::TransferLeft(index));
        }
    }
    let (places, mappings) = (places(bus, node), mappings(bus, node));
    bus.turn += 1;
    let state = bus.node_mut(node);
    let before = state.parameters().count();
    state.restart();
    let forgotten = before.saturating_sub(state.parameters().count());
    let device = state.device.clone();
    let parameters: Vec<_> = state.parameters().collect();
    bus.room.give(forgotten * Node::PARAMETER);
    bus.cob_ids.reset(node);
    // The first server has default CAN-IDs; others have none without their parameters.
    for channel in bus.channels_of(node).skip(1).collect::<Vec<_>>() {
        bus.cob_ids.release(Use::SdoRequest(channel), None);
        bus.cob_ids.release(Use::SdoResponse(channel), None);
    }
    let announced = bus.events.len();
    if let Some(device) = device {
        from_description(bus, node, &device.description);
    }
    for (object, value) in parameters {
        learn_cob_id(bus, node, object, value, Source::Trace);
    }
    // Only the differences between before and after the start are events, not the steps between.
    bus.events.truncate(announced);
    announce_moves(bus, node, &places);
    for (pdo, before) in mappings {
        if bus.node_mut(node).mapping(node, pdo) != before {
            bus.events.push(Event::MappingChanged(node, pdo));
        }
    }
}

/// Handles the user's description of a node: the description holds from here on, unless the trace has shown otherwise.
pub(crate) fn after_description(bus: &mut Bus, node: NodeId, device: &Arc<KnownDevice>) {
    if bus.node_mut(node).parameters().next().is_some() {
        return described_late(bus, node, device, None);
    }
    bus.turn += 1;
    bus.node_mut(node).describe(Arc::clone(device));
    from_description(bus, node, &device.description);
}

/// Handles the recognition of a node: the description of its model holds from here on, unless the trace has shown
/// otherwise.
pub(crate) fn after_recognition(bus: &mut Bus, node: NodeId, device: &Arc<KnownDevice>) {
    described_late(bus, node, device, Some(Event::Recognised(node)));
}

fn described_late(bus: &mut Bus, node: NodeId, device: &Arc<KnownDevice>, event: Option<Event>) {
    let (places, announced) = (places(bus, node), bus.events.len());
    bus.turn += 1;
    bus.node_mut(node).describe(Arc::clone(device));
    from_description(bus, node, &device.description);
    let parameters: Vec<_> = bus.node_mut(node).parameters().collect();
    for (object, value) in parameters {
        learn_cob_id(bus, node, object, value, Source::Trace);
    }
    bus.events.truncate(announced);
    bus.events.extend(event);
    announce_moves(bus, node, &places);
}

/// Moves the knowledge of a node whose node-ID was set by writing an object.
pub(crate) fn after_written_node_id(bus: &mut Bus, from: NodeId, to: NodeId, object: Multiplexer) {
    bus.events.push(Event::NodeIdChanged { from: Some(from), to, object: Some(object) });
    take_over_description(bus, from, to);
}

/// Moves the knowledge of a node whose node-ID was set by layer setting.
pub(crate) fn after_new_node_id(bus: &mut Bus, to: NodeId, before: &Before) {
    let of_address = || NodeId::all().find(|&id| bus.node(id).is_some_and(|node| has_address(node, id, before)));
    let from = before.told.or_else(of_address);
    if from == Some(to) {
        return;
    }
    bus.events.push(Event::NodeIdChanged { from, to, object: None });
    if let Some(from) = from {
        take_over_description(bus, from, to);
    }
}

/// Moves the description of a device to its new node-ID.
fn take_over_description(bus: &mut Bus, from: NodeId, to: NodeId) {
    let Some(known) = bus.node(from) else { return };
    let Some(device) = known.device.clone() else { return };
    let recognition = known.recognition.clone();
    bus.turn += 1;
    let node = bus.node_mut(to);
    if node.device.is_none() {
        node.describe(Arc::clone(&device));
        node.recognition = recognition;
        from_description(bus, to, &device.description);
    }
}

/// Whether a node has shown the four numbers of an LSS address.
fn has_address(node: &Node, id: NodeId, before: &Before) -> bool {
    let shown = |sub: u8| node.parameter(id, Multiplexer::new(object::IDENTITY, sub));
    (1..).zip(before.address).all(|(sub, part)| part.is_some() && part == shown(sub))
}

/// The CAN-IDs that a node uses.
fn places(bus: &Bus, node: NodeId) -> Vec<(Use, u16, Source)> {
    let own = bus.cob_ids.of_node(node).filter(|row| !matches!(row.1, Use::ErrorControl(_)));
    let further =
        bus.channels_of(node).skip(1).flat_map(|channel| [Use::SdoRequest(channel), Use::SdoResponse(channel)]);
    let further = further.filter_map(|used| {
        let id = bus.cob_ids.place(used)?;
        Some((id, used, bus.cob_ids.get(id).1))
    });
    let mut places: Vec<_> = own.chain(further).map(|(id, used, source)| (used, id, source)).collect();
    places.sort_unstable_by_key(|place| place.1);
    places
}

fn announce_moves(bus: &mut Bus, node: NodeId, before: &[(Use, u16, Source)]) {
    let now = places(bus, node);
    let place = |places: &[(Use, u16, Source)], used| places.iter().find(|place| place.0 == used).copied();
    for &(used, from, _) in before {
        let to = place(&now, used);
        if to.map(|to| to.1) != Some(from) {
            let source = to.map_or(Source::Predefined, |to| to.2);
            bus.events.push(Event::CobIdMoved(Move { used, from: Some(from), to: to.map(|to| to.1), source }));
        }
    }
    for &(used, to, source) in &now {
        if place(before, used).is_none() {
            bus.events.push(Event::CobIdMoved(Move { used, from: None, to: Some(to), source }));
        }
    }
}

/// The mappings of the PDOs with a parameter that the trace has shown.
fn mappings(bus: &mut Bus, id: NodeId) -> Vec<(PdoNumber, Option<Vec<MappingEntry>>)> {
    let node = bus.node_mut(id);
    let mut pdos: Vec<_> = node.parameters().filter_map(|row| PdoNumber::of_mapping_index(row.0.index.0)).collect();
    pdos.dedup();
    pdos.into_iter().map(|pdo| (pdo, node.mapping(id, pdo))).collect()
}

/// Whether an object is learned: communication parameters, parameters of device profiles, and parameters that
/// determine units.
fn is_learned(object: Multiplexer) -> bool {
    matches!(object.index.0, 0x1000..=0x1FFF)
        || names::has_role(object.index, Role::Parameter)
        || is_scaling_parameter(object)
}

/// Sets the use of a COB-ID parameter's CAN-ID.
fn assign(bus: &mut Bus, used: Use, value: u32, source: Source) {
    let cob_id = CobId(value);
    if !is_possible(used, cob_id) {
        return;
    }
    // In 1005h and 1012h bit 31 does not switch SYNC or TIME off, and SRDOs have no such bit.
    let exists = match used {
        Use::Sync | Use::Time => true,
        Use::Srdo(node, number, _) => match srdo_direction(bus, node, number) {
            Some(SRDO_NONE) => false,
            // The SRDO is sent by another node.
            Some(SRDO_RECEIVED) if is_srdo_of_another(bus, cob_id, node) => return,
            _ => cob_id.can_id() != 0,
        },
        _ => cob_id.is_valid(),
    };
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

/// Whether a CAN-ID can have this use, independently of the device's claim: CiA 301 (7.3.5) restricts some CAN-IDs; but
/// SRDOs use restricted ones.
fn is_possible(used: Use, cob_id: CobId) -> bool {
    match used {
        Use::Srdo(..) => true,
        // The message is switched off.
        Use::Pdo(..) | Use::Emcy(_) | Use::SdoRequest(_) | Use::SdoResponse(_) if !cob_id.is_valid() => true,
        // CAN-IDs outside all standards are free for devices to use.
        _ => !cob_id.is_restricted() || u16::try_from(cob_id.can_id()).is_ok_and(cob_ids::is_free),
    }
}

/// Value of 1301h..1340h:01: the SRDO does not exist.
const SRDO_NONE: u32 = 0;
/// 1301h..1340h:01: the node receives the SRDO.
const SRDO_RECEIVED: u32 = 2;

fn srdo_direction(bus: &Bus, node: NodeId, number: u8) -> Option<u32> {
    bus.node(node)?.parameter(node, Multiplexer::new(0x1300 + u16::from(number), 1))
}

fn is_srdo_of_another(bus: &Bus, cob_id: CobId, node: NodeId) -> bool {
    let used = u16::try_from(cob_id.can_id()).map(|can_id| bus.cob_ids.get(can_id).0);
    matches!(used, Ok(Use::Srdo(sender, ..)) if sender != node)
}

/// The use of the CAN-ID in `object`; `None` for an object without a CAN-ID.
fn used_by(bus: &mut Bus, node: NodeId, object: Multiplexer) -> Option<Use> {
    match (object.index.0, object.sub.0) {
        (object::COB_ID_SYNC, 0) => Some(Use::Sync),
        (object::COB_ID_TIME, 0) => Some(Use::Time),
        (object::COB_ID_EMCY, 0) => Some(Use::Emcy(node)),
        (index @ 0x1200..=0x127F, sub @ 1..=2) => {
            let channel = server_channel(bus, node, index - object::SDO_SERVER_PARAMETER)?;
            Some(if sub == 1 { Use::SdoRequest(channel) } else { Use::SdoResponse(channel) })
        }
        (index @ 0x1301..=0x1340, sub @ 5..=6) => {
            let half = if sub == 5 { Half::Normal } else { Half::Inverted };
            srdo::of_communication_index(index).map(|number| Use::Srdo(node, number, half))
        }
        (index @ 0x1400..=0x15FF, 1) => {
            Some(Use::Pdo(node, PdoNumber::Receive(index - object::RPDO_COMMUNICATION_PARAMETER + 1)))
        }
        (index @ 0x1800..=0x19FF, 1) => {
            Some(Use::Pdo(node, PdoNumber::Transmit(index - object::TPDO_COMMUNICATION_PARAMETER + 1)))
        }
        _ => None,
    }
}

/// The channel of a node's n-th SDO server; channels beyond the first are made at their first use.
fn server_channel(bus: &mut Bus, node: NodeId, n: u16) -> Option<ChannelIndex> {
    if n == 0 {
        return Some(ChannelIndex::predefined(node));
    }
    // One further channel for each node and server, 127 * 127, is the maximum that a trace can need.
    bus.further_channels.get(&(node, n)).copied().or_else(|| {
        let index = ChannelIndex(u16::try_from(bus.channels.len()).ok()?);
        if !bus.room.take(Channel::MEMORY) {
            return None;
        }
        bus.channels.push(Channel::new(node));
        bus.further_channels.insert((node, n), index);
        Some(index)
    })
}
