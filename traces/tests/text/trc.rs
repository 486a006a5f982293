use crate::frames::*;
use canvass_traces::*;
use proptest::prelude::*;

const TRC: Format = Format::Trc;
/// 2021-12-18 14:28:07.062000960, the date of `$STARTTIME=44548.6028595139`.
const START: u64 = 1_639_837_687_062_000_960;

fn seen(text: &str) -> Vec<String> {
    items(TRC, text)
        .into_iter()
        .map(|item| match item {
            Ok(record) => format!("{} {}", record.notation(), record.direction).trim_end().to_owned(),
            Err(damage) => damage.kind.name().to_owned(),
        })
        .collect()
}

#[test]
fn version_1_0_has_no_version() {
    let text = ";##########################\n;   Start time: 18.12.2021 14:28:07.062\n;----+-   ---+---  ----+---  +  -+ -- -- ...\n\
        \u{20}    1)     17535  00000100  8  00 11 22 33 44 55 66 77 \n\
        \u{20}    2)     17540  FFFFFFFF  4  00 00 00 08 -- -- -- -- BUSHEAVY\n\
        \u{20}    3)     19295      0010  2  01 02\n     4)     48937      0704  1  RTR\n\
        \u{20}    5)     48938      0008  4  ERROR  00 19 08 08\n";
    assert_eq!(seen(text), ["00000100#0011223344556677", "010#0102", "704#R1", "20000080#"]);
    let (items, names, base) = read(TRC, text.as_bytes());
    let start = 1_639_837_687_062_000_000;
    assert_eq!(items[0].as_ref().unwrap().timestamp, Timestamp(start + 17_535_000_000));
    assert_eq!((names, base), (vec!["1".to_owned()], TimeBase::Local));
    let without_start = text.replace("Start time", "Beginning");
    assert_eq!(read(TRC, without_start.as_bytes()).2, TimeBase::Start);
}

#[test]
fn version_1_1() {
    let text = ";$FILEVERSION=1.1\r\n;$STARTTIME=44548.6028595139\r\n;---+--\r\n\
        \u{20}    1)     17535.4  Tx     00000100  8  00 00 00 00 00 00 00 01 \r\n\
        \u{20}    2)     17540.3  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY \r\n\
        \u{20}    3)     19295.4  Rx         0000  1  02 \r\n     4)      7468.9  Tx         0000  8  RTR\r\n\
        \u{20}    5)      7469.0  Error      0008  4  00 19 08 08\r\n";
    assert_eq!(seen(text), ["00000100#0000000000000001 Tx", "000#02 Rx", "000#R8 Tx", "20000080#"]);
    let times: Vec<_> = items(TRC, text).into_iter().map(|item| item.unwrap().timestamp.nanos() - START).collect();
    assert_eq!(times[..2], [17_535_400_000, 19_295_400_000]);
}

#[test]
fn versions_1_2_and_1_3_have_a_bus() {
    let rows = "     1)        17535.4 2  Tx    00000100 -  2    00 01\n";
    let text = format!(";$FILEVERSION=1.3\n;$STARTTIME=44548.6028595139\n{rows}");
    let (items, names, _) = read(TRC, text.as_bytes());
    assert_eq!((items[0].as_ref().unwrap().data(), names), (&[0, 1][..], vec!["2".to_owned()]));
    assert_eq!(seen(&text.replace("1.3", "1.2").replace("- ", "")), ["00000100#0001 Tx"]);
}

#[test]
fn version_2_says_its_columns() {
    let v2_0 = ";$FILEVERSION=2.0\n;$STARTTIME=44548.6028595139\n;$COLUMNS=N,O,T,I,d,l,D\n\
        \u{20}     1     17535.400 DT 00000100 Tx 8  00 00 00 00 00 00 00 00\n\
        \u{20}     2     17540.300 ST          Rx    00 00 00 08\n\
        \u{20}     3     17541.300 FB     0100 Rx 12 00 01 02 03 04 05 06 07 08 09 0A 0B\n";
    assert_eq!(seen(v2_0), ["00000100#0000000000000000 Tx", "100##5000102030405060708090A0B Rx"]);
    let v2_1 = ";$FILEVERSION=2.1\n;$STARTTIME=44548.6028595139\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n\
        \u{20}     1     17535.400 DT 1      0100 Tx -  15   00 00 00 00 00 00 00 00\n\
        \u{20}     2     17540.300 ST 1         - Rx -  4    00 00 00 08\n\
        \u{20}     3     17541.300 FD 1      0100 Rx -  9    00 01 02 03 04 05 06 07 08 09 0A 0B\n\
        \u{20}     4     17541.300 FE 1      0100 Rx -  0 \n      5     17541.300 BI 1      0100 Rx -  1    01\n\
        \u{20}     6     17541.300 RR 1      0100 Rx -  3\n      7     17541.300 ER 1         - Rx -  5    04 00 02 00 00\n\
        \u{20}     8     17541.300 EC 1         - Rx -  2    01 02\n      9     17541.300 XX 1      0100 Rx -  0\n\
        \u{20}    10     17541.300 DT 1   0000123 Rx -  0 \n";
    let expected = [
        "100#0000000000000000_F Tx",
        "100##4000102030405060708090A0B Rx",
        "100##6 Rx",
        "100##701 Rx",
        "100#R3 Rx",
        "20000080# Rx",
        "unsupported",
        "00000123# Rx",
    ];
    assert_eq!(seen(v2_1), expected);
}

