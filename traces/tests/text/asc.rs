use crate::frames::*;
use canvass_traces::*;
use proptest::prelude::*;

const ASC: Format = Format::Asc;
const HEADER: &str = "date Sam Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\ninternal events logged\n";
/// 2017-09-30 15:06:13.191 in nanoseconds since 1970.
const START: u64 = 1_506_783_973_191_000_000;

fn shown(row: &str) -> String {
    let record = one(ASC, &format!("{HEADER}{row}\n"));
    format!("{} {}", record.notation(), record.direction).trim_end().to_owned()
}

#[test]
fn classical_rows() {
    for (row, expected) in [
        (
            "  3.098426 1  18EBFF00x       Rx d 8 01 A0 0F A6 60 3B D1 40    Length = 273910 BitCount = 141",
            "18EBFF00#01A00FA6603BD140 Rx",
        ),
        (" 17.876708 1  6F9             Tx   d 2 05 0C  Length = 240015 BitCount = 124 ID = 1785", "6F9#050C Tx"),
        ("  0.5 1  100 Rx d 0", "100# Rx"),
        ("  0.5 1  100 Rx d a 01 02 03 04 05 06 07 08", "100#0102030405060708_A Rx"),
        ("  2.510001 1 100 Rx r", "100#R Rx"),
        ("  2.520002 3 200 Tx r Length = 1704000 BitCount = 145 ID = 88888888x", "200#R Tx"),
        ("  2.584921 4 300 Rx r 8 Length = 1704000 BitCount = 145 ID = 88888888x", "300#R8 Rx"),
        ("  2.501000 1 ErrorFrame", "20000080#"),
        ("  3.501000 1 ErrorFrame ECC: 10100010", "20000080#"),
    ] {
        assert_eq!(shown(row), expected, "{row}");
    }
}

#[test]
fn canfd_rows_carry_every_kind() {
    let tail = "   104812  132   323000 a800f6c9 46500250 4b140250 20011736 2001040d";
    for (row, expected) in [
        (
            format!(" 0.1 CANFD  62 Rx  7d  BrakeSnData_4  1 0 8  8 01 1b d6 d0 8a 1f d7 f6 {tail}"),
            "07D##5011BD6D08A1FD7F6 Rx",
        ),
        (format!(" 0.1 CANFD  62 Rx  88   0 1 8  8 00 00 f6 90 00 00 00 00 {tail}"), "088##60000F69000000000 Rx"),
        (
            format!(" 0.1 CANFD  62 Tx  167x  1 0 9 12 73 80 00 10 00 09 e3 00 01 02 03 04 {tail}"),
            "00000167##573800010000 9E30001020304 Tx",
        ),
        (" 0.1 CANFD 3 Tx 50005x  0 1 5 0 140000 73 200050 7a60 46500250 460a0250".into(), "00050005#R5 Tx"),
        (" 0.1 CANFD 3 Rx 123  0 0 3 3 11 22 33 140000 73 200040 7a60 46500250".into(), "123#112233 Rx"),
        (" 0.1 CANFD 3 Rx 123  0 0 3 3 11 22 33 140000 73 1000 7a60 46500250".into(), "123##4112233 Rx"),
        (" 0.1 CANFD 5 Tx ErrorFrame Not Acknowledge error, dominant error flag fffe c7".into(), "20000080# Tx"),
    ]
    .map(|(row, expected): (String, &str)| (row, expected.replace(' ', "").replace("Rx", " Rx").replace("Tx", " Tx")))
    {
        assert_eq!(shown(&row), expected, "{row}");
    }
    let long = format!(" 0.1 CANFD 4 Rx 4EE  0 1 f 64 {} 1331984 11 0 46500250 460a0250", "A1 ".repeat(64));
    let record = one(ASC, &format!("{HEADER}{long}\n"));
    assert!(record.frame.is_fd() && record.data() == [0xA1; 64], "its length tells CAN FD, though its flags are 0");
}

