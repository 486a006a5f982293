//! One bus: which CAN-ID means what, its nodes, its transfers.

use super::cob_ids::{CobIds, Source, Use};
use super::event::{Change, Event};
use super::node::{Cause, Node};
use super::sdo::{Channel, ChannelIndex, Step, Transfer};
use super::{Decoded, learning};
use crate::NodeId;
use crate::dictionary::DeviceDescription;
use crate::message::{Message, PdoNumber, Service};
use crate::wire::error_control::{ErrorControl, State};
use crate::wire::nmt::{Command, Nmt};
use crate::wire::sync::Sync;
use crate::wire::time::TimeOfDay;
use crate::wire::{Malformed, Wire, emcy::Emcy, lss};
use canvass_traces::{Frame, FrameKind, Record, Timestamp};
use std::sync::Arc;

/// What is known of one bus.
pub struct Bus {
    pub(super) cob_ids: CobIds,
    pub(super) channels: Vec<Channel>,
    /// The SDO servers beyond the first of a node: node, number from 1, channel.
    pub(super) further_channels: Vec<(NodeId, u16, ChannelIndex)>,
    nodes: Box<[Option<Box<Node>>]>,
}

impl Bus {
    /// A bus of which nothing is known but the predefined connection set.
    pub fn new() -> Self {
        Self {
            cob_ids: CobIds::default(),
            channels: NodeId::all().map(Channel::new).collect(),
            further_channels: Vec::new(),
            nodes: (0..=127).map(|_| None).collect(),
        }
    }

    /// What is known of a node, if it was seen or described.
    pub fn node(&self, id: NodeId) -> Option<&Node> {
        self.nodes.get(usize::from(id.raw())).and_then(|node| node.as_deref())
    }

    /// The transfer under way on an SDO channel, or the last one.
    pub fn transfer(&self, channel: ChannelIndex) -> Option<&Transfer> {
        self.channels.get(usize::from(channel.0)).and_then(Channel::transfer)
    }

    pub(super) fn node_mut(&mut self, id: NodeId) -> &mut Node {
        // 128 places for the node-IDs 1 to 127: the index is always there.
        self.nodes[usize::from(id.raw())].get_or_insert_default()
    }

    /// Says which device a node is.
    pub fn describe(&mut self, id: NodeId, description: &Arc<DeviceDescription>) {
        self.node_mut(id).describe(Arc::clone(description));
        learning::from_description(self, id, description);
    }

    /// Takes the next record and says what it means.
    pub fn handle(&mut self, record: &Record) -> Decoded {
        let frame = &record.frame;
        match (frame.cob_id(), frame.kind()) {
            (Some(can_id), _) => self.data(record.timestamp, can_id, frame),
            (None, FrameKind::Error) => {
                let class = frame.error_class().unwrap_or(canvass_traces::ErrorClass(0));
                plain(Service::ErrorFrame, None, Message::ErrorFrame(class))
            }
            (None, FrameKind::Remote) => self.remote(frame),
            (None, FrameKind::Data) => plain(Service::Unknown, None, Message::Foreign),
        }
    }

    fn data(&mut self, now: Timestamp, can_id: u16, frame: &Frame) -> Decoded {
        let (used, source) = self.cob_ids.get(can_id);
        let payload = frame.data();
        let decoded = match used {
            Use::Nmt => self.nmt(payload),
            Use::Sync => read::<Sync>(Service::Sync, None, payload, Message::Sync),
            Use::Time => read::<TimeOfDay>(Service::Time, None, payload, Message::Time),
            Use::Emcy(node) => read::<Emcy>(Service::Emcy, Some(node), payload, Message::Emcy),
            Use::Pdo(node, number) => self.pdo(node, number),
            Use::SdoRequest(channel) => self.sdo(channel, |channel| channel.request(now, payload)),
            Use::SdoResponse(channel) => self.sdo(channel, |channel| channel.response(now, payload)),
            Use::ErrorControl(node) => self.error_control(node, payload),
            Use::LssRequest => read::<lss::Request>(Service::Lss, None, payload, Message::LssRequest),
            Use::LssResponse => read::<lss::Response>(Service::Lss, None, payload, Message::LssResponse),
            Use::Unknown => plain(Service::Unknown, None, Message::Unknown),
        };
        Decoded { source, ..decoded }
    }

