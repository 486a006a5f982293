//! The SDO server as CiA 301 demands it, seen from outside: which answers are right in which state.
//!
//! A request is first turned into what is awaited ([`Awaited`]); the answer is then compared with it. States are those
//! of the transfer; a state carries only what it knows.

mod awaited;
mod block;
mod initiate;
mod response;
mod segment;

use super::codes::{self, CodeSet};
use super::expected_values::ExpectedValues;
use super::{Served, Violation, silence};
use crate::Knowledge;
use crate::coverage::{Answer, Command, Coverage, SdoState};
use crate::property::Property;
use awaited::Awaited;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{BlockSegment, Request};
use canvass_traces::{Duration, Frame, Timestamp};

/// A transfer whose client says nothing for that time may be over (CiA 301, 7.2.4.3.17, abort 0504 0000h); the server need
/// not say so.
const LASTING: Duration = Duration::from_millis(400);

/// The longest value whose bytes are followed; of longer ones only the length is judged.
const LONGEST: usize = 1 << 16;

/// The server.
#[derive(Clone, Debug)]
pub(crate) struct Server {
    state: TransferState,
    awaited: Awaited,
    /// When the awaited answer is overdue.
    due: Timestamp,
    /// A second request was sent before the first was answered: what comes now can belong to either.
    overlapped: bool,
    /// Nobody has waited since the last request for an answer that need not come.
    unsettled: bool,
    grace: Timestamp,
    /// From then on a request comes when the last change of state has been done long since.
    settled: Timestamp,
    /// When the client or the server said something last.
    last: Timestamp,
    /// When the last request came that was not due to be served.
    unserved: Option<Timestamp>,
    /// The bytes of the running transfer.
    data: Vec<u8>,
    /// For coverage: where the request found the server.
    asked_in: Option<SdoState>,
    command: Command,
    /// The object that the last request named.
    named: Option<Multiplexer>,
    /// Reserved bits of the last request's command were set: it may be taken for one that does not exist.
    odd: bool,
    /// When the client ended a transfer last: the server may have given it up at that moment, and says so a little later.
    ended: Option<Timestamp>,
}

/// The state of the transfer.
#[derive(Clone, Copy, PartialEq, Debug)]
enum TransferState {
    Idle,
    /// The server takes segments.
    Download {
        at: Multiplexer,
        entry: Option<usize>,
        toggle: bool,
        announced: Option<u32>,
    },
    /// The server sends segments.
    Upload {
        at: Multiplexer,
        entry: Option<usize>,
        toggle: bool,
        announced: Option<u32>,
    },
    /// The server takes the segments of a block.
    BlockDownload {
        at: Multiplexer,
        entry: Option<usize>,
        announced: Option<u32>,
        size: u8,
        sequence: u8,
        crc: bool,
        /// A segment of this block was missing or came twice: the server may confirm what it has before the block's end.
        gap: bool,
    },
    /// The last segment has come; the end of the transfer follows.
    BlockDownloadEnd {
        at: Multiplexer,
        entry: Option<usize>,
        announced: Option<u32>,
        crc: bool,
    },
    /// The server waits for the start.
    BlockUploadReady {
        at: Multiplexer,
        entry: Option<usize>,
        announced: Option<u32>,
        size: u8,
        crc: bool,
    },
    /// The server sends a block, or waits for its confirmation once it has sent the last segment of it.
    BlockUpload(block::Upload),
    /// The server has announced the end.
    BlockUploadEnd,
    /// Not known: after a request that the standard does not describe.
    Unsure,
}

impl TransferState {
    /// Whether a block transfer is under way whose next message is no segment.
    const fn is_block(self) -> bool {
        matches!(
            self,
            Self::BlockDownloadEnd { .. } | Self::BlockUploadReady { .. } | Self::BlockUpload(_) | Self::BlockUploadEnd
        )
    }

    /// For the statistics; `None`: nobody knows, and nothing is counted.
    const fn class(self) -> Option<SdoState> {
        Some(match self {
            Self::Unsure => return None,
            Self::Idle => SdoState::Idle,
            Self::Download { .. } => SdoState::Download,
            Self::Upload { .. } => SdoState::Upload,
            Self::BlockDownload { .. } => SdoState::BlockDownload,
            Self::BlockDownloadEnd { .. } => SdoState::BlockDownloadEnd,
            Self::BlockUploadReady { .. } => SdoState::BlockUploadReady,
            Self::BlockUpload(_) => SdoState::BlockUpload,
            Self::BlockUploadEnd => SdoState::BlockUploadEnd,
        })
    }
}

