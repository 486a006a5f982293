//! A correct SDO client that checks each response against the state of the transfer.
//!
//! The client does expedited and segmented transfers; block transfers are in [`super::block_upload`] and
//! [`super::block_download`].

use super::limit::{Bound, Excess, UploadLimit};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{Abort, AbortCode, Payload, Request, Response, response};
use canvass_analyzer::wire::sdo::{Expedited, Segment};
use canvass_traces::{Duration, Frame, Timestamp, hex};
use std::fmt;

/// One transfer, seen by the client.
#[derive(Clone, Debug)]
pub struct Transfer {
    multiplexer: Multiplexer,
    state: ClientState,
    /// The limit, if the transfer is an upload.
    limit: UploadLimit,
}

#[derive(Clone, Debug)]
enum ClientState {
    AwaitUpload,
    UploadSegments { data: Vec<u8>, announced: Option<u32>, toggle: bool },
    AwaitDownload { pending: Option<Vec<u8>> },
    DownloadSegments { data: Vec<u8>, sent: usize, toggle: bool },
}

/// The form of a download; CiA 301 leaves the choice to the client.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mode {
    /// Expedited up to four bytes, otherwise segmented; an empty value is segmented.
    Shortest,
    /// Always segmented, with the size announced.
    Segmented,
}

/// The connection to an SDO server: a bus in commands, the bench in cases.
pub trait ServerLine {
    /// The error of sending or receiving.
    type Error;

    /// The time on the bus.
    fn now(&self) -> Timestamp;

    /// Sends a request.
    ///
    /// # Errors
    /// If the request could not be sent.
    fn send(&mut self, request: &Request) -> Result<(), Self::Error>;

    /// The next frame of the server; `None` if the timeout passes.
    ///
    /// # Errors
    /// If the bus can't receive.
    fn receive(&mut self) -> Result<Option<Frame>, Self::Error>;
}

/// The client's reaction to a response.
#[derive(Debug)]
pub enum Reaction {
    /// Send this request and wait for the next response.
    Send(Request),
    /// The transfer has ended.
    Done(Outcome),
}

/// The outcome of a transfer.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// The uploaded value.
    Uploaded(Vec<u8>),
    /// The server confirmed the whole download.
    Downloaded,
    /// The server aborted the transfer.
    Aborted(Abort),
    /// No response came before the timeout.
    Silent,
    /// The response violates the protocol.
    Violated(Violation),
    /// The client aborted an upload that exceeded its limit.
    Exceeded(Excess),
}

impl Outcome {
    /// The abort code of the client, unless the server ended the transfer.
    pub const fn own_abort(&self) -> Option<AbortCode> {
        match self {
            Self::Silent => Some(AbortCode::TIMEOUT),
            Self::Violated(_) => Some(AbortCode::GENERAL),
            Self::Exceeded(_) => Some(AbortCode::OUT_OF_MEMORY),
            Self::Uploaded(_) | Self::Downloaded | Self::Aborted(_) => None,
        }
    }
}

/// A violation of the protocol by a server.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Violation {
    /// A response to another service than requested.
    Unexpected(Response),
    /// A response too short for its content.
    Malformed(String),
    /// The response names another object.
    Multiplexer(Multiplexer),
    /// The toggle bit did not alternate.
    Toggle,
    /// The number of bytes differs from the announced one.
    Size {
        /// The number in the first response.
        announced: u32,
        /// The number received.
        received: usize,
    },
    /// The server continues the transfer without end.
    Endless,
    /// A segment of a block has an unexpected sequence number.
    Sequence {
        /// The expected number.
        expected: u8,
        /// The received number.
        found: u8,
    },
    /// The server confirms segments that were not sent, or requests them again without end.
    Confirmation {
        /// Number of segments in the block.
        sent: u8,
        /// The last segment that the server confirms.
        confirmed: u8,
    },
    /// An invalid block size: 0, or more than 127.
    BlockSize(u8),
    /// The checksum does not match the data.
    Checksum {
        /// The checksum of the data.
        computed: u16,
        /// The checksum of the server.
        found: u16,
    },
}

impl Transfer {
    /// Starts to read an object; returns the first request.
    pub fn upload(multiplexer: Multiplexer) -> (Self, Request) {
        Self::upload_within(multiplexer, UploadLimit::default())
    }

    /// Starts to read an object like [`Transfer::upload`], but with a limit; a longer upload ends in
    /// [`Outcome::Exceeded`].
    pub fn upload_within(multiplexer: Multiplexer, limit: UploadLimit) -> (Self, Request) {
        (Self { multiplexer, state: ClientState::AwaitUpload, limit }, Request::upload(multiplexer))
    }

