//! A model of the SDO server of CiA 301, seen from outside: the correct answers in each state.
//!
//! A request is first turned into the allowed answers ([`Awaited`]), and the actual answer is then compared with them.
//! The states are the states of the transfer, and each carries only its own data.

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
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{BlockSegment, Request};
use canvass_traces::{Duration, Frame, Timestamp};

/// Time after which a server may end a transfer whose client is silent (CiA 301, 7.2.4.3.17, abort 0504 0000h). The
/// server need not report it.
const LASTING: Duration = Duration::from_millis(400);

/// Maximum length of a value whose bytes are compared. Of a longer value only the length is judged.
const LONGEST: usize = 1 << 16;

/// The model of the server.
#[derive(Clone, Debug)]
pub(crate) struct Server {
    state: TransferState,
    awaited: Awaited,
    /// When the awaited answer is overdue.
    due: Timestamp,
    /// Whether a second request came before the answer to the first, so that the next answer can belong to either.
    overlapped: bool,
    /// Whether the last request has an optional answer, and the fuzzer has not waited for silence since then.
    unsettled: bool,
    grace: Timestamp,
    /// The NMT state is certain for requests from this time on: its last change is completed by then.
    settled: Timestamp,
    /// The time of the last message of the client or the server.
    last: Timestamp,
    /// The time of the last request that the server must not serve.
    unserved: Option<Timestamp>,
    /// The bytes of the running transfer.
    data: Vec<u8>,
    /// The state of the server at the last request, for the coverage.
    asked_in: Option<SdoState>,
    command: Command,
    /// The object that the last request named.
    named: Option<Multiplexer>,
    /// Whether the command of the last request had reserved bits set, so that the server may take it for an unknown
    /// command.
    odd: bool,
    /// The time at which the client last ended a transfer. The server may have given up the transfer at the same moment
    /// and report this a little later.
    ended: Option<Timestamp>,
}

/// The state of the transfer.
#[derive(Clone, Copy, PartialEq, Debug)]
enum TransferState {
    Idle,
    /// The server accepts segments.
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
    /// The server accepts the segments of a block.
    BlockDownload {
        at: Multiplexer,
        entry: Option<usize>,
        announced: Option<u32>,
        size: u8,
        sequence: u8,
        crc: bool,
        /// Whether a segment of this block was missing or came twice. The server may then confirm the segments before
        /// it ahead of the block's end.
        gap: bool,
    },
    /// The last segment has come. The client has to end the transfer.
    BlockDownloadEnd {
        at: Multiplexer,
        entry: Option<usize>,
        announced: Option<u32>,
        crc: bool,
    },
    /// The server waits for the start of the block upload.
    BlockUploadReady {
        at: Multiplexer,
        entry: Option<usize>,
        announced: Option<u32>,
        size: u8,
        crc: bool,
    },
    /// The server sends a block, or has sent its last segment and waits for the confirmation.
    BlockUpload(block::Upload),
    /// The server has announced the end of the transfer.
    BlockUploadEnd,
    /// Unknown, after a request that the standard does not describe.
    Unsure,
}

impl TransferState {
    /// Whether a block transfer is in progress whose next message is no segment.
    const fn is_block(self) -> bool {
        matches!(
            self,
            Self::BlockDownloadEnd { .. } | Self::BlockUploadReady { .. } | Self::BlockUpload(_) | Self::BlockUploadEnd
        )
    }

    /// The state for the coverage. `None` if the state is not known, so that nothing is counted.
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

    /// Handles a reset of the device: the server begins anew.
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

    /// Handles a sign that a device which counted as booting has booted. The device may serve a request from just
    /// before, which came while its boot-up message waited for the bus.
    pub fn booted(&mut self, now: Timestamp, grace: Duration) {
        if self.unserved.take().is_some_and(|asked| now < asked + grace) {
            self.state = TransferState::Unsure;
            self.awaited = Awaited::Anything;
        }
    }

