//! One bus: the use of its CAN-IDs, its nodes, its transfers.

use super::Candidates;
use super::cob_ids::CobIds;
use super::event::Event;
use super::layer_setting::LayerSetting;
use super::node::Node;
use super::sdo::{Channel, ChannelIndex, Transfer};
use super::srdo_pairs::SrdoPairs;
use crate::room::Room;
use crate::wire::layer_setting::Protocol;
use crate::{NodeId, PerNode};
use std::collections::BTreeMap;

/// The state of one bus.
#[derive(Clone)]
pub struct Bus {
    pub(super) cob_ids: CobIds,
    pub(super) channels: Vec<Channel>,
    /// The SDO servers beyond the first of a node, by node and number from 1.
    pub(super) further_channels: BTreeMap<(NodeId, u16), ChannelIndex>,
    pub(super) nodes: PerNode<Option<Box<Node>>>,
    /// The models as which nodes can be recognised.
    pub(super) candidates: Candidates,
    /// The protocol on 7E5h and 7E4h, according to the last message that only one of the two protocols has.
    pub(super) protocol: Option<Protocol>,
    pub(super) srdo_pairs: SrdoPairs,
    pub(super) layer_setting: LayerSetting,
    /// The events of the last frame; the memory is reused.
    pub(super) events: Vec<Event>,
    /// Memory for objects that devices have shown.
    pub(super) room: Room,
    /// Memory for long values during their transfer.
    pub(super) values: Room,
    /// Whether the next frame begins a new list of events.
    pub(super) handled: bool,
    /// Counts changes of state, other than of CAN-IDs, that affect the meaning of later frames.
    pub(super) turn: u64,
}

/// Memory limits that all buses share.
#[derive(Clone)]
pub(super) struct Rooms {
    shown: Room,
    values: Room,
}

impl Rooms {
    /// Limit of the memory for objects that devices have shown, in bytes: enough for all communication parameters of
    /// the devices on several full buses.
    const SHOWN: usize = 8 << 20;
    /// Limit of the memory for long values, in bytes: enough for the kept part of the firmware of dozens of devices
    /// at a time.
    const VALUES: usize = 4 << 20;
}

impl Rooms {
    /// Independent copies of the rooms, with the same numbers of bytes left.
    pub(super) fn apart(&self) -> Self {
        Self { shown: self.shown.apart(), values: self.values.apart() }
    }
}

impl Default for Rooms {
    fn default() -> Self {
        Self { shown: Room::new(Self::SHOWN), values: Room::new(Self::VALUES) }
    }
}

impl Bus {
    /// A bus with only the predefined connection set.
    pub fn new() -> Self {
        Self::within(Rooms::default())
    }

    /// As [`Bus::new`], with memory from these rooms.
    pub(super) fn within(rooms: Rooms) -> Self {
        Self {
            cob_ids: CobIds::default(),
            channels: NodeId::all().map(Channel::new).collect(),
            further_channels: BTreeMap::new(),
            nodes: PerNode::default(),
            candidates: Candidates::default(),
            protocol: None,
            srdo_pairs: SrdoPairs::default(),
            layer_setting: LayerSetting::default(),
            events: Vec::new(),
            room: rooms.shown,
            values: rooms.values,
            handled: false,
            turn: 0,
        }
    }

    /// A copy of the bus with memory from other rooms.
    pub(super) fn moved(&self, rooms: &Rooms) -> Self {
        Self { room: rooms.shown.clone(), values: rooms.values.clone(), ..self.clone() }
    }

    /// The state of a node that was seen or described.
    #[inline]
    pub fn node(&self, id: NodeId) -> Option<&Node> {
        self.nodes[id].as_deref()
    }

    /// The transfer under way on an SDO channel, or the last one.
    #[inline]
    pub fn transfer(&self, channel: ChannelIndex) -> Option<&Transfer> {
        self.channels.get(usize::from(channel.0)).and_then(Channel::transfer)
    }

    /// The last transfer on an SDO channel that did not reach its end.
    pub fn left_transfer(&self, channel: ChannelIndex) -> Option<&Transfer> {
        self.channels.get(usize::from(channel.0)).and_then(Channel::left_transfer)
    }

    /// All SDO channels of a node.
    pub(super) fn channels_of(&self, node: NodeId) -> impl Iterator<Item = ChannelIndex> {
        let further = self.further_channels.range((node, 0)..=(node, u16::MAX)).map(|row| *row.1);
        std::iter::once(ChannelIndex::predefined(node)).chain(further)
    }

    /// The node that serves an SDO channel.
    pub fn server(&self, channel: ChannelIndex) -> Option<NodeId> {
        self.channels.get(usize::from(channel.0)).map(|channel| channel.server)
    }

