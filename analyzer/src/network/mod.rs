//! What happened on the buses of a capture.
//!
//! A [`Network`] takes records one by one and says of each what it means in its context: which service the CAN-ID
//! belongs to at this moment, which object an SDO frame is about, what state a node is in. It learns COB-IDs and
//! mappings from the SDO traffic it sees.

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
    /// For what the devices of all buses show of themselves.
    rooms: Rooms,
}

/// A frame, understood in its context.
#[derive(Clone, Copy, Debug)]
pub struct Decoded {
    /// The service that it belongs to.
    pub service: Service,
    /// The node that it is about: sender of its own messages, server of SDOs, the node that an NMT command names.
    pub node: Option<NodeId>,
    /// What it says.
    pub message: Message,
    /// How the use of its CAN-ID is known.
    pub source: Source,
    /// The object that it is about.
    pub object: Option<Multiplexer>,
    /// The SDO channel that it went over.
    pub channel: Option<ChannelIndex>,
    /// What it brought about, first of all; [`Bus::events`] holds everything.
    pub event: Option<Event>,
    /// The rule of the SDO protocol that it broke.
    pub violation: Option<Violation>,
}

impl Decoded {
    /// An EMCY message of a node, whose use of the CAN-ID is known from `source`.
    pub(crate) fn emcy(node: NodeId, source: Source, payload: &[u8]) -> Self {
        handling::emcy(node, source, payload)
    }

    /// Whether it is a boot-up message that says only what another one has just said.
    pub fn repeats_boot_up(&self) -> bool {
        self.service == Service::BootUp && self.event.is_none()
    }

    /// Whether it ends an SDO transfer.
    #[inline]
    pub const fn ends_transfer(&self) -> bool {
        matches!(self.event, Some(Event::TransferEnded))
    }

    /// Whether the node that the frame is about has sent it itself.
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
    /// A network of which nothing is known.
    pub fn new() -> Self {
        Self::default()
    }

    /// Says which device a node is, on all buses. Its COB-IDs, mappings, names and types are then known.
    pub fn describe(&mut self, node: NodeId, device: KnownDevice) {
        let device = Arc::new(device);
        for bus in &mut self.buses {
            bus.describe(node, &device);
        }
        self.devices.push((node, device));
    }

    /// Says which models nodes that nobody described can be recognised as. Of models that show the same, the first one is
    /// taken. To be said before the first record; they are not asked for before a node shows something of itself.
    pub fn offer(&mut self, candidates: Candidates) {
        self.candidates = candidates;
    }

    /// The network as it is now: to go on from here again later, as often as one likes.
    #[must_use]
    pub fn snapshot(&self) -> Self {
        let rooms = self.rooms.apart();
        let buses = self.buses.iter().map(|bus| bus.moved(&rooms)).collect();
        Self { buses, devices: self.devices.clone(), candidates: self.candidates.clone(), rooms }
    }

    /// Takes the next record and says what it means.
    pub fn handle(&mut self, record: &Record) -> Decoded {
        self.bus_mut(record.channel).handle(record)
    }

    /// The bus of a channel, once a record of it was seen.
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
