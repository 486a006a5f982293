//! A block upload (CiA 301, 7.2.4.3.12 to 7.2.4.3.15) by a client that checks every response, and that can
//! deliberately behave as if segments were lost.

use super::sdo::{Outcome, Violation};
use super::{BlockStep, BlockTransfer, Message, UploadLimit};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{AbortCode, BlockSegment, Payload, Request, Response, Segment, crc16};

/// The behaviour of the client.
#[derive(Clone, Debug)]
pub struct UploadManner {
    /// Block sizes: one for each block; the last one applies to all further blocks.
    pub block_sizes: Vec<u8>,
    /// Whether the client can check a CRC.
    pub crc: bool,
    /// The protocol switch threshold in bytes; 0: never switch.
    pub threshold: u8,
    /// A block (counted from 0) and a segment number: once, the client confirms the segments of this block only up to
    /// this number, as if the later segments had been lost.
    pub lose_after: Option<(usize, u8)>,
    /// A block (counted from 0) and a segment number: the client confirms this block with this number, whatever
    /// segments the client has received.
    pub confirm: Option<(usize, u8)>,
    /// Whether the client leaves the end of the upload unanswered.
    pub no_end: bool,
}

impl Default for UploadManner {
    fn default() -> Self {
        let block_sizes = vec![BlockSegment::MAX];
        Self { block_sizes, crc: true, threshold: 0, lose_after: None, confirm: None, no_end: false }
    }
}

#[derive(Debug)]
pub struct BlockUpload {
    multiplexer: Multiplexer,
    manner: UploadManner,
    state: UploadState,
    data: Vec<u8>,
    announced: Option<u32>,
    server_crc: bool,
    /// The current block, from 0.
    block: usize,
    /// Number of segments of this block received in order.
    received: u8,
    /// Whether the last segment of the value was received in order.
    complete: bool,
    toggle: bool,
    /// The number of segments of each block.
    pub blocks: Vec<u8>,
    /// Whether the server switched to a normal upload.
    pub switched: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum UploadState {
    Initiated,
    Receiving,
    Ending,
    /// Segments of a normal upload, after the server switched the protocol.
    Segments,
}

impl BlockUpload {
    /// A client that will upload this object.
    pub fn new(multiplexer: Multiplexer, manner: UploadManner) -> Self {
        Self {
            multiplexer,
            manner,
            state: UploadState::Initiated,
            data: Vec::new(),
            announced: None,
            server_crc: false,
            block: 0,
            received: 0,
            complete: false,
            toggle: false,
            blocks: Vec::new(),
            switched: false,
        }
    }

    fn block_size(&self, block: usize) -> u8 {
        let sizes = &self.manner.block_sizes;
        sizes.get(block).or(sizes.last()).copied().unwrap_or(BlockSegment::MAX)
    }

    fn on_initiated(&mut self, response: Response) -> BlockStep {
        match response {
            Response::InitiateBlockUpload { multiplexer, crc, size } if multiplexer == self.multiplexer => {
                self.server_crc = crc;
                self.announced = size;
                self.state = UploadState::Receiving;
                BlockStep::Send(vec![message(&Request::StartBlockUpload)])
            }
            Response::InitiateUpload { multiplexer, payload } if multiplexer == self.multiplexer => {
                self.switched = true;
                match payload {
                    Payload::Segmented(size) => self.announced = Some(size),
                    Payload::SegmentedUnsized => {}
                    _ => return BlockStep::Done(Outcome::Uploaded(payload.value().unwrap_or_default().to_vec())),
                }
                self.state = UploadState::Segments;
                BlockStep::Send(vec![message(&Request::UploadSegment { toggle: false })])
            }
            Response::InitiateBlockUpload { multiplexer, .. } | Response::InitiateUpload { multiplexer, .. } => {
                violated(Violation::Multiplexer(multiplexer))
            }
            other => violated(Violation::Unexpected(other)),
        }
    }

    fn on_block_segment(&mut self, segment: BlockSegment) -> BlockStep {
        let expected = self.received + 1;
        if segment.sequence != expected {
            return violated(Violation::Sequence { expected, found: segment.sequence });
        }
        self.received = segment.sequence;
        let lost = matches!(self.manner.lose_after, Some((block, last)) if block == self.block && self.received > last);
        if !lost {
            self.data.extend_from_slice(&segment.data);
            self.complete |= segment.last;
        }
        if self.data.len() > UploadLimit::default().bytes {
            return violated(Violation::Endless);
        }
        if segment.last || self.received == self.block_size(self.block) { self.confirm() } else { BlockStep::Wait }
    }

