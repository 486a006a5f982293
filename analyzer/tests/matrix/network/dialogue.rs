//! SDO transfers of a client with a node.

use super::spec::NodeSpec;
use crate::draw::Draw;
use crate::plan::{Plan, Planned};
use crate::play::SDO_TIMEOUT;
use crate::sort::Sort;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{
    AbortCode, BlockSegment, Expedited, Payload, REQUEST_BASE, RESPONSE_BASE, Request, Response, Segment, crc16,
};

/// A text of 20 bytes.
pub const NAME: Multiplexer = Multiplexer::new(0x2010, 0);
/// A program of some hundred bytes.
pub const PROGRAM: Multiplexer = Multiplexer::new(0x2011, 0);
/// A number that the client writes now and then.
pub const LIMIT: Multiplexer = Multiplexer::new(0x2012, 0);
/// An object that no node has.
pub const ABSENT: Multiplexer = Multiplexer::new(0x2FFF, 0);

/// A kind of transfer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Transfer {
    Read,
    Write,
    SegmentedRead,
    SegmentedWrite,
    BlockRead,
    BlockWrite,
    Refused,
    GivenUp,
}

impl Transfer {
    /// Transfers of healthy operation.
    pub const HEALTHY: [Self; 8] = [
        Self::Read,
        Self::Write,
        Self::SegmentedRead,
        Self::BlockRead,
        Self::Read,
        Self::SegmentedWrite,
        Self::BlockWrite,
        Self::Read,
    ];
}

/// A client that talks with one node.
pub struct Talk<'a> {
    plan: &'a mut Plan,
    draw: &'a mut Draw,
    node: &'a NodeSpec,
    /// The time of the latest message.
    pub at: u64,
    last: Option<usize>,
    object: Multiplexer,
}

impl<'a> Talk<'a> {
    /// A client that begins at this time.
    pub fn new(plan: &'a mut Plan, draw: &'a mut Draw, node: &'a NodeSpec, at: u64) -> Self {
        Self { plan, draw, node, at, last: None, object: LIMIT }
    }

    fn say(&mut self, sort: Sort, message: &impl Wire, is_client: bool) {
        let (base, wait) = match is_client {
            true => (REQUEST_BASE, self.draw.between(200_000, 1_500_000)),
            false => (RESPONSE_BASE, self.draw.about(self.node.response, 200)),
        };
        self.at += wait;
        let frame = message.to_frame(base + u16::from(self.node.id));
        let mut planned = Planned::new(self.at, frame, sort, self.node.id);
        planned.cause = self.last;
        planned.sender = (!is_client).then_some(self.node.id);
        // Some clients abort a transfer that gets no response, others say nothing.
        if !self.node.id.is_multiple_of(3) {
            let abort =
                Request::abort(self.object, AbortCode::TIMEOUT).to_frame(REQUEST_BASE + u16::from(self.node.id));
            planned.on_silence = Some((SDO_TIMEOUT, abort));
        }
        self.last = Some(self.plan.add(planned));
    }

    fn ask(&mut self, request: Request) {
        self.object = request.multiplexer().unwrap_or(self.object);
        self.say(Sort::sdo_request(&request), &request, true);
    }

    fn answer(&mut self, response: Response) {
        self.say(Sort::sdo_response(&response), &response, false);
    }

    /// Reads a value of at most four bytes.
    pub fn read(&mut self, object: Multiplexer, value: &[u8]) {
        self.last = None;
        self.ask(Request::upload(object));
        self.answer(Response::upload(object, value));
    }

    /// Writes a value of at most four bytes.
    pub fn write(&mut self, object: Multiplexer, value: &[u8]) {
        self.last = None;
        let payload = Expedited::new(value).map_or(Payload::SegmentedUnsized, Payload::Expedited);
        self.ask(Request::InitiateDownload { multiplexer: object, payload });
        self.answer(Response::InitiateDownload { multiplexer: object });
    }

