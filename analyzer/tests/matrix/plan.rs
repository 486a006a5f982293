//! A plan of what a network sends: frames with their times, senders and causes.

use super::sort::Sort;
use canvass_traces::Frame;

/// A millisecond in nanoseconds.
pub const MS: u64 = 1_000_000;
/// A second in nanoseconds.
pub const SECOND: u64 = 1_000_000_000;

/// A frame of the plan.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The time since the beginning of the capture, in nanoseconds.
    pub at: u64,
    /// The frame.
    pub frame: Frame,
    /// The sort of its message.
    pub sort: Sort,
    /// The node that the message is about; 0 for the bus or all nodes.
    pub node: u8,
    /// The node that sends it; `None` for a master or client without node-ID.
    pub sender: Option<u8>,
    /// The frame that makes the sender send this one.
    pub cause: Option<usize>,
    /// The usual interval to the next one; 0 where there is none.
    pub period: u64,
    /// What a client sends, and after how long, if this frame does not come.
    pub on_silence: Option<(u64, Frame)>,
}

impl Planned {
    /// A message without cause.
    pub const fn new(at: u64, frame: Frame, sort: Sort, node: u8) -> Self {
        Self { at, frame, sort, node, sender: None, cause: None, period: 0, on_silence: None }
    }

    /// The message, sent by its own node.
    pub const fn by_node(self) -> Self {
        Self { sender: Some(self.node), ..self }
    }

    /// The message, sent at regular intervals.
    pub const fn every(self, period: u64) -> Self {
        Self { period, ..self }
    }

    /// The message, sent because of another one.
    pub const fn because_of(self, cause: usize) -> Self {
        Self { cause: Some(cause), ..self }
    }
}

/// What a network sends. A cause stands before its effects.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The frames, in no order of time.
    pub frames: Vec<Planned>,
    /// Nodes that are operational when the capture begins.
    pub running: Vec<u8>,
    /// Nodes that are pre-operational when the capture begins.
    pub waiting: Vec<u8>,
    /// Masters with a node-ID, which obey no commands.
    pub masters: Vec<u8>,
    /// Nodes that go to operational by themselves after their boot-up.
    pub self_starting: Vec<u8>,
}

impl Plan {
    /// Adds a frame and returns its place.
    pub fn add(&mut self, planned: Planned) -> usize {
        self.frames.push(planned);
        self.frames.len() - 1
    }
}
