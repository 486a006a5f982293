//! The state of the buses of a capture.
//!
//! A [`Network`] takes records one by one and returns the meaning of each in its context: the service of the CAN-ID
//! at this moment, the object of an SDO frame, the state of a node. It learns COB-IDs and mappings from the SDO
//! traffic.

mod bus;
mod cob_ids;
mod configured;
mod event;
mod guarding;
mod handling;
mod layer_setting;
mod layout;
mod layouts;
mod learning;
mod node;
mod number;
mod open_errors;
mod recognition;
mod scaling;
pub mod sdo;
mod srdo_pairs;
mod steady;

pub use bus::Bus;
pub use cob_ids::{Source, Use};
pub use event::{Emergency, Event, Exchange, Move, StateChange};
pub use layout::{Layout, Signal};
pub use node::{Cause, Node};
pub use open_errors::OpenErrors;
pub use recognition::{Candidate, Candidates, Fact, Recognition, Shown};
pub use steady::{Skipping, Steady};

use crate::dictionary::KnownDevice;
use crate::message::{Message, PdoNumber, Service};
use crate::{Multiplexer, NodeId};
use bus::Rooms;
use canvass_traces::{ChannelId, Record};
use sdo::{ChannelIndex, Violation};
use std::sync::Arc;

/// All buses of a capture, each with its nodes and transfers.
///
/// ```
/// use canvass_analyzer::network::{Event, Network, sdo::Outcome};
/// use canvass_traces::parse_frame;
///
/// let mut network = Network::new();
/// // The device type of node 5 is read: its low word is the profile.
/// network.handle(&parse_frame("605#4000100000000000")?);
/// let answer = parse_frame("585#4300100096010200")?;
/// let decoded = network.handle(&answer);
/// assert!(matches!(decoded.event, Some(Event::TransferEnded)));
/// let transfer = network.bus(answer.channel).unwrap().transfer(decoded.channel.unwrap()).unwrap();
/// assert_eq!((transfer.outcome, transfer.data()), (Outcome::Complete, &[0x96, 0x01, 0x02, 0x00][..]));
/// # Ok::<(), canvass_traces::FrameSyntax>(())
/// ```
#[derive(Default)]
pub struct Network {
    buses: Vec<Bus>,
    devices: Vec<(NodeId, Arc<KnownDevice>)>,
    candidates: Candidates,
    /// Memory limits for the devices of all buses.
    rooms: Rooms,
}

/// A frame, decoded in its context.
#[derive(Clone, Copy, Debug)]
pub struct Decoded {
    /// The service of the frame.
    pub service: Service,
    /// The node concerned: the sender of its own messages, the server of an SDO, the node that an NMT command names.
    pub node: Option<NodeId>,
    /// The content of the frame.
    pub message: Message,
    /// The source of the knowledge about the CAN-ID's use.
    pub source: Source,
    /// The object concerned.
    pub object: Option<Multiplexer>,
    /// The SDO channel of the frame.
    pub channel: Option<ChannelIndex>,
    /// The first event of the frame; [`Bus::events`] holds all.
    pub event: Option<Event>,
    /// The rule of the SDO protocol that the frame breaks.
    pub violation: Option<Violation>,
}

impl Decoded {
    /// An EMCY message of a node; `source` tells how the use of the CAN-ID is known.
    pub(crate) fn emcy(node: NodeId, source: Source, payload: &[u8]) -> Self {
        handling::emcy(node, source, payload)
    }

    /// Whether the frame is a boot-up message that only repeats the boot-up message just before.
    pub(crate) fn repeats_boot_up(&self) -> bool {
        self.service == Service::BootUp && self.event.is_none()
    }

    /// Whether the frame ends an SDO transfer.
    #[inline]
    pub const fn ends_transfer(&self) -> bool {
        matches!(self.event, Some(Event::TransferEnded))
    }

    /// Whether the concerned node itself sent the frame.
    pub const fn is_from_node(&self) -> bool {
        match self.message {
            Message::ErrorControl(_)
            | Message::Emcy(_)
            | Message::Pdo(PdoNumber::Transmit(_))
            | Message::Mpdo(PdoNumber::Transmit(_), _)
            | Message::SdoResponse(_)
            | Message::SdoBlockUpload(_) => true,
            Message::Malformed(service, _) => matches!(service, Service::Heartbeat | Service::Emcy),
            _ => false,
        }
    }
}

impl Network {
    /// An empty network.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the device of a node on all buses; its COB-IDs, mappings, names and types are then known.
    pub fn describe(&mut self, node: NodeId, device: impl Into<Arc<KnownDevice>>) {
        let device = device.into();
        for bus in &mut self.buses {
            bus.describe(node, &device);
        }
        self.devices.push((node, device));
    }

    /// Sets the models as which undescribed nodes can be recognised. If several models show the same objects, the first
    /// one is taken. Must be called before the first record; the models are loaded only when a node shows one of its
    /// identifying objects.
    pub fn offer(&mut self, candidates: Candidates) {
        self.candidates = candidates;
    }

    /// A copy of the current state, from which decoding can continue repeatedly.
    #[must_use]
    pub fn snapshot(&self) -> Self {
        let rooms = self.rooms.apart();
        let buses = self.buses.iter().map(|bus| bus.moved(&rooms)).collect();
        Self { buses, devices: self.devices.clone(), candidates: self.candidates.clone(), rooms }
    }

    /// Handles the next record; returns its meaning.
    pub fn handle(&mut self, record: &Record) -> Decoded {
        self.bus_mut(record.channel).handle(record)
    }

    /// The bus of a channel; `None` before its first record.
    pub fn bus(&self, channel: ChannelId) -> Option<&Bus> {
        self.buses.get(usize::from(channel.0))
    }

    fn bus_mut(&mut self, channel: ChannelId) -> &mut Bus {
        let index = usize::from(channel.0);
        while self.buses.len() <= index {
            let mut bus = Bus::within(self.rooms.clone());
            bus.candidates = self.candidates.clone();
            for (node, device) in &self.devices {
                bus.describe(*node, device);
            }
            self.buses.push(bus);
        }
        &mut self.buses[index]
    }
}
