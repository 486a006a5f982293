//! The answer that a server owes to a request.

use super::super::codes::{self, CodeSet};
use super::block;
use canvass_analyzer::Multiplexer;

/// The allowed answers to a request.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Awaited {
    /// No answer: every frame is wrong.
    Nothing,
    /// Any legal answer, or none.
    Anything,
    /// An abort with one of these codes, and with the object that the request named, if it named one.
    Abort { codes: CodeSet, at: Option<Multiplexer>, why: &'static str },
    /// The toggle bit did not alternate: the server ignores the segment or aborts the transfer (CiA 301, 7.2.4.3.2 and
    /// 7.2.4.3.5).
    AbortOrIgnored,
    /// The value of an object.
    Read(Reading),
    /// The value of an object in blocks, or by a normal upload up to the threshold.
    BlockRead { reading: Reading, block_size: u8, threshold: u8, crc: bool },
    /// The confirmation of an expedited download.
    Write { at: Multiplexer, writing: Writing },
    /// The confirmation that a segmented download may begin.
    BeginDownload { at: Multiplexer, writing: Writing, announced: Option<u32> },
    /// The confirmation that a block download may begin.
    BeginBlockDownload { at: Multiplexer, writing: Writing, announced: Option<u32>, crc: bool },
    /// The confirmation of a download segment; that of the last segment ends the transfer.
    ConfirmSegment { toggle: bool, last: Option<(Multiplexer, Writing)> },
    /// An upload segment.
    Segment { toggle: bool },
    /// The confirmation of a block whose last good sequence number is `sequence`. If a segment was missing, the
    /// confirmation may come before the end of the block.
    ConfirmBlock { sequence: u8, required: bool, last: bool },
    /// The confirmation of the end of a block download.
    ConfirmEnd { at: Multiplexer, writing: Writing },
    /// The segments of a block.
    Block,
    /// The end of a block upload. `odd_size`: the confirmation of the last block named a next block size that does not
    /// exist, which the server may refuse.
    EndOfBlocks { upload: block::Upload, odd_size: bool },
}

/// The allowed answers to a request to read.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Reading {
    pub at: Multiplexer,
    /// The position of the object in the dictionary.
    pub entry: Option<usize>,
    /// The server has to abort, with one of these codes.
    pub must: CodeSet,
    /// The server may abort, with one of these codes.
    pub may: CodeSet,
}

/// The allowed answers to a write.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Writing {
    pub entry: Option<usize>,
    /// The value, if it fits into eight bytes.
    pub raw: Option<u64>,
    /// The server has to abort, with one of these codes.
    pub must: CodeSet,
    /// The server may abort, with one of these codes.
    pub may: CodeSet,
    /// The reason for the required abort.
    pub why: &'static str,
    /// Whether a rule of the PDO configuration requires the abort.
    pub pdo_rule: bool,
}

impl Awaited {
    /// Whether the server has to answer.
    pub(crate) const fn is_required(&self) -> bool {
        match self {
            Self::Nothing | Self::Anything | Self::AbortOrIgnored => false,
            Self::ConfirmBlock { required, .. } => *required,
            _ => true,
        }
    }

    /// Whether the server may answer but need not.
    pub fn is_open(&self) -> bool {
        matches!(self, Self::Anything | Self::AbortOrIgnored)
    }

    /// The rule that a wrong or missing answer violates.
    pub const fn rule(&self) -> &'static str {
        match self {
            Self::Nothing => "unsolicited response",
            Self::Anything => "response to an odd request",
            Self::Abort { why, .. } => why,
            Self::AbortOrIgnored => "a toggle bit that does not alternate",
            Self::Read(_) => "initiate upload",
            Self::BlockRead { .. } => "initiate block upload",
            Self::Write { .. } => "expedited download",
            Self::BeginDownload { .. } => "initiate download",
            Self::BeginBlockDownload { .. } => "initiate block download",
            Self::ConfirmSegment { .. } => "download segment",
            Self::Segment { .. } => "upload segment",
            Self::ConfirmBlock { .. } => "download of a block",
            Self::ConfirmEnd { .. } => "end of a block download",
            Self::Block => "upload of a block",
            Self::EndOfBlocks { .. } => "end of a block upload",
        }
    }

    /// The required answer in words.
    pub fn text(&self) -> String {
        match self {
            Self::Nothing => "no SDO response without a request".to_owned(),
            Self::Anything => "a legal response, or none".to_owned(),
            Self::Abort { codes, at: Some(at), why } => format!("{why}: abort of {at} with {}", codes.text()),
            Self::Abort { codes, at: None, why } => format!("{why}: abort with {}", codes.text()),
            Self::AbortOrIgnored => format!("{}: no answer, or abort with {}", self.rule(), codes::TOGGLE.text()),
            Self::Read(reading) => reading.text("the value of"),
            Self::BlockRead { reading, .. } => reading.text("block upload of"),
            Self::Write { at, writing } => writing.text(&format!("confirmation of the download to {at}")),
            Self::BeginDownload { at, writing, .. } => {
                writing.text(&format!("confirmation of the begin of a segmented download to {at}"))
            }
            Self::BeginBlockDownload { at, writing, .. } => {
                writing.text(&format!("confirmation of the begin of a block download to {at}"))
            }
            Self::ConfirmSegment { toggle, last: None } => {
                format!("confirmation of the segment with toggle bit {}", u8::from(*toggle))
            }
            Self::ConfirmSegment { toggle, last: Some((_, writing)) } => {
                writing.text(&format!("confirmation of the last segment with toggle bit {}", u8::from(*toggle)))
            }
            Self::Segment { toggle } => format!("the next segment with toggle bit {}", u8::from(*toggle)),
            Self::ConfirmBlock { sequence, .. } => {
                format!("confirmation of the block up to sequence number {sequence}")
            }
            Self::ConfirmEnd { at, writing } => writing.text(&format!("confirmation of the block download to {at}")),
            Self::Block => "the segments of the block, numbered from 1".to_owned(),
            Self::EndOfBlocks { .. } => "the end of the block upload with its checksum".to_owned(),
        }
    }
}

impl Reading {
    fn text(&self, what: &str) -> String {
        if self.must.is_empty() {
            format!("{what} {}", self.at)
        } else {
            format!("{} can't be read: abort with {}", self.at, self.must.text())
        }
    }
}

impl Writing {
    fn text(&self, what: &str) -> String {
        if self.must.is_empty() { what.to_owned() } else { format!("{}: abort with {}", self.why, self.must.text()) }
    }
}
