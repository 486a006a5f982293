//! SDO block transfers: the analyzer joins them to their values, whatever is lost, repeated or interleaved.
//!
//! The frames come from a sender and a receiver written here from CiA 301, which know nothing of the analyzer's state
//! machine; only the encoders are shared.

#[cfg(test)]
mod trace;

use canvass_analyzer::network::sdo::{ChannelIndex, Direction, Mode, Outcome, Transfer, Violation};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{AbortCode, BlockSegment, Request, Response, crc16};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::{ChannelId, Duration, Frame, Record, Timestamp};
use proptest::prelude::*;
use trace::{Said, Trace};

/// The fate of a segment on its way.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Fate {
    /// The segment arrives.
    Arrives,
    /// The segment is never on the bus.
    Lost,
    /// The segment is on the bus, but the receiver does not accept it.
    Missed,
    /// The segment is on the bus twice.
    Repeated,
}

/// The course of a transfer.
#[derive(Clone, Debug)]
struct Plan {
    node: u8,
    direction: Direction,
    value: Vec<u8>,
    /// The sizes of the blocks, repeated for further blocks.
    block_sizes: Vec<u8>,
    /// The fates of the first segments that are sent; all others arrive.
    fates: Vec<Fate>,
    size_said: bool,
    /// Whether client and server can do a CRC.
    crc: (bool, bool),
    crc_error: u16,
}

const OBJECT: Multiplexer = Multiplexer::new(0x1F50, 1);

impl Plan {
    fn new(node: u8, direction: Direction, value: Vec<u8>) -> Self {
        Self {
            node,
            direction,
            value,
            block_sizes: vec![127],
            fates: Vec::new(),
            size_said: true,
            crc: (true, true),
            crc_error: 0,
        }
    }

    fn request(&self, request: Request) -> Frame {
        request.to_frame(0x600 + u16::from(self.node))
    }

    fn response(&self, response: Response) -> Frame {
        response.to_frame(0x580 + u16::from(self.node))
    }

    fn size(&self) -> Option<u32> {
        self.size_said.then_some(self.value.len() as u32)
    }

    fn block_size(&self, block: usize) -> u8 {
        self.block_sizes[block % self.block_sizes.len()]
    }

    /// CRC and number of bytes that don't count in the last segment.
    fn end(&self) -> (u16, u8) {
        let crc = if self.crc == (true, true) { crc16(0, &self.value) ^ self.crc_error } else { 0 };
        (crc, ((7 - self.value.len() % 7) % 7) as u8)
    }

    fn frames(&self) -> Vec<Frame> {
        match self.direction {
            Direction::Download => self.download(),
            Direction::Upload => self.upload(),
        }
    }

    fn download(&self) -> Vec<Frame> {
        let (crc, unused) = self.end();
        let begin = Request::InitiateBlockDownload { multiplexer: OBJECT, crc: self.crc.0, size: self.size() };
        let accepted =
            Response::InitiateBlockDownload { multiplexer: OBJECT, crc: self.crc.1, block_size: self.block_size(0) };
        let mut frames = vec![self.request(begin), self.response(accepted)];
        self.blocks(&mut frames);
        frames.push(self.request(Request::EndBlockDownload { unused, crc }));
        frames.push(self.response(Response::EndBlockDownload));
        frames
    }

    fn upload(&self) -> Vec<Frame> {
        let (crc, unused) = self.end();
        let block_size = self.block_size(0);
        let begin = Request::InitiateBlockUpload { multiplexer: OBJECT, crc: self.crc.0, block_size, threshold: 0 };
        let accepted = Response::InitiateBlockUpload { multiplexer: OBJECT, crc: self.crc.1, size: self.size() };
        let mut frames = vec![self.request(begin), self.response(accepted), self.request(Request::StartBlockUpload)];
        self.blocks(&mut frames);
        frames.push(self.response(Response::EndBlockUpload { unused, crc }));
        frames.push(self.request(Request::EndBlockUpload));
        frames
    }

