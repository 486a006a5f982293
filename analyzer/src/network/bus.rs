//! One bus: which CAN-ID means what, its nodes, its transfers.

use super::Candidates;
use super::cob_ids::CobIds;
use super::event::Event;
use super::layer_setting::LayerSetting;
use super::node::Node;
use super::sdo::{Channel, ChannelIndex, Transfer};
use super::srdo_pairs::SrdoPairs;
use crate::wire::lmt::Dialect;
use crate::{NodeId, PerNode};

/// What is known of one bus.
pub struct Bus {
    pub(super) cob_ids: CobIds,
    pub(super) channels: Vec<Channel>,
    /// The SDO servers beyond the first of a node: node, number from 1, channel.
    pub(super) further_channels: Vec<(NodeId, u16, ChannelIndex)>,
    pub(super) nodes: PerNode<Option<Box<Node>>>,
    /// The models that nodes can be recognised as.
    pub(super) candidates: Candidates,
    /// The protocol of 7E5h and 7E4h, as the last message showed that only one of the two knows.
    pub(super) dialect: Option<Dialect>,
    pub(super) srdo_pairs: SrdoPairs,
    pub(super) layer_setting: LayerSetting,
    /// What the last frame brought about; its memory is used again.
    pub(super) events: Vec<Event>,
    /// The next frame begins a new list of events.
    pub(super) handled: bool,
}

impl Bus {
    /// A bus of which nothing is known but the predefined connection set.
    pub fn new() -> Self {
        Self {
            cob_ids: CobIds::default(),
            channels: NodeId::all().map(Channel::new).collect(),
            further_channels: Vec::new(),
            nodes: PerNode::default(),
            candidates: Candidates::default(),
            dialect: None,
            srdo_pairs: SrdoPairs::default(),
            layer_setting: LayerSetting::default(),
            events: Vec::new(),
            handled: false,
        }
    }

    /// What is known of a node, if it was seen or described.
    #[inline]
    pub fn node(&self, id: NodeId) -> Option<&Node> {
        self.nodes[id].as_deref()
    }

    /// The transfer under way on an SDO channel, or the last one.
    #[inline]
    pub fn transfer(&self, channel: ChannelIndex) -> Option<&Transfer> {
        self.channels.get(usize::from(channel.0)).and_then(Channel::transfer)
    }

    /// The transfer on an SDO channel that was left last, before its end.
    pub fn left_transfer(&self, channel: ChannelIndex) -> Option<&Transfer> {
        self.channels.get(usize::from(channel.0)).and_then(Channel::left_transfer)
    }

    /// The node that serves an SDO channel.
    pub fn server(&self, channel: ChannelIndex) -> Option<NodeId> {
        self.channels.get(usize::from(channel.0)).map(|channel| channel.server)
    }

    /// The transfers that are under way.
    pub fn open_transfers(&self) -> impl Iterator<Item = (NodeId, &Transfer)> {
        let open = self.channels.iter().filter(|channel| channel.is_busy());
        open.filter_map(|channel| Some((channel.server, channel.transfer()?)))
    }

    /// All that the last frame brought about, in its order; with the first frame also what descriptions said before.
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
