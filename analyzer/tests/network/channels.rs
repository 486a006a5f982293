//! The rules of SDO dialogues, message by message (CiA 301, 7.2.4): the order of messages, and the reported violations.

use crate::trace::Trace;
use canvass_analyzer::network::Event;
use canvass_analyzer::network::sdo::{Direction, Mode, Outcome, Side, Transfer, Violation};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::{ChannelId, Duration};

/// Decodes the frames of a dialogue with node 5, and checks the violation of each frame.
pub fn dialogue(frames: &[(&str, Option<Violation>)]) -> Trace {
    let mut trace = Trace::new();
    for (n, (frame, violation)) in frames.iter().enumerate() {
        assert_eq!(trace.say(frame).decoded.violation, *violation, "{n}: {frame}");
    }
    trace
}

pub fn transfer(trace: &Trace) -> &Transfer {
    let channel = canvass_analyzer::network::sdo::ChannelIndex::predefined(NodeId::new(5).unwrap());
    trace.network.bus(ChannelId(0)).unwrap().transfer(channel).unwrap()
}

fn left(trace: &Trace) -> &Transfer {
    let channel = canvass_analyzer::network::sdo::ChannelIndex::predefined(NodeId::new(5).unwrap());
    trace.network.bus(ChannelId(0)).unwrap().left_transfer(channel).unwrap()
}

pub fn open(trace: &Trace) -> usize {
    trace.network.bus(ChannelId(0)).unwrap().open_transfers().count()
}

pub fn events(trace: &Trace) -> &[Event] {
    trace.network.bus(ChannelId(0)).unwrap().events()
}

const TOGGLE: Option<Violation> = Some(Violation::Toggle);
pub const UNEXPECTED: Option<Violation> = Some(Violation::Unexpected);

const READ: &str = "605#40 08 10 00 00 00 00 00";
const READ_ANSWER: &str = "585#41 08 10 00 0F 00 00 00";
const WRITE: &str = "605#21 08 10 00 0F 00 00 00";
const WRITE_ANSWER: &str = "585#60 08 10 00 00 00 00 00";

/// The toggle bit begins with 0 and alternates with each segment, on both sides (7.2.4.3.4 and 7.2.4.3.7).
#[test]
fn each_side_has_to_toggle() {
    let start = [(READ, None), (READ_ANSWER, None)];
    let upload = |rest: &[(&str, Option<Violation>)]| dialogue(&[&start[..], rest].concat());
    upload(&[("605#70 00 00 00 00 00 00 00", TOGGLE)]);
    let trace = upload(&[("605#60 00 00 00 00 00 00 00", None), ("585#10 41 42 43 44 45 46 47", TOGGLE)]);
    assert_eq!(transfer(&trace).violation, TOGGLE);
    upload(&[
        ("605#60 00 00 00 00 00 00 00", None),
        ("585#00 41 42 43 44 45 46 47", None),
        ("605#60 00 00 00 00 00 00 00", TOGGLE),
    ]);
    let trace = upload(&[
        ("605#60 00 00 00 00 00 00 00", None),
        ("585#00 41 42 43 44 45 46 47", None),
        ("605#70 00 00 00 00 00 00 00", None),
        ("585#10 48 49 4A 4B 4C 4D 4E", None),
        ("605#60 00 00 00 00 00 00 00", None),
        ("585#0D 4F 00 00 00 00 00 00", None),
    ]);
    assert_eq!((transfer(&trace).outcome, transfer(&trace).segments), (Outcome::Complete, 3));

    let start = [(WRITE, None), (WRITE_ANSWER, None)];
    let download = |rest: &[(&str, Option<Violation>)]| dialogue(&[&start[..], rest].concat());
    download(&[("605#10 41 42 43 44 45 46 47", TOGGLE)]);
    download(&[("605#00 41 42 43 44 45 46 47", None), ("585#30 00 00 00 00 00 00 00", TOGGLE)]);
    download(&[
        ("605#00 41 42 43 44 45 46 47", None),
        ("585#20 00 00 00 00 00 00 00", None),
        ("605#00 48 49 4A 4B 4C 4D 4E", TOGGLE),
    ]);
    let trace = download(&[
        ("605#00 41 42 43 44 45 46 47", None),
        ("585#20 00 00 00 00 00 00 00", None),
        ("605#10 48 49 4A 4B 4C 4D 4E", None),
        ("585#30 00 00 00 00 00 00 00", None),
        ("605#0D 4F 00 00 00 00 00 00", None),
        ("585#20 00 00 00 00 00 00 00", None),
    ]);
    assert_eq!((transfer(&trace).outcome, transfer(&trace).segments), (Outcome::Complete, 3));
    assert_eq!(transfer(&trace).violation, None);
}