    fn remote(&mut self, frame: &Frame) -> Decoded {
        let used = frame.id().as_standard().filter(|_| !frame.is_fd()).map(|id| self.cob_ids.get(id));
        match used {
            Some((Use::ErrorControl(node), source)) => {
                self.node_mut(node).guarded = true;
                Decoded { source, ..plain(Service::Guarding, Some(node), Message::GuardingRequest) }
            }
            Some((Use::Pdo(node, number @ PdoNumber::Transmit(_)), source)) => {
                Decoded { source, ..plain(Service::Pdo, Some(node), Message::PdoRequest(number)) }
            }
            _ => plain(Service::Unknown, None, Message::UnexpectedRemote),
        }
    }

    fn nmt(&mut self, payload: &[u8]) -> Decoded {
        let command = match Nmt::read(payload) {
            Ok(command) => command,
            Err(error) => return malformed(Service::Nmt, None, error),
        };
        let event = match NodeId::new(command.node) {
            Some(node) => self.commanded(node, command.command),
            None if command.node == 0 => {
                for node in NodeId::all() {
                    if self.node(node).is_some() {
                        self.commanded(node, command.command);
                    }
                }
                None
            }
            None => None,
        };
        Decoded { event, ..plain(Service::Nmt, NodeId::new(command.node), Message::Nmt(command)) }
    }

    /// Takes an NMT command as obeyed: error control shows soon enough if it was not.
    fn commanded(&mut self, id: NodeId, command: Command) -> Option<Event> {
        let node = self.node_mut(id);
        let from = node.state.map(|state| state.0);
        let to = node.obey(command)?;
        Some(Event::StateChanged(id, Change { from, to, cause: Cause::Command }))
    }

    fn error_control(&mut self, id: NodeId, payload: &[u8]) -> Decoded {
        let message = match ErrorControl::read(payload) {
            Ok(message) => message,
            Err(error) => return malformed(Service::Heartbeat, Some(id), error),
        };
        let node = self.node_mut(id);
        let from = node.state;
        let (service, to, cause) = match (message.is_boot_up(), node.guarded || message.toggle) {
            (true, _) => (Service::BootUp, State::PRE_OPERATIONAL, Cause::BootUp),
            (false, true) => (Service::Guarding, message.state, Cause::ErrorControl),
            (false, false) => (Service::Heartbeat, message.state, Cause::ErrorControl),
        };
        node.state = Some((to, cause));
        if service == Service::BootUp {
            learning::after_boot_up(self, id);
        }
        let changed = service == Service::BootUp || from.is_none_or(|from| from.0 != to);
        let change = Change { from: from.map(|from| from.0), to, cause };
        let event = changed.then_some(Event::StateChanged(id, change));
        Decoded { event, ..plain(service, Some(id), Message::ErrorControl(message)) }
    }

    fn pdo(&mut self, id: NodeId, number: PdoNumber) -> Decoded {
        // Works out the layout if it is new: who shows the PDO finds it in the node.
        let node = self.node_mut(id);
        node.layout(id, number);
        plain(Service::Pdo, Some(id), Message::Pdo(number))
    }

    fn sdo(&mut self, index: ChannelIndex, step: impl FnOnce(&mut Channel) -> Step) -> Decoded {
        let Some(channel) = self.channels.get_mut(usize::from(index.0)) else {
            return plain(Service::Unknown, None, Message::Unknown);
        };
        let step = step(channel);
        let server = channel.server;
        let object = channel.transfer().map(|transfer| transfer.multiplexer);
        if step.ended {
            learning::from_transfer(self, index);
        }
        Decoded {
            object: own_object(&step.message).or(object),
            channel: Some(index),
            event: step.ended.then_some(Event::TransferEnded),
            violation: step.violation,
            ..plain(Service::Sdo, Some(server), step.message)
        }
    }
}

impl Default for Bus {
    fn default() -> Self {
        Self::new()
    }
}

/// The object that an SDO message names itself.
fn own_object(message: &Message) -> Option<crate::Multiplexer> {
    match message {
        Message::SdoRequest(request) => request.multiplexer(),
        Message::SdoResponse(response) => response.multiplexer(),
        _ => None,
    }
}

fn plain(service: Service, node: Option<NodeId>, message: Message) -> Decoded {
    Decoded {
        service,
        node,
        message,
        source: Source::Predefined,
        object: None,
        channel: None,
        event: None,
        violation: None,
    }
}

fn malformed(service: Service, node: Option<NodeId>, error: Malformed) -> Decoded {
    plain(service, node, Message::Malformed(service, error))
}

fn read<M: Wire>(
    service: Service,
    node: Option<NodeId>,
    payload: &[u8],
    message: impl FnOnce(M) -> Message,
) -> Decoded {
    match M::read(payload) {
        Ok(read) => plain(service, node, message(read)),
        Err(error) => malformed(service, node, error),
    }
}