    /// The segments, and the confirmations of the blocks.
    fn blocks(&self, frames: &mut Vec<Frame>) {
        let segments: Vec<_> = self.value.chunks(7).collect();
        let mut fates = self.fates.iter().copied();
        let (mut confirmed, mut block) = (0, 0);
        while confirmed < segments.len() {
            let count = usize::from(self.block_size(block)).min(segments.len() - confirmed);
            let mut received = 0;
            for sequence in 1..=count {
                let chunk = segments[confirmed + sequence - 1];
                let mut data = [0x55; 7];
                data[..chunk.len()].copy_from_slice(chunk);
                let last = confirmed + sequence == segments.len();
                let frame = self.segment(BlockSegment { sequence: sequence as u8, last, data });
                let fate = fates.next().unwrap_or(Fate::Arrives);
                let copies = match fate {
                    Fate::Lost => 0,
                    Fate::Repeated => 2,
                    Fate::Arrives | Fate::Missed => 1,
                };
                frames.extend(std::iter::repeat_n(frame, copies));
                if matches!(fate, Fate::Arrives | Fate::Repeated) && received == sequence - 1 {
                    received = sequence;
                }
            }
            block += 1;
            confirmed += received;
            frames.push(self.confirmation(received as u8, self.block_size(block)));
        }
    }

    fn segment(&self, segment: BlockSegment) -> Frame {
        segment.to_frame(match self.direction {
            Direction::Download => 0x600 + u16::from(self.node),
            Direction::Upload => 0x580 + u16::from(self.node),
        })
    }

    fn confirmation(&self, sequence: u8, block_size: u8) -> Frame {
        match self.direction {
            Direction::Download => self.response(Response::ConfirmBlockDownload { sequence, block_size }),
            Direction::Upload => self.request(Request::ConfirmBlockUpload { sequence, block_size }),
        }
    }

    /// Asserts that the analyzer holds this transfer with its whole value.
    fn assert_joined(&self, trace: &Trace) {
        let transfer = transfer(trace, self.node);
        assert_eq!((transfer.multiplexer, transfer.direction, transfer.mode), (OBJECT, self.direction, Mode::Block));
        assert_eq!(transfer.outcome, Outcome::Complete);
        assert_eq!(transfer.length(), self.value.len() as u64);
        assert_eq!(transfer.announced, self.size());
        assert_eq!(transfer.segments as usize, self.value.len().div_ceil(7));
        let kept = &self.value[..self.value.len().min(Transfer::KEPT)];
        assert!(transfer.data() == kept, "{} bytes differ", kept.len());
        let (sent, calculated) = (self.end().0, crc16(0, &self.value));
        let wrong = self.crc == (true, true) && self.crc_error != 0;
        assert_eq!(transfer.violation, wrong.then_some(Violation::Crc { sent, calculated }));
    }
}

#[cfg(test)]
fn transfer(trace: &Trace, node: u8) -> &Transfer {
    let channel = ChannelIndex::predefined(NodeId::new(node).unwrap());
    trace.network.bus(ChannelId(0)).and_then(|bus| bus.transfer(channel)).expect("a transfer")
}

fn play(trace: &mut Trace, frames: &[Frame]) -> Vec<Said> {
    let record = |frame: &Frame| Record::new(Timestamp::ZERO, ChannelId(0), *frame);
    frames.iter().map(|frame| trace.record(record(frame))).collect()
}

/// Bytes that are unlike each other and look like commands: 21h, 40h, 60h, 80h are among them.
fn value(length: usize) -> Vec<u8> {
    (0..length).map(|n| (n * 31 + n / 256) as u8).collect()
}

const BOTH: [Direction; 2] = [Direction::Download, Direction::Upload];

#[test]
fn from_one_byte_to_100_kilobytes() {
    for direction in BOTH {
        for length in [1, 6, 7, 8, 13, 14, 15, 127 * 7 - 1, 127 * 7, 127 * 7 + 1, 10_000, 65_536, 65_537, 100_000] {
            let plan = Plan::new(5, direction, value(length));
            let mut trace = Trace::new();
            let said = play(&mut trace, &plan.frames());
            plan.assert_joined(&trace);
            assert!(said.iter().all(|said| said.decoded.violation.is_none() && said.service() == "sdo"));
            let last = &said.last().unwrap().text;
            assert!(last.contains("1F50h:01") && last.contains(&format!("({length} bytes)")), "{last}");
        }
    }
}

