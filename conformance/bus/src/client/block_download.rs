//! A block download (CiA 301, 7.2.4.3.8 to 7.2.4.3.11): correct, or with a deliberate error.

use super::block_upload::{message, violated};
use super::sdo::{Outcome, Violation};
use super::{BlockStep, BlockTransfer, Message};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{BlockSegment, Request, Response, crc16};

/// A deliberate error in the segments of the first block.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Mischief {
    /// No error.
    #[default]
    None,
    /// This segment is not sent, as if it had been lost.
    Skip(u8),
    /// This segment is sent twice.
    Repeat(u8),
    /// This segment and the next one are exchanged.
    Swap(u8),
    /// The first segment has sequence number 0.
    NumberZero,
    /// After this segment the client falls silent.
    StopAfter(u8),
}

/// The behaviour of the client.
#[derive(Clone, Copy, Debug)]
pub struct DownloadManner {
    /// Whether the client sends a CRC.
    pub crc: bool,
    /// The announced number of bytes.
    pub announce: Option<u32>,
    /// An error added to the correct CRC.
    pub crc_error: u16,
    /// The number of unused bytes in the last segment that the client states at the end; `None` for the correct number.
    pub unused: Option<u8>,
    /// The deliberate error in the first block.
    pub mischief: Mischief,
}

impl DownloadManner {
    /// The behaviour of a correct client, with CRC and size.
    pub fn right(value: &[u8]) -> Self {
        let announce = u32::try_from(value.len()).ok();
        Self { crc: true, announce, crc_error: 0, unused: None, mischief: Mischief::None }
    }
}

/// Number of repetitions of a block after which the client assumes that the server repeats it without end.
const MOST_REPETITIONS: usize = 4;

#[derive(Debug)]
pub struct BlockDownload {
    multiplexer: Multiplexer,
    manner: DownloadManner,
    value: Vec<u8>,
    state: DownloadState,
    server_crc: bool,
    /// Number of segments that the server has confirmed.
    confirmed: usize,
    /// Number of segments in the last sent block.
    sent: u8,
    repetitions: usize,
    /// The sequence number in each confirmation of the server.
    pub confirmations: Vec<u8>,
    /// The block size in the server's first confirmation.
    pub block_size: u8,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum DownloadState {
    Initiated,
    Sending,
    Ending,
}

impl BlockDownload {
    /// A client that will download `value`.
    pub fn new(multiplexer: Multiplexer, value: &[u8], manner: DownloadManner) -> Self {
        Self {
            multiplexer,
            manner,
            value: value.to_vec(),
            state: DownloadState::Initiated,
            server_crc: false,
            confirmed: 0,
            sent: 0,
            repetitions: 0,
            confirmations: Vec::new(),
            block_size: 0,
        }
    }

    /// The number of segments of the whole value; an empty value takes one, too.
    fn segments(&self) -> usize {
        self.value.len().div_ceil(7).max(1)
    }

    fn send_block(&mut self, block_size: u8) -> BlockStep {
        if !(1..=BlockSegment::MAX).contains(&block_size) {
            return violated(Violation::BlockSize(block_size));
        }
        let total = self.segments();
        let until = total.min(self.confirmed + usize::from(block_size));
        let mut block: Vec<Message> =
            (self.confirmed..until).zip(1..=BlockSegment::MAX).map(|(n, sequence)| self.segment(n, sequence)).collect();
        debug_assert!(
            (1..=usize::from(block_size)).contains(&block.len()),
            "a block has at least one segment, and at most its size"
        );
        self.sent = u8::try_from(block.len()).unwrap_or(BlockSegment::MAX);
        spoil(&mut block, std::mem::take(&mut self.manner.mischief));
        self.state = DownloadState::Sending;
        BlockStep::Send(block)
    }

    fn segment(&self, n: usize, sequence: u8) -> Message {
        let mut data = [0; 7];
        let bytes = self.value.iter().skip(n * 7).take(7);
        data.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        let mut message = [0; 8];
        BlockSegment { sequence, last: n + 1 == self.segments(), data }.emit(&mut message);
        message
    }

    fn on_confirmation(&mut self, sequence: u8, block_size: u8) -> BlockStep {
        self.confirmations.push(sequence);
        if sequence > self.sent {
            return violated(Violation::Confirmation { sent: self.sent, confirmed: sequence });
        }
        self.repetitions = if sequence == 0 { self.repetitions + 1 } else { 0 };
        if self.repetitions > MOST_REPETITIONS {
            return violated(Violation::Confirmation { sent: self.sent, confirmed: sequence });
        }
        self.confirmed += usize::from(sequence);
        debug_assert!(self.confirmed <= self.segments(), "only segments that were sent are confirmed");
        if self.confirmed < self.segments() {
            return self.send_block(block_size);
        }
        let right = (self.segments() * 7 - self.value.len()) as u8;
        let crc = match self.manner.crc && self.server_crc {
            true => crc16(0, &self.value).wrapping_add(self.manner.crc_error),
            false => 0,
        };
        self.state = DownloadState::Ending;
        let unused = self.manner.unused.unwrap_or(right);
        BlockStep::Send(vec![message(&Request::EndBlockDownload { unused, crc })])
    }
}

impl BlockTransfer for BlockDownload {
    fn begin(&mut self) -> Message {
        let DownloadManner { crc, announce, .. } = self.manner;
        message(&Request::InitiateBlockDownload { multiplexer: self.multiplexer, crc, size: announce })
    }