    /// Starts to write an object; returns the first request.
    pub fn download(multiplexer: Multiplexer, value: &[u8], mode: Mode) -> (Self, Request) {
        let payload = match mode {
            Mode::Shortest => Payload::of(value),
            Mode::Segmented => Payload::Segmented(u32::try_from(value.len()).unwrap_or(u32::MAX)),
        };
        let pending = matches!(payload, Payload::Segmented(_)).then(|| value.to_vec());
        let request = Request::InitiateDownload { multiplexer, payload };
        let limit = UploadLimit::default();
        (Self { multiplexer, state: ClientState::AwaitDownload { pending }, limit }, request)
    }

    /// The object of the transfer.
    pub const fn multiplexer(&self) -> Multiplexer {
        self.multiplexer
    }

    /// Sends `request` and all further messages until the transfer ends. The client aborts the transfer if the server
    /// is silent, violates the protocol or exceeds the limit of an upload.
    ///
    /// # Errors
    /// The errors of the line.
    pub fn carry_out<L: ServerLine>(mut self, mut request: Request, line: &mut L) -> Result<Outcome, L::Error> {
        let begun = line.now();
        let outcome = loop {
            line.send(&request)?;
            let Some(frame) = line.receive()? else { break Outcome::Silent };
            let reaction = match Response::read(frame.data()) {
                Ok(response) => self.handle(&response),
                Err(error) => Reaction::Done(Outcome::Violated(Violation::Malformed(error.to_string()))),
            };
            match reaction {
                Reaction::Send(next) => request = next,
                Reaction::Done(outcome) => break outcome,
            }
            if let Some(excess) = self.takes_too_long(line.now().since(begun)) {
                break Outcome::Exceeded(excess);
            }
        };
        if let Some(code) = outcome.own_abort() {
            line.send(&self.abort(code))?;
        }
        Ok(outcome)
    }

    /// Handles a response. [`Reaction::Done`] means that the transfer has ended; the caller should then answer a
    /// violation with [`Transfer::abort`].
    pub fn handle(&mut self, response: &Response) -> Reaction {
        if let Response::Abort(abort) = response {
            return Reaction::Done(Outcome::Aborted(*abort));
        }
        match std::mem::replace(&mut self.state, ClientState::AwaitUpload) {
            ClientState::AwaitUpload => self.on_upload(response),
            ClientState::UploadSegments { data, announced, toggle } => {
                self.on_segment(response, data, announced, toggle)
            }
            ClientState::AwaitDownload { pending } => self.on_download(response, pending),
            ClientState::DownloadSegments { data, sent, toggle } => self.on_confirmation(response, data, sent, toggle),
        }
    }

    /// The request by which the client aborts the transfer.
    pub const fn abort(&self, code: AbortCode) -> Request {
        Request::abort(self.multiplexer, code)
    }

    fn takes_too_long(&self, elapsed: Duration) -> Option<Excess> {
        let ClientState::UploadSegments { data, announced, .. } = &self.state else { return None };
        let excess = Excess { received: data.len(), announced: *announced, bound: Bound::Time(self.limit.time) };
        (elapsed > self.limit.time).then_some(excess)
    }

    /// The excess, if the received bytes or the announced size of an unfinished upload exceed the limit.
    fn has_too_many(&self, received: usize, announced: Option<u32>) -> Option<Excess> {
        let most = self.limit.bytes;
        let is_beyond = received > most || announced.is_some_and(|size| size as usize > most);
        is_beyond.then_some(Excess { received, announced, bound: Bound::Bytes(most) })
    }

    fn on_upload(&mut self, response: &Response) -> Reaction {
        let Response::InitiateUpload { multiplexer, payload } = response else {
            return violated(Violation::Unexpected(*response));
        };
        if *multiplexer != self.multiplexer {
            return violated(Violation::Multiplexer(*multiplexer));
        }
        if let Some(value) = payload.value() {
            return Reaction::Done(Outcome::Uploaded(value.to_vec()));
        }
        let announced = match payload {
            Payload::Segmented(size) => Some(*size),
            _ => None,
        };
        if let Some(excess) = self.has_too_many(0, announced) {
            return Reaction::Done(Outcome::Exceeded(excess));
        }
        self.state = ClientState::UploadSegments { data: Vec::new(), announced, toggle: false };
        Reaction::Send(Request::UploadSegment { toggle: false })
    }