#[test]
fn decimal_base() {
    let text = "base dec  timestamps absolute\n 0.1 1  1663 Rx d 3 17 255 0\n 0.1 1  418119424x Rx d 1 7\n";
    let shown: Vec<_> = items(ASC, text).into_iter().map(|item| item.unwrap().frame.to_string()).collect();
    assert_eq!(shown, ["67F#11FF00", "18EBFF00#07"]);
}

#[test]
fn other_events_are_passed_over_but_move_a_relative_clock() {
    let rows = "Begin Triggerblock Sam Sep 30 15:06:13.191 2017\n   0.000000 Start of measurement\n\
        \u{20} 1.0 CAN 1 Status:chip status error passive - TxErr: 132 RxErr: 0\n  1.0 1  Statistic: D 0 R 0 XD 0\n\
        \u{20} 1.0 1  J1939TP FEE3p        6    0  0   -   Rx   d 23 A0 0F A6\n  1.0 1  100 TxRq d 1 11\n// note\n\
        \u{20} 1.0 1  100 Tx d 1 11\nEnd TriggerBlock\n";
    let relative = HEADER.replace("absolute", "relative") + rows;
    assert_eq!(one(ASC, &relative).timestamp, Timestamp(START + 5_000_000_000));
    let (items, names, base) = read(ASC, format!("{HEADER}{rows}").as_bytes());
    assert_eq!(items[0].as_ref().unwrap().timestamp, Timestamp(START + 1_000_000_000));
    assert_eq!((items.len(), names, base), (1, vec!["1".to_owned()], TimeBase::Local));
}

#[test]
fn a_row_that_is_neither_a_frame_nor_a_known_event_is_reported() {
    let whole = "  0.1 1  100             Rx   d 2 11 22\n";
    assert_eq!(shown(whole.trim_end()), "100#1122 Rx");
    for (row, kind) in [
        ("0.1 x  100 Rx d 2 11 22", DamageKind::Unsupported),
        ("0.1 CANFE 1 Rx 100 1 0 2 2 11 22", DamageKind::Unsupported),
        ("0.1 CAND 1 Rx 100 1 0 2 2 11 22", DamageKind::Unsupported),
        ("0.1 1 100 Ry d 2 11 22", DamageKind::Malformed),
        ("0.1 1 100 xR d 2 11 22", DamageKind::Malformed),
        ("0.1 1 1x0 Rx d 2 11 22", DamageKind::Malformed),
        ("0.1 1 100", DamageKind::Malformed),
        ("0.1 1", DamageKind::Malformed),
        ("0.1 1 100 Rx r 2 11 22", DamageKind::Malformed),
        ("0.1 1 ErrorFrane", DamageKind::Malformed),
        ("0.1 1 Statistik: D 0", DamageKind::Malformed),
        ("; 0.1 1 100 Rx d 2 11 22", DamageKind::Malformed),
        ("99999999999.1 1 100 Rx d 2 11 22", DamageKind::Malformed),
        ("18446744073.1 1 100 Rx d 2 11 22", DamageKind::Malformed),
    ] {
        assert_eq!(damage(ASC, &format!("{HEADER}{row}\n")).kind, kind, "{row}");
    }
    let relative = HEADER.replace("absolute", "relative") + "18446744073.5 1 100 Rx d 0\n".repeat(2).as_str();
    assert_eq!(items(ASC, &relative).iter().filter(|item| item.is_err()).count(), 2);
    for event in [
        "Start of measurement",
        "SV: 2 0 1 ::x::y = 1",
        "CAN 1 Status:chip status error active",
        "EnvSpeed := 12",
        "L1 3c Rx 8",
        "1 OverloadFrame",
        "log trigger event",
    ] {
        assert_eq!(items(ASC, &format!("{HEADER}0.1 {event}\n; time can ident\n")), [], "{event}");
    }
}

