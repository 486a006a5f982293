//! The SDO server: one transfer at a time, expedited, segmented or in blocks (CiA 301, 7.2.4).
//!
//! Each kind of transfer is one file. A state has only the data of its kind of transfer. An event takes the state and
//! returns the [`Next`].

mod block_download;
mod block_upload;
mod download;
mod history;
mod upload;

use super::chance::Chance;
use super::objects::Objects;
use crate::models::Timing;
use crate::{Fault, Firmware, Liberty};
use block_download::{BlockDownload, BlockDownloadEnd};
use block_upload::BlockUpload;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{AbortCode, BlockSegment, Expedited, Payload, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::{CanId, Duration, Frame, Timestamp};
use download::SegmentedDownload;
use history::History;
use std::collections::VecDeque;
use upload::SegmentedUpload;

/// The SDO server of one SDO channel.
#[derive(Clone, Debug)]
pub(super) struct SdoServer {
    transfer: Transfer,
    timing: Timing,
    blocks: bool,
    /// The waiting answers with their times and lengths, in the order of sending.
    answers: VecDeque<(Timestamp, [u8; 8], usize)>,
    /// The time at which a transfer ends if its client stays silent.
    expires: Timestamp,
    /// The object of the last transfer, for a firmware that names it in aborts of later transfers.
    stale: Multiplexer,
    /// The first bytes of a refused segment, for a firmware that returns them as the next value.
    refused: Option<[u8; 4]>,
    /// Whether a block download with CRC has begun since boot-up.
    had_crc: bool,
    history: History,
    /// The time until which a faulty firmware ignores requests.
    deaf_until: Timestamp,
    /// Whether a request was received since boot-up.
    began: bool,
    /// Number of requests since boot-up.
    requests: u32,
    /// Whether the firmware has crashed: it does not answer until the next start.
    wedged: bool,
    chance: Chance,
}

/// The open transfer, by its kind.
#[derive(Clone, Debug)]
enum Transfer {
    Idle,
    Upload(SegmentedUpload),
    Download(SegmentedDownload),
    BlockUpload(BlockUpload),
    BlockDownload(BlockDownload),
    BlockDownloadEnd(BlockDownloadEnd),
}

impl Transfer {
    /// The code with which a faulty firmware refuses new requests without ending this transfer.
    fn survives(&self, firmware: &Firmware) -> Option<AbortCode> {
        match self {
            Self::Download(_) => firmware.has(Fault::SdoOpenDownloadSurvivesReset).then_some(AbortCode::LOCAL_CONTROL),
            Self::BlockUpload(_) => {
                firmware.has(Fault::SdoBlockUploadSurvivesRefusal).then_some(AbortCode::COMMAND_SPECIFIER)
            }
            _ => None,
        }
    }
}

/// The result of a message: the next state of the transfer, and the messages to send.
struct Next {
    transfer: Transfer,
    answer: Answer,
}

enum Answer {
    Silence,
    Response(Response),
    /// A block of an upload.
    Segments(Vec<BlockSegment>),
}

impl Next {
    const fn answer(transfer: Transfer, response: Response) -> Self {
        Self { transfer, answer: Answer::Response(response) }
    }

    const fn end(response: Response) -> Self {
        Self::answer(Transfer::Idle, response)
    }

    const fn abort(object: Multiplexer, code: AbortCode) -> Self {
        Self::end(Response::abort(object, code))
    }

    const fn silence(transfer: Transfer) -> Self {
        Self { transfer, answer: Answer::Silence }
    }
}

impl Transfer {
    /// The object of the transfer.
    const fn object(&self) -> Option<Multiplexer> {
        match self {
            Self::Idle => None,
            Self::Upload(upload) => Some(upload.object),
            Self::Download(download) => Some(download.object),
            Self::BlockUpload(upload) => Some(upload.object),
            Self::BlockDownload(download) => Some(download.object),
            Self::BlockDownloadEnd(end) => Some(end.object()),
        }
    }
}

impl SdoServer {
    /// An idle server. `seed` determines random response times.
    pub fn new(timing: Timing, blocks: bool, seed: u64) -> Self {
        Self {
            transfer: Transfer::Idle,
            timing,
            blocks,
            answers: VecDeque::with_capacity(usize::from(BlockSegment::MAX) + 1),
            expires: Timestamp::MAX,
            stale: Multiplexer::new(0, 0),
            refused: None,
            had_crc: false,
            history: History::default(),
            deaf_until: Timestamp::ZERO,
            began: false,
            requests: 0,
            wedged: false,
            chance: Chance::new(seed),
        }
    }

    /// Drops the transfer and waiting answers.
    pub fn reset(&mut self) {
        self.transfer = Transfer::Idle;
        self.answers.clear();
        self.expires = Timestamp::MAX;
    }

    /// Resets the server as [`SdoServer::reset`] does, at the start of the device.
    pub fn boot(&mut self) {
        self.reset();
        self.refused = None;
        self.had_crc = false;
        self.history = std::mem::take(&mut self.history).at_start();
        self.began = false;
        self.requests = 0;
        self.wedged = false;
    }

    /// Whether a segmented download is open.
    pub const fn is_downloading(&self) -> bool {
        matches!(self.transfer, Transfer::Download(_))
    }

    /// Time of the next event: an answer is ready, or the transfer expires.
    pub fn timeout(&self) -> Timestamp {
        self.answers.front().map_or(self.expires, |(due, ..)| *due)
    }

    /// Handles a frame on the client's CAN-ID.
    pub fn handle(&mut self, now: Timestamp, frame: &Frame, objects: &mut Objects) {
        // SDO messages have eight bytes (CiA 301); the server ignores other messages.
        if frame.len() != 8 {
            self.wedged |= objects.has(Fault::SdoShortRequestWedges);
            return;
        }
        self.requests = self.requests.wrapping_add(1);
        let lost = self.requests.is_multiple_of(LOST_EVERY) && objects.has(Fault::SdoResponseLost);
        if lost || self.wedged || now < self.deaf_until {
            return;
        }
        self.mix_up(frame, objects);
        let transfer = std::mem::replace(&mut self.transfer, Transfer::Idle);
        let next = match transfer {
            // A last segment with sequence number 0 has the command byte 80h, as an abort has.
            Transfer::BlockDownload(download) if frame.bytes()[0] != 0x80 => match BlockSegment::read(frame.data()) {
                Ok(segment) => {
                    if !segment.last && objects.has(Fault::SdoBlockSegmentsEchoed) {
                        self.answers.push_back((now, frame.bytes(), 8));
                    }
                    download.on_segment(segment, &objects.firmware)
                }
                Err(_) => Next::silence(Transfer::BlockDownload(download)),
            },
            transfer => match Request::read(frame.data()) {
                Ok(request) if has_reserved_bits(frame, &request) && objects.takes(Liberty::ReservedBitsRefused) => {
                    Next::abort(Multiplexer::new(0, 0), AbortCode::COMMAND_SPECIFIER)
                }
                Ok(request) => self.on_request(now, transfer, request, objects),
                Err(_) => Next::silence(transfer),
            },
        };
        self.began = true;
        self.proceed(now, next, objects);
    }

    /// Handles a request outside a block. A request that begins a transfer ends the open transfer.
    fn on_request(&mut self, now: Timestamp, transfer: Transfer, request: Request, objects: &mut Objects) -> Next {
        let firmware = &objects.firmware;
        let request = self.history.taken(request, firmware);
        if let Some(code) = transfer.survives(firmware)
            && let Some(object) = request.multiplexer().filter(|_| !matches!(request, Request::Abort(_)))
        {
            return Next::answer(transfer, Response::abort(object, code));
        }
        if let Some(refused) = self.history.begin(&request, firmware) {
            return refused;
        }
        let is_busy = match transfer {
            Transfer::Idle => false,
            Transfer::Upload(_) => firmware.has(Fault::SdoBusyAfterAbandonedTransfer),
            Transfer::Download(_) => firmware.has(Fault::SdoBusyAfterAbandonedDownload),
            _ => firmware.has(Fault::SdoBusyAfterAbandonedBlock) || firmware.takes(Liberty::BlockInitiateRefused),
        };
        match request {
            Request::InitiateUpload { multiplexer } | Request::InitiateDownload { multiplexer, .. } if is_busy => {
                Next::abort(multiplexer, AbortCode::COMMAND_SPECIFIER)
            }
            Request::InitiateUpload { multiplexer } => upload::initiate(now, multiplexer, objects),
            Request::InitiateDownload { multiplexer, payload } => {
                download::initiate(now, multiplexer, payload, objects)
            }
            Request::InitiateBlockUpload { multiplexer, crc, block_size, threshold } if self.blocks => {
                block_upload::initiate(now, multiplexer, crc, block_size, threshold, objects)
            }
            Request::InitiateBlockDownload { multiplexer, crc, size } if self.blocks => {
                self.had_crc |= crc;
                let kept = self.had_crc && objects.has(Fault::SdoBlockCrcKept);
                let stale = self.history.take_block();
                block_download::initiate(multiplexer, crc || kept, size, stale, objects)
            }
            Request::Abort(abort) if objects.has(Fault::SdoAbortAnswered) => {
                Next::abort(abort.multiplexer, AbortCode::GENERAL)
            }
            Request::Abort(_)
                if matches!(&transfer, Transfer::BlockDownload(download) if download.has_begun())
                    && firmware.has(Fault::SdoBlockAbortIgnored) =>
            {
                Next::silence(transfer)
            }
            Request::Abort(_)
                if matches!(&transfer, Transfer::BlockDownload(download) if !download.has_begun())
                    && firmware.has(Fault::SdoFirstBlockAbortIgnored) =>
            {
                Next::silence(transfer)
            }
            Request::Abort(_) if firmware.has(Fault::SdoAbortIgnored) => Next::silence(transfer),
            Request::Abort(_) => Next::silence(Transfer::Idle),
            request => match (transfer, request) {
                (Transfer::Upload(upload), Request::UploadSegment { toggle }) => {
                    let next = upload.on_request(toggle, objects);
                    self.history.uploaded(&next);
                    next
                }
                (Transfer::Download(download), Request::DownloadSegment(segment)) => {
                    download.on_segment(now, segment, objects)
                }
                (Transfer::BlockUpload(upload), request) => {
                    if request == Request::EndBlockUpload {
                        if firmware.has(Fault::SdoDeafAfterBlockUpload) {
                            self.deaf_until = now + DEAF;
                        }
                        self.history.block_uploaded(upload.value(), firmware);
                    }
                    upload.on_request(request)
                }
                (Transfer::BlockDownloadEnd(end), Request::EndBlockDownload { unused, crc }) => {
                    end.on_end(now, unused, crc, objects)
                }
                (transfer, request) => {
                    self.spill(&transfer, &request, objects);
                    self.unexpected(&transfer, &request, objects)
                }
            },
        }
    }

    /// Writes the bytes of a misplaced segment, in a firmware that accepts such segments.
    fn spill(&mut self, transfer: &Transfer, request: &Request, objects: &mut Objects) {
        let Request::DownloadSegment(segment) = request else { return };
        if objects.has(Fault::SdoRefusedSegmentServed) {
            self.refused = segment.data().first_chunk().copied();
        }
        if let Transfer::Upload(upload) = transfer
            && objects.has(Fault::SdoSegmentWrittenInUpload)
            && let Ok(held) = objects.parameters.entry(upload.object)
        {
            let content = held.decode(segment.data());
            objects.parameters.set(upload.object, content);
        }
    }

    /// Handles a command specifier that is unknown, or not allowed at this point of the transfer.
    fn unexpected(&self, transfer: &Transfer, request: &Request, objects: &Objects) -> Next {
        if let Request::Unknown { .. } = request {
            let first = objects.has(Fault::SdoFirstUnknownCommandSilent) && !self.began;
            if first || objects.has(Fault::SdoUnknownCommandSilent) {
                return Next::silence(Transfer::Idle);
            }
        }
        let is_block = matches!(
            request,
            Request::StartBlockUpload
                | Request::ConfirmBlockUpload { .. }
                | Request::EndBlockUpload
                | Request::EndBlockDownload { .. }
        );
        if is_block && objects.has(Fault::SdoStrayBlockSilent) {
            return Next::silence(Transfer::Idle);
        }
        if !matches!(transfer, Transfer::Idle) && objects.has(Fault::SdoWrongCommandIgnored) {
            return Next::silence(transfer.clone());
        }
        let stray = matches!(request, Request::DownloadSegment(_) | Request::UploadSegment { .. });
        if stray && matches!(transfer, Transfer::Idle) && objects.has(Fault::SdoStraySegmentSilent) {
            return Next::silence(Transfer::Idle);
        }
        // An abort names the object of the request, if the request names one, even if another transfer was open.
        let named = request.multiplexer().or(transfer.object()).or(match *request {
            Request::Unknown { tail: [low, high, sub, ..], .. } => Some(Multiplexer::from_bytes([low, high, sub])),
            _ => None,
        });
        Next::abort(named.unwrap_or(Multiplexer::new(0, 0)), AbortCode::COMMAND_SPECIFIER)
    }

    /// Enters the next state of the transfer and queues the answer.
    fn proceed(&mut self, now: Timestamp, next: Next, objects: &Objects) {
        self.transfer = next.transfer;
        self.expires = match self.transfer {
            Transfer::Idle => Timestamp::MAX,
            Transfer::Download(_) if objects.has(Fault::SdoOpenDownloadSurvivesReset) => Timestamp::MAX,
            _ => now + self.timing.sdo_timeout(),
        };
        let due = self.due(now, objects);
        match next.answer {
            Answer::Silence => {}
            Answer::Response(response) => self.answer(due, response, objects),
            Answer::Segments(segments) => {
                for segment in segments {
                    let mut bytes = [0; 8];
                    let len = segment.emit(&mut bytes);
                    self.answers.push_back((due, bytes, len));
                }
            }
        }
    }

    /// Puts the object of a new request into a waiting answer, in a firmware with one buffer for requests.
    fn mix_up(&mut self, frame: &Frame, objects: &Objects) {
        if objects.has(Fault::SdoBackToBackMixed)
            && let Some((_, waiting, _)) = self.answers.back_mut()
        {
            waiting[1..4].copy_from_slice(&frame.bytes()[1..4]);
        }
    }

    /// The time of the answer to a request received now. The server processes requests one after the other.
    fn due(&mut self, now: Timestamp, objects: &Objects) -> Timestamp {
        let free = self.answers.back().map_or(now, |(due, ..)| now.max(*due));
        let storing = objects.written.iter().any(|(at, _)| objects.takes_long(*at));
        let slow = self.requests.is_multiple_of(SLOW_EVERY) && objects.has(Fault::SdoResponseSlow);
        let extra = match (storing, slow) {
            (true, _) => self.timing.store(),
            (_, true) => SLOW,
            _ => Duration::ZERO,
        };
        let jitter = self.chance.below(self.timing.sdo_response_jitter_us);
        free + self.timing.sdo_response() + Duration::from_micros(jitter) + extra
    }

    fn answer(&mut self, due: Timestamp, response: Response, objects: &Objects) {
        let firmware = &objects.firmware;
        let response = match response {
            Response::Abort(abort) if abort.code == AbortCode::NO_OBJECT && firmware.has(Fault::SdoNoObjectSilent) => {
                return;
            }
            Response::Abort(abort) => {
                let named = match () {
                    () if firmware.has(Fault::SdoStaleMultiplexer) => self.stale,
                    () if firmware.has(Fault::SdoAbortMultiplexerZero) => Multiplexer::new(0, 0),
                    () => abort.multiplexer,
                };
                Response::abort(named, firmware.abort_code(abort.code))
            }
            response => self.replaced(response),
        };
        if let Some(object) = response.multiplexer() {
            self.stale = object;
        }
        let mut bytes = [0; 8];
        let mut len = response.emit(&mut bytes);
        let used = used_bytes(&response);
        if firmware.has(Fault::SdoUnusedBytesNotZero) {
            bytes.iter_mut().skip(used).for_each(|byte| *byte = 0xA5);
        }
        if firmware.has(Fault::SdoShortResponse) {
            len = used;
        }
        self.answers.push_back((due, bytes, len));
    }

    /// Replaces a value of four bytes by the bytes of a refused segment, in a firmware that has kept such bytes.
    fn replaced(&mut self, response: Response) -> Response {
        match response {
            Response::InitiateUpload { multiplexer, payload: Payload::Expedited(value) } if value.data().len() == 4 => {
                let value = self.refused.take().and_then(|bytes| Expedited::new(&bytes)).unwrap_or(value);
                Response::InitiateUpload { multiplexer, payload: Payload::Expedited(value) }
            }
            response => response,
        }
    }

    /// The next ready answer as a frame.
    pub fn poll(&mut self, now: Timestamp, node: NodeId) -> Option<Frame> {
        let &(due, bytes, len) = self.answers.front()?;
        if now < due {
            return None;
        }
        debug_assert!(len <= 8, "an SDO message has at most 8 bytes, found {len}");
        self.answers.pop_front();
        let id = CanId::standard_masked(u32::from(canvass_analyzer::wire::sdo::RESPONSE_BASE) + u32::from(node.raw()));
        match len {
            8 => Some(Frame::full(id, bytes)),
            len => Frame::new(id, bytes.get(..len).unwrap_or(&bytes)),
        }
    }

    /// Ends the transfer if its client stayed silent too long.
    pub fn expire(&mut self, now: Timestamp, objects: &Objects) {
        if now < self.expires {
            return;
        }
        let transfer = std::mem::replace(&mut self.transfer, Transfer::Idle);
        self.expires = Timestamp::MAX;
        if objects.has(Fault::SdoTimeoutWedges) {
            self.wedged = true;
            return;
        }
        if let Some(object) = transfer.object().filter(|_| !objects.takes(Liberty::TimeoutWithoutAbort)) {
            self.answer(now, Response::abort(object, AbortCode::TIMEOUT), objects);
        }
    }
}

/// A firmware with delayed responses answers one of this many requests late, after [`SLOW`].
const SLOW_EVERY: u32 = 150;
const SLOW: Duration = Duration::from_millis(1_200);

/// Time after a block upload in which a firmware that is busy with it ignores requests.
const DEAF: Duration = Duration::from_millis(3);

/// A firmware that loses responses leaves one of this many requests unanswered.
const LOST_EVERY: u32 = 100;

/// Number of bytes of a response that are not reserved.
fn used_bytes(response: &Response) -> usize {
    match response {
        Response::UploadSegment(segment) => 1 + segment.data().len(),
        Response::DownloadSegment { .. } | Response::EndBlockDownload => 1,
        Response::InitiateDownload { .. } => 4,
        Response::InitiateUpload { payload: Payload::Expedited(value), .. } => 4 + value.data().len(),
        Response::InitiateUpload { payload: Payload::SegmentedUnsized, .. } => 4,
        Response::InitiateBlockDownload { .. } => 5,
        Response::ConfirmBlockDownload { .. } | Response::EndBlockUpload { .. } => 3,
        _ => 8,
    }
}

/// Whether the command byte of the request has reserved bits set.
fn has_reserved_bits(frame: &Frame, request: &Request) -> bool {
    let mut plain = [0; 8];
    request.emit(&mut plain);
    !matches!(request, Request::Abort(_)) && frame.bytes()[0] != plain[0]
}
