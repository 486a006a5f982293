use crate::frames::*;
use canvass_traces::*;
use proptest::prelude::*;
use std::io::Cursor;

const CSV: Format = Format::PythonCanCsv;
const MINIMON: Format = Format::MiniMon;
const HEADER: &str = "timestamp,arbitration_id,extended,remote,error,dlc,data\n";

#[test]
fn python_can_rows() {
    for (row, nanos, expected) in [
        ("1483389946.197,0xdadada,1,0,0,6,WzQyLCA5", 1_483_389_946_197_000_000, "00DADADA#5B34322C2039"),
        ("0.0,0x63f,0,0,0,8,QABgAAAAAAA=", 0, "63F#4000600000000000"),
        ("5e-05,0x1,0,1,0,3,", 50_000, "001#R3"),
        ("0.12345678951,0x80,1,0,1,2,AAE=", 123_456_790, "20000080#0001"),
        ("1.5,0x1,0,0,0,0,", 1_500_000_000, "001#"),
        ("1.5,0x1,0,0,0,12,AAECAwQFBgcICQoL", 1_500_000_000, "001##4000102030405060708090A0B"),
    ] {
        let record = one(CSV, &format!("{HEADER}{row}\n"));
        assert_eq!((record.timestamp.nanos(), record.notation().to_string().as_str()), (nanos, expected));
    }
}

#[test]
fn python_can_mistakes() {
    for (row, kind) in [
        ("1.5,0x800,0,0,0,0,\n", DamageKind::Malformed),
        ("1.5,0x1,0,0,0,2,AA==\n", DamageKind::Malformed),
        ("1.5,0x1,0,0,0,9,AAECAwQFBgcI\n", DamageKind::Malformed),
        ("-1.5,0x1,0,0,0,0,\n", DamageKind::Malformed),
        ("1.5,0x1,2,0,0,0,\n", DamageKind::Malformed),
        ("1.5,0x1,0,0,0,2,A*E=\n", DamageKind::Malformed),
        ("1.5,0x1,0,0,0,6,WzQy", DamageKind::Truncated),
        ("1.5,0x1,0,0,0,1,AA=", DamageKind::Truncated),
        ("1.5,0x1,0,0,0", DamageKind::Truncated),
    ] {
        assert_eq!(damage(CSV, &format!("{HEADER}{row}")).kind, kind, "{row}");
    }
}

proptest! {
    #[test]
    fn python_can_written_and_read_back(mut records in records(prop_oneof![
        classical().prop_filter("raw DLC is lost", |r| r.frame.dlc() <= 8), error(),
        fd().prop_filter("flags are lost", |r| r.frame.len() > 8 && r.frame.flags() == Flags::FDF),
    ], any::<u64>(), Just(Direction::Unknown))) {
        for record in &mut records {
            record.channel = ChannelId(0);
        }
        let (bytes, losses) = written(CSV, &records, &channels(&["1"]), TimeBase::Utc);
        prop_assert!(losses.is_empty());
        let read = without_places(items(CSV, std::str::from_utf8(&bytes).unwrap()).into_iter().map(Result::unwrap));
        prop_assert_eq!(read, records);
    }
}

const MINIMON_HEADER: &str = "ASCII Trace IXXAT MiniMon V3  Version: 1.1.4.4533\r\nDate: 28.01.2025\r\nStart time: 10:47:15\r\n\
    Stop time: 10:48:02\r\nOverruns: 0\r\nBaudrate: 250 kbit/s\r\n\
    \"Time\";\"Identifier (hex)\";\"Format\";\"Flags\";\"Data (hex)\"\r\n";
/// 2025-01-28 00:00.
const DAY: u64 = 1_738_022_400_000_000_000;

fn minimon(rows: &str) -> (Vec<(u64, String)>, TimeBase) {
    let (items, _, base) = read(MINIMON, format!("{MINIMON_HEADER}{rows}").as_bytes());
    let seen = items.into_iter().map(Result::unwrap).map(|r| (r.timestamp.nanos() - DAY, r.notation().to_string()));
    (seen.collect(), base)
}