const V1_0: &str = ";###\n";
const V1_1: &str = ";$FILEVERSION=1.1\n;$STARTTIME=44548.6028595139\n";
const V2_0: &str = ";$FILEVERSION=2.0\n;$STARTTIME=44548.6028595139\n;$COLUMNS=N,O,T,I,d,l,D\n";
const V2_1: &str = ";$FILEVERSION=2.1\n;$STARTTIME=44548.6028595139\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n";

#[test]
fn a_row_that_is_neither_a_frame_nor_a_known_status_is_reported() {
    let (malformed, unsupported) = (DamageKind::Malformed, DamageKind::Unsupported);
    for (header, row, kind) in [
        (V1_0, "1)     1  FFFFFFF0  1  05", malformed),
        (V1_0, "1)     1  FFFFFFFF1  1  05", malformed),
        (V1_1, "1)     1.0  RX     0100  1  05", unsupported),
        (V1_1, "1)     1.0  Ry     0100  1  05", unsupported),
        (V1_1, "1)     1.0  DT     0100  1  05", unsupported),
        (V1_1, "1)     1.0  Rx FFFFFFFF  1  05", malformed),
        (V1_1, "1)     1.0  Rx FFFFFFF0  1  05", malformed),
        (V1_1, ";1)     1.0  Rx     0100  1  05", malformed),
        (V2_0, "1      1.0 ST     0100 Rx 1  05", malformed),
        (V2_0, "1      1.0 ER     0100 Rx 1  05", malformed),
        (V2_0, "1      1.0 EV     0100 Rx 1  05", malformed),
        (V2_0, "1      1.0 DX     0100 Rx 1  05", unsupported),
        (V2_1, "1      1.0 ST 1      0100 Rx -  1    05", malformed),
        (V2_1, "1      1.0 EC 1      0100 Rx -  1    05", malformed),
        (V2_1, "1      1.0 ER 1      0100 Rx -  1", malformed),
        (V2_1, "1      1.0 EV 1      0100 Rx -  1", malformed),
        (V2_1, "1      1.0 XT 1      0100 Rx -  1    05", unsupported),
        (V2_1, "1      18446744073709.0 DT 1      0100 Rx -  1    05", malformed),
    ] {
        assert_eq!(damage(TRC, &format!("{header}{row}\n")).kind, kind, "{row}");
    }
    for (header, row, expected) in [
        (V1_0, "1)     1  FFFFFFFF  4  00 00 00 08 -- -- -- -- BUSHEAVY", ""),
        (V1_1, "1)     1.0  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY", ""),
        (V2_0, "1      1.0 ST          Rx    00 00 00 08", ""),
        (V2_0, "1      1.0 ER          Rx    04 00 02 00 00", "20000080# Rx"),
        (V2_0, "1      1.0 EV  any text", ""),
        (V2_1, "1      1.0 EC 1         - Rx -  2    01 02", ""),
        (V2_1, "1      1.0 EV 1         - -  -  -    any text", ""),
        (V2_1, "1      1.0 ER 2         - Tx -  5    04 00 02 00 00", "20000080# Tx"),
    ] {
        let expected: Vec<_> = [expected].into_iter().filter(|text| !text.is_empty()).collect();
        assert_eq!(seen(&format!("{header}{row}\n")), expected, "{row}");
    }
}

#[test]
fn rows_that_are_missing_show_in_the_message_numbers() {
    let row = |number: u32| format!("{number:>7}      1.0 DT 1      0100 Rx -  1    05\n");
    let kinds = |numbers: &[u32]| {
        let text: String = numbers.iter().map(|&number| row(number)).collect();
        items(TRC, &format!("{V2_1}{text}")).into_iter().map(|item| item.err().map(|d| d.kind)).collect::<Vec<_>>()
    };
    assert_eq!(kinds(&[5, 6, 7]), [None; 3]);
    assert_eq!(kinds(&[5, 9, 10]), [None, None, None, Some(DamageKind::Dropped(3))]);
    assert_eq!(kinds(&[5, 96, 7, 8]), [None, None, None, Some(DamageKind::Malformed), None]);
    assert_eq!(kinds(&[5, 9]), [None, None, Some(DamageKind::Dropped(3))]);
    let status = "      6      1.0 ST 1         - Rx -  4    00 00 00 08\n";
    let broken = "      7      1.0 DT 1      01G0 Rx -  4    00 00 00 08\n";
    assert_eq!(seen(&format!("{V2_1}{}{status}{broken}{}", row(5), row(8))), ["100#05 Rx", "malformed", "100#05 Rx"]);
}