/// A message of the other direction, of a block transfer or of no transfer is unexpected.
#[test]
fn what_does_not_belong_into_the_state_is_told() {
    let anywhere = [
        "605#60 00 00 00 00 00 00 00",
        "605#00 41 42 43 44 45 46 47",
        "585#00 41 42 43 44 45 46 47",
        "585#20 00 00 00 00 00 00 00",
        "585#41 08 10 00 0F 00 00 00",
        "585#60 08 10 00 00 00 00 00",
    ];
    // A whole transfer comes first, so that the capture has not begun in the middle of one.
    let whole = [("605#40 18 10 01 00 00 00 00", None), ("585#43 18 10 01 13 00 00 00", None)];
    for frame in anywhere {
        dialogue(&[whole[0], whole[1], (frame, UNEXPECTED)]);
    }
    for frame in [
        "605#A1 00 00 00 00 00 00 00",
        "605#A2 01 03 00 00 00 00 00",
        "605#A3 00 00 00 00 00 00 00",
        "605#C1 00 00 00 00 00 00 00",
        "605#E0 00 00 00 00 00 00 00",
        "585#A4 08 10 00 03 00 00 00",
        "585#A1 00 00 00 00 00 00 00",
        "585#A2 01 03 00 00 00 00 00",
        "585#C6 08 10 00 0F 00 00 00",
        "585#C1 00 00 00 00 00 00 00",
        "585#E0 00 00 00 00 00 00 00",
    ] {
        for before in
            [&[whole[0], whole[1]][..], &[(READ, None), (READ_ANSWER, None)], &[(WRITE, None), (WRITE_ANSWER, None)]]
        {
            let trace = dialogue(&[before, &[(frame, UNEXPECTED)]].concat());
            assert_eq!(open(&trace), usize::from(before[0] != whole[0]), "{frame}");
        }
    }
    // A message of the other direction.
    let reading = [(READ, None), (READ_ANSWER, None), ("605#60 00 00 00 00 00 00 00", None)];
    dialogue(&[reading[0], reading[1], ("605#00 41 42 43 44 45 46 47", UNEXPECTED)]);
    dialogue(&[reading[0], reading[1], reading[2], ("585#20 00 00 00 00 00 00 00", UNEXPECTED)]);
    dialogue(&[reading[0], ("585#60 08 10 00 00 00 00 00", UNEXPECTED)]);
    let writing = [(WRITE, None), (WRITE_ANSWER, None), ("605#00 41 42 43 44 45 46 47", None)];
    dialogue(&[writing[0], writing[1], ("605#60 00 00 00 00 00 00 00", UNEXPECTED)]);
    dialogue(&[writing[0], writing[1], writing[2], ("585#00 41 42 43 44 45 46 47", UNEXPECTED)]);
    dialogue(&[writing[0], READ_ANSWER_AMID_WRITE]);
}

const READ_ANSWER_AMID_WRITE: (&str, Option<Violation>) = (READ_ANSWER, UNEXPECTED);

/// If a capture begins in the middle of a block transfer, the messages at its end are no violation.
#[test]
fn the_rest_of_a_block_transfer_from_before_the_capture_is_excused() {
    let rest = [
        "605#A1 00 00 00 00 00 00 00",
        "605#A2 01 03 00 00 00 00 00",
        "605#C1 00 00 00 00 00 00 00",
        "585#A2 01 03 00 00 00 00 00",
        "585#A1 00 00 00 00 00 00 00",
        "585#C1 00 00 00 00 00 00 00",
    ];
    for frame in rest {
        dialogue(&[(frame, None)]);
    }
    // These messages begin a transfer, or belong to none.
    for frame in ["605#A3 00 00 00 00 00 00 00", "585#A4 08 10 00 03 00 00 00", "585#C6 08 10 00 0F 00 00 00"] {
        dialogue(&[(frame, UNEXPECTED)]);
    }
}