    fn on_segment(&mut self, response: &Response, mut data: Vec<u8>, announced: Option<u32>, toggle: bool) -> Reaction {
        let Response::UploadSegment(segment) = response else {
            return violated(Violation::Unexpected(*response));
        };
        if segment.toggle != toggle {
            return violated(Violation::Toggle);
        }
        data.extend_from_slice(segment.data());
        let too_many = announced.is_some_and(|size| data.len() as u64 > u64::from(size));
        let mismatch = segment.last && announced.is_some_and(|size| data.len() as u64 != u64::from(size));
        if let (true, Some(announced)) = (too_many || mismatch, announced) {
            return violated(Violation::Size { announced, received: data.len() });
        }
        if segment.last {
            return Reaction::Done(Outcome::Uploaded(data));
        }
        if let Some(excess) = self.has_too_many(data.len(), announced) {
            return Reaction::Done(Outcome::Exceeded(excess));
        }
        self.state = ClientState::UploadSegments { data, announced, toggle: !toggle };
        Reaction::Send(Request::UploadSegment { toggle: !toggle })
    }

    fn on_download(&mut self, response: &Response, pending: Option<Vec<u8>>) -> Reaction {
        let Response::InitiateDownload { multiplexer } = response else {
            return violated(Violation::Unexpected(*response));
        };
        if *multiplexer != self.multiplexer {
            return violated(Violation::Multiplexer(*multiplexer));
        }
        match pending {
            None => Reaction::Done(Outcome::Downloaded),
            Some(data) => self.send_segment(data, 0, false),
        }
    }

    fn on_confirmation(&mut self, response: &Response, data: Vec<u8>, sent: usize, toggle: bool) -> Reaction {
        match response {
            Response::DownloadSegment { toggle: confirmed } if *confirmed == toggle => {}
            Response::DownloadSegment { .. } => return violated(Violation::Toggle),
            _ => return violated(Violation::Unexpected(*response)),
        }
        if sent >= data.len() { Reaction::Done(Outcome::Downloaded) } else { self.send_segment(data, sent, !toggle) }
    }

    fn send_segment(&mut self, data: Vec<u8>, from: usize, toggle: bool) -> Reaction {
        let to = data.len().min(from + 7);
        let Some(segment) = data.get(from..to).and_then(|part| Segment::new(toggle, part, to == data.len())) else {
            return violated(Violation::Endless);
        };
        self.state = ClientState::DownloadSegments { data, sent: to, toggle };
        Reaction::Send(Request::DownloadSegment(segment))
    }
}

fn violated(violation: Violation) -> Reaction {
    Reaction::Done(Outcome::Violated(violation))
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Uploaded(value) => write!(f, "the value {}", Bytes(value)),
            Self::Downloaded => f.write_str("confirmation"),
            Self::Aborted(abort) => write!(f, "abort {}", abort.code),
            Self::Silent => f.write_str("no answer"),
            Self::Violated(violation) => fmt::Display::fmt(violation, f),
            Self::Exceeded(excess) => fmt::Display::fmt(excess, f),
        }
    }
}

impl Violation {
    /// The name of the kind of violation, without its numbers, for patterns.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Unexpected(_) => "response",
            Self::Malformed(_) => "form",
            Self::Multiplexer(_) => "multiplexer",
            Self::Toggle => "toggle",
            Self::Size { .. } => "size",
            Self::Endless => "end",
            Self::Sequence { .. } => "sequence",
            Self::Confirmation { .. } => "acknowledgement",
            Self::BlockSize(_) => "block size",
            Self::Checksum { .. } => "CRC",
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unexpected(response) => write!(f, "{}, which was not requested", name(response)),
            Self::Malformed(why) => write!(f, "an unreadable response ({why})"),
            Self::Multiplexer(other) => write!(f, "a response that names {other}"),
            Self::Toggle => f.write_str("a toggle bit that does not alternate"),
            Self::Size { announced, received } => {
                write!(f, "{received} bytes, but {announced} announced")
            }
            Self::Sequence { expected, found } => write!(f, "segment {found}, expected {expected}"),
            Self::Confirmation { sent, confirmed } => {
                write!(f, "a confirmation of segment {confirmed}, after {sent} segments")
            }
            Self::BlockSize(size) => write!(f, "a block size of {size}"),
            Self::Checksum { computed, found } => write!(f, "the CRC {found:04X}h, expected {computed:04X}h"),
            Self::Endless => f.write_str("an upload that does not end"),
        }
    }
}