#[test]
fn minimon_rows() {
    let rows = "\"10:47:15.23\";\"83\";\"Std\";\"\";\"00 11 \"\r\n\"10:47:15.24\";\"83\";\"Ext\";\"\";\"\"\r\n\
        10:47:15.250;\"24C\";\"Std\";\"\";\"00 00 00 00 00 00 00 00\"\r\n\"10:47:16.00\";\"701\";\"Std\";\"Rtr\";\"\"\r\n";
    let second = 1_000_000_000;
    let start = (10 * 3600 + 47 * 60 + 15) * second;
    let expected = [
        (start + 230_000_000, "083#0011".to_owned()),
        (start + 240_000_000, "00000083#".to_owned()),
        (start + 250_000_000, "24C#0000000000000000".to_owned()),
        (start + second, "701#R".to_owned()),
    ];
    assert_eq!(minimon(rows), (expected.to_vec(), TimeBase::Local));
}

#[test]
fn minimon_says_the_bit_rate() {
    let rate = |words: &str| {
        let header = MINIMON_HEADER.replace("250 kbit/s", words);
        let (text, options) = (header + "\"10:47:15.23\";\"83\";\"Std\";\"\";\"00 \"\r\n", ReadOptions::default());
        let mut capture = Capture::from_source("x", Source::new(Cursor::new(text.into_bytes())), &options).unwrap();
        assert_eq!(capture.by_ref().filter(Result::is_ok).count(), 1);
        capture.bit_rate()
    };
    assert_eq!(
        (rate("250 kbit/s"), rate("1 Mbit/s"), rate("83,3 kBaud")),
        (Some(250_000), Some(1_000_000), Some(83_300))
    );
    assert_eq!((rate("auto"), rate("-5 kbit/s"), rate("9 Mbit/s"), rate("")), (None, None, None, None));
}

#[test]
fn minimon_times_of_the_day_pass_midnight_and_others_count_from_the_start() {
    let times = |rows: &str| minimon(rows).0.into_iter().map(|(time, _)| time / 1_000_000_000).collect::<Vec<_>>();
    let row = |time: &str| format!("\"{time}\",\"83\",\"Std\",\"\",\"00 \"\n");
    assert_eq!(times(&(row("23:59:59.99") + &row("00:00:01.00"))), [86_399, 86_401]);
    assert_eq!(times(&(row("00:00:01.00") + &row("00:00:02.00"))), [38_836, 38_837]);
}

#[test]
fn minimon_with_english_settings() {
    let text = "ASCII Trace IXXAT MiniMon V3  Version: 1.1.4.4533\nDate: 5/9/2024\nStart time: 2:37:37 PM\nOverruns: 12\n\
        \"Time\",\"Identifier (hex)\",\"Format\",\"Flags\",\"Data (hex)\"\n\"14:37:37.866\",\"184\",\"Std\",\"\",\"00 06\"\n";
    let items = items(MINIMON, text);
    assert_eq!(items[0].as_ref().unwrap_err().kind, DamageKind::Dropped(12));
    assert_eq!(items[1].as_ref().unwrap().timestamp.nanos(), 1_715_265_457_866_000_000);
}

#[test]
fn minimon_mistakes() {
    for (row, kind) in [
        ("Overruns: many\n", DamageKind::Malformed),
        ("\"10:47:15.23\";\"800\";\"Std\";\"\";\"00\"\n", DamageKind::Malformed),
        ("\"10:47:15.23\";\"80\";\"Std\";\"\";\"00 1\"\n", DamageKind::Malformed),
        ("\"10:47:15.23\";\"80\";\"Std\";\"\";\"00 00 00 00 00 00 00 00 00\"\n", DamageKind::Malformed),
        ("\"10:47:61.23\";\"80\";\"Std\";\"\";\"00\"\n", DamageKind::Malformed),
        ("what is this\n", DamageKind::Malformed),
        ("\"10:47:15.23\";\"80\";\"Std\";\"\";\"00 11", DamageKind::Truncated),
        ("10:47:15.23;80;Std;;00 11", DamageKind::Truncated),
    ] {
        assert_eq!(damage(MINIMON, &format!("{MINIMON_HEADER}{row}")).kind, kind, "{row}");
    }
}

#[test]
fn recognised() {
    assert_eq!(Format::sniff(HEADER.as_bytes()), Some(CSV));
    assert_eq!(Format::sniff(MINIMON_HEADER.as_bytes()), Some(MINIMON));
    assert_eq!(Format::sniff(b"\"10:47:15.23\";\"83\";\"Std\";\"\";\"00 11 \"\r\n"), Some(MINIMON));
}