    fn handle(&mut self, bytes: Message) -> BlockStep {
        match (Response::read(&bytes), self.state) {
            (Ok(Response::Abort(abort)), _) => BlockStep::Done(Outcome::Aborted(abort)),
            (Ok(Response::InitiateBlockDownload { multiplexer, crc, block_size }), DownloadState::Initiated) => {
                if multiplexer != self.multiplexer {
                    return violated(Violation::Multiplexer(multiplexer));
                }
                self.server_crc = crc;
                self.block_size = block_size;
                self.send_block(block_size)
            }
            (Ok(Response::ConfirmBlockDownload { sequence, block_size }), DownloadState::Sending) => {
                self.on_confirmation(sequence, block_size)
            }
            (Ok(Response::EndBlockDownload), DownloadState::Ending) => BlockStep::Done(Outcome::Downloaded),
            (Ok(response), _) => violated(Violation::Unexpected(response)),
            (Err(error), _) => violated(Violation::Malformed(error.to_string())),
        }
    }

    fn multiplexer(&self) -> Multiplexer {
        self.multiplexer
    }
}

fn spoil(block: &mut Vec<Message>, mischief: Mischief) {
    let place = |n: u8| usize::from(n).saturating_sub(1);
    match mischief {
        Mischief::None => {}
        Mischief::Skip(n) if place(n) < block.len() => _ = block.remove(place(n)),
        Mischief::Repeat(n) => {
            if let Some(&again) = block.get(place(n)) {
                block.insert(place(n), again);
            }
        }
        Mischief::Swap(n) if place(n) + 1 < block.len() => block.swap(place(n), place(n) + 1),
        Mischief::NumberZero => {
            if let Some(first) = block.first_mut() {
                first[0] &= 0x80;
            }
        }
        Mischief::StopAfter(n) => block.truncate(usize::from(n)),
        Mischief::Skip(_) | Mischief::Swap(_) => {}
    }
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

    fn sent(step: BlockStep) -> Vec<Message> {
        match step {
            BlockStep::Send(messages) => messages,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn blocks_end_and_lost_segments_come_again() {
        let value: Vec<u8> = (0..20).collect();
        let manner = DownloadManner { mischief: Mischief::Skip(2), ..DownloadManner::right(&value) };
        let mut client = BlockDownload::new(OBJECT, &value, manner);
        assert_eq!(client.begin(), [0xC6, 0, 0x20, 0, 20, 0, 0, 0]);
        let start = Response::InitiateBlockDownload { multiplexer: OBJECT, crc: true, block_size: 3 };
        let block = sent(client.handle(server(start)));
        assert_eq!(block.iter().map(|message| message[0]).collect::<Vec<_>>(), [1, 0x83]);
        let confirm = |sequence| server(Response::ConfirmBlockDownload { sequence, block_size: 2 });
        let block = sent(client.handle(confirm(1)));
        assert_eq!(block, [[1, 7, 8, 9, 10, 11, 12, 13], [0x82, 14, 15, 16, 17, 18, 19, 0]]);
        let [low, high] = crc16(0, &value).to_le_bytes();
        assert_eq!(sent(client.handle(confirm(2))), [[0xC5, low, high, 0, 0, 0, 0, 0]]);
        let end = client.handle(server(Response::EndBlockDownload));
        assert_eq!(end, BlockStep::Done(Outcome::Downloaded));
    }

    #[test]
    fn a_server_that_confirms_what_it_can_not_have_is_found_out() {
        let value = [7; 10];
        let mut client = BlockDownload::new(OBJECT, &value, DownloadManner::right(&value));
        client.begin();
        client.handle(server(Response::InitiateBlockDownload { multiplexer: OBJECT, crc: true, block_size: 5 }));
        let step = client.handle(server(Response::ConfirmBlockDownload { sequence: 3, block_size: 5 }));
        assert_eq!(step, violated(Violation::Confirmation { sent: 2, confirmed: 3 }));
        let mut client = BlockDownload::new(OBJECT, &value, DownloadManner::right(&value));
        client.begin();
        let step =
            client.handle(server(Response::InitiateBlockDownload { multiplexer: OBJECT, crc: true, block_size: 0 }));
        assert_eq!(step, violated(Violation::BlockSize(0)));
    }
}
