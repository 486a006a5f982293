//! One SDO channel: joins requests and responses to transfers.

use super::block::{Block, HeldBack};
use super::transfer::{Direction, Mode, Outcome, Side, Transfer, Violation};
use super::under_way::UnderWay;
use crate::message::{Message, Service};
use crate::room::Room;
use crate::wire::sdo::{Abort, BlockSegment, Payload, Request, Response, Segment};
use crate::wire::{Malformed, Wire};
use crate::{Multiplexer, NodeId};
use canvass_traces::Timestamp;

/// A channel of a bus, by its index; the 127 predefined channels come first.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct ChannelIndex(pub u16);

impl ChannelIndex {
    /// The default channel of a node.
    pub const fn predefined(node: NodeId) -> Self {
        Self(node.raw() as u16 - 1)
    }

    /// The node of a default channel.
    pub const fn predefined_server(self) -> Option<NodeId> {
        if self.0 < 127 { NodeId::new(self.0 as u8 + 1) } else { None }
    }
}

/// A channel, and its open or last transfer.
#[derive(Clone)]
pub struct Channel {
    /// The node that serves.
    pub server: NodeId,
    pub(super) transfer: Option<Transfer>,
    /// The last transfer that did not reach its end.
    left: Option<Transfer>,
    pub(super) held_back: HeldBack,
    phase: Phase,
    under_way: UnderWay,
    /// Number of bytes that long values have taken from a room.
    taken: usize,
}

/// The next expected message on a channel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Phase {
    Idle,
    /// The server's answer to an initiate request.
    Initiated,
    /// The client's next segment or segment request, with its toggle bit.
    Client {
        toggle: bool,
    },
    /// The server's segment or confirmation, with its toggle bit and whether it ends the transfer.
    Server {
        toggle: bool,
        last: bool,
    },
    /// A block transfer.
    Block(Block),
}

/// The effect of a frame on its channel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Step {
    /// The frame's message.
    pub message: Message,
    /// Whether the frame ended the transfer.
    pub ended: bool,
    /// Whether the frame ended an open transfer as superseded; the channel keeps this transfer in `left`.
    pub superseded: bool,
    /// The rule that the frame breaks.
    pub violation: Option<Violation>,
}

impl Step {
    fn of(message: Message) -> Self {
        Self { message, ended: false, superseded: false, violation: None }
    }

    fn unexpected(mut self) -> Self {
        self.violation = Some(Violation::Unexpected);
        self
    }
}

impl Channel {
    /// Memory of a channel, including the request that rules keep of it.
    pub(in crate::network) const MEMORY: usize = 2 * size_of::<Self>() + 512;

    /// A channel without traffic so far.
    pub fn new(server: NodeId) -> Self {
        let (held_back, under_way) = (HeldBack::default(), UnderWay::default());
        Self { server, transfer: None, left: None, held_back, phase: Phase::Idle, under_way, taken: 0 }
    }

    /// Memory of values that are longer than [`Transfer::SHORT`].
    #[inline]
    fn held(&self) -> usize {
        let values = self.transfer.iter().chain(&self.left).map(Transfer::capacity).sum::<usize>();
        (values + self.held_back.capacity()).saturating_sub(2 * Transfer::SHORT)
    }

    /// Takes the memory of long values from `room`; if `room` is full, only the beginning of the value is kept.
    #[inline]
    pub fn settle(&mut self, room: &Room) {
        if self.held() != self.taken {
            self.settle_in(room);
        }
    }

    #[cold]
    fn settle_in(&mut self, room: &Room) {
        room.give(std::mem::take(&mut self.taken));
        if !room.take(self.held()) {
            self.transfer.iter_mut().chain(&mut self.left).for_each(Transfer::shorten);
            // The bytes that a block holds back are needed until its end, and they are few.
            return;
        }
        self.taken = self.held();
    }

    /// The open or last transfer.
    pub fn transfer(&self) -> Option<&Transfer> {
        self.transfer.as_ref()
    }

    /// The last transfer that did not reach its end.
    pub fn left_transfer(&self) -> Option<&Transfer> {
        self.left.as_ref()
    }

    /// Drops the open transfer, as its node was reset; returns whether there was one.
    pub fn reset(&mut self) -> bool {
        let open = self.phase != Phase::Idle;
        self.phase = Phase::Idle;
        if open {
            self.left = self.transfer.take();
        }
        open
    }

    /// Whether a transfer is open.
    pub fn is_busy(&self) -> bool {
        self.phase != Phase::Idle
    }