    /// Ends the block by confirming it.
    fn confirm(&mut self) -> BlockStep {
        let mut sequence = self.received;
        match self.manner.lose_after {
            Some((block, last)) if block == self.block => sequence = sequence.min(last),
            _ => {}
        }
        match self.manner.confirm {
            Some((block, wrong)) if block == self.block => sequence = wrong,
            _ => {}
        }
        self.blocks.push(self.received);
        self.block += 1;
        self.received = 0;
        if self.complete {
            self.state = UploadState::Ending;
        }
        let block_size = self.block_size(self.block);
        BlockStep::Send(vec![message(&Request::ConfirmBlockUpload { sequence, block_size })])
    }

    fn on_end(&mut self, response: Response) -> BlockStep {
        let Response::EndBlockUpload { unused, crc } = response else {
            return violated(Violation::Unexpected(response));
        };
        self.data.truncate(self.data.len().saturating_sub(usize::from(unused)));
        let received = self.data.len();
        if let Some(announced) = self.announced.filter(|&size| size as usize != received) {
            return violated(Violation::Size { announced, received });
        }
        let computed = if self.manner.crc && self.server_crc { crc16(0, &self.data) } else { 0 };
        if crc != computed {
            return violated(Violation::Checksum { computed, found: crc });
        }
        let outcome = Outcome::Uploaded(std::mem::take(&mut self.data));
        match self.manner.no_end {
            true => BlockStep::Done(outcome),
            false => BlockStep::Finish(vec![message(&Request::EndBlockUpload)], outcome),
        }
    }

    fn on_segment(&mut self, segment: Segment) -> BlockStep {
        if segment.toggle != self.toggle {
            return violated(Violation::Toggle);
        }
        self.data.extend_from_slice(segment.data());
        let received = self.data.len();
        if segment.last {
            return match self.announced.filter(|&size| size as usize != received) {
                Some(announced) => violated(Violation::Size { announced, received }),
                None => BlockStep::Done(Outcome::Uploaded(std::mem::take(&mut self.data))),
            };
        }
        if received > UploadLimit::default().bytes {
            return violated(Violation::Endless);
        }
        self.toggle = !self.toggle;
        BlockStep::Send(vec![message(&Request::UploadSegment { toggle: self.toggle })])
    }
}

impl BlockTransfer for BlockUpload {
    fn begin(&mut self) -> Message {
        let UploadManner { crc, threshold, .. } = self.manner;
        let (multiplexer, block_size) = (self.multiplexer, self.block_size(0));
        message(&Request::InitiateBlockUpload { multiplexer, crc, block_size, threshold })
    }

    fn handle(&mut self, bytes: Message) -> BlockStep {
        if self.state == UploadState::Receiving
            && bytes[0] != 0x80
            && let Ok(segment) = BlockSegment::read(&bytes)
        {
            return self.on_block_segment(segment);
        }
        match (Response::read(&bytes), self.state) {
            (Ok(Response::Abort(abort)), _) => BlockStep::Done(Outcome::Aborted(abort)),
            (Ok(response), UploadState::Initiated) => self.on_initiated(response),
            (Ok(response), UploadState::Ending) => self.on_end(response),
            (Ok(Response::UploadSegment(segment)), UploadState::Segments) => self.on_segment(segment),
            (Ok(response), _) => violated(Violation::Unexpected(response)),
            (Err(error), _) => violated(Violation::Malformed(error.to_string())),
        }
    }

    fn multiplexer(&self) -> Multiplexer {
        self.multiplexer
    }

    fn awaits_segment(&self) -> bool {
        self.state == UploadState::Receiving
    }
}

/// The eight bytes of the message with a request.
pub(super) fn message(request: &Request) -> Message {
    let mut bytes = [0; 8];
    request.emit(&mut bytes);
    bytes
}

/// The end of a transfer after a violation by the server: the client aborts the transfer.
pub(super) fn violated(violation: Violation) -> BlockStep {
    BlockStep::Done(Outcome::Violated(violation))
}

/// The message by which the client aborts.
pub fn abort(multiplexer: Multiplexer, code: AbortCode) -> Message {
    message(&Request::abort(multiplexer, code))
}

#[cfg(test)]
mod tests {
    use super::*;

