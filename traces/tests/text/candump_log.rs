use crate::frames::*;
use canvass_traces::*;
use proptest::prelude::*;
use std::io::Read;

const LOG: Format = Format::Candump;

fn id(raw: u32) -> CanId {
    CanId::standard(raw).unwrap()
}

#[test]
fn a_line_as_candump_writes_it() {
    let (items, names, base) = read(LOG, b"(1700000000.123456) can0 63F#4000600000000000\n");
    let expected = Record::new(
        Timestamp(1_700_000_000_123_456_000),
        ChannelId(0),
        Frame::full(id(0x63F), [0x40, 0, 0x60, 0, 0, 0, 0, 0]),
    );
    assert_eq!(items, [Ok(expected.at(1, 0))]);
    assert_eq!((names, base), (vec!["can0".to_owned()], TimeBase::Utc));
}

#[test]
fn padded_names_directions_and_line_ends() {
    let text = "(1700000000.000001)   can0 123#11 R\r\n(1700000000.000002) vcan12 123#22 T\n\n(1700000000.000003)  can0 123#33 0\n";
    let (items, names, _) = read(LOG, text.as_bytes());
    let records: Vec<_> = items.into_iter().map(Result::unwrap).collect();
    assert_eq!(names, ["can0", "vcan12"]);
    let seen: Vec<_> = records.iter().map(|r| (r.channel.0, r.direction, r.place.number, r.frame.data()[0])).collect();
    let expected = [(0, Direction::Rx, 1, 0x11), (1, Direction::Tx, 2, 0x22), (0, Direction::Unknown, 4, 0x33)];
    assert_eq!(seen, expected);
    assert_eq!(records[1].place.offset, 37);
}

#[test]
fn times_of_six_and_nine_digits_and_from_zero() {
    assert_eq!(one(LOG, "(1700000000.123456789) can0 123#11\n").timestamp, Timestamp(1_700_000_000_123_456_789));
    let (items, _, base) = read(LOG, b"(000.000123) can0 123#11\n(012.500000) can0 123#11\n");
    let times: Vec<_> = items.into_iter().map(|item| item.unwrap().timestamp.nanos()).collect();
    assert_eq!((times, base), (vec![123_000, 12_500_000_000], TimeBase::Start));
}

#[test]
fn recorded_losses_are_told() {
    let text = "DROPCOUNT: dropped 5 CAN frames on 'can0' socket (total drops 7)\n\
                (1700000000.123456) can0 123#11\n\
                DROPCOUNT: dropped 1 CAN frame on 'can0' socket (total drops 8)\n";
    let kinds: Vec<_> = items(LOG, text).into_iter().filter_map(|item| item.err().map(|d| d.kind)).collect();
    assert_eq!(kinds, [DamageKind::Dropped(5), DamageKind::Dropped(1)]);
}

#[test]
fn what_explains_and_comments_is_passed_over() {
    let text = "\u{FEFF}# excerpt\n; of\n// a log\n\n(1700000000.123456) can0 20000004#0008000000000000\n\
                \tcontroller-problem{tx-error-warning}\n\terror-counter-tx-rx{{96}{0}}\n  (1700000001.0) can0 123#11 # here\n";
    let items = items(LOG, text);
    assert_eq!(items.len(), 2, "{items:?}");
    assert!(items[0].as_ref().unwrap().frame.is_error());
    assert_eq!(items[1].as_ref().unwrap().place.number, 8);
    assert_eq!(damage(LOG, "\tcontroller-problem{}\n").kind, DamageKind::Malformed, "no error frame before it");
}

#[test]
fn a_frame_with_a_damaged_first_byte_is_no_comment() {
    for first in ['#', ';', '\t', ' ', 'x'] {
        let text = format!("(1700000000.1) can0 20000004#0008000000000000\n{first}1700000000.123456) can0 123#11\n");
        let items = items(LOG, &text);
        assert_eq!(items[1].as_ref().unwrap_err().kind, DamageKind::Malformed, "{first}");
    }
    assert_eq!(items(LOG, "#(1700000000.1) can0 123#11\n# 1700000000.123456) can0 123#11\n;x\n//y\n"), []);
}

#[test]
fn malformed_lines_are_located_and_reading_goes_on() {
    for (text, column, expected) in [
        ("(1700000000.123456) can0 123#112\n", 33, "second hex digit"),
        ("(1700000000.123456) can0 1234#11\n", 26, "3 digits"),
        ("(1700000000.123456) can0 123#11 22 33\n", 33, "end of the line"),
        ("(1700000000.123456) can0 123#11 22\n", 33, "end of the line"),
        ("(1700000000.123456) can0 123#11x\n", 32, "hex digit of the data"),
        ("(1700000000.123456) can0\n", 25, "a space before the line ends"),
        ("(1700000000 can0 123#11\n", 12, "decimal point"),
        ("(1700000000.123456 can0 123#11\n", 19, "')'"),
        ("(-1.123456) can0 123#11\n", 2, "time in seconds"),
        ("123#11\n", 1, "a frame, such as"),
    ] {
        let twice = format!("{text}(1700000000.123456) can0 123#11\n");
        let items = items(LOG, &twice);
        let damage = items[0].as_ref().unwrap_err();
        assert_eq!((damage.kind, damage.column), (DamageKind::Malformed, Some(column)), "{text}: {damage}");
        assert!(damage.expected.contains(expected), "{text}: {damage}");
        assert_eq!(items[1].as_ref().unwrap().place, Place { number: 2, offset: text.len() as u64 });
    }
}

