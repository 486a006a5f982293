//! Events: the consequences of a frame.

use super::cob_ids::{Source, Use};
use super::node::Cause;
use super::sdo::ChannelIndex;
use crate::message::PdoNumber;
use crate::wire::emcy::Emcy;
use crate::wire::error_control::State;
use crate::{Multiplexer, NodeId};
use canvass_traces::{Duration, Timestamp};

/// An event on a bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event {
    /// An SDO transfer ended; the frame's channel holds it.
    TransferEnded,
    /// An SDO transfer was left before its end: the client began another one, or the server was reset. The channel
    /// holds it as [`Bus::left_transfer`](super::Bus::left_transfer).
    TransferLeft(ChannelIndex),
    /// A node's state changed or became known.
    StateChanged(NodeId, StateChange),
    /// A node sent an EMCY.
    Emergency(NodeId, Emergency),
    /// A message of layer setting (LSS or LMT); the frame contains it.
    LayerSetting(Exchange),
    /// A node starts with a node-ID assigned by layer setting or by a manufacturer-specific object.
    NodeIdChanged {
        /// The former node-ID, if the dialogue or the identity tells it.
        from: Option<NodeId>,
        /// The new node-ID.
        to: NodeId,
        /// The written object; `None` for layer setting.
        object: Option<Multiplexer>,
    },
    /// The master activated the bit rate that it had set, or one node starts with another bit rate.
    BitRateChanged {
        /// The node, if one of its objects set the bit rate; `None` for layer setting.
        node: Option<NodeId>,
        /// The bit rate in bit/s, if the trace or the table tells it.
        bit_rate: Option<u32>,
        /// The silence before and after the change.
        delay: Duration,
    },
    /// A use of a CAN-ID has moved.
    CobIdMoved(Move),
    /// A node was recognised as a known model; the node holds the model.
    Recognised(NodeId),
    /// The mapping of a PDO changed or became known; the node holds it.
    MappingChanged(NodeId, PdoNumber),
}

/// A change of a node's NMT state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct StateChange {
    /// The former state, if known.
    pub from: Option<State>,
    /// The new state.
    pub to: State,
    /// The source of the knowledge.
    pub cause: Cause,
}

/// An EMCY in its context.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Emergency {
    /// The message.
    pub emcy: Emcy,
    /// Time of the oldest error that is still present, or was until this message.
    pub since: Option<Timestamp>,
}

/// The role of a layer setting message in its dialogue.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Exchange {
    /// A request of the master.
    Request {
        /// Whether the previous request should have been answered, but was not.
        unanswered: bool,
    },
    /// An answer of a slave, with the time since the request.
    Response(Duration),
    /// An answer of a slave without a request.
    Unasked,
}

/// A use that has moved to another CAN-ID.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Move {
    /// The use.
    pub used: Use,
    /// The former CAN-ID, if there was one.
    pub from: Option<u16>,
    /// The new CAN-ID; `None` if the communication object does not exist any more.
    pub to: Option<u16>,
    /// The source of the knowledge.
    pub source: Source,
}