    /// The open transfers.
    pub fn open_transfers(&self) -> impl Iterator<Item = (NodeId, &Transfer)> {
        let open = self.channels.iter().filter(|channel| channel.is_busy());
        open.filter_map(|channel| Some((channel.server, channel.transfer()?)))
    }

    /// All events of the last frame in order; with the first frame, also the events of earlier descriptions.
    #[inline]
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    #[inline]
    pub(super) fn node_mut(&mut self, id: NodeId) -> &mut Node {
        self.nodes[id].get_or_insert_default()
    }
}

impl Default for Bus {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::{CanId, ChannelId, Frame, Record, Timestamp};

    /// A segmented download of 600 segments to a node.
    fn download(bus: &mut Bus, node: u8) {
        let mut times = 1..;
        let mut send = |id: u32, data: [u8; 8]| {
            let time = Timestamp(times.next().unwrap_or(0) * 1_000_000);
            bus.handle(&Record::new(
                time,
                ChannelId(0),
                Frame::full(CanId::standard_masked(id + u32::from(node)), data),
            ));
        };
        send(0x600, [0x20, 0x00, 0x20, 0, 0, 0, 0, 0]);
        send(0x580, [0x60, 0x00, 0x20, 0, 0, 0, 0, 0]);
        for n in 0..600_u16 {
            let toggle = (n as u8 & 1) << 4;
            send(0x600, [toggle | u8::from(n == 599), 1, 2, 3, 4, 5, 6, 7]);
            send(0x580, [0x20 | toggle, 0, 0, 0, 0, 0, 0, 0]);
        }
    }

    /// The length of a long value is known even if there is no room for the value.
    #[test]
    fn long_values_share_their_room() {
        let mut bus = Bus::within(Rooms { shown: Room::new(1 << 20), values: Room::new(8_000) });
        download(&mut bus, 1);
        download(&mut bus, 2);
        let seen = |node: u8| {
            let transfer = bus.transfer(ChannelIndex::predefined(NodeId::new(node).unwrap())).unwrap();
            (transfer.data().len(), transfer.length(), transfer.is_open())
        };
        assert_eq!((seen(1), seen(2)), ((4_200, 4_200, false), (Transfer::SHORT, 4_200, false)));
    }

    /// A node accepts a value of four bytes.
    fn written(bus: &mut Bus, index: u16, value: u32) {
        let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
        for (id, data) in [(0x605, [0x23, low, high, 1, a, b, c, d]), (0x585, [0x60, low, high, 1, 0, 0, 0, 0])] {
            let frame = Frame::full(CanId::standard_masked(id), data);
            bus.handle(&Record::new(Timestamp(1), ChannelId(0), frame));
        }
    }

    fn place(bus: &Bus, number: u16) -> Option<u16> {
        let used = crate::network::Use::Pdo(NodeId::new(5).unwrap(), crate::PdoNumber::Transmit(number));
        bus.cob_ids.place(used)
    }

    /// A parameter takes memory once, however often it is shown, and gives it back when the node has forgotten it.
    #[test]
    fn what_devices_show_shares_its_room() {
        let mut bus = Bus::within(Rooms { shown: Room::new(2 * Node::PARAMETER), values: Room::new(1 << 20) });
        let has_shown = |bus: &Bus, index| {
            bus.node(NodeId::new(5).unwrap()).is_some_and(|node| node.has_shown(crate::Multiplexer::new(index, 1)))
        };
        for start in 0..3 {
            for value in 0..10 {
                written(&mut bus, 0x1804, 0x190 + value);
            }
            written(&mut bus, 0x1805, 0x19A);
            written(&mut bus, 0x1806, 0x19B);
            assert_eq!([0x1804, 0x1805, 0x1806].map(|index| has_shown(&bus, index)), [true, true, false], "{start}");
            assert_eq!([5, 6].map(|number| place(&bus, number)), [Some(0x199), Some(0x19A)]);
            let boot_up = Frame::new(CanId::standard_masked(0x705), &[0]).unwrap();
            bus.handle(&Record::new(Timestamp(2), ChannelId(0), boot_up));
            assert_eq!([0x1804, 0x1805].map(|index| has_shown(&bus, index)), [false, false], "{start}");
            assert_eq!([5, 6].map(|number| place(&bus, number)), [None, None]);
        }
    }

    /// Without room for a further SDO channel, no channel is made.
    #[test]
    fn further_channels_take_room() {
        let server = |room: usize| {
            let mut bus = Bus::within(Rooms { shown: Room::new(room), values: Room::new(1 << 20) });
            written(&mut bus, 0x1201, 0x690);
            written(&mut bus, 0x1201, 0x691);
            bus.channels_of(NodeId::new(5).unwrap()).count()
        };
        assert_eq!((server(Channel::MEMORY), server(Channel::MEMORY + Node::PARAMETER)), (1, 2));
    }
}
