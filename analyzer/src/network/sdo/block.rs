//! Block transfers on a channel.
//!
//! The segments of a sub-block are held back until it is confirmed: only confirmed segments count, the others are
//! sent again.

use super::channel::{Channel, Step};
use super::transfer::{Direction, Violation};
use crate::wire::Wire;
use crate::wire::sdo::{BlockSegment, Request, Response};
use canvass_traces::{Duration, Timestamp};

/// A sub-block without frames for this long is over: all SDO timeouts in use are shorter.
const SILENCE: Duration = Duration(10_000_000_000);

/// The state of a block transfer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Block {
    /// The client has requested a download; the server's answer is due.
    DownloadInitiated {
        /// The client can send a CRC.
        crc: bool,
    },
    /// The client has requested an upload; the server's answer is due.
    UploadInitiated {
        /// The client can check a CRC.
        crc: bool,
        /// The size of the first sub-block.
        block_size: u8,
    },
    /// The server has answered; the client's start message is due.
    UploadAnswered {
        /// Both sides use a CRC.
        crc: bool,
        /// The size of the first sub-block.
        block_size: u8,
    },
    /// Both sides have agreed, and data is being transferred.
    Data {
        /// The direction of the data.
        direction: Direction,
        /// Both sides use a CRC.
        crc: bool,
        /// The next expected message.
        due: Due,
    },
}

/// The next expected message during the data phase.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Due {
    /// The sender's segments.
    Segments(Run),
    /// The receiver's confirmation of the sub-block.
    Confirmation(Run),
    /// The sender's end message.
    End,
    /// The receiver's confirmation of the end.
    EndConfirmation,
}

impl Block {
    const fn direction(self) -> Direction {
        match self {
            Self::DownloadInitiated { .. } => Direction::Download,
            Self::UploadInitiated { .. } | Self::UploadAnswered { .. } => Direction::Upload,
            Self::Data { direction, .. } => direction,
        }
    }
}

/// The progress of a sub-block.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Run {
    /// Number of segments in the sub-block.
    block_size: u8,
    /// The sequence number of the last segment that came in order.
    in_order: u8,
    /// Whether the segment `in_order` is the last one of the transfer.
    last: bool,
    /// The latest segment, in order or not.
    latest: Option<BlockSegment>,
}

impl Run {
    const fn new(block_size: u8) -> Self {
        Self { block_size, in_order: 0, last: false, latest: None }
    }

    /// Whether the transfer's last segment is among the segments up to `sequence`.
    ///
    /// If a receiver confirms more segments than the capture shows, and less than the whole sub-block, the receiver has
    /// got the last segment, which the capture lacks.
    fn ends_with(self, sequence: u8) -> bool {
        let latest = self.latest.map_or(0, |segment| segment.sequence);
        match self.latest {
            Some(segment) if segment.last => sequence >= latest,
            _ => sequence > latest && sequence < self.block_size,
        }
    }
}

/// Bytes that may be sent again, or whose final number is still unknown.
#[derive(Clone, Default)]
pub(crate) struct HeldBack(Vec<u8>);

impl HeldBack {
    /// The occupied memory, in bytes.
    pub(super) const fn capacity(&self) -> usize {
        self.0.capacity()
    }

    /// Releases the bytes of the first `segments` segments, which count; `keep_last` holds back the last of these
    /// segments, because only the end message tells how many of its bytes count.
    fn release(&mut self, segments: u8, keep_last: bool, mut take: impl FnMut(&[u8])) {
        let confirmed = (usize::from(segments) * 7).min(self.0.len());
        let kept = if keep_last { 7.min(confirmed) } else { 0 };
        take(&self.0[..confirmed - kept]);
        self.0.copy_within(confirmed - kept..confirmed, 0);
        self.0.truncate(kept);
    }
}

impl Channel {
    /// Checks the invariants of a block transfer, which hold between two frames.
    pub(super) fn check_block(&self, block: Block) {
        let held_back = self.held_back.0.len();
        match block {
            Block::Data { due: Due::Segments(run) | Due::Confirmation(run), .. } => {
                debug_assert!(run.in_order <= BlockSegment::MAX, "{run:?}");
                debug_assert_eq!(held_back, usize::from(run.in_order) * 7, "{run:?}");
            }
            Block::Data { due: Due::End, .. } => debug_assert!(held_back <= 7, "only the last segment is held back"),
            Block::Data { due: Due::EndConfirmation, .. } => debug_assert_eq!(held_back, 0),
            Block::DownloadInitiated { .. } | Block::UploadInitiated { .. } | Block::UploadAnswered { .. } => {}
        }
    }

