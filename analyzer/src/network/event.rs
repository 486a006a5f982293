//! What a frame brought about, beyond itself.

use super::node::Cause;
use crate::NodeId;
use crate::wire::error_control::State;

/// Something that happened on a bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event {
    /// An SDO transfer ended; the channel holds it.
    TransferEnded,
    /// A node's state changed, or is known now.
    StateChanged(NodeId, Change),
}

/// A change of a node's NMT state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Change {
    /// The state before, where it was known.
    pub from: Option<State>,
    /// The state now.
    pub to: State,
    /// How it is known.
    pub cause: Cause,
}