#[test]
fn a_last_line_without_end_is_read_only_if_it_can_not_go_on() {
    let last = |frame: &str| items(LOG, &format!("(1700000000.123456) can0 {frame}")).remove(0);
    for whole in [
        "123#1122334455667788",
        "123#1122334455667788_E",
        "123#11 R",
        "123#11 0",
        "123#R3",
        "123#R8",
        "20000004#0008000000000000",
        "123#11\r",
    ] {
        assert!(last(whole).is_ok(), "{whole}");
    }
    assert!(last(&format!("123##5{}", "11".repeat(64))).is_ok());
    for cut in
        ["1", "123", "123#", "123#1", "123#11", "123#11 ", "123#R", "123##", "123##51122", "45123#81:00:12345678#11"]
    {
        assert_eq!(last(cut).unwrap_err().kind, DamageKind::Truncated, "{cut}");
    }
    assert_eq!(last("123#11x").unwrap_err().kind, DamageKind::Malformed);
}

#[test]
fn the_last_line_needs_what_the_others_had() {
    let last = |before: &str, frame: &str| {
        items(LOG, &format!("(1700000000.123456) can0 {before}\n(1700000000.123456) can0 {frame}")).remove(1)
    };
    assert!(last("123#11", "123#1122334455667788").is_ok());
    assert!(last("123#11 R", "123#1122334455667788").is_err());
    assert!(last("123#11 R", "123#1122334455667788 T").is_ok());
    assert!(last("123#1122334455667788_9", "123#1122334455667788").is_err());
    assert!(last("123#1122334455667788_9", "123#1122334455667788_A").is_ok());
}

#[test]
fn a_frame_comes_out_as_soon_as_its_line_is_complete() {
    /// Gives two lines, and panics if more is read before the first record is returned.
    struct Pipe(Vec<&'static [u8]>);
    impl Read for Pipe {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            let next = self.0.pop().expect("asked for more than one line");
            buffer[..next.len()].copy_from_slice(next);
            Ok(next.len())
        }
    }
    let source = Source::new(Pipe(vec![b"(1.0) can0 123#11\n"]));
    let mut capture = Capture::from_source("-", source, &ReadOptions::default()).unwrap();
    assert_eq!(capture.format(), LOG);
    assert!(capture.next().unwrap().is_ok());
}

#[test]
fn recognised_from_its_first_line() {
    for log in [
        "(1700000000.123456) can0 123#11\n",
        "(1700000000.123456) can0 123#",
        "\u{FEFF}\r\n# note\r\nDROPCOUNT: dropped 5 CAN frames on 'can0' socket (total drops 7)\r\n(000.000000)   can0 1ABCDEF0##5\r\n",
        "damaged\n(1700000000.123456) can0 123#11\n",
        "(1700000000.123456) can0 12G#11\n",
    ] {
        assert_eq!(Format::sniff(log.as_bytes()), Some(LOG), "{log}");
    }
    for other in ["", "\n", "(1700000000.123456) can0", "(1700000000.123456)  can0  123   [1]  11\n", "# comment\n"] {
        assert_ne!(Format::sniff(other.as_bytes()), Some(LOG), "{other}");
    }
}

#[test]
fn written_as_candump_writes_it() {
    let frame = Frame::new(id(0x123), &[0x11]).unwrap();
    let records = [
        Record::new(Timestamp(1_700_000_000_123_456_000), ChannelId(0), frame),
        Record::new(Timestamp(1_700_000_000_123_456_789), ChannelId(0), frame).with_direction(Direction::Tx),
        Record::new(Timestamp(5_000), ChannelId(1), frame),
    ];
    let (bytes, losses) = written(LOG, &records, &channels(&["can0", "CAN 1"]), TimeBase::Utc);
    let text = String::from_utf8(bytes).unwrap();
    assert_eq!(
        text,
        "(1700000000.123456) can0 123#11\n(1700000000.123456789) can0 123#11 T\n(000.000005) CAN_1 123#11\n"
    );
    assert_eq!(losses.iter().collect::<Vec<_>>(), [(Loss::ChannelName, 1)]);
}

proptest! {
    #[test]
    fn written_and_read_back(records in records(any_frame(), any::<u64>(), direction())) {
        let (bytes, losses) = written(LOG, &records, &channels(&["can0", "vcan1"]), TimeBase::Utc);
        prop_assert!(losses.is_empty());
        let (items, names, _) = read(LOG, &bytes);
        let channels = channels(&["can0", "vcan1"]);
        let read = without_places(items.into_iter().map(Result::unwrap));
        prop_assert_eq!(read.len(), records.len());
        for (mut read, record) in read.into_iter().zip(records) {
            prop_assert_eq!(&names[usize::from(read.channel.0)], channels.name(record.channel));
            read.channel = record.channel;
            prop_assert_eq!(read, record);
        }
    }
}