#[test]
fn a_last_remote_row_without_line_end_is_read_unless_its_length_may_go_on() {
    let last = |length: &str| {
        let row = format!("{V2_1}      1      1.0 RR 1      0100 Rx -  {length}");
        items(TRC, &row).remove(0).map(|record| record.notation().to_string()).map_err(|damage| damage.kind)
    };
    assert_eq!(last("3"), Ok("100#R3".to_owned()));
    assert_eq!(last("0"), Ok("100#R".to_owned()));
    assert_eq!(last("12"), Ok("100#R8_C".to_owned()));
    assert_eq!(last("1"), Err(DamageKind::Truncated), "12 for one");
    assert_eq!(last("1 "), Ok("100#R1".to_owned()));
    assert_eq!(last(""), Err(DamageKind::Truncated));
    let by_length = format!("{V2_0}      1      1.0 RR     0100 Rx 1");
    assert!(items(TRC, &by_length)[0].is_ok(), "there are no lengths above 8");
}

#[test]
fn rows_with_too_many_bytes_are_malformed_and_reading_goes_on() {
    let text = ";$FILEVERSION=1.1\n;$STARTTIME=44548.6028595139\n\
        \u{20}1)     1.0  Rx     0100  10  00 00 00 00 00 00 00 00 00 00\n\
        \u{20}2)     1.1  Rx     0100  14  00 00 00 00 00 00 00 00 00 00 00 00 00 00\n\
        \u{20}3)     1.2  Rx     0100  2  00\n 4)     1.3  Rx     0100  2  00 0\n 5)     1.4  Rx     0800  0\n\
        \u{20}6)     1.5  Rx     0100  1  00\n";
    assert_eq!(seen(text), ["malformed", "malformed", "malformed", "malformed", "malformed", "100#00 Rx"]);
    assert_eq!(items(TRC, text)[4].as_ref().unwrap_err().column, Some(21));
}

#[test]
fn recognised() {
    for text in [
        ";$FILEVERSION=1.1\r\n",
        ";\n; comment\n;$STARTTIME=44548.6\n",
        ";####\n;\n     1)     17535  00000100  8  00 11 22 33 44 55 66 77 \n",
    ] {
        assert_eq!(Format::sniff(text.as_bytes()), Some(TRC), "{text}");
    }
    assert_eq!(Format::sniff(b"; a comment\n(1700000000.123456) can0 123#11\n"), Some(Format::Candump));
}

proptest! {
    #[test]
    fn written_and_read_back(
        mut records in records(prop_oneof![classical(), fd()], 0..1_000_000_000_u64,
            prop_oneof![Just(Direction::Rx), Just(Direction::Tx)])
    ) {
        for record in &mut records {
            // The format has a resolution of microseconds.
            record.timestamp = Timestamp(1_639_837_687_062_000_000 + record.timestamp.nanos() * 1_000);
            record.channel = ChannelId(0);
        }
        records.sort_by_key(|record| record.timestamp);
        let (bytes, losses) = written(TRC, &records, &channels(&["1"]), TimeBase::Local);
        prop_assert!(losses.is_empty());
        let read = without_places(items(TRC, std::str::from_utf8(&bytes).unwrap()).into_iter().map(Result::unwrap));
        prop_assert_eq!(read, records);
    }
}

/// PEAK-Converter writes a table of the buses into the header of version 2.1.
#[test]
fn a_table_of_buses_in_the_header_is_no_damage() {
    let header = ";$FILEVERSION=2.1\n;$STARTTIME=45364.369224537\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n;\n\
                  ;   Bus  Name         Connection  Protocol\n;   1    PCAN-ROUTER  Channel-0   CAN\n\
                  ;   2    PCAN-ROUTER  Channel-1   CAN\n;-----\n";
    let row = "      1     16310.827 DT 1      0770 Rx -  1    05\n";
    let read = items(TRC, &format!("{header}{row}"));
    assert_eq!(read.iter().map(|item| item.is_ok()).collect::<Vec<_>>(), [true], "{read:?}");
    let damaged = items(TRC, &format!("{header};{}", &row[1..]));
    assert!(damaged.iter().any(|item| item.is_err()), "a row whose first byte is damaged");
}
