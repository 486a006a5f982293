//! Block transfers after their initiation.

use super::super::codes::{self, CodeSet};
use super::super::expected_values::ExpectedValues;
use super::awaited::Awaited;
use super::initiate::writing;
use super::{LONGEST, Server, TransferState};
use crate::Knowledge;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{BlockSegment, crc16};

/// A block upload in progress.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Upload {
    pub at: Multiplexer,
    pub entry: Option<usize>,
    pub announced: Option<u32>,
    pub crc: bool,
    /// Number of segments in this block.
    pub size: u8,
    /// The last sequence number that was sent in this block.
    pub sequence: u8,
    /// Whether the last segment of the transfer was sent.
    pub complete: bool,
    /// Number of bytes in earlier blocks.
    pub settled: u32,
}

impl Upload {
    /// Whether the block is complete, so that its confirmation is awaited.
    pub const fn is_sent(&self) -> bool {
        self.complete || self.sequence >= self.size
    }
}

impl Server {
    /// Checks a segment of a block download.
    pub(super) fn block_segment(&mut self, segment: BlockSegment, knowledge: &Knowledge) -> Awaited {
        let TransferState::BlockDownload { at, entry, announced, size, sequence, crc, gap } = self.state else {
            return Awaited::Anything;
        };
        if segment.sequence == 0 || segment.sequence > size {
            // The sequence number does not exist in this block: the server may refuse the segment or wait.
            self.state = TransferState::Unsure;
            return Awaited::Anything;
        }
        let good = segment.sequence == sequence + 1;
        let sequence = if good { segment.sequence } else { sequence };
        if good && self.data.len() < LONGEST {
            self.data.extend_from_slice(&segment.data);
        }
        let fixed = knowledge.entry(at).and_then(|known| known.size).map(|size| size as u32);
        let limit = announced.into_iter().chain(fixed).min();
        if limit.is_some_and(|limit| self.data.len() as u32 >= limit.saturating_add(7)) {
            // More bytes than announced: the server may refuse them now or at the end of the transfer.
            self.state = TransferState::Unsure;
            return Awaited::Anything;
        }
        if good && segment.last {
            self.state = TransferState::BlockDownloadEnd { at, entry, announced, crc };
            return Awaited::ConfirmBlock { sequence, required: true, last: true };
        }
        let is_end = segment.last || segment.sequence == size;
        let gap = gap || !good;
        self.state = TransferState::BlockDownload { at, entry, announced, size, sequence, crc, gap };
        match (gap, is_end) {
            (false, false) => Awaited::Nothing,
            (_, true) => Awaited::ConfirmBlock { sequence, required: true, last: false },
            // The server may report a gap at once, after the number of segments in the block, or at the block's end.
            (true, false) => Awaited::ConfirmBlock { sequence, required: false, last: false },
        }
    }

    pub(super) fn end_block_download(
        &mut self,
        unused: u8,
        crc: u16,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
    ) -> Awaited {
        let TransferState::BlockDownloadEnd { at, entry, announced, crc: checked } = self.state else {
            return self.refuse(codes::COMMAND, "the end of a block download without its transfer", expected_values);
        };
        self.state = TransferState::Idle;
        let len = self.data.len().saturating_sub(usize::from(unused));
        self.data.truncate(len);
        let mut writing = writing(at, &self.data, knowledge, expected_values);
        let lengths = codes::TOO_LONG.or(codes::TOO_SHORT);
        let is_announced = announced.is_none_or(|announced| announced as usize == len);
        let is_right_length = is_announced && knowledge.entry(at).is_none_or(|known| known.size.is_some());
        if checked && crc16(0, &self.data) != crc {
            // The server may report another error of the value instead.
            let others = if is_right_length { writing.must } else { writing.must.or(lengths) };
            (writing.must, writing.why) = (codes::CRC.or(others), "the checksum is wrong");
        } else if !is_announced {
            let others = writing.must.or(codes::REFUSED);
            (writing.must, writing.why) = (lengths.or(others), "the length is not the announced one");
        }
        if !writing.must.is_empty() {
            expected_values.aborted = entry;
        }
        Awaited::ConfirmEnd { at, writing }
    }

    pub(super) fn start_block_upload(&mut self) -> Awaited {
        let TransferState::BlockUploadReady { at, entry, announced, size, crc } = self.state else {
            return self.wrong_block_command();
        };
        self.data.clear();
        let upload = Upload { at, entry, announced, crc, size, sequence: 0, complete: false, settled: 0 };
        self.state = TransferState::BlockUpload(upload);
        Awaited::Block
    }

    pub(super) fn confirm_block_upload(&mut self, sequence: u8, block_size: u8) -> Awaited {
        let TransferState::BlockUpload(mut upload) = self.state else {
            return self.wrong_block_command();
        };
        if !upload.is_sent() {
            self.state = TransferState::Unsure;
            return Awaited::Anything;
        }
        if sequence > upload.sequence {
            self.state = TransferState::Idle;
            let codes = codes::SEQUENCE.or(size_codes(block_size));
            return Awaited::Abort { codes, at: None, why: "a segment is confirmed that was never sent" };
        }
        if upload.complete && sequence == upload.sequence {
            // After the last block the next block size has no meaning.
            self.state = TransferState::BlockUploadEnd;
            return Awaited::EndOfBlocks { upload, odd_size: !(1..=127).contains(&block_size) };
        }
        if !(1..=127).contains(&block_size) {
            self.state = TransferState::Idle;
            let codes = codes::BLOCK_SIZE.or(codes::COMMAND);
            return Awaited::Abort { codes, at: None, why: "a block size outside 1 to 127" };
        }
        upload.settled += u32::from(sequence) * 7;
        self.data.truncate(upload.settled as usize);
        upload = Upload { size: block_size, sequence: 0, complete: false, ..upload };
        self.state = TransferState::BlockUpload(upload);
        Awaited::Block
    }

    pub(super) fn end_block_upload(&mut self) -> Awaited {
        if self.state == TransferState::BlockUploadEnd {
            self.state = TransferState::Idle;
            return Awaited::Nothing;
        }
        self.wrong_block_command()
    }

    fn wrong_block_command(&mut self) -> Awaited {
        self.state = TransferState::Idle;
        let codes = codes::COMMAND.or(codes::SEQUENCE);
        Awaited::Abort { codes, at: None, why: "a command of a block upload without its transfer" }
    }
}

fn size_codes(block_size: u8) -> CodeSet {
    if (1..=127).contains(&block_size) { CodeSet::NONE } else { codes::BLOCK_SIZE }
}