#[test]
fn a_wrong_crc_is_named() {
    for direction in BOTH {
        let plan = Plan { crc_error: 0x0101, ..Plan::new(5, direction, value(300)) };
        let mut trace = Trace::new();
        let said = play(&mut trace, &plan.frames());
        plan.assert_joined(&trace);
        let blamed: Vec<_> = said.iter().filter(|said| said.decoded.violation.is_some()).collect();
        assert_eq!(blamed.len(), 1);
        let expected = format!(
            "[violation: CRC {:04X}h does not match the data, expected {:04X}h]",
            plan.end().0,
            crc16(0, &plan.value)
        );
        assert!(blamed[0].text.ends_with(&expected), "{}", blamed[0].text);
    }
}

/// A CRC counts only where both sides announced it.
#[test]
fn without_a_crc_none_is_checked() {
    for direction in BOTH {
        for crc in [(false, false), (true, false), (false, true)] {
            let plan = Plan { crc, ..Plan::new(5, direction, value(300)) };
            let mut trace = Trace::new();
            play(&mut trace, &plan.frames());
            plan.assert_joined(&trace);
        }
    }
}

/// The receiver confirms segments that the capture lacks. The value can't be right, so a violation is reported. The
/// transfer ends all the same, and the next transfer is decoded.
#[test]
fn segments_missing_in_the_capture() {
    for direction in BOTH {
        let plan = Plan::new(5, direction, value(70));
        let first_segment = if direction == Direction::Download { 2 } else { 3 };
        for missing in 0..10 {
            let mut frames = plan.frames();
            frames.remove(first_segment + missing);
            let mut trace = Trace::new();
            play(&mut trace, &frames);
            let transfer = transfer(&trace, 5);
            assert_eq!(transfer.outcome, Outcome::Complete, "without segment {}", missing + 1);
            let expected = missing as u8 + 1;
            assert_eq!(transfer.violation, Some(Violation::Sequence { expected, found: 10 }));
            play(&mut trace, &plan.frames());
            plan.assert_joined(&trace);
        }
    }
}

/// Whichever frame is missing in a capture, the next transfer is decoded.
#[test]
fn any_frame_missing_in_the_capture() {
    for direction in BOTH {
        let plan = Plan { block_sizes: vec![4], ..Plan::new(5, direction, value(90)) };
        for missing in 0..plan.frames().len() {
            let mut frames = plan.frames();
            frames.remove(missing);
            let mut trace = Trace::new();
            play(&mut trace, &frames);
            play(&mut trace, &plan.frames());
            plan.assert_joined(&trace);
        }
    }
}

#[test]
fn fewer_bytes_than_announced() {
    let plan = Plan::new(5, Direction::Download, value(70));
    let mut frames = plan.frames();
    frames[0] = plan.request(Request::InitiateBlockDownload { multiplexer: OBJECT, crc: true, size: Some(71) });
    let mut trace = Trace::new();
    let said = play(&mut trace, &frames);
    assert_eq!(transfer(&trace, 5).violation, Some(Violation::Size { announced: 71, received: 70 }));
    assert!(said.last().unwrap().text.contains("70 bytes transferred, but 71 announced"));
}

#[test]
fn an_abort_ends_it_at_any_place() {
    for direction in BOTH {
        let plan = Plan { block_sizes: vec![3], ..Plan::new(5, direction, value(70)) };
        let frames = plan.frames();
        for place in 1..frames.len() {
            let client = plan.request(Request::abort(OBJECT, AbortCode::TIMEOUT));
            let server = Response::abort(OBJECT, AbortCode::SEQUENCE_NUMBER);
            for abort in [client, plan.response(server)] {
                let mut trace = Trace::new();
                play(&mut trace, &frames[..place]);
                let said = play(&mut trace, &[abort]);
                assert!(matches!(transfer(&trace, 5).outcome, Outcome::Aborted(..)), "after frame {place}");
                assert!(said[0].text.contains("aborts 1F50h:01"), "{}", said[0].text);
                // The next transfer is decoded.
                play(&mut trace, &frames);
                plan.assert_joined(&trace);
            }
        }
    }
}

