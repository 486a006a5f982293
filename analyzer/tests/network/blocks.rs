//! The order of the messages in block transfers (CiA 301, 7.2.4.3.8 to 7.2.4.3.16).

use crate::channels::{UNEXPECTED, dialogue, open, transfer};
use canvass_analyzer::network::sdo::{Mode, Outcome, Violation};
use canvass_analyzer::wire::sdo::crc16;
use canvass_traces::Duration;

type Line = (&'static str, Option<Violation>);

const fn right(frame: &'static str) -> Line {
    (frame, None)
}

/// Fifteen bytes in sub-blocks of two segments, without CRC.
const UPLOAD: [Line; 11] = [
    right("605#A0 08 10 00 02 00 00 00"),
    right("585#C2 08 10 00 0F 00 00 00"),
    right("605#A3 00 00 00 00 00 00 00"),
    right("585#01 41 42 43 44 45 46 47"),
    right("585#02 48 49 4A 4B 4C 4D 4E"),
    right("605#A2 02 02 00 00 00 00 00"),
    right("585#81 4F 00 00 00 00 00 00"),
    right("605#A2 01 02 00 00 00 00 00"),
    right("585#D9 00 00 00 00 00 00 00"),
    right("605#A1 00 00 00 00 00 00 00"),
    right("605#40 18 10 01 00 00 00 00"),
];

const DOWNLOAD: [Line; 10] = [
    right("605#C2 08 10 00 0F 00 00 00"),
    right("585#A0 08 10 00 02 00 00 00"),
    right("605#01 41 42 43 44 45 46 47"),
    right("605#02 48 49 4A 4B 4C 4D 4E"),
    right("585#A2 02 02 00 00 00 00 00"),
    right("605#81 4F 00 00 00 00 00 00"),
    right("585#A2 01 02 00 00 00 00 00"),
    right("605#D9 00 00 00 00 00 00 00"),
    right("585#A1 00 00 00 00 00 00 00"),
    right("605#40 18 10 01 00 00 00 00"),
];

#[test]
fn both_directions_message_by_message() {
    for whole in [&UPLOAD[..], &DOWNLOAD[..]] {
        let last = whole.len() - 1;
        let trace = dialogue(&whole[..last]);
        let done = transfer(&trace);
        assert_eq!((done.mode, done.outcome, done.violation), (Mode::Block, Outcome::Complete, None));
        assert_eq!((done.data(), done.announced, done.segments), (&b"ABCDEFGHIJKLMNO"[..], Some(15), 3));
        assert_eq!((done.crc(), done.length()), (crc16(0, b"ABCDEFGHIJKLMNO"), 15));
        assert_eq!(open(&trace), 0);
        // Each message belongs to the transfer and counts for its duration.
        for length in 1..=last {
            let trace = dialogue(&whole[..length]);
            assert_eq!(transfer(&trace).duration(), Duration::from_millis(length as u64 - 1), "{length}");
            assert_eq!(open(&trace), usize::from(length < last), "{length}");
        }
        // The next request leaves no transfer behind.
        assert_eq!(open(&dialogue(whole)), 1);
    }
}

/// Bytes count when the receiver has confirmed them; the last seven bytes count when the end message says how many.
#[test]
fn bytes_count_when_they_are_confirmed() {
    let lengths = |whole: &[Line]| {
        (1..whole.len()).map(|length| transfer(&dialogue(&whole[..length])).length()).collect::<Vec<_>>()
    };
    assert_eq!(lengths(&UPLOAD), [0, 0, 0, 0, 0, 14, 14, 14, 15, 15]);
    assert_eq!(lengths(&DOWNLOAD), [0, 0, 0, 0, 14, 14, 14, 15, 15]);
}

/// A complete exchange before, so that the capture can't have begun in the middle of a transfer.
const BEFORE: [Line; 2] = [right("605#40 18 10 01 00 00 00 00"), right("585#43 18 10 01 13 00 00 00")];

/// A message that belongs to another place of the transfer is reported, and changes nothing: the transfer goes on.
#[test]
fn a_message_of_another_place_is_told() {
    let start = "605#A3 00 00 00 00 00 00 00";
    let end = "585#D9 00 00 00 00 00 00 00";
    let confirm = "605#A2 02 02 00 00 00 00 00";
    for (place, strangers) in [
        (1, &[start, end, confirm, "585#A2 02 02 00 00 00 00 00"][..]),
        (2, &[end, confirm, "585#C2 08 10 00 0F 00 00 00", "585#A1 00 00 00 00 00 00 00"]),
        (3, &[start]),
        (5, &[start, end]),
        (8, &[start, confirm, "585#C2 08 10 00 0F 00 00 00"]),
        (9, &[start, confirm, end]),
    ] {
        for stranger in strangers {
            let mut frames = [&BEFORE, &UPLOAD[..UPLOAD.len() - 1]].concat();
            frames.insert(BEFORE.len() + place, (stranger, UNEXPECTED));
            let trace = dialogue(&frames);
            assert_eq!(transfer(&trace).data(), b"ABCDEFGHIJKLMNO", "{place}: {stranger}");
        }
    }
    let confirm = "585#A2 02 02 00 00 00 00 00";
    let end = "605#D9 00 00 00 00 00 00 00";
    for (place, strangers) in [
        (1, &[confirm, end, "605#A3 00 00 00 00 00 00 00", "585#C2 08 10 00 0F 00 00 00"][..]),
        (4, &[end, "585#A0 08 10 00 02 00 00 00"]),
        (7, &[confirm, "585#A0 08 10 00 02 00 00 00", "585#C1 00 00 00 00 00 00 00"]),
        (8, &[end, confirm]),
    ] {
        for stranger in strangers {
            let mut frames = [&BEFORE, &DOWNLOAD[..DOWNLOAD.len() - 1]].concat();
            frames.insert(BEFORE.len() + place, (stranger, UNEXPECTED));
            let trace = dialogue(&frames);
            assert_eq!(transfer(&trace).data(), b"ABCDEFGHIJKLMNO", "{place}: {stranger}");
        }
    }
}

/// An end message that comes before other messages that are due ends the transfer, and is reported.
#[test]
fn an_early_end_ends_it() {
    for place in [2, 3, 4, 5, 6, 7, 8] {
        let mut frames = UPLOAD[..place].to_vec();
        frames.push(("605#A1 00 00 00 00 00 00 00", UNEXPECTED));
        let trace = dialogue(&frames);
        assert_eq!((transfer(&trace).outcome, transfer(&trace).violation), (Outcome::Complete, UNEXPECTED), "{place}");
        assert_eq!(transfer(&trace).duration(), Duration::from_millis(place as u64));
    }
    for place in [2, 3, 4, 5, 6, 7] {
        let mut frames = DOWNLOAD[..place].to_vec();
        frames.push(("585#A1 00 00 00 00 00 00 00", UNEXPECTED));
        let trace = dialogue(&frames);
        assert_eq!((transfer(&trace).outcome, transfer(&trace).violation), (Outcome::Complete, UNEXPECTED), "{place}");
        assert_eq!(transfer(&trace).duration(), Duration::from_millis(place as u64));
    }
}

/// Segments are numbered from 1 in every sub-block. A missing or repeated segment is reported. The transfer itself gets
/// a violation only when the receiver confirms segments that the capture lacks.
#[test]
fn numbers_of_segments_go_up_by_one() {
    let sequence = |expected, found| Some(Violation::Sequence { expected, found });
    let trace = dialogue(&[
        DOWNLOAD[0],
        DOWNLOAD[1],
        ("605#02 48 49 4A 4B 4C 4D 4E", sequence(1, 2)),
        right("585#A2 00 03 00 00 00 00 00"),
        right("605#01 41 42 43 44 45 46 47"),
        ("605#01 41 42 43 44 45 46 47", sequence(2, 1)),
        right("605#02 48 49 4A 4B 4C 4D 4E"),
        right("605#83 4F 00 00 00 00 00 00"),
        // A CAN controller repeats a frame whose last bit was disturbed.
        ("605#83 4F 00 00 00 00 00 00", sequence(4, 3)),
        right("585#A2 03 02 00 00 00 00 00"),
        DOWNLOAD[7],
        DOWNLOAD[8],
    ]);
    let done = transfer(&trace);
    assert_eq!((done.data(), done.violation, done.segments), (&b"ABCDEFGHIJKLMNO"[..], None, 3));

    let trace = dialogue(&[
        DOWNLOAD[0],
        DOWNLOAD[1],
        ("605#02 48 49 4A 4B 4C 4D 4E", sequence(1, 2)),
        right("585#A2 02 02 00 00 00 00 00"),
    ]);
    assert_eq!((transfer(&trace).violation, transfer(&trace).segments), (sequence(1, 2), 0));

    // The same holds for an upload.
    let trace = dialogue(&[
        UPLOAD[0],
        UPLOAD[1],
        UPLOAD[2],
        right("585#01 41 42 43 44 45 46 47"),
        ("585#03 4F 00 00 00 00 00 00", sequence(2, 3)),
        right("605#A2 01 02 00 00 00 00 00"),
        right("585#01 48 49 4A 4B 4C 4D 4E"),
        right("585#82 4F 00 00 00 00 00 00"),
        right("605#A2 02 02 00 00 00 00 00"),
        UPLOAD[8],
        UPLOAD[9],
    ]);
    assert_eq!((transfer(&trace).data(), transfer(&trace).violation), (&b"ABCDEFGHIJKLMNO"[..], None));
}

/// The checksum of `123456789` is 31C3h (CiA 301, 7.2.4.3.16): checked where both sides announced it.
#[test]
fn a_checksum_counts_where_both_know_it() {
    let with = |client: &'static str, server: &'static str, end: &'static str| {
        let crc = Violation::Crc { sent: 0x31C4, calculated: 0x31C3 };
        let wrong = client.contains("#C6") && server.contains("#A4") && end.contains("C4 31");
        let trace = dialogue(&[
            right(client),
            right(server),
            right("605#01 31 32 33 34 35 36 37"),
            right("605#82 38 39 00 00 00 00 00"),
            right("585#A2 02 02 00 00 00 00 00"),
            (end, wrong.then_some(crc)),
            right("585#A1 00 00 00 00 00 00 00"),
        ]);
        assert_eq!((transfer(&trace).data(), transfer(&trace).outcome), (&b"123456789"[..], Outcome::Complete));
        assert_eq!(transfer(&trace).violation, wrong.then_some(crc));
    };
    for client in ["605#C6 08 10 00 09 00 00 00", "605#C2 08 10 00 09 00 00 00"] {
        for server in ["585#A4 08 10 00 02 00 00 00", "585#A0 08 10 00 02 00 00 00"] {
            for end in ["605#D5 C3 31 00 00 00 00 00", "605#D5 C4 31 00 00 00 00 00"] {
                with(client, server, end);
            }
        }
    }
}