impl Server {
    pub fn new() -> Self {
        Self {
            state: TransferState::Idle,
            awaited: Awaited::Nothing,
            due: Timestamp::MAX,
            overlapped: false,
            unsettled: false,
            grace: Timestamp::ZERO,
            settled: Timestamp::ZERO,
            last: Timestamp::ZERO,
            unserved: None,
            data: Vec::with_capacity(256),
            asked_in: None,
            command: Command::Abort,
            named: None,
            odd: false,
            ended: None,
        }
    }

    /// The server was started anew.
    pub fn reset(&mut self) {
        self.state = TransferState::Idle;
        self.awaited = Awaited::Nothing;
        self.due = Timestamp::MAX;
        self.overlapped = false;
        self.grace = Timestamp::ZERO;
        self.unserved = None;
        self.ended = None;
        self.data.clear();
    }

    /// The device has shown another state than it was thought to be in: it has booted. A request of the moment before
    /// may have come when its boot-up message waited for the bus, and be served.
    pub fn booted(&mut self, now: Timestamp, grace: Duration) {
        if self.unserved.take().is_some_and(|asked| now < asked + grace) {
            self.state = TransferState::Unsure;
            self.awaited = Awaited::Anything;
        }
    }

    /// Another NMT state. Responses that were on their way already may still come for `grace`, unless nothing was asked for
    /// `quiet`: what is asked then is asked in the new state.
    pub fn state_changed(&mut self, now: Timestamp, served: Served, grace: Duration, quiet: Duration) {
        match served {
            Served::No => {
                self.reset();
                (self.grace, self.settled) = (now + grace, now + quiet);
            }
            // What was under way may go on.
            Served::Unsure => {
                self.reset();
                (self.state, self.awaited) = (TransferState::Unsure, Awaited::Anything);
            }
            Served::Yes if self.awaited != Awaited::Nothing => {
                (self.awaited, self.due) = (Awaited::Anything, Timestamp::MAX);
            }
            Served::Yes => {}
        }
    }

    /// The state, for the statistics.
    pub fn class(&self) -> Option<SdoState> {
        self.state.class()
    }

    fn count(&self, coverage: &mut Coverage, answer: Answer) {
        if let Some(state) = self.asked_in {
            coverage.sdo(state, self.command, answer);
        }
    }

    /// When the awaited answer is overdue.
    pub fn due(&self) -> Option<Timestamp> {
        (self.due < Timestamp::MAX).then_some(self.due)
    }

    /// A request of the client. `true`: what it does can't be followed.
    pub fn asked(
        &mut self,
        now: Timestamp,
        frame: &Frame,
        served: Served,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
        coverage: &mut Coverage,
    ) -> bool {
        if self.state != TransferState::Idle && now.since(self.last) >= LASTING {
            self.state = TransferState::Unsure;
        }
        self.last = now;
        self.asked_in = self.class();
        self.command = Command::of(frame, matches!(self.state, TransferState::BlockDownload { .. }));
        match served {
            Served::Yes => {}
            Served::No => {
                if self.unserved.is_none() && now >= self.settled {
                    self.grace = Timestamp::ZERO;
                }
                self.unserved = Some(now);
                return false;
            }
            Served::Unsure => {
                self.state = TransferState::Unsure;
                self.await_answer(now, Awaited::Anything, knowledge);
                return stores(frame, knowledge);
            }
        }
        // The answer to a store may take seconds, however long silence lasts.
        let was_storing = self.written_object().is_some_and(|at| is_store(at, knowledge));
        let may_come = matches!(self.awaited, Awaited::ConfirmBlock { required: false, .. });
        let unsettled = std::mem::replace(&mut self.unsettled, true);
        self.overlapped |= self.due < Timestamp::MAX || self.awaited.is_open() || may_come && unsettled;
        let was_running = self.state != TransferState::Idle;
        let mut awaited = self.judge_request(frame, knowledge, expected_values);
        if was_running && frame.len() == 8 && self.named.is_some() {
            self.ended = Some(now);
        }
        if self.overlapped {
            // Whether the first request is answered, or given up for the second, is left to the server.
            self.state = TransferState::Unsure;
            awaited = Awaited::Anything;
        }
        if !awaited.is_required() {
            self.count(coverage, Answer::None);
        }
        self.await_answer(now, awaited, knowledge);
        awaited == Awaited::Anything && (stores(frame, knowledge) || was_storing)
    }