    /// Handles a frame from the client.
    pub fn request(&mut self, now: Timestamp, payload: &[u8]) -> Step {
        let step = if let Some(step) = self.any_block_segment(now, Direction::Download, payload) {
            step
        } else {
            match Request::read(payload) {
                Ok(request) => {
                    let step = self.on_request(now, request);
                    self.excused(step)
                }
                Err(error) => malformed(error),
            }
        };
        self.check();
        step
    }

    /// Checks the invariants after each frame: a transfer is open exactly while a message is due, and a sub-block holds
    /// back the bytes of the segments that came in order.
    fn check(&self) {
        debug_assert_eq!(self.is_busy(), self.transfer.as_ref().is_some_and(Transfer::is_open), "{:?}", self.phase);
        if cfg!(debug_assertions)
            && let Some(block) = self.block()
        {
            self.check_block(block);
        }
    }

    /// Handles a frame from the server.
    pub fn response(&mut self, now: Timestamp, payload: &[u8]) -> Step {
        let step = if let Some(step) = self.any_block_segment(now, Direction::Upload, payload) {
            step
        } else {
            match Response::read(payload) {
                Ok(response) => {
                    let step = self.on_response(now, response);
                    self.excused(step)
                }
                Err(error) => malformed(error),
            }
        };
        self.check();
        step
    }

    /// The frame as a segment of a block transfer, even if the transfer began before the capture.
    #[inline]
    fn any_block_segment(&mut self, now: Timestamp, direction: Direction, payload: &[u8]) -> Option<Step> {
        if let Some(segment) = self.as_block_segment(now, direction, payload) {
            return Some(self.block_segment(now, direction, segment));
        }
        let segment = self.segment_under_way(now, direction, payload)?;
        Some(Step::segment(direction, segment))
    }

    /// Removes the violation from a message of a block transfer that began before the capture.
    fn excused(&self, step: Step) -> Step {
        let block = matches!(
            step.message,
            Message::SdoRequest(
                Request::ConfirmBlockUpload { .. } | Request::EndBlockUpload | Request::EndBlockDownload { .. }
            ) | Message::SdoResponse(
                Response::ConfirmBlockDownload { .. } | Response::EndBlockDownload | Response::EndBlockUpload { .. }
            )
        );
        let is_excused = self.under_way.is_possible() && block && step.violation == Some(Violation::Unexpected);
        if is_excused { Step { violation: None, ..step } } else { step }
    }

    /// The frame as a segment of a block transfer that began before the capture.
    fn segment_under_way(&mut self, now: Timestamp, direction: Direction, payload: &[u8]) -> Option<BlockSegment> {
        if !self.under_way.is_possible() || matches!(self.phase, Phase::Block(_)) {
            return None;
        }
        let segment = self.under_way.segment(now, direction, payload)?;
        // The previous segment was taken for another message.
        (self.phase, self.transfer) = (Phase::Idle, None);
        Some(segment)
    }

    fn on_request(&mut self, now: Timestamp, request: Request) -> Step {
        let step = Step::of(Message::SdoRequest(request));
        match request {
            Request::InitiateDownload { multiplexer, payload } => {
                let superseded = self.begin(now, multiplexer, Direction::Download, Mode::Expedited);
                self.announce(payload);
                Step { superseded, ..step }
            }
            Request::InitiateUpload { multiplexer } => {
                let superseded = self.begin(now, multiplexer, Direction::Upload, Mode::Expedited);
                Step { superseded, ..step }
            }
            Request::InitiateBlockDownload { multiplexer, crc, size } => {
                let superseded = self.begin(now, multiplexer, Direction::Download, Mode::Block);
                self.phase = Phase::Block(Block::DownloadInitiated { crc });
                self.with(|transfer| transfer.announced = size);
                Step { superseded, ..step }
            }
            Request::InitiateBlockUpload { multiplexer, crc, block_size, .. } => {
                let superseded = self.begin(now, multiplexer, Direction::Upload, Mode::Block);
                self.phase = Phase::Block(Block::UploadInitiated { crc, block_size });
                Step { superseded, ..step }
            }
            Request::DownloadSegment(segment) => self.download_segment(now, segment, step),
            Request::UploadSegment { toggle } => self.upload_segment_request(now, toggle, step),
            Request::Abort(abort) => self.aborted(now, Side::Client, abort, step),
            Request::ConfirmBlockUpload { .. } | Request::StartBlockUpload | Request::EndBlockUpload => {
                self.block_upload_request(now, request, step)
            }
            Request::EndBlockDownload { unused, crc } => self.end_block_download(now, unused, crc, step),
            Request::Unknown { .. } => step.unexpected(),
        }
    }

