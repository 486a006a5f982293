//! What a frame brought about, beyond itself.

use super::cob_ids::{Source, Use};
use super::node::Cause;
use super::sdo::ChannelIndex;
use crate::message::PdoNumber;
use crate::wire::emcy::Emcy;
use crate::wire::error_control::State;
use crate::{Multiplexer, NodeId};
use canvass_traces::{Duration, Timestamp};

/// Something that happened on a bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event {
    /// An SDO transfer ended; the channel of the frame holds it.
    TransferEnded,
    /// An SDO transfer was left before its end: the client began another one, or the server was reset. The channel
    /// holds it as [`Bus::left_transfer`](super::Bus::left_transfer).
    TransferLeft(ChannelIndex),
    /// A node's state changed, or is known now.
    StateChanged(NodeId, StateChange),
    /// A node sent an EMCY.
    Emergency(NodeId, Emergency),
    /// A message of layer setting (LSS or LMT); the frame has its meaning.
    LayerSetting(Exchange),
    /// A node starts with the node-ID that layer setting, or an object of the manufacturer, gave it.
    NodeIdChanged {
        /// The node-ID before, where the dialogue or the identity tells.
        from: Option<NodeId>,
        /// The node-ID now.
        to: NodeId,
        /// The object that set it; `None` where layer setting did.
        object: Option<Multiplexer>,
    },
    /// The master told the nodes to change to the bit rate that it had set, or one node starts with another bit rate.
    BitRateChanged {
        /// The node, where it was set by an object of its own; `None` where layer setting did.
        node: Option<NodeId>,
        /// In bit/s, where the trace or the table tells.
        bit_rate: Option<u32>,
        /// The silence before and after the change.
        delay: Duration,
    },
    /// A use of a CAN-ID has moved.
    CobIdMoved(Move),
    /// A node was recognised as a known model by what it showed of itself; the node holds which.
    Recognised(NodeId),
    /// The mapping of a PDO changed, or is known now; the node holds it.
    MappingChanged(NodeId, PdoNumber),
}

/// A change of a node's NMT state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct StateChange {
    /// The state before, where it was known.
    pub from: Option<State>,
    /// The state now.
    pub to: State,
    /// How it is known.
    pub cause: Cause,
}

/// An EMCY in its context.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Emergency {
    /// The message.
    pub emcy: Emcy,
    /// When the oldest error was reported that is not yet gone, or was not until this message.
    pub since: Option<Timestamp>,
}

/// The part of a layer setting message in its dialogue.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Exchange {
    /// The master asks.
    Request {
        /// Its request before should have been answered and was not.
        unanswered: bool,
    },
    /// A slave answers, so long after the request.
    Response(Duration),
    /// A slave answers, and no request was seen.
    Unasked,
}

/// A use of a CAN-ID that was elsewhere before.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Move {
    /// What the CAN-ID is used for.
    pub used: Use,
    /// The CAN-ID before, if there was one.
    pub from: Option<u16>,
    /// The CAN-ID now; `None` where the communication object does not exist any more.
    pub to: Option<u16>,
    /// How that is known.
    pub source: Source,
}