/// After ten seconds without a frame the sub-block is over. Until then a frame that looks like a segment is one.
#[test]
fn a_sub_block_waits_for_ten_seconds() {
    for (silence, is_segment) in [(9_999, true), (10_000, false)] {
        let mut trace = dialogue(&DOWNLOAD[..3]);
        trace.now += Duration::from_millis(silence);
        let said = trace.say("605#40 00 10 00 00 00 00 00");
        assert_eq!(said.text.starts_with("read 1000h:00"), !is_segment, "{}", said.text);
    }
}

/// A block upload, too, reports an answer that names another object than the request.
#[test]
fn an_answer_about_another_object_is_told() {
    let other = Violation::Multiplexer(canvass_analyzer::Multiplexer::new(0x1009, 0));
    let trace = dialogue(&[UPLOAD[0], ("585#C2 09 10 00 0F 00 00 00", Some(other))]);
    assert_eq!(transfer(&trace).violation, Some(other));
    let trace = dialogue(&[DOWNLOAD[0], ("585#A0 09 10 00 02 00 00 00", Some(other))]);
    assert_eq!(transfer(&trace).violation, Some(other));
}

/// After the end of a sub-block no other frame is a segment, whatever it looks like.
#[test]
fn after_a_sub_block_requests_are_requests() {
    for (whole, places, request) in
        [(&DOWNLOAD[..], [4, 6], "605#40 00 10 00 00 00 00 00"), (&UPLOAD[..], [5, 7], "585#43 00 10 00 96 01 02 00")]
    {
        for place in places {
            let mut trace = dialogue(&whole[..place]);
            let said = trace.say(request);
            assert!(said.text.starts_with("read "), "{place}: {}", said.text);
        }
    }
}

/// The receiver confirms a whole sub-block of which the capture lacks segments: this does not make it the last
/// sub-block.
#[test]
fn a_sub_block_with_a_gap_goes_on() {
    let sequence = |expected, found| Some(Violation::Sequence { expected, found });
    for (confirmed, next, goes_on) in [
        ("585#A2 03 02 00 00 00 00 00", right("605#01 4F 50 51 52 53 54 55"), true),
        ("585#A2 02 02 00 00 00 00 00", right("605#D9 00 00 00 00 00 00 00"), false),
    ] {
        let trace = dialogue(&[
            DOWNLOAD[0],
            right("585#A0 08 10 00 03 00 00 00"),
            right("605#01 41 42 43 44 45 46 47"),
            right(confirmed),
            next,
        ]);
        let expected = if goes_on { sequence(2, 3) } else { sequence(2, 2) };
        assert_eq!(transfer(&trace).violation, expected, "{confirmed}");
        assert_eq!(open(&trace), 1);
    }
}