    fn on_response(&mut self, now: Timestamp, response: Response) -> Step {
        let step = Step::of(Message::SdoResponse(response));
        match response {
            Response::InitiateUpload { multiplexer, payload } => self.upload_initiated(now, multiplexer, payload, step),
            Response::InitiateDownload { multiplexer } => self.download_initiated(now, multiplexer, step),
            Response::UploadSegment(segment) => self.upload_segment(now, segment, step),
            Response::DownloadSegment { toggle } => self.download_segment_confirmed(now, toggle, step),
            Response::Abort(abort) => self.aborted(now, Side::Server, abort, step),
            Response::InitiateBlockDownload { .. }
            | Response::ConfirmBlockDownload { .. }
            | Response::EndBlockDownload
            | Response::InitiateBlockUpload { .. }
            | Response::EndBlockUpload { .. } => self.block_response(now, response, step),
            Response::Unknown { .. } => step.unexpected(),
        }
    }

    /// Starts a transfer; returns whether another one was open.
    fn begin(&mut self, now: Timestamp, multiplexer: Multiplexer, direction: Direction, mode: Mode) -> bool {
        let superseded = self.phase != Phase::Idle;
        if superseded {
            self.with(|transfer| transfer.end(Outcome::Superseded));
            // The memory of the previous transfer is reused.
            std::mem::swap(&mut self.transfer, &mut self.left);
        }
        match &mut self.transfer {
            Some(transfer) => transfer.restart(multiplexer, direction, mode, now),
            None => self.transfer = Some(Transfer::new(multiplexer, direction, mode, now)),
        }
        self.phase = Phase::Initiated;
        superseded
    }

    /// Handles an answer to another request during a block download: the client has abandoned the download, and its
    /// request was taken for a segment.
    fn leave_block_download(&mut self, step: Step) -> Step {
        // Before the first segment no request can have been taken for a segment.
        let Phase::Block(Block::Data { direction: Direction::Download, .. }) = self.phase else { return step };
        self.phase = Phase::Idle;
        self.with(|transfer| transfer.end(Outcome::Superseded));
        self.left = self.transfer.take();
        Step { superseded: true, ..step }
    }

    /// Takes the value of an initiate message, or the announcement of its segments.
    fn announce(&mut self, payload: Payload) {
        self.with(|transfer| match payload {
            Payload::Expedited(_) | Payload::ExpeditedUnsized(_) => {
                transfer.mode = Mode::Expedited;
                transfer.extend(payload.value().unwrap_or(&[]));
            }
            Payload::Segmented(size) => {
                transfer.mode = Mode::Segmented;
                transfer.announced = Some(size);
            }
            Payload::SegmentedUnsized => transfer.mode = Mode::Segmented,
        });
    }

    fn upload_initiated(&mut self, now: Timestamp, multiplexer: Multiplexer, payload: Payload, step: Step) -> Step {
        let block = matches!(self.phase, Phase::Block(Block::UploadInitiated { .. }));
        if !(block || self.phase == Phase::Initiated && self.direction() == Some(Direction::Upload)) {
            return self.leave_block_download(step).unexpected();
        }
        let step = self.answered(now, multiplexer, step);
        self.announce(payload);
        if payload.value().is_some() {
            return self.complete(step);
        }
        self.phase = Phase::Client { toggle: false };
        step
    }

    fn download_initiated(&mut self, now: Timestamp, multiplexer: Multiplexer, step: Step) -> Step {
        if self.phase != Phase::Initiated || self.direction() != Some(Direction::Download) {
            return self.leave_block_download(step).unexpected();
        }
        let step = self.answered(now, multiplexer, step);
        if self.mode() == Some(Mode::Expedited) {
            return self.complete(step);
        }
        self.phase = Phase::Client { toggle: false };
        step
    }

    fn download_segment(&mut self, now: Timestamp, segment: Segment, step: Step) -> Step {
        let Phase::Client { toggle } = self.phase else { return step.unexpected() };
        if self.direction() != Some(Direction::Download) {
            return step.unexpected();
        }
        let step = self.check_toggle(toggle, segment.toggle, step);
        self.seen(now);
        self.take_segment(segment);
        self.phase = Phase::Server { toggle: segment.toggle, last: segment.last };
        step
    }

    fn download_segment_confirmed(&mut self, now: Timestamp, confirmed: bool, step: Step) -> Step {
        let Phase::Server { toggle, last } = self.phase else { return step.unexpected() };
        if self.direction() != Some(Direction::Download) {
            return step.unexpected();
        }
        let step = self.check_toggle(toggle, confirmed, step);
        self.seen(now);
        if last {
            return self.complete(step);
        }
        self.phase = Phase::Client { toggle: !toggle };
        step
    }

