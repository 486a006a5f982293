//! Written captures are read back the same, and properties that a format can't hold are counted.

use crate::shown;
use canvass_traces::{
    CanId, ChannelId, Channels, ChunkCompression, DamageKind, Direction, ErrorClass, Flags, Format, Frame, Loss,
    Losses, Record, TimeBase, Timestamp, WriteOptions, XlHeader,
};
use proptest::prelude::*;
use std::io::{self, Write};
use std::sync::{Arc, Mutex};

/// A sink whose bytes a test can read while a writer owns it.
#[derive(Clone, Default)]
struct Sink(Arc<Mutex<Vec<u8>>>);

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().map_err(|_| io::ErrorKind::Other)?.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn channels() -> Channels {
    let mut channels = Channels::new();
    for name in ["can0", "can1", "vcan17"] {
        channels.intern(name);
    }
    channels
}

/// Channels as formats without names number them.
fn numbered() -> Channels {
    let mut channels = Channels::new();
    for name in ["1", "2", "3"] {
        channels.intern(name);
    }
    channels
}

fn written(format: Format, options: &WriteOptions, records: &[Record]) -> (Vec<u8>, Losses) {
    let sink = Sink::default();
    let mut writer = format.create(Box::new(sink.clone()), options).unwrap();
    for (n, record) in records.iter().enumerate() {
        writer.write(record, &channels()).unwrap();
        if n == 3 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    let losses = writer.losses().clone();
    let beginning = writer.beginning().map(<[u8]>::to_vec).unwrap_or_default();
    assert_eq!(beginning.is_empty(), !format.rewrites_beginning());
    drop(writer);
    let mut bytes = sink.0.lock().unwrap().clone();
    bytes[..beginning.len()].copy_from_slice(&beginning);
    (bytes, losses)
}

fn id() -> impl Strategy<Value = CanId> {
    prop_oneof![
        (0..=CanId::MAX_STANDARD).prop_filter_map("standard", CanId::standard),
        (0..=CanId::MAX_EXTENDED).prop_filter_map("extended", CanId::extended),
    ]
}

fn bytes(most: usize) -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..=most)
}

fn classical() -> impl Strategy<Value = Frame> {
    prop_oneof![
        4 => (id(), bytes(8)).prop_filter_map("data", |(id, data)| Frame::new(id, &data)),
        1 => (id(), 0u8..=8).prop_filter_map("remote", |(id, len)| Frame::remote(id, len)),
        1 => (0..=CanId::MAX_EXTENDED, bytes(8)).prop_filter_map("error", |(class, data)| Frame::error(ErrorClass(class), &data)),
    ]
}

fn record() -> impl Strategy<Value = Record> {
    let at = || (0..4_000_000_000_000_000_000u64).prop_map(Timestamp);
    let channel = || (0u16..3).prop_map(ChannelId);
    let xl = (any::<u8>(), any::<bool>(), any::<bool>(), any::<u8>(), any::<u32>())
        .prop_map(|(vcid, sec, rrs, sdt, af)| XlHeader { vcid, sec, rrs, sdt, af });
    let classical = (at(), channel(), classical()).prop_map(|(at, channel, frame)| Record::new(at, channel, frame));
    let fd = (at(), channel(), id(), 0u8..4, 0usize..16, bytes(64)).prop_filter_map(
        "CAN FD",
        |(at, channel, id, flags, code, mut data)| {
            data.resize(usize::from(Frame::FD_LENGTHS[code]), 0x55);
            Record::fd(at, channel, id, Flags::from_bits(flags), &data)
        },
    );
    let xl = (at(), channel(), 0..=CanId::MAX_STANDARD, xl, prop::collection::vec(any::<u8>(), 1..=2048))
        .prop_filter_map("CAN XL", |(at, channel, id, xl, data)| {
            Record::xl(at, channel, CanId::standard(id)?, xl, &data)
        });
    let direction = prop::sample::select(&[Direction::Unknown, Direction::Rx, Direction::Tx]);
    (prop_oneof![6 => classical, 3 => fd, 1 => xl], direction)
        .prop_map(|(record, direction)| record.with_direction(direction))
}

/// The texts of the records after a round trip; `keeps` gives the part of a record that the format can hold.
fn expected(records: &[Record], keeps: impl Fn(&Record) -> Option<Record>) -> Vec<String> {
    records.iter().filter_map(keeps).map(|record| shown::shown(&record, &channels())).collect()
}