    /// The object whose writing awaits its confirmation.
    const fn written_object(&self) -> Option<Multiplexer> {
        match self.awaited {
            Awaited::Write { at, .. }
            | Awaited::ConfirmSegment { last: Some((at, _)), .. }
            | Awaited::ConfirmEnd { at, .. } => Some(at),
            _ => None,
        }
    }

    fn await_answer(&mut self, now: Timestamp, awaited: Awaited, knowledge: &Knowledge) {
        self.due = if awaited.is_required() { now + knowledge.patience.answer } else { Timestamp::MAX };
        self.awaited = awaited;
    }

    /// Whether the next frame is, or may be, taken for a segment of a block download.
    pub fn is_in_blocks(&self) -> bool {
        matches!(self.state, TransferState::Unsure | TransferState::BlockDownload { .. })
    }

    /// What has to be answered now.
    pub fn awaits(&self) -> Option<&'static str> {
        self.awaited.is_required().then(|| self.awaited.rule())
    }

    /// Whether a value is on its way that may be read already.
    pub fn is_busy(&self) -> bool {
        self.awaited != Awaited::Nothing || self.state != TransferState::Idle
    }

    /// Whether segments of a block come one after the other.
    pub fn is_sending_blocks(&self) -> bool {
        matches!(self.state, TransferState::BlockUpload(_) | TransferState::Unsure)
    }

    /// Whether a value is on its way that may be written already.
    pub fn is_writing(&self) -> bool {
        self.overlapped
            || matches!(
                self.awaited,
                Awaited::Anything
                    | Awaited::Write { .. }
                    | Awaited::ConfirmSegment { last: Some(_), .. }
                    | Awaited::ConfirmEnd { .. }
            )
    }

    /// Whether one of these objects may be written already, though nothing has confirmed it.
    pub fn may_move(&self, objects: &[Multiplexer]) -> bool {
        match self.awaited {
            _ if self.overlapped => !objects.is_empty(),
            Awaited::Anything => !objects.is_empty(),
            _ => self.written_object().is_some_and(|at| objects.contains(&at)),
        }
    }

    /// Whether nobody knows what comes next, nor whether a transfer is under way.
    pub fn is_lost(&self) -> bool {
        matches!(self.state, TransferState::Unsure | TransferState::Idle) && self.is_open()
    }

    /// Whether the server may answer but need not.
    pub fn is_open(&self) -> bool {
        self.overlapped || self.awaited.is_open()
    }

    /// Nothing has come for a while: no answer to an earlier request is under way.
    pub const fn quiet(&mut self) {
        self.overlapped = false;
        self.unsettled = false;
        if matches!(self.awaited, Awaited::Anything | Awaited::AbortOrIgnored) {
            self.awaited = Awaited::Nothing;
        }
    }

    /// What the server has to answer, and in which state the request leaves it meanwhile.
    fn judge_request(&mut self, frame: &Frame, knowledge: &Knowledge, expected_values: &mut ExpectedValues) -> Awaited {
        if frame.len() != 8 {
            // The standard knows only messages of eight bytes; what a server makes of others is its own affair.
            self.state = TransferState::Unsure;
            return Awaited::Anything;
        }
        if let TransferState::BlockDownload { .. } = self.state
            && frame.data().first() != Some(&0x80)
        {
            let Ok(segment) = BlockSegment::read(frame.data()) else { return Awaited::Anything };
            return self.block_segment(segment, knowledge);
        }
        if let [0x81..=0x9F, ..] = frame.data() {
            // An abort whose reserved bits are set: whether it is one, the standard leaves open.
            self.give_up(expected_values);
            self.state = TransferState::Unsure;
            return Awaited::Anything;
        }
        let Ok(request) = Request::read(frame.data()) else { return Awaited::Anything };
        self.named = request.multiplexer();
        self.odd = has_reserved_bits(frame, &request);
        if self.named.is_some() && self.awaited == Awaited::Nothing {
            expected_values.resume();
        }
        if self.state == TransferState::Unsure && frame.bytes()[0] != 0x80 {
            // It may be taken for the segment of a block download that nobody knows of. The answer tells.
            return Awaited::Anything;
        }
        if self.state.is_block() && initiates(&request) {
            // Only the last segment and an abort end a block transfer (CiA 301, 7.2.4.3.8 and 7.2.4.3.12): a new transfer may
            // begin, or be refused.
            self.give_up(expected_values);
            self.state = TransferState::Unsure;
            return Awaited::Anything;
        }
        match request {
            Request::InitiateUpload { multiplexer } => self.begin_upload(multiplexer, knowledge),
            Request::InitiateDownload { multiplexer, payload } => {
                self.begin_download(multiplexer, payload, frame, knowledge, expected_values)
            }
            Request::InitiateBlockUpload { multiplexer, block_size, threshold, crc } => {
                self.begin_block_upload(multiplexer, block_size, threshold, crc, knowledge)
            }
            Request::InitiateBlockDownload { multiplexer, size, crc } => {
                self.begin_block_download(multiplexer, size, crc, knowledge)
            }
            Request::DownloadSegment(segment) => self.download_segment(segment, knowledge, expected_values),
            Request::UploadSegment { toggle } => self.upload_segment(toggle),
            Request::Abort(_) => {
                self.give_up(expected_values);
                Awaited::Nothing
            }
            Request::StartBlockUpload => self.start_block_upload(),
            Request::ConfirmBlockUpload { sequence, block_size } => self.confirm_block_upload(sequence, block_size),
            Request::EndBlockUpload => self.end_block_upload(),
            Request::EndBlockDownload { unused, crc } => {
                self.end_block_download(unused, crc, knowledge, expected_values)
            }
            Request::Unknown { .. } => {
                self.refuse(codes::COMMAND, "a command specifier that does not exist", expected_values)
            }
        }
    }

    /// The transfer ends in an abort.
    fn refuse(&mut self, codes: CodeSet, why: &'static str, expected_values: &mut ExpectedValues) -> Awaited {
        self.give_up(expected_values);
        Awaited::Abort { codes, at: None, why }
    }

    /// The transfer ends; a download has no effect.
    fn give_up(&mut self, expected_values: &mut ExpectedValues) {
        if let TransferState::Download { entry, .. }
        | TransferState::BlockDownload { entry, .. }
        | TransferState::BlockDownloadEnd { entry, .. } = self.state
        {
            expected_values.aborted = entry;
        }
        self.state = TransferState::Idle;
    }

    /// An answer is overdue.
    ///
    /// # Errors
    /// [`Violation`]: silence where an answer is due.
    pub fn expire(&mut self, now: Timestamp) -> Result<(), Violation> {
        if now < self.due {
            return Ok(());
        }
        let expected = self.awaited.text();
        let rule = self.awaited.rule();
        self.reset();
        Err(silence(Property::LegalSdo, rule, expected, now))
    }
}

/// Whether bits of the command are set that the standard has 0 in that request.
fn has_reserved_bits(frame: &Frame, request: &Request) -> bool {
    let mut plain = [0; 8];
    request.emit(&mut plain);
    let [command, ..] = frame.bytes();
    !matches!(request, Request::Abort(_)) && command != plain[0]
}

/// Whether a request begins a transfer.
const fn initiates(request: &Request) -> bool {
    matches!(
        request,
        Request::InitiateUpload { .. }
            | Request::InitiateDownload { .. }
            | Request::InitiateBlockUpload { .. }
            | Request::InitiateBlockDownload { .. }
    )
}

/// Whether the request, or the transfer that it begins, may store: the device may be silent for long then.
fn stores(frame: &Frame, knowledge: &Knowledge) -> bool {
    let [command, low, high, sub, ..] = frame.bytes();
    let at = Multiplexer::from_bytes([low, high, sub]);
    is_store(at, knowledge) && matches!(command >> 5, 1 | 6)
}

/// Whether writing that object stores.
fn is_store(at: Multiplexer, knowledge: &Knowledge) -> bool {
    matches!(at.index.0, object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS)
        || knowledge.services.bus_save_object == Some(at)
}
