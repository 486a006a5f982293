//! The samples of other tools: read completely, cut at every byte, and damaged at random.

use crate::frames::*;
use canvass_traces::*;
use proptest::prelude::*;
use std::path::PathBuf;

/// The samples: file, format, number of frames.
const SAMPLES: [(&str, Format, usize); 6] = [
    ("python-can.log", Format::Candump, 40),
    ("python-can.asc", Format::Asc, 40),
    ("python-can.csv", Format::PythonCanCsv, 40),
    ("python-can.trc", Format::Trc, 27),
    ("log2long.txt", Format::CandumpConsole, 14),
    ("log2asc.asc", Format::Asc, 14),
];

fn sample(name: &str) -> Vec<u8> {
    let path: PathBuf = [env!("CARGO_MANIFEST_DIR"), "samples", name].iter().collect();
    std::fs::read(path).unwrap()
}

#[test]
fn read_whole() {
    for (name, format, count) in SAMPLES {
        let bytes = sample(name);
        assert_eq!(Format::sniff(&bytes), Some(format), "{name}");
        let items = read(format, &bytes).0;
        assert_eq!(items.iter().filter(|item| item.is_ok()).count(), count, "{name}");
        assert_eq!(items.len(), count, "{name}: {:?}", items.iter().find(|item| item.is_err()));
    }
}

#[test]
fn the_same_frames_in_every_format() {
    let frames = |name, format| {
        read(format, &sample(name)).0.into_iter().map(|item| item.unwrap().notation().to_string()).collect::<Vec<_>>()
    };
    let (log, asc) = (frames("python-can.log", Format::Candump), frames("python-can.asc", Format::Asc));
    let is_plain = |frame: &&String| !frame.contains('R') && !frame.starts_with("200000");
    let plain = |frames: &[String]| frames.iter().filter(is_plain).cloned().collect::<Vec<_>>();
    assert_eq!(plain(&log), plain(&asc), "python-can's log has no remote length, its ASC no class of errors");
    let (trc, csv) = (frames("python-can.trc", Format::Trc), frames("python-can.csv", Format::PythonCanCsv));
    let classical = |frames: &[String]| plain(frames).into_iter().filter(|f| !f.contains("##")).collect::<Vec<_>>();
    assert_eq!(trc, classical(&log));
    // CSV does not distinguish CAN FD frames of up to 8 bytes from classical ones.
    assert_eq!(plain(&csv)[..25], plain(&log)[..25]);
}

#[test]
fn cut_anywhere_no_frame_is_invented() {
    for (name, format, _) in SAMPLES {
        let bytes = sample(name);
        let whole = read(format, &bytes).0;
        for cut in 0..bytes.len() {
            let items = read(format, &bytes[..cut]).0;
            let records: Vec<_> = items.iter().filter(|item| item.is_ok()).collect();
            assert!(
                records.iter().zip(&whole).all(|(read, written)| *read == written),
                "{name} cut at {cut}: {items:?}"
            );
            assert!(items.len() - records.len() <= 1, "{name} cut at {cut}: {items:?}");
        }
    }
}

#[test]
fn line_ends_of_windows_and_a_byte_order_mark_change_nothing() {
    for (name, format, _) in SAMPLES {
        let bytes = sample(name);
        let text = String::from_utf8(bytes.clone()).unwrap().replace("\r\n", "\n");
        let dos = format!("\u{FEFF}{}", text.replace('\n', "\r\n"));
        assert_eq!(Format::sniff(dos.as_bytes()), Some(format), "{name}");
        let records = |bytes: &[u8]| without_places(read(format, bytes).0.into_iter().map(Result::unwrap));
        assert_eq!(records(dos.as_bytes()), records(&bytes), "{name}");
    }
}

/// A compressed log that ends early gives the lines before the end, and is unfinished, not unreadable.
#[test]
fn a_compressed_log_that_ends_early_is_unfinished() {
    let plain = sample("python-can.log");
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
    std::io::Write::write_all(&mut gzip, &plain).unwrap();
    let gzip = gzip.finish().unwrap();
    let source = Source::from_bytes(&gzip[..gzip.len() - 300]);
    let capture = Capture::from_source("cut", source, &ReadOptions::default()).unwrap();
    let (records, damages): (Items, Items) = capture.partition(Result::is_ok);
    let whole = read(Format::Candump, &plain).0;
    assert!(!records.is_empty() && whole.starts_with(&records));
    let kinds: Vec<_> = damages.into_iter().map(|damage| damage.unwrap_err().kind).collect();
    assert_eq!(kinds, [DamageKind::Unfinished]);
}

proptest! {
    #[test]
    fn random_damage_is_survived(
        which in 0..SAMPLES.len(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20),
        delete in any::<(prop::sample::Index, prop::sample::Index)>(),
    ) {
        let mut bytes = sample(SAMPLES[which].0);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let (a, b) = (delete.0.index(bytes.len()), delete.1.index(bytes.len()));
        bytes.drain(a.min(b)..a.max(b));
        for (_, format, _) in SAMPLES {
            let _ = Format::sniff(&bytes);
            let items = read(format, &bytes).0;
            prop_assert!(items.len() <= bytes.iter().filter(|&&b| b == b'\n').count() + 1);
        }
    }

    #[test]
    fn anything_is_survived(bytes in proptest::collection::vec(any::<u8>(), 0..400), lines in "(?s)[0-9a-fA-FxX#;:,.()\\[\\]{}'\"RxTDd \t\n-]{0,400}") {
        for bytes in [bytes, lines.into_bytes()] {
            for (_, format, _) in SAMPLES {
                read(format, &bytes);
            }
            read(Format::MiniMon, &bytes);
        }
    }
}

/// Wireshark's text has the frames of the capture that it shows: from the details of packets with their dates, and from
/// rows, with times since the first packet.
#[test]
fn the_text_of_wireshark_has_the_frames_of_the_capture() {
    for (text, capture) in [("wireshark-details.txt", "two-interfaces.pcapng"), ("wireshark-rows.txt", "cooked.pcap")] {
        let (told, captured) = (all(text), all(capture));
        let first = captured[0].timestamp;
        assert_eq!(told.len(), captured.len(), "{text}");
        for (told, captured) in told.iter().zip(&captured) {
            assert_eq!((told.frame, told.data()), (captured.frame, captured.data()), "{text}");
            let since = captured.timestamp.since(first).nanos() / 1_000 * 1_000;
            let expected = if text.contains("rows") { since } else { captured.timestamp.nanos() };
            assert_eq!(told.timestamp.nanos(), expected, "{text}");
        }
    }
    let without_bytes = String::from_utf8(sample("wireshark-details.txt")).unwrap();
    let without_bytes: Vec<&str> = without_bytes.lines().filter(|line| !line.starts_with("0000  ")).collect();
    let (frames, damages): (Vec<_>, Vec<_>) =
        items(Format::WiresharkText, &without_bytes.join("\n")).into_iter().partition(Result::is_ok);
    assert_eq!((frames.len(), damages.len()), (0, all("two-interfaces.pcapng").len()), "each packet is missed");
}

/// Reads all records of a sample. Its format must be recognised, and it must have no damage.
fn all(name: &str) -> Vec<Record> {
    let source = Source::from_bytes(sample(name));
    let capture = Capture::from_source(name, source, &ReadOptions::default()).unwrap();
    capture.map(|item| item.unwrap_or_else(|damage| panic!("{name}: {damage}"))).collect()
}