/// The server answers the request for blocks by an ordinary upload, because the value is small.
#[test]
fn the_server_may_switch_to_an_ordinary_upload() {
    let mut trace = Trace::new();
    trace.say("605#A4 08 10 00 7F 08 00 00");
    let said = trace.say("585#4B 08 10 00 34 12 00 00");
    assert_eq!(said.decoded.violation, None);
    assert_eq!((transfer(&trace, 5).mode, transfer(&trace, 5).data()), (Mode::Expedited, &[0x34, 0x12][..]));
}

/// The client gives up in the middle of a block without an abort. Its next request looks like a segment, but the
/// server's answer does not: from the answer on all frames are decoded again.
#[test]
fn a_client_that_gives_up_silently() {
    let plan = Plan::new(5, Direction::Download, value(700));
    let mut trace = Trace::new();
    play(&mut trace, &plan.frames()[..20]);
    trace.say("605#40 00 10 00 00 00 00 00");
    trace.say("585#43 00 10 00 96 01 02 00");
    trace.say("605#40 18 10 01 00 00 00 00");
    let said = trace.say("585#43 18 10 01 13 00 00 00");
    assert_eq!(said.decoded.violation, None, "{}", said.text);
    assert!(said.text.starts_with("read answered: 1018h:01"), "{}", said.text);
    assert_eq!(transfer(&trace, 5).data(), [0x13, 0, 0, 0]);
}

/// After ten seconds of silence nobody waits for a segment any more.
#[test]
fn a_block_left_alone_is_over() {
    for direction in BOTH {
        let plan = Plan::new(5, direction, value(700));
        let mut trace = Trace::new();
        play(&mut trace, &plan.frames()[..20]);
        trace.now += Duration(11_000_000_000);
        let said = trace.say("605#40 00 10 00 00 00 00 00");
        assert!(said.text.starts_with("read 1000h:00"), "{}", said.text);
        let said = trace.say("585#43 00 10 00 96 01 02 00");
        assert_eq!(said.decoded.violation, None);
    }
}

fn fate() -> impl Strategy<Value = Fate> {
    prop_oneof![
        6 => Just(Fate::Arrives),
        1 => Just(Fate::Lost),
        1 => Just(Fate::Missed),
        1 => Just(Fate::Repeated),
    ]
}

fn plan(node: u8) -> impl Strategy<Value = Plan> {
    let length = prop_oneof![1..40_usize, 1..4000_usize];
    let value = length.prop_flat_map(|length| proptest::collection::vec(any::<u8>(), length));
    let block_sizes = proptest::collection::vec(1..=127_u8, 1..5);
    let fates = proptest::collection::vec(fate(), 0..200);
    let crc_error = prop_oneof![3 => Just(0), 1 => any::<u16>()];
    let direction = prop_oneof![Just(Direction::Download), Just(Direction::Upload)];
    (direction, value, block_sizes, fates, any::<bool>(), any::<(bool, bool)>(), crc_error).prop_map(
        move |(direction, value, block_sizes, fates, size_said, crc, crc_error)| Plan {
            node,
            direction,
            value,
            block_sizes,
            fates,
            size_said,
            crc,
            crc_error,
        },
    )
}

proptest! {
    #[test]
    fn any_transfer(plan in plan(5)) {
        let mut trace = Trace::new();
        play(&mut trace, &plan.frames());
        plan.assert_joined(&trace);
    }

    /// Two transfers one after the other on the same channel.
    #[test]
    fn nothing_is_left_behind(first in plan(5), second in plan(5)) {
        let mut trace = Trace::new();
        play(&mut trace, &first.frames());
        play(&mut trace, &second.frames());
        second.assert_joined(&trace);
    }

    #[test]
    fn two_at_once(first in plan(5), second in plan(6), order: Vec<bool>) {
        let (mut a, mut b) = (first.frames().into_iter(), second.frames().into_iter());
        let mut frames = Vec::new();
        for pick_first in order {
            frames.extend(if pick_first { a.next() } else { b.next() });
        }
        frames.extend(a);
        frames.extend(b);
        let mut trace = Trace::new();
        play(&mut trace, &frames);
        first.assert_joined(&trace);
        second.assert_joined(&trace);
    }
}