/// Either side may abort at any time (7.2.4.3.17). An abort without a transfer ends none.
#[test]
fn an_abort_ends_the_transfer_and_says_who_did() {
    let code = AbortCode::TIMEOUT;
    let trace = dialogue(&[(READ, None), (READ_ANSWER, None), ("605#80 08 10 00 00 00 04 05", None)]);
    assert_eq!(transfer(&trace).outcome, Outcome::Aborted(Side::Client, code));
    assert_eq!(transfer(&trace).duration(), Duration::from_millis(2));
    assert_eq!(events(&trace), [Event::TransferEnded]);
    assert_eq!(open(&trace), 0);

    let trace = dialogue(&[(READ, None), ("585#80 08 10 00 00 00 02 06", None)]);
    assert_eq!(transfer(&trace).outcome, Outcome::Aborted(Side::Server, AbortCode::NO_OBJECT));
    assert_eq!(transfer(&trace).violation, None, "bytes that were announced are not due any more");

    // The object in an abort of the server must be the right one; the object in an abort of the client is not checked.
    let other = Violation::Multiplexer(Multiplexer::new(0x1009, 0));
    let trace = dialogue(&[(READ, None), ("585#80 09 10 00 00 00 02 06", Some(other))]);
    assert_eq!(transfer(&trace).violation, Some(other));
    dialogue(&[(READ, None), ("605#80 09 10 00 00 00 04 05", None)]);

    let trace = dialogue(&[("605#80 08 10 00 00 00 04 05", None), ("585#80 08 10 00 00 00 04 05", None)]);
    assert_eq!((open(&trace), events(&trace)), (0, &[][..]));
}

/// An initiate request in the middle of a transfer leaves the open transfer.
#[test]
fn each_kind_of_request_leaves_the_transfer_before() {
    for (request, direction, mode) in [
        ("605#40 00 10 00 00 00 00 00", Direction::Upload, Mode::Expedited),
        ("605#2F 00 10 00 01 00 00 00", Direction::Download, Mode::Expedited),
        ("605#21 00 10 00 09 00 00 00", Direction::Download, Mode::Segmented),
        ("605#20 00 10 00 00 00 00 00", Direction::Download, Mode::Segmented),
        ("605#C6 00 10 00 09 00 00 00", Direction::Download, Mode::Block),
        ("605#A4 00 10 00 09 00 00 00", Direction::Upload, Mode::Block),
    ] {
        let trace = dialogue(&[(READ, None), (READ_ANSWER, None), (request, None)]);
        assert!(matches!(events(&trace), [Event::TransferLeft(_)]), "{request}");
        assert_eq!((left(&trace).outcome, left(&trace).multiplexer.index.0), (Outcome::Superseded, 0x1008));
        assert_eq!((left(&trace).mode, left(&trace).violation), (Mode::Segmented, None));
        let new = transfer(&trace);
        assert_eq!((new.direction, new.mode, new.multiplexer.index.0), (direction, mode, 0x1000), "{request}");
        assert_eq!((new.outcome, new.segments, new.duration()), (Outcome::Open, 0, Duration::ZERO), "{request}");
        // Without a transfer before, no transfer is left.
        let trace = dialogue(&[(request, None)]);
        assert_eq!((events(&trace), open(&trace)), (&[][..], 1), "{request}");
    }
}

/// The number of bytes must equal the announced number.
#[test]
fn the_number_of_bytes_is_that_which_was_announced() {
    let size = |announced, received| Some(Violation::Size { announced, received });
    for (announced, last, violation) in [
        ("585#41 08 10 00 07 00 00 00", "585#01 41 42 43 44 45 46 47", None),
        ("585#41 08 10 00 08 00 00 00", "585#01 41 42 43 44 45 46 47", size(8, 7)),
        ("585#41 08 10 00 06 00 00 00", "585#01 41 42 43 44 45 46 47", size(6, 7)),
        ("585#41 08 10 00 05 00 00 00", "585#05 41 42 43 44 45 00 00", None),
        ("585#40 08 10 00 00 00 00 00", "585#05 41 42 43 44 45 00 00", None),
    ] {
        let trace =
            dialogue(&[(READ, None), (announced, None), ("605#60 00 00 00 00 00 00 00", None), (last, violation)]);
        assert_eq!((transfer(&trace).outcome, transfer(&trace).violation), (Outcome::Complete, violation));
        assert_eq!(transfer(&trace).duration(), Duration::from_millis(3));
    }
    // The transfer keeps its first violation.
    let trace = dialogue(&[
        (READ, None),
        ("585#41 08 10 00 08 00 00 00", None),
        ("605#70 00 00 00 00 00 00 00", TOGGLE),
        ("585#11 41 42 43 44 45 46 47", None),
    ]);
    assert_eq!(transfer(&trace).violation, TOGGLE);
}