/// The name of a response in CiA 301.
pub const fn name(response: &Response) -> &'static str {
    use response::Response as R;
    match response {
        R::UploadSegment(_) => "an upload segment",
        R::DownloadSegment { .. } => "the confirmation of a download segment",
        R::InitiateUpload { payload: Payload::Expedited(_) | Payload::ExpeditedUnsized(_), .. } => {
            "an expedited upload response"
        }
        R::InitiateUpload { .. } => "the start of a segmented upload",
        R::InitiateDownload { .. } => "the confirmation of a download",
        R::Abort(_) => "an abort",
        R::InitiateBlockDownload { .. } => "the confirmation of a block download",
        R::ConfirmBlockDownload { .. } => "the confirmation of a block",
        R::EndBlockDownload => "the end of a block download",
        R::InitiateBlockUpload { .. } => "the start of a block upload",
        R::EndBlockUpload { .. } => "the end of a block upload",
        R::Unknown { .. } => "a response with an unknown command specifier",
    }
}

/// Bytes in hexadecimal, such as `01 7F`, with their number if there are many.
#[derive(Clone, Copy, Debug)]
pub struct Bytes<'a>(pub &'a [u8]);

impl fmt::Display for Bytes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 16;
        if self.0.is_empty() {
            return f.write_str("(empty)");
        }
        hex::spaced(&self.0[..self.0.len().min(SHOWN)]).fmt(f)?;
        if self.0.len() > SHOWN { write!(f, " … ({} bytes)", self.0.len()) } else { Ok(()) }
    }
}