    /// The frame as a segment, if the state of the transfer makes it one.
    ///
    /// After the end of a sub-block only a repetition of the sub-block's last segment counts as a segment: a CAN
    /// controller repeats a frame whose last bit was disturbed, although other nodes have received it.
    pub(super) fn as_block_segment(
        &self,
        now: Timestamp,
        direction: Direction,
        payload: &[u8],
    ) -> Option<BlockSegment> {
        let Block::Data { direction: of, due, .. } = self.block()? else { return None };
        let (run, over) = match due {
            _ if of != direction => return None,
            Due::Segments(run) => (run, false),
            Due::Confirmation(run) => (run, true),
            Due::End | Due::EndConfirmation => return None,
        };
        // 80h is an abort: there is no segment 0.
        let segment = BlockSegment::read(payload).ok().filter(|_| payload.first() != Some(&0x80))?;
        let silence = self.transfer.as_ref().map_or(Duration(0), |transfer| now - transfer.latest);
        let belongs = if over { run.latest == Some(segment) } else { silence <= SILENCE };
        belongs.then_some(segment)
    }

    /// Handles a segment, from the client of a download or the server of an upload.
    pub(super) fn block_segment(&mut self, now: Timestamp, direction: Direction, segment: BlockSegment) -> Step {
        let step = Step::segment(direction, segment);
        let Some(Block::Data { crc, due: Due::Segments(run) | Due::Confirmation(run), .. }) = self.block() else {
            return step.out_of_place();
        };
        let (run, over, step) = self.in_sub_block(now, run, segment, step);
        let due = if over { Due::Confirmation(run) } else { Due::Segments(run) };
        self.set_block(Block::Data { direction, crc, due });
        step
    }

    /// Handles a segment in its sub-block; returns the progress and whether the sub-block is over.
    fn in_sub_block(&mut self, now: Timestamp, mut run: Run, segment: BlockSegment, step: Step) -> (Run, bool, Step) {
        self.seen(now);
        run.latest = Some(segment);
        let over = segment.last || segment.sequence >= run.block_size;
        let expected = run.in_order.saturating_add(1);
        if segment.sequence != expected || run.last {
            let violation = Violation::Sequence { expected, found: segment.sequence };
            // The receiver will request it again and the transfer may still succeed, so only the frame gets the
            // violation.
            return (run, over, Step { violation: Some(violation), ..step });
        }
        run.in_order = expected;
        run.last = segment.last;
        self.held_back.0.extend_from_slice(&segment.data);
        self.with(|transfer| transfer.unconfirmed += segment.data.len() as u32);
        (run, over, step)
    }

    /// Handles the receiver's confirmation of a sub-block: confirmed bytes count, the rest is sent again. Returns the
    /// next expected message.
    fn confirm(&mut self, run: Run, sequence: u8, next_size: u8) -> Due {
        let done = run.ends_with(sequence);
        let held_back = &mut self.held_back;
        if let Some(transfer) = &mut self.transfer {
            transfer.segments += u32::from(sequence.min(run.in_order));
            transfer.unconfirmed = 0;
            if sequence > run.in_order {
                // The receiver has segments that the capture lacks.
                transfer.blame(Violation::Sequence { expected: run.in_order.saturating_add(1), found: sequence });
            }
            held_back.release(sequence, done, |bytes| transfer.extend(bytes));
        }
        if done {
            return Due::End;
        }
        self.held_back.0.clear();
        Due::Segments(Run::new(next_size))
    }