    /// Handles a change of the NMT state. Responses that were on their way may still come for `grace`, unless no
    /// request came for `quiet`. Later requests belong to the new state.
    pub(crate) fn state_changed(&mut self, now: Timestamp, served: Served, grace: Duration, quiet: Duration) {
        match served {
            Served::No => {
                self.reset();
                (self.grace, self.settled) = (now + grace, now + quiet);
            }
            // A transfer under way may go on.
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

    /// The state for the coverage.
    pub fn class(&self) -> Option<SdoState> {
        self.state.class()
    }

    fn count(&self, coverage: &mut Coverage, answer: Answer) {
        if let Some(state) = self.asked_in {
            coverage.sdo(state, self.command, answer);
        }
    }

    /// The time at which the awaited answer is overdue.
    pub fn due(&self) -> Option<Timestamp> {
        (self.due < Timestamp::MAX).then_some(self.due)
    }

    /// Applies a request of the client. `true`: the models can't follow its effect.
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
        // The answer to a store command may take seconds, longer than the required silence.
        let was_storing = self.written_object().is_some_and(|at| knowledge.stores(at));
        let may_come = matches!(self.awaited, Awaited::ConfirmBlock { required: false, .. });
        let unsettled = std::mem::replace(&mut self.unsettled, true);
        self.overlapped |= self.due < Timestamp::MAX || self.awaited.is_open() || may_come && unsettled;
        let was_running = self.state != TransferState::Idle;
        let mut awaited = self.judge_request(frame, knowledge, expected_values);
        if was_running && frame.len() == 8 && self.named.is_some() {
            self.ended = Some(now);
        }
        if self.overlapped {
            // The server decides whether it answers the first request or drops it for the second.
            self.state = TransferState::Unsure;
            awaited = Awaited::Anything;
        }
        if !awaited.is_required() {
            self.count(coverage, Answer::None);
        }
        self.await_answer(now, awaited, knowledge);
        awaited == Awaited::Anything && (stores(frame, knowledge) || was_storing)
    }

    /// The object whose write is not confirmed yet.
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
    pub(crate) fn is_in_blocks(&self) -> bool {
        matches!(self.state, TransferState::Unsure | TransferState::BlockDownload { .. })
    }

    /// The rule of the answer that the server owes now, if it owes one.
    pub(crate) fn awaits(&self) -> Option<&'static str> {
        self.awaited.is_required().then(|| self.awaited.rule())
    }

    /// Whether a transfer is in progress whose value may already have been read.
    pub fn is_busy(&self) -> bool {
        self.awaited != Awaited::Nothing || self.state != TransferState::Idle
    }

    /// Whether the server is sending the segments of a block.
    pub(crate) fn is_sending_blocks(&self) -> bool {
        matches!(self.state, TransferState::BlockUpload(_) | TransferState::Unsure)
    }

    /// Whether a value without confirmation may already have been written.
    pub(crate) fn is_writing(&self) -> bool {
        self.overlapped
            || matches!(
                self.awaited,
                Awaited::Anything
                    | Awaited::Write { .. }
                    | Awaited::ConfirmSegment { last: Some(_), .. }
                    | Awaited::ConfirmEnd { .. }
            )
    }

    /// Whether one of the objects may already have been written without confirmation.
    pub(crate) fn may_move(&self, objects: &[Multiplexer]) -> bool {
        match self.awaited {
            _ if self.overlapped => !objects.is_empty(),
            Awaited::Anything => !objects.is_empty(),
            _ => self.written_object().is_some_and(|at| objects.contains(&at)),
        }
    }

    /// Whether it is not known which answer comes next, nor whether a transfer is in progress.
    pub fn is_lost(&self) -> bool {
        matches!(self.state, TransferState::Unsure | TransferState::Idle) && self.is_open()
    }

    /// Whether the server may answer but need not.
    pub fn is_open(&self) -> bool {
        self.overlapped || self.awaited.is_open()
    }

    /// Handles the end of the required silence: the server answers no earlier request any more.
    pub const fn quiet(&mut self) {
        self.overlapped = false;
        self.unsettled = false;
        if matches!(self.awaited, Awaited::Anything | Awaited::AbortOrIgnored) {
            self.awaited = Awaited::Nothing;
        }
    }

    /// Determines the allowed answers to a request, and the state of the server after it.
    fn judge_request(&mut self, frame: &Frame, knowledge: &Knowledge, expected_values: &mut ExpectedValues) -> Awaited {
        if frame.len() != 8 {
            // The standard defines messages of eight bytes only, so the effect of another length is unknown.
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
            // The standard leaves open whether a frame with reserved bits set counts as an abort.
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
            // The server may take the frame for a segment of a block download that the model does not know of. The
            // answer shows this.
            return Awaited::Anything;
        }
        if self.state.is_block() && initiates(&request) {
            // Only the last segment and an abort end a block transfer (CiA 301, 7.2.4.3.8 and 7.2.4.3.12). The server
            // may begin a new transfer or refuse it.
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

    /// Ends the transfer, which the server has to abort. Returns the required abort.
    fn refuse(&mut self, codes: CodeSet, why: &'static str, expected_values: &mut ExpectedValues) -> Awaited {
        self.give_up(expected_values);
        Awaited::Abort { codes, at: None, why }
    }

    /// Ends the transfer. An unfinished download has no effect.
    fn give_up(&mut self, expected_values: &mut ExpectedValues) {
        if let TransferState::Download { entry, .. }
        | TransferState::BlockDownload { entry, .. }
        | TransferState::BlockDownloadEnd { entry, .. } = self.state
        {
            expected_values.aborted = entry;
        }
        self.state = TransferState::Idle;
    }

    /// Checks whether an answer is overdue.
    ///
    /// # Errors
    /// [`Violation`] if an answer is due and has not come.
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

/// Whether reserved bits of the command are set.
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

/// Whether the request, or the transfer that it begins, may store parameters. The device may be silent for long then.
fn stores(frame: &Frame, knowledge: &Knowledge) -> bool {
    let [command, low, high, sub, ..] = frame.bytes();
    let at = Multiplexer::from_bytes([low, high, sub]);
    knowledge.stores(at) && matches!(command >> 5, 1 | 6)
}