#[test]
fn dates() {
    let start = |date: &str| {
        one(ASC, &format!("date {date}\nbase hex timestamps absolute\n0.0 1 100 Rx d 0\n")).timestamp.nanos()
    };
    assert_eq!(start("Sam Sep 30 03:06:13.191 PM 2017"), START);
    assert_eq!(start("Sat Sep 30 15:06:13.191 2017"), START);
    assert_eq!(start("Sam Mai 30 12:06:13 am 2020"), 1_590_797_173_000_000_000);
    assert_eq!(start("Son M\u{E4}r 1 10:00:00.000 2020"), 1_583_056_800_000_000_000);
    let (items, _, base) = read(ASC, b"date someday\nbase hex  timestamps absolute\n1.5 1 100 Rx d 0\n");
    assert_eq!(items[0].as_ref().unwrap_err().kind, DamageKind::Unsupported);
    assert_eq!((items[1].as_ref().unwrap().timestamp, base), (Timestamp(1_500_000_000), TimeBase::Start));
}

#[test]
fn malformed_rows_are_located() {
    for (row, column, expected) in [
        ("0.1 1 800 Rx d 1 11", 7, "at most 7FF"),
        ("0.1 1 12G Rx d 1 11", 7, "an id"),
        ("0.1 1 100 Rx d 2 11", 20, "a byte"),
        ("0.1 1 100 Rx d 2 11 2", 22, "second hex digit"),
        ("0.1 1 100 Rx d 1 11 22", 21, "no more bytes"),
        ("0.1 1 100 Rx d 10 11", 16, "one hex digit"),
        ("0.1 1 100 Rx q 1 11", 14, "d (data) or r"),
        ("0.1 CANFD 1 Rx 100 1 0 9 13 1 2 3", 30, "second hex digit"),
        ("nonsense", 1, "time in seconds"),
    ] {
        let damage = damage(ASC, &format!("{HEADER}{row}\n"));
        assert_eq!(
            (damage.kind, damage.column, damage.place.number),
            (DamageKind::Malformed, Some(column), 4),
            "{row}: {damage}"
        );
        assert!(damage.expected.contains(expected), "{row}: {damage}");
    }
    assert_eq!(damage(ASC, &format!("{HEADER}0.1 CANXL 1 Rx\n")).kind, DamageKind::Unsupported);
}

#[test]
fn recognised() {
    for text in
        ["date Sam Sep 30 15:06:13.191 2017\n", "// x\r\nbase hex  timestamps absolute\r\n", "0.5 1  100 Rx d 1 11"]
    {
        assert_eq!(Format::sniff(text.as_bytes()), Some(ASC), "{text}");
    }
}

#[test]
fn losses_are_counted() {
    let frame = Frame::new(CanId::standard(1).unwrap(), &[]).unwrap();
    let records = [
        Record::new(Timestamp(2_000_000_000_000_000_000), ChannelId(0), frame),
        Record::new(Timestamp(1_000_000_000_000_000_000), ChannelId(0), Frame::error(ErrorClass(4), &[1]).unwrap()),
        parse_frame("45123#81:00:12345678#11").unwrap(),
    ];
    let (_, losses) = written(ASC, &records, &channels(&["can0"]), TimeBase::Utc);
    let expected = [
        (Loss::Frame, 1),
        (Loss::ChannelName, 2),
        (Loss::Direction, 1),
        (Loss::TimeResolution, 1),
        (Loss::TimeZone, 2),
        (Loss::ErrorDetail, 1),
    ];
    assert_eq!(losses.iter().collect::<Vec<_>>(), expected);
}

proptest! {
    #[test]
    fn written_and_read_back(
        mut records in records(prop_oneof![classical(), fd()], START..START + 1_000_000_000_000,
            prop_oneof![Just(Direction::Rx), Just(Direction::Tx)])
    ) {
        records.sort_by_key(|record| record.timestamp);
        for record in &mut records {
            record.channel = ChannelId(0);
        }
        let (bytes, losses) = written(ASC, &records, &channels(&["1"]), TimeBase::Local);
        prop_assert!(losses.is_empty());
        let read = without_places(items(ASC, std::str::from_utf8(&bytes).unwrap()).into_iter().map(Result::unwrap));
        prop_assert_eq!(read, records);
    }
}