proptest! {

    #[test]
    fn pcapng_holds_everything(records in prop::collection::vec(record(), 1..30)) {
        let (bytes, losses) = written(Format::Pcapng, &WriteOptions::default(), &records);
        prop_assert!(losses.is_empty());
        prop_assert_eq!(shown::read(&bytes), (expected(&records, |record| Some(record.clone())), vec![]));
    }

    #[test]
    fn blf_holds_all_but_names_and_directions_of_errors(mut records in prop::collection::vec(record(), 1..30)) {
        records.sort_by_key(|record| record.timestamp);
        let options = WriteOptions { time_base: TimeBase::Local, ..WriteOptions::default() };
        let (bytes, losses) = written(Format::Blf, &options, &records);
        let mut numbers = Channels::new();
        let keeps = |record: &Record| {
            let direction = match record.direction {
                _ if record.frame.is_error() => Direction::Unknown,
                Direction::Unknown => Direction::Rx,
                known => known,
            };
            let mut kept = record.clone().with_direction(direction);
            if record.frame.is_xl() {
                return None;
            }
            // Channels get their numbers in the order of their first frames.
            kept.channel = numbers.intern(&format!("{}", record.channel.0));
            let is_nameless = kept.frame.error_class().is_some_and(|class| class.0 == 0);
            if is_nameless {
                kept.frame = Frame::error(ErrorClass(0x80), &[]).unwrap();
            }
            Some(kept)
        };
        let kept: Vec<Record> = records.iter().filter_map(keeps).collect();
        let expected: Vec<String> = kept.iter().map(|record| shown::shown(record, &numbered())).collect();
        prop_assert_eq!(shown::read(&bytes), (expected, vec![]));
        let lost = |wanted: Loss| losses.iter().find(|(loss, _)| *loss == wanted).map_or(0, |(_, n)| n);
        prop_assert_eq!(lost(Loss::ChannelName), kept.len() as u64);
        prop_assert_eq!(lost(Loss::Frame), (records.len() - kept.len()) as u64);
    }

    #[test]
    fn mf4_holds_all_but_names_and_details_of_errors(
        mut records in prop::collection::vec(record(), 1..30),
        spans in prop::collection::vec(0u64..30_000_000_000_000, 30),
    ) {
        // A span of ten days: longer ones do not fit into the digits of seconds in floating point.
        let mut now = 1_700_000_000_000_000_000;
        for (record, span) in records.iter_mut().zip(spans) {
            now += span;
            record.timestamp = Timestamp(now);
        }
        let options = WriteOptions { time_base: TimeBase::Utc, ..WriteOptions::default() };
        let (bytes, losses) = written(Format::Mf4, &options, &records);
        let mut numbers = Channels::new();
        let keeps = |record: &Record| {
            let direction = if record.direction == Direction::Tx { Direction::Tx } else { Direction::Rx };
            let mut kept = record.clone().with_direction(direction);
            if record.frame.is_xl() {
                return None;
            }
            kept.channel = numbers.intern(&format!("{}", record.channel.0));
            if kept.frame.is_error() {
                kept.frame = Frame::error(ErrorClass(0x80), &[]).unwrap();
            }
            Some(kept)
        };
        let kept: Vec<Record> = records.iter().filter_map(keeps).collect();
        let expected: Vec<String> = kept.iter().map(|record| shown::shown(record, &numbered())).collect();
        let (found, damages) = shown::read(&bytes);
        prop_assert_eq!((found, damages), (expected, vec![]));
        prop_assert!(!losses.iter().any(|(loss, _)| loss == Loss::UnknownDate || loss == Loss::TimeZone));
    }

    #[test]
    fn pcap_holds_all_but_channels_and_directions(records in prop::collection::vec(record(), 1..30)) {
        let (bytes, losses) = written(Format::Pcap, &WriteOptions::default(), &records);
        let keeps = |record: &Record| {
            let mut kept = record.clone().with_direction(Direction::Unknown);
            kept.channel = ChannelId(0);
            Some(kept)
        };
        prop_assert_eq!(shown::read(&bytes), (expected(&records, keeps), vec![]));
        let others = records.iter().filter(|record| record.channel != ChannelId(0)).count() as u64;
        let lost = losses.iter().find(|(loss, _)| *loss == Loss::ChannelName).map_or(0, |(_, n)| n);
        prop_assert_eq!(lost, others);
    }

    #[test]
    fn mcap_holds_all_but_can_xl_and_flags(
        records in prop::collection::vec(record(), 1..30),
        chunk_compression in prop::sample::select(&[ChunkCompression::Zstd, ChunkCompression::Lz4, ChunkCompression::None]),
        live in any::<bool>(),
    ) {
        let options = WriteOptions { chunk_compression, live, ..WriteOptions::default() };
        let (bytes, losses) = written(Format::Mcap, &options, &records);
        let keeps = |record: &Record| {
            let (at, channel) = (record.timestamp, record.channel);
            if record.frame.is_xl() {
                None
            } else if record.frame.is_fd() {
                Record::fd(at, channel, record.frame.id(), Flags::NONE, record.data())
            } else {
                Some(record.clone().with_direction(Direction::Unknown))
            }
        };
        prop_assert_eq!(shown::read(&bytes), (expected(&records, keeps), vec![]));
        let lost = losses.iter().find(|(loss, _)| *loss == Loss::Frame).map_or(0, |(_, n)| n);
        prop_assert_eq!(lost, records.iter().filter(|record| record.frame.is_xl()).count() as u64);
    }
}

