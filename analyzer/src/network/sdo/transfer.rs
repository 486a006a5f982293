//! A whole SDO transfer.

use crate::Multiplexer;
use crate::wire::sdo::{AbortCode, crc16};
use canvass_traces::{Duration, Timestamp};
use std::fmt;

/// Reading or writing an object, as far as it has progressed.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Transfer {
    /// The object.
    pub multiplexer: Multiplexer,
    /// Upload or download.
    pub direction: Direction,
    /// Expedited, segmented, or block.
    pub mode: Mode,
    /// Time of the transfer's first frame.
    pub started: Timestamp,
    /// Time of the transfer's latest frame.
    pub latest: Timestamp,
    /// The announced number of bytes, if there is one.
    pub announced: Option<u32>,
    /// The number of segments with data; repeated ones count once.
    pub segments: u32,
    /// Number of bytes in the segments of a block that the receiver has not confirmed yet, as they stand in the frames: the
    /// last segment may be padded.
    pub unconfirmed: u32,
    /// Whether the server has answered the first request.
    pub is_answered: bool,
    /// The outcome of the transfer; open until its end.
    pub outcome: Outcome,
    /// The first violation of the protocol in the transfer.
    pub violation: Option<Violation>,
    data: Vec<u8>,
    /// Maximum number of bytes of the value that are kept.
    most: usize,
    length: u64,
    crc: u16,
}

/// The direction, seen from the client.
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

/// A side of a transfer.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Side {
    /// The client, which requests.
    Client,
    /// The server, which owns the objects.
    Server,
}

/// The outcome of a transfer.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Outcome {
    /// The transfer has not ended yet.
    Open,
    /// The transfer was completed.
    Complete,
    /// One side aborted the transfer.
    Aborted(Side, AbortCode),
    /// The client began another transfer before its end.
    Superseded,
}

/// A broken rule of the SDO protocol.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Violation {
    /// The toggle bit did not alternate.
    Toggle,
    /// The answer names another object than the request.
    Multiplexer(Multiplexer),
    /// The number of bytes differs from the announced one.
    Size {
        /// The announced number.
        announced: u32,
        /// The counted number.
        received: u64,
    },
    /// The checksum of the data differs from the transmitted one.
    Crc {
        /// The transmitted checksum.
        sent: u16,
        /// The calculated checksum.
        calculated: u16,
    },
    /// A segment of a block is missing or repeated.
    Sequence {
        /// The expected number.
        expected: u8,
        /// The number found.
        found: u8,
    },
    /// A message that is not allowed in this state.
    Unexpected,
}

impl Transfer {
    /// Maximum number of bytes of a value that are kept. Of longer values all bytes are counted, and the CRC is
    /// calculated.
    pub const KEPT: usize = 64 * 1024;
    /// Number of bytes that are kept even without room for more.
    pub const SHORT: usize = 256;

    /// A transfer at its first frame.
    pub fn new(multiplexer: Multiplexer, direction: Direction, mode: Mode, now: Timestamp) -> Self {
        Self {
            multiplexer,
            direction,
            mode,
            started: now,
            latest: now,
            announced: None,
            segments: 0,
            unconfirmed: 0,
            is_answered: false,
            outcome: Outcome::Open,
            violation: None,
            data: Vec::new(),
            most: Self::KEPT,
            length: 0,
            crc: 0,
        }
    }

    /// Begins a transfer in the memory of an earlier one.
    pub fn restart(&mut self, multiplexer: Multiplexer, direction: Direction, mode: Mode, now: Timestamp) {
        let mut data = std::mem::take(&mut self.data);
        data.clear();
        *self = Self { data, ..Self::new(multiplexer, direction, mode, now) };
    }

    /// The kept bytes of the value.
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// The number of bytes received.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// The CRC of the bytes received.
    pub fn crc(&self) -> u16 {
        self.crc
    }

    /// The time from the first to the latest frame.
    pub fn duration(&self) -> Duration {
        self.latest - self.started
    }

    /// Whether the transfer is open.
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

    /// The memory of the value.
    pub(super) fn capacity(&self) -> usize {
        self.data.capacity()
    }

    /// Reduces the value to the length of a short one.
    pub(super) fn shorten(&mut self) {
        self.most = Self::SHORT;
        self.data.truncate(Self::SHORT);
        self.data.shrink_to(Self::SHORT);
    }

    /// Notes a broken rule, if it is the first.
    pub(crate) fn blame(&mut self, violation: Violation) {
        self.violation.get_or_insert(violation);
    }

    /// Ends the transfer; a complete one must have the announced number of bytes.
    pub fn end(&mut self, outcome: Outcome) {
        debug_assert!(outcome != Outcome::Open, "a transfer ends with an outcome");
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
            Self::Size { announced, received } => write!(f, "{received} bytes transferred, but {announced} announced"),
            Self::Crc { sent, calculated } => {
                write!(f, "CRC {sent:04X}h does not match the data, expected {calculated:04X}h")
            }
            Self::Sequence { expected, found } => write!(f, "segment {found}, expected {expected}"),
            Self::Unexpected => f.write_str("unexpected in this state"),
        }
    }
}