/// Request and answer are one message each (7.2.4.3.3 and 7.2.4.3.6), and the value is in one of them.
#[test]
fn expedited_transfers_hold_their_value() {
    let trace = dialogue(&[("605#2B 17 10 00 E8 03 00 00", None), ("585#60 17 10 00 00 00 00 00", None)]);
    let written = transfer(&trace);
    assert_eq!((written.direction, written.mode), (Direction::Download, Mode::Expedited));
    assert_eq!((written.data(), written.length(), written.segments), (&[0xE8, 0x03][..], 2, 0));
    assert_eq!(
        (written.announced, written.outcome, written.duration()),
        (None, Outcome::Complete, Duration(1_000_000))
    );

    let trace = dialogue(&[("605#40 17 10 00 00 00 00 00", None), ("585#4B 17 10 00 E8 03 00 00", None)]);
    let read = transfer(&trace);
    assert_eq!((read.direction, read.mode, read.data()), (Direction::Upload, Mode::Expedited, &[0xE8, 0x03][..]));
    assert_eq!((read.outcome, read.duration()), (Outcome::Complete, Duration(1_000_000)));
    // The next transfer keeps nothing of this transfer.
    let mut trace = trace;
    trace.say("605#40 17 10 00 00 00 00 00");
    assert_eq!((transfer(&trace).data(), transfer(&trace).length(), transfer(&trace).crc()), (&[][..], 0, 0));
}

/// The server may answer a request for a block upload with a normal one (7.2.4.3.13, protocol switch threshold).
#[test]
fn a_block_upload_can_become_a_normal_one() {
    let request = "605#A4 00 10 00 7F 15 00 00";
    let trace = dialogue(&[(request, None), ("585#43 00 10 00 96 01 02 00", None)]);
    assert_eq!((transfer(&trace).mode, transfer(&trace).outcome), (Mode::Expedited, Outcome::Complete));
    let trace = dialogue(&[
        (request, None),
        ("585#41 00 10 00 05 00 00 00", None),
        ("605#60 00 00 00 00 00 00 00", None),
        ("585#05 41 42 43 44 45 00 00", None),
    ]);
    assert_eq!((transfer(&trace).mode, transfer(&trace).outcome), (Mode::Segmented, Outcome::Complete));
    // Once the blocks have begun, the server can't change to a normal upload.
    dialogue(&[(request, None), ("585#C6 00 10 00 0F 00 00 00", None), ("585#43 00 10 00 96 01 02 00", UNEXPECTED)]);
}

/// A client gives up a block download and requests something else. Its request looks like a segment, and the answer
/// shows that it was none.
#[test]
fn the_answer_to_another_request_ends_a_block_download() {
    let start = [("605#C6 00 20 00 0F 00 00 00", None), ("585#A4 00 20 00 03 00 00 00", None)];
    for answer in ["585#43 00 10 00 96 01 02 00", "585#60 17 10 00 00 00 00 00"] {
        let segment = ("605#01 41 42 43 44 45 46 47", None);
        let trace = dialogue(&[start[0], start[1], segment, (answer, UNEXPECTED)]);
        assert!(matches!(events(&trace), [Event::TransferLeft(_)]), "{answer}");
        assert_eq!((left(&trace).outcome, open(&trace)), (Outcome::Superseded, 0), "{answer}");
        // Before the first segment no request can have been taken for a segment.
        let trace = dialogue(&[start[0], (answer, UNEXPECTED)]);
        assert_eq!((events(&trace), open(&trace)), (&[][..], 1), "{answer}");
    }
}

/// A boot-up leaves the open transfer, and an answer after the boot-up has no request.
#[test]
fn a_boot_up_leaves_the_transfer() {
    let mut trace = dialogue(&[(READ, None), (READ_ANSWER, None)]);
    trace.say("705#00");
    assert!(events(&trace).iter().any(|event| matches!(event, Event::TransferLeft(_))));
    assert_eq!((left(&trace).multiplexer.index.0, open(&trace)), (0x1008, 0));
    trace.say("705#00");
    assert!(!events(&trace).iter().any(|event| matches!(event, Event::TransferLeft(_))), "nothing was under way");
}

/// Each message of a transfer counts for its duration.
#[test]
fn a_transfer_lasts_until_its_latest_message() {
    let upload = [
        (READ, None),
        (READ_ANSWER, None),
        ("605#60 00 00 00 00 00 00 00", None),
        ("585#00 41 42 43 44 45 46 47", None),
        ("605#70 00 00 00 00 00 00 00", None),
    ];
    let download = [
        (WRITE, None),
        (WRITE_ANSWER, None),
        ("605#00 41 42 43 44 45 46 47", None),
        ("585#20 00 00 00 00 00 00 00", None),
        ("605#10 48 49 4A 4B 4C 4D 4E", None),
    ];
    for whole in [upload, download] {
        for length in 1..=whole.len() {
            let trace = dialogue(&whole[..length]);
            assert_eq!(
                transfer(&trace).duration(),
                Duration::from_millis(length as u64 - 1),
                "{}",
                whole[length - 1].0
            );
        }
    }
}