#[test]
fn data_length_codes_above_eight() {
    let frame = Frame::full(CanId::standard_masked(1), [7; 8]).with_raw_dlc(0xB);
    let record = Record::new(Timestamp(5), ChannelId(0), frame);
    for format in [Format::Pcap, Format::Pcapng] {
        let (bytes, losses) = written(format, &WriteOptions::default(), std::slice::from_ref(&record));
        assert!(losses.is_empty());
        assert_eq!(shown::read(&bytes).0, ["0.000000005 can0 001#0707070707070707_B"]);
    }
    let (bytes, losses) = written(Format::Mcap, &WriteOptions::default(), &[record]);
    assert_eq!(losses.iter().collect::<Vec<_>>(), [(Loss::RawDlc, 1)]);
    assert_eq!(shown::read(&bytes).0, ["0.000000005 can0 001#0707070707070707"]);
}

#[test]
fn the_crate_mcap_reads_what_is_written() {
    let frame = Frame::new(CanId::standard_masked(0x63F), &[0x40, 0, 0x60, 0]).unwrap();
    let record = Record::new(Timestamp(1_700_000_000_000_000_001), ChannelId(1), frame);
    let (bytes, _) = written(Format::Mcap, &WriteOptions::default(), &[record]);
    let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().collect::<Result<_, _>>().unwrap();
    assert_eq!(messages.len(), 1);
    assert_eq!(messages[0].channel.topic, "/can1");
    assert_eq!(messages[0].channel.schema.as_ref().unwrap().name, "can_msgs/msg/Frame");
    assert_eq!(messages[0].data.len(), 36);
    assert_eq!(messages[0].log_time, 1_700_000_000_000_000_001);
}

/// A flushed record is written at once, and needs only its own bytes: no chunk, no row of an index.
#[test]
fn mcap_that_is_written_live_holds_nothing_back() {
    let sink = Sink::default();
    let options = WriteOptions { live: true, ..WriteOptions::default() };
    let mut writer = Format::Mcap.create(Box::new(sink.clone()), &options).unwrap();
    let size = || sink.0.lock().unwrap().len();
    let frame = Frame::new(CanId::standard_masked(0x63F), &[0x40, 0, 0x60, 0]).unwrap();
    let mut record = |n| {
        writer.write(&Record::new(Timestamp(n), ChannelId(0), frame), &channels()).unwrap();
        writer.flush().unwrap();
        size()
    };
    let first = record(0);
    let sizes: Vec<usize> = (1..1_000).map(record).collect();
    assert!(sizes.iter().zip(1..).all(|(size, n)| *size == first + n * (9 + 22 + 36)), "{sizes:?}");
    writer.finish().unwrap();
    // The end of the file repeats the schemas and channels.
    assert!(size() < sizes[998] + 4_000);
}

/// A file of which the recorder was killed has its frames with their dates, and says that it is not finished.
#[test]
fn what_was_never_finished_is_read_with_its_dates() {
    let record = |n: u64| {
        let frame = Frame::new(CanId::standard(0x181).unwrap(), &[n as u8]).unwrap();
        Record::new(Timestamp(1_700_000_000_123_000_000 + n), ChannelId(0), frame).with_direction(Direction::Rx)
    };
    for format in [Format::Blf, Format::Mf4] {
        let sink = Sink::default();
        let options = WriteOptions { time_base: TimeBase::Local, ..WriteOptions::default() };
        let mut writer = format.create(Box::new(sink.clone()), &options).unwrap();
        writer.flush().unwrap();
        for n in 0..50 {
            writer.write(&record(n), &channels()).unwrap();
        }
        writer.flush().unwrap();
        drop(writer);
        let bytes = sink.0.lock().unwrap().clone();
        let (frames, damages) = shown::read(&bytes);
        let expected: Vec<String> = (0..50).map(|n| shown::shown(&record(n), &numbered())).collect();
        assert_eq!(frames, expected, "{format}");
        let kinds: Vec<_> = damages.iter().map(|damage| damage.kind).collect();
        assert_eq!(kinds, [DamageKind::Unfinished], "{format}");
    }
}