    /// A transfer of this kind.
    pub fn transfer(&mut self, transfer: Transfer) {
        self.last = None;
        match transfer {
            Transfer::Read => self.read(Multiplexer::new(0x1001, 0), &[0]),
            Transfer::Write => {
                let value = self.draw.number().to_le_bytes();
                self.write(LIMIT, &value[..4]);
            }
            Transfer::SegmentedRead => self.segmented_read(usize::MAX),
            Transfer::SegmentedWrite => self.segmented_write(),
            Transfer::BlockRead => self.block_read(),
            Transfer::BlockWrite => self.block_write(),
            Transfer::Refused => {
                self.ask(Request::upload(ABSENT));
                self.answer(Response::abort(ABSENT, AbortCode(0x0602_0000)));
            }
            Transfer::GivenUp => self.segmented_read(1),
        }
    }

    fn bytes(&mut self, length: usize) -> Vec<u8> {
        (0..length).map(|_| self.draw.between(b'A'.into(), b'Z'.into()) as u8).collect()
    }

    /// Reads the name; aborts after `most` segments.
    fn segmented_read(&mut self, most: usize) {
        let name = self.bytes(20);
        self.ask(Request::upload(NAME));
        self.answer(Response::upload(NAME, &name));
        let segments: Vec<&[u8]> = name.chunks(7).collect();
        for (count, part) in segments.iter().enumerate() {
            if count == most {
                return self.ask(Request::abort(NAME, AbortCode(0x0800_0000)));
            }
            let (toggle, last) = (count % 2 == 1, count + 1 == segments.len());
            self.ask(Request::UploadSegment { toggle });
            if let Some(segment) = Segment::new(toggle, part, last) {
                self.answer(Response::UploadSegment(segment));
            }
        }
    }

    fn segmented_write(&mut self) {
        let name = self.bytes(20);
        self.ask(Request::download(NAME, &name));
        self.answer(Response::InitiateDownload { multiplexer: NAME });
        let segments: Vec<&[u8]> = name.chunks(7).collect();
        for (count, part) in segments.iter().enumerate() {
            let (toggle, last) = (count % 2 == 1, count + 1 == segments.len());
            if let Some(segment) = Segment::new(toggle, part, last) {
                self.ask(Request::DownloadSegment(segment));
            }
            self.answer(Response::DownloadSegment { toggle });
        }
    }

    /// The segments of a block transfer, from the client or from the server.
    fn segments(&mut self, program: &[u8], block_size: usize, is_client: bool, confirm: fn(&mut Self, u8, u8)) {
        let segments: Vec<&[u8]> = program.chunks(7).collect();
        for (number, block) in segments.chunks(block_size).enumerate() {
            for (place, part) in block.iter().enumerate() {
                let mut data = [0; 7];
                data[..part.len()].copy_from_slice(part);
                let last = number * block_size + place + 1 == segments.len();
                let segment = BlockSegment { sequence: place as u8 + 1, last, data };
                let sort = if is_client { Sort::block_download() } else { Sort::block_upload() };
                self.say(sort, &segment, is_client);
            }
            confirm(self, block.len() as u8, block_size as u8);
        }
    }

    fn block_read(&mut self) {
        let program = self.bytes(60);
        let block_size = 5;
        self.ask(Request::InitiateBlockUpload { multiplexer: PROGRAM, crc: true, block_size, threshold: 0 });
        self.answer(Response::InitiateBlockUpload { multiplexer: PROGRAM, crc: true, size: Some(60) });
        self.ask(Request::StartBlockUpload);
        self.segments(&program, block_size.into(), false, |talk, sequence, block_size| {
            talk.ask(Request::ConfirmBlockUpload { sequence, block_size });
        });
        self.answer(Response::EndBlockUpload { unused: unused(&program), crc: crc16(0, &program) });
        self.ask(Request::EndBlockUpload);
    }

    fn block_write(&mut self) {
        let program = self.bytes(60);
        let block_size = 5;
        self.ask(Request::InitiateBlockDownload { multiplexer: PROGRAM, crc: true, size: Some(60) });
        self.answer(Response::InitiateBlockDownload { multiplexer: PROGRAM, crc: true, block_size });
        self.segments(&program, block_size.into(), true, |talk, sequence, block_size| {
            talk.answer(Response::ConfirmBlockDownload { sequence, block_size });
        });
        self.ask(Request::EndBlockDownload { unused: unused(&program), crc: crc16(0, &program) });
        self.answer(Response::EndBlockDownload);
    }
}

/// Number of bytes of the last segment that do not count.
fn unused(program: &[u8]) -> u8 {
    ((7 - program.len() % 7) % 7) as u8
}