    fn upload_segment_request(&mut self, now: Timestamp, asked: bool, step: Step) -> Step {
        let Phase::Client { toggle } = self.phase else { return step.unexpected() };
        if self.direction() != Some(Direction::Upload) {
            return step.unexpected();
        }
        let step = self.check_toggle(toggle, asked, step);
        self.seen(now);
        self.phase = Phase::Server { toggle: asked, last: false };
        step
    }

    fn upload_segment(&mut self, now: Timestamp, segment: Segment, step: Step) -> Step {
        let Phase::Server { toggle, .. } = self.phase else { return step.unexpected() };
        if self.direction() != Some(Direction::Upload) {
            return step.unexpected();
        }
        let step = self.check_toggle(toggle, segment.toggle, step);
        self.seen(now);
        self.take_segment(segment);
        if segment.last {
            return self.complete(step);
        }
        self.phase = Phase::Client { toggle: !toggle };
        step
    }

    fn take_segment(&mut self, segment: Segment) {
        self.with(|transfer| {
            transfer.segments += 1;
            transfer.extend(segment.data());
        });
    }

    fn aborted(&mut self, now: Timestamp, side: Side, abort: Abort, step: Step) -> Step {
        if self.phase == Phase::Idle {
            // The transfer is unknown: it may have begun before the capture.
            return step;
        }
        let step = match side {
            Side::Server => self.answered(now, abort.multiplexer, step),
            Side::Client => step,
        };
        self.end(now, Outcome::Aborted(side, abort.code), step)
    }

    /// Notes a frame of the transfer that names its object.
    pub(super) fn answered(&mut self, now: Timestamp, multiplexer: Multiplexer, step: Step) -> Step {
        self.under_way.end();
        self.seen(now);
        self.with(|transfer| transfer.is_answered = true);
        match &mut self.transfer {
            Some(transfer) if transfer.multiplexer != multiplexer => {
                let violation = Violation::Multiplexer(multiplexer);
                transfer.blame(violation);
                Step { violation: Some(violation), ..step }
            }
            _ => step,
        }
    }

    fn check_toggle(&mut self, expected: bool, found: bool, step: Step) -> Step {
        if expected == found {
            return step;
        }
        self.with(|transfer| transfer.blame(Violation::Toggle));
        Step { violation: Some(Violation::Toggle), ..step }
    }

    pub(super) fn complete(&mut self, step: Step) -> Step {
        let latest = self.transfer.as_ref().map_or(Timestamp::ZERO, |transfer| transfer.latest);
        self.end(latest, Outcome::Complete, step)
    }

    fn end(&mut self, now: Timestamp, outcome: Outcome, step: Step) -> Step {
        self.seen(now);
        self.phase = Phase::Idle;
        let mut violation = step.violation;
        self.with(|transfer| {
            let before = transfer.violation;
            transfer.end(outcome);
            if before.is_none() {
                violation = violation.or(transfer.violation);
            }
        });
        Step { ended: true, violation, ..step }
    }

    pub(super) fn seen(&mut self, now: Timestamp) {
        self.with(|transfer| transfer.latest = now);
    }

    pub(super) fn with(&mut self, change: impl FnOnce(&mut Transfer)) {
        if let Some(transfer) = &mut self.transfer {
            change(transfer);
        }
    }

    pub(super) fn block(&self) -> Option<Block> {
        match self.phase {
            Phase::Block(block) => Some(block),
            _ => None,
        }
    }

    pub(super) fn set_block(&mut self, block: Block) {
        self.phase = Phase::Block(block);
    }

    fn direction(&self) -> Option<Direction> {
        self.transfer.as_ref().map(|transfer| transfer.direction)
    }

    fn mode(&self) -> Option<Mode> {
        self.transfer.as_ref().map(|transfer| transfer.mode)
    }
}

fn malformed(error: Malformed) -> Step {
    Step::of(Message::Malformed(Service::Sdo, error))
}

impl Step {
    /// The step of a block segment.
    pub(super) fn segment(direction: Direction, segment: BlockSegment) -> Self {
        Self::of(match direction {
            Direction::Download => Message::SdoBlockDownload(segment),
            Direction::Upload => Message::SdoBlockUpload(segment),
        })
    }

    /// Marks the step as unexpected.
    pub(super) fn out_of_place(self) -> Self {
        self.unexpected()
    }
}