    /// Handles the sender's end message: the number of unused bytes in the last segment, and the CRC.
    fn end_data(&mut self, now: Timestamp, unused: u8, sent: u16, step: Step) -> Step {
        let Some(Block::Data { direction, crc, due: Due::End }) = self.block() else { return step.out_of_place() };
        self.seen(now);
        let last = std::mem::take(&mut self.held_back.0);
        let mut violation = step.violation;
        self.with(|transfer| {
            transfer.extend(&last[..last.len().saturating_sub(usize::from(unused))]);
            if crc && sent != transfer.crc() {
                let wrong = Violation::Crc { sent, calculated: transfer.crc() };
                transfer.blame(wrong);
                violation = Some(wrong);
            }
        });
        self.held_back.0 = last;
        self.held_back.0.clear();
        self.set_block(Block::Data { direction, crc, due: Due::EndConfirmation });
        Step { violation, ..step }
    }

    /// Handles the client's messages of a block upload after the initiate request.
    pub(super) fn block_upload_request(&mut self, now: Timestamp, request: Request, step: Step) -> Step {
        let block = self.block().filter(|block| block.direction() == Direction::Upload);
        let Some(block) = block else { return step.out_of_place() };
        self.seen(now);
        let (crc, due) = match (block, request) {
            (Block::UploadAnswered { crc, block_size }, Request::StartBlockUpload) => {
                self.held_back.0.clear();
                (crc, Due::Segments(Run::new(block_size)))
            }
            // A receiver that misses the end of a sub-block confirms the segments received.
            (
                Block::Data { crc, due: Due::Confirmation(run) | Due::Segments(run), .. },
                Request::ConfirmBlockUpload { sequence, block_size },
            ) => (crc, self.confirm(run, sequence, block_size)),
            (Block::Data { due: Due::EndConfirmation, .. }, Request::EndBlockUpload) => return self.complete(step),
            (_, Request::EndBlockUpload) => return self.complete_early(step),
            _ => return step.out_of_place(),
        };
        self.set_block(Block::Data { direction: Direction::Upload, crc, due });
        step
    }

    /// Handles the client's end of a block download.
    pub(super) fn end_block_download(&mut self, now: Timestamp, unused: u8, sent: u16, step: Step) -> Step {
        let is_download = self.block().is_some_and(|block| block.direction() == Direction::Download);
        if is_download { self.end_data(now, unused, sent, step) } else { step.out_of_place() }
    }

    /// Handles the server's messages of block transfers.
    pub(super) fn block_response(&mut self, now: Timestamp, response: Response, step: Step) -> Step {
        match (self.block(), response) {
            (Some(block), _) if block.direction() == Direction::Download => {
                self.block_download_response(now, block, response, step)
            }
            (
                Some(Block::UploadInitiated { crc: asked, block_size }),
                Response::InitiateBlockUpload { multiplexer, crc, size },
            ) => {
                self.set_block(Block::UploadAnswered { crc: crc && asked, block_size });
                self.with(|transfer| transfer.announced = size);
                self.answered(now, multiplexer, step)
            }
            (_, Response::EndBlockUpload { unused, crc }) => self.end_data(now, unused, crc, step),
            _ => step.out_of_place(),
        }
    }

    /// Handles the confirmation of the transfer's end if other messages were due before it: the capture lacks frames.
    fn complete_early(&mut self, step: Step) -> Step {
        self.with(|transfer| transfer.blame(Violation::Unexpected));
        self.complete(step.out_of_place())
    }

    fn block_download_response(&mut self, now: Timestamp, block: Block, response: Response, step: Step) -> Step {
        let direction = Direction::Download;
        let (crc, due) = match (block, response) {
            (
                Block::DownloadInitiated { crc: asked },
                Response::InitiateBlockDownload { multiplexer, crc, block_size },
            ) => {
                self.held_back.0.clear();
                let due = Due::Segments(Run::new(block_size));
                self.set_block(Block::Data { direction, crc: crc && asked, due });
                return self.answered(now, multiplexer, step);
            }
            (
                Block::Data { crc, due: Due::Confirmation(run) | Due::Segments(run), .. },
                Response::ConfirmBlockDownload { sequence, block_size },
            ) => (crc, self.confirm(run, sequence, block_size)),
            (Block::Data { due: Due::EndConfirmation, .. }, Response::EndBlockDownload) => {
                self.seen(now);
                return self.complete(step);
            }
            (_, Response::EndBlockDownload) => {
                self.seen(now);
                return self.complete_early(step);
            }
            _ => return step.out_of_place(),
        };
        self.seen(now);
        self.set_block(Block::Data { direction, crc, due });
        step
    }
}