    const OBJECT: Multiplexer = Multiplexer::new(0x2000, 0);

    fn server(response: Response) -> Message {
        let mut bytes = [0; 8];
        response.emit(&mut bytes);
        bytes
    }

    fn started(manner: UploadManner, size: u32) -> BlockUpload {
        let mut client = BlockUpload::new(OBJECT, manner);
        assert_eq!(client.begin()[0], 0xA4);
        let response = Response::InitiateBlockUpload { multiplexer: OBJECT, crc: true, size: Some(size) };
        assert!(matches!(client.handle(server(response)), BlockStep::Send(_)));
        client
    }

    fn segment(sequence: u8, last: bool, data: [u8; 7]) -> Message {
        let mut bytes = [0; 8];
        BlockSegment { sequence, last, data }.emit(&mut bytes);
        bytes
    }

    /// The CRC of "123456789" is 31C3h (CiA 301, 7.2.4.3.16).
    #[test]
    fn data_count_and_checksum_are_checked() {
        let run = |unused, crc| {
            let mut client = started(UploadManner::default(), 9);
            assert_eq!(client.handle(segment(1, false, *b"1234567")), BlockStep::Wait);
            let confirmation = client.handle(segment(2, true, *b"89\0\0\0\0\0"));
            assert_eq!(confirmation, BlockStep::Send(vec![[0xA2, 2, 127, 0, 0, 0, 0, 0]]));
            client.handle(server(Response::EndBlockUpload { unused, crc }))
        };
        let value = Outcome::Uploaded(b"123456789".to_vec());
        assert_eq!(run(5, 0x31C3), BlockStep::Finish(vec![[0xA1, 0, 0, 0, 0, 0, 0, 0]], value));
        assert_eq!(run(5, 0xC331), violated(Violation::Checksum { computed: 0x31C3, found: 0xC331 }));
        assert_eq!(run(4, 0x31C3), violated(Violation::Size { announced: 9, received: 10 }));
    }

    /// Without CRC the field of the CRC is 0, even if the server remembers the CRC of another transfer (CiA 301,
    /// 7.2.4.3.15).
    #[test]
    fn without_crc_its_field_is_0() {
        for (client_has, server_has) in [(false, true), (true, false), (false, false)] {
            let run = |crc| {
                let manner = UploadManner { crc: client_has, ..UploadManner::default() };
                let mut client = BlockUpload::new(OBJECT, manner);
                client.begin();
                client.handle(server(Response::InitiateBlockUpload {
                    multiplexer: OBJECT,
                    crc: server_has,
                    size: None,
                }));
                client.handle(segment(1, true, *b"1234567"));
                client.handle(server(Response::EndBlockUpload { unused: 0, crc }))
            };
            assert!(matches!(run(0), BlockStep::Finish(_, Outcome::Uploaded(_))));
            assert_eq!(run(0x31C3), violated(Violation::Checksum { computed: 0, found: 0x31C3 }));
        }
    }

    #[test]
    fn lost_segments_are_asked_for_again() {
        let manner = UploadManner { block_sizes: vec![2], lose_after: Some((0, 1)), ..UploadManner::default() };
        let mut client = started(manner, 14);
        client.handle(segment(1, false, [1; 7]));
        assert_eq!(client.handle(segment(2, true, [2; 7])), BlockStep::Send(vec![[0xA2, 1, 2, 0, 0, 0, 0, 0]]));
        assert_eq!(client.handle(segment(1, true, [2; 7])), BlockStep::Send(vec![[0xA2, 1, 2, 0, 0, 0, 0, 0]]));
        let data: Vec<u8> = [[1; 7], [2; 7]].concat();
        let end = Response::EndBlockUpload { unused: 0, crc: crc16(0, &data) };
        assert!(matches!(client.handle(server(end)), BlockStep::Finish(_, Outcome::Uploaded(found)) if found == data));
    }

    #[test]
    fn gaps_and_strange_messages_are_violations() {
        let mut client = started(UploadManner::default(), 14);
        assert_eq!(client.handle(segment(2, false, [0; 7])), violated(Violation::Sequence { expected: 1, found: 2 }));
        let mut client = BlockUpload::new(OBJECT, UploadManner::default());
        client.begin();
        let other = Multiplexer::new(0x2001, 0);
        let response = Response::InitiateBlockUpload { multiplexer: other, crc: true, size: None };
        assert_eq!(client.handle(server(response)), violated(Violation::Multiplexer(other)));
    }
}