/// The expedited download of `value`, for requests that a correct client would not send.
pub fn expedited(multiplexer: Multiplexer, value: &[u8]) -> Option<Request> {
    Expedited::new(value).map(|value| Request::InitiateDownload { multiplexer, payload: Payload::Expedited(value) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::object;
    use canvass_analyzer::wire::Wire;
    use proptest::prelude::*;

    const NAME: Multiplexer = Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0);

    fn respond(transfer: &mut Transfer, bytes: &[u8]) -> Reaction {
        transfer.handle(&Response::read(bytes).unwrap())
    }

    fn ended(step: Reaction) -> Outcome {
        match step {
            Reaction::Done(outcome) => outcome,
            Reaction::Send(request) => panic!("{request:?}"),
        }
    }

    /// Kübler manual 000, 5.3.7.4.2: the upload of 6000h.
    #[test]
    fn expedited_upload() {
        let (mut transfer, request) = Transfer::upload(Multiplexer::new(0x6000, 0));
        assert_eq!(request, Request::read(&[0x40, 0x00, 0x60, 0x00, 0, 0, 0, 0]).unwrap());
        let outcome = ended(respond(&mut transfer, &[0x4B, 0x00, 0x60, 0x00, 1, 0, 0, 0]));
        assert_eq!(outcome, Outcome::Uploaded(vec![1, 0]));
    }

    #[test]
    fn segmented_upload() {
        let (mut transfer, _) = Transfer::upload(NAME);
        assert!(matches!(respond(&mut transfer, &[0x41, 8, 0x10, 0, 9, 0, 0, 0]), Reaction::Send(_)));
        let step = respond(&mut transfer, &[0x00, b'K', b'u', b'e', b'b', b'l', b'e', b'r']);
        assert!(matches!(step, Reaction::Send(Request::UploadSegment { toggle: true })));
        let outcome = ended(respond(&mut transfer, &[0x1B, b' ', b'S', 0, 0, 0, 0, 0]));
        assert_eq!(outcome, Outcome::Uploaded(b"Kuebler S".to_vec()));
    }

    /// The excess of an upload under this limit, from a server that announces this size and sends segments of `each`
    /// bytes.
    fn endless(limit: UploadLimit, announced: Option<u32>, each: usize) -> Excess {
        struct Server {
            now: Timestamp,
            announced: Option<u32>,
            each: usize,
            answer: Option<Response>,
            aborts: Vec<AbortCode>,
        }
        impl ServerLine for Server {
            type Error = ();
            fn now(&self) -> Timestamp {
                self.now
            }
            fn send(&mut self, request: &Request) -> Result<(), ()> {
                let payload = self.announced.map_or(Payload::SegmentedUnsized, Payload::Segmented);
                self.answer = match *request {
                    Request::InitiateUpload { multiplexer } => Some(Response::InitiateUpload { multiplexer, payload }),
                    Request::UploadSegment { toggle } => {
                        Segment::new(toggle, &[7; 7][..self.each], false).map(Response::UploadSegment)
                    }
                    Request::Abort(abort) => {
                        self.aborts.push(abort.code);
                        None
                    }
                    _ => None,
                };
                Ok(())
            }
            fn receive(&mut self) -> Result<Option<Frame>, ()> {
                self.now += Duration::from_millis(2);
                Ok(self.answer.take().map(|response| response.to_frame(0x585)))
            }
        }
        let mut server = Server { now: Timestamp::ZERO, announced, each, answer: None, aborts: Vec::new() };
        let (transfer, request) = Transfer::upload_within(NAME, limit);
        let outcome = transfer.carry_out(request, &mut server).unwrap();
        assert_eq!(server.aborts, [AbortCode::OUT_OF_MEMORY], "the server is told");
        match outcome {
            Outcome::Exceeded(excess) => excess,
            other => panic!("{other}"),
        }
    }

    #[test]
    fn an_upload_without_end_has_one() {
        let limit = UploadLimit { bytes: 100, time: Duration::from_secs(1) };
        let told = |announced, each| endless(limit, announced, each).to_string();
        assert_eq!(told(None, 7), "upload ended after 105 bytes: expected at most 100 bytes");
        // The announced size need not be sent to exceed the limit.
        assert_eq!(told(Some(u32::MAX), 7), "upload ended after 0 of 4294967295 bytes: expected at most 100 bytes");
        assert_eq!(told(None, 0), "upload ended after 0 bytes: expected its end within 1 s");
        assert_eq!(told(Some(90), 0), "upload ended after 0 of 90 bytes: expected its end within 1 s");
    }

    #[test]
    fn what_is_as_long_as_the_limit_is_read() {
        let (mut transfer, _) = Transfer::upload_within(NAME, UploadLimit { bytes: 9, ..UploadLimit::default() });
        assert!(matches!(respond(&mut transfer, &[0x41, 8, 0x10, 0, 9, 0, 0, 0]), Reaction::Send(_)));
        respond(&mut transfer, &[0x00, b'K', b'u', b'e', b'b', b'l', b'e', b'r']);
        let outcome = ended(respond(&mut transfer, &[0x1B, b' ', b'S', 0, 0, 0, 0, 0]));
        assert_eq!(outcome, Outcome::Uploaded(b"Kuebler S".to_vec()));
    }

    #[test]
    fn what_does_not_fit_is_a_violation() {
        let start = || {
            let (mut transfer, _) = Transfer::upload(NAME);
            respond(&mut transfer, &[0x41, 8, 0x10, 0, 9, 0, 0, 0]);
            transfer
        };
        let violation = |bytes: &[u8]| match ended(respond(&mut start(), bytes)) {
            Outcome::Violated(violation) => violation,
            other => panic!("{other:?}"),
        };
        assert_eq!(violation(&[0x10, 0, 0, 0, 0, 0, 0, 0]), Violation::Toggle);
        assert_eq!(violation(&[0x0D, 1, 0, 0, 0, 0, 0, 0]), Violation::Size { announced: 9, received: 1 });
        assert!(matches!(violation(&[0x60, 8, 0x10, 0, 0, 0, 0, 0]), Violation::Unexpected(_)));
        let (mut transfer, _) = Transfer::upload(NAME);
        let outcome = ended(respond(&mut transfer, &[0x43, 0, 0x10, 0, 1, 2, 3, 4]));
        assert_eq!(outcome, Outcome::Violated(Violation::Multiplexer(Multiplexer::new(object::DEVICE_TYPE, 0))));
    }

    proptest! {
        /// A server that follows the protocol receives the downloaded value, whatever the length.
        #[test]
        fn a_download_arrives_whole(value in proptest::collection::vec(any::<u8>(), 0..40)) {
            let (mut transfer, mut request) = Transfer::download(NAME, &value, Mode::Segmented);
            let (mut received, mut toggle) = (Vec::new(), false);
            let outcome = loop {
                let response = match request {
                    Request::InitiateDownload { multiplexer, .. } => Response::InitiateDownload { multiplexer },
                    Request::DownloadSegment(segment) => {
                        prop_assert_eq!(segment.toggle, toggle);
                        received.extend_from_slice(segment.data());
                        toggle = !toggle;
                        Response::DownloadSegment { toggle: segment.toggle }
                    }
                    other => panic!("{other:?}"),
                };
                match transfer.handle(&response) {
                    Reaction::Send(next) => request = next,
                    Reaction::Done(outcome) => break outcome,
                }
            };
            prop_assert_eq!(outcome, Outcome::Downloaded);
            prop_assert_eq!(received, value);
        }

        /// No sequence of responses makes the client panic.
        #[test]
        fn any_responses(frames in proptest::collection::vec(any::<[u8; 8]>(), 0..6)) {
            let (mut transfer, _) = Transfer::upload(NAME);
            for frame in frames {
                transfer.handle(&Response::read(&frame).unwrap());
            }
        }
    }
}
