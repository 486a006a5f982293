//! The statuswords and controlwords of drives in a frame, and a table by node and axis.

use crate::findings::{Context, Effect, SETTLE, SOON, Scene};
use crate::message::{Message, PdoNumber};
use crate::profiles::cia402::{AXES, NUMBER, objects};
use crate::{NodeId, PerNode};
use canvass_traces::Timestamp;

/// The findings from which findings about drives follow: an EMCY reports a condition to which the drive reacts.
pub const FOLLOWS: &[(&str, Effect)] = &[(
    "emcy/raised",
    Effect::on(&["drive/fault", "drive/left-operation", "drive/not-enabled"]).of_same_node().during(SOON, SETTLE),
)];

/// A value that concerns the state of an axis.
#[derive(Clone, Copy)]
pub struct Sign {
    pub node: NodeId,
    /// The axis, from 0.
    pub axis: usize,
    pub word: Word,
}

/// The meaning of the value.
#[derive(Clone, Copy)]
pub enum Word {
    /// A statusword that the drive has sent.
    Status(u16),
    /// A controlword that a client or an RPDO has written.
    Control(u16),
    /// An error code (603Fh) that the drive has sent.
    Error(u16),
}

/// The statuswords, controlwords and error codes in a frame.
pub fn signs<'a>(context: &Context<'a>) -> impl Iterator<Item = Sign> + use<'a> {
    let news = context.news();
    let operands = if news.profile == Some(NUMBER) { news.operands.as_slice() } else { &[] };
    operands.iter().filter_map(|operand| {
        const SIZE: u16 = 0x800;
        let offset = operand.object.index.0.checked_sub(0x6000)?;
        let value = operand.raw as u16;
        let word = match (0x6000 + offset % SIZE, operand.written) {
            (objects::STATUSWORD, false) => Word::Status(value),
            (objects::CONTROLWORD, true) => Word::Control(value),
            (objects::ERROR_CODE, false) => Word::Error(value),
            _ => return None,
        };
        Some(Sign { node: operand.node, axis: usize::from(offset / SIZE), word })
    })
}

/// Whether an RPDO whose mapping is unknown has come since a time: it may carry a controlword.
pub fn has_unknown_rpdo(node: NodeId, since: Timestamp, scene: &Scene<'_>) -> bool {
    const FIRST: u16 = 0x200;
    (0..4).any(|n| {
        let seen = scene.latest.get(FIRST + 0x100 * n + u16::from(node.raw()));
        seen.filter(|seen| seen.time() > since && seen.decoded.node == Some(node)).is_some_and(|seen| {
            let known = scene.bus.node(node);
            match seen.decoded.message {
                Message::Pdo(number @ PdoNumber::Receive(_)) => {
                    known.is_none_or(|known| known.known_layout(number).is_none())
                }
                _ => false,
            }
        })
    })
}

/// One `T` for each axis of each node that has shown one.
pub struct Axes<T>(PerNode<Option<Box<[T; AXES]>>>);

impl<T> Default for Axes<T> {
    fn default() -> Self {
        Self(PerNode::default())
    }
}

impl<T: Default> Axes<T> {
    /// The entry of an axis.
    pub fn get(&mut self, node: NodeId, axis: usize) -> Option<&mut T> {
        self.0[node].get_or_insert_with(|| Box::new(std::array::from_fn(|_| T::default()))).get_mut(axis)
    }

    /// The entry of an axis that has shown itself.
    pub fn peek(&self, node: NodeId, axis: usize) -> Option<&T> {
        self.0[node].as_deref()?.get(axis)
    }

    /// All entries of a node, with the axes from 0.
    pub fn of(&mut self, node: NodeId) -> impl Iterator<Item = (usize, &mut T)> {
        self.0[node].iter_mut().flat_map(|axes| axes.iter_mut().enumerate())
    }

    /// All entries.
    pub fn all(&mut self) -> impl Iterator<Item = (NodeId, usize, &mut T)> {
        let nodes = self.0.iter_mut().filter_map(|(node, axes)| axes.as_deref_mut().map(|axes| (node, axes)));
        nodes.flat_map(|(node, axes)| axes.iter_mut().enumerate().map(move |(axis, entry)| (node, axis, entry)))
    }
}

/// The begin of a message about an axis; empty for the first one, as most drives have only this.
pub fn prefix(axis: usize) -> String {
    if axis == 0 { String::new() } else { format!("axis {}: ", axis + 1) }
}
