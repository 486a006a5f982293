//! A whole SDO transfer.

use crate::Multiplexer;
use crate::wire::sdo::{AbortCode, crc16};
use canvass_traces::{Duration, Timestamp};
use std::fmt;

/// Reading or writing an object, as far as it has come.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Transfer {
    /// The object.
    pub multiplexer: Multiplexer,
    /// Read or written.
    pub direction: Direction,
    /// In one message, in segments, or in blocks.
    pub mode: Mode,
    /// When its first frame was seen.
    pub started: Timestamp,
    /// When its last frame was seen.
    pub latest: Timestamp,
    /// The number of bytes that was announced, if any.
    pub announced: Option<u32>,
    /// The number of segments that carried data; repeated ones count once.
    pub segments: u32,
    /// How it ended, or that it has not.
    pub outcome: Outcome,
    /// The first rule that was broken in it.
    pub violation: Option<Violation>,
    data: Vec<u8>,
    /// How many bytes of it are kept at most.
    most: usize,
    length: u64,
    crc: u16,
}

/// Read or written, seen from the client.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Direction {
    /// The client reads.
    Upload,
    /// The client writes.
    Download,
}

/// The kind of transfer.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Mode {
    /// The value is in the initiate message.
    Expedited,
    /// Each segment is confirmed.
    Segmented,
    /// Blocks of up to 127 segments are confirmed.
    Block,
}

/// Client or server.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Side {
    /// The one that asks.
    Client,
    /// The one that owns the objects.
    Server,
}

/// How a transfer ended.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Outcome {
    /// It has not ended yet.
    Open,
    /// Done.
    Complete,
    /// Aborted.
    Aborted(Side, AbortCode),
    /// The client began another one before it ended.
    Superseded,
}

/// A broken rule of the SDO protocol.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Violation {
    /// The toggle bit did not alternate.
    Toggle,
    /// The answer names another object than the request.
    Multiplexer(Multiplexer),
    /// More or fewer bytes came than were announced.
    Size {
        /// As announced.
        announced: u32,
        /// As counted.
        received: u64,
    },
    /// The checksum over the data differs from the one that was sent.
    Crc {
        /// As sent.
        sent: u16,
        /// As calculated.
        calculated: u16,
    },
    /// A segment of a block is missing or repeated.
    Sequence {
        /// The number that should have come.
        expected: u8,
        /// The number that came.
        found: u8,
    },
    /// A message that does not belong into this state.
    Unexpected,
}

impl Transfer {
    /// How many bytes of a value are kept; longer ones are counted and their CRC is calculated all the same.
    pub const KEPT: usize = 64 * 1024;
    /// So many are kept even where there is no room for more.
    pub const SHORT: usize = 256;

    /// A transfer whose first frame was just seen.
    pub fn new(multiplexer: Multiplexer, direction: Direction, mode: Mode, now: Timestamp) -> Self {
        Self {
            multiplexer,
            direction,
            mode,
            started: now,
            latest: now,
            announced: None,
            segments: 0,
            outcome: Outcome::Open,
            violation: None,
            data: Vec::new(),
            most: Self::KEPT,
            length: 0,
            crc: 0,
        }
    }

    /// Begins anew with the memory of an earlier transfer.
    pub fn restart(&mut self, multiplexer: Multiplexer, direction: Direction, mode: Mode, now: Timestamp) {
        let mut data = std::mem::take(&mut self.data);
        data.clear();
        *self = Self { data, ..Self::new(multiplexer, direction, mode, now) };
    }

    /// The value as far as it came and is kept.
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// The number of bytes that came.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// The CRC over the bytes that came.
    pub fn crc(&self) -> u16 {
        self.crc
    }

    /// The time from the first to the latest frame.
    pub fn duration(&self) -> Duration {
        self.latest - self.started
    }

    /// Whether it is under way.
    pub fn is_open(&self) -> bool {
        self.outcome == Outcome::Open
    }

    /// Adds bytes to the value.
    pub fn extend(&mut self, bytes: &[u8]) {
        self.length += bytes.len() as u64;
        self.crc = crc16(self.crc, bytes);
        let room = self.most.saturating_sub(self.data.len()).min(bytes.len());
        self.data.extend_from_slice(&bytes[..room]);
    }

    /// What the value takes in memory.
    pub(super) fn capacity(&self) -> usize {
        self.data.capacity()
    }

    /// Keeps no more of the value than a short one has.
    pub(super) fn shorten(&mut self) {
        self.most = Self::SHORT;
        self.data.truncate(Self::SHORT);
        self.data.shrink_to(Self::SHORT);
    }

    /// Notes a broken rule, if it is the first.
    pub fn blame(&mut self, violation: Violation) {
        self.violation.get_or_insert(violation);
    }

    /// Ends the transfer; a complete one must have as many bytes as announced.
    pub fn end(&mut self, outcome: Outcome) {
        self.outcome = outcome;
        if outcome == Outcome::Complete
            && let Some(announced) = self.announced
            && u64::from(announced) != self.length
        {
            self.blame(Violation::Size { announced, received: self.length });
        }
    }
}

impl Direction {
    /// The name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Upload => "upload",
            Self::Download => "download",
        }
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Mode {
    /// The name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Expedited => "expedited",
            Self::Segmented => "segmented",
            Self::Block => "block",
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Side {
    /// The name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Client => "client",
            Self::Server => "server",
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Violation {
    /// The name in JSON.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Toggle => "toggle",
            Self::Multiplexer(_) => "multiplexer",
            Self::Size { .. } => "size",
            Self::Crc { .. } => "crc",
            Self::Sequence { .. } => "sequence",
            Self::Unexpected => "unexpected",
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Toggle => f.write_str("toggle bit not alternated"),
            Self::Multiplexer(multiplexer) => write!(f, "answer names {multiplexer}"),
            Self::Size { announced, received } => write!(f, "{received} bytes came, {announced} were announced"),
            Self::Crc { sent, calculated } => write!(f, "CRC {sent:04X}h does not fit, calculated {calculated:04X}h"),
            Self::Sequence { expected, found } => write!(f, "segment {found} came, {expected} was due"),
            Self::Unexpected => f.write_str("unexpected in this state"),
        }
    }
}
