//! Frames for the tests: short functions to make them, and arbitrary frames.

use canvass_traces::*;
use proptest::collection::vec;
use proptest::prelude::*;
use std::cell::RefCell;
use std::io::Write;
use std::rc::Rc;

pub type Items = Vec<Result<Record, Damage>>;

/// All items of a reader, its channel names and its time base.
pub fn read(format: Format, bytes: &[u8]) -> (Items, Vec<String>, TimeBase) {
    let mut reader = format.open(Source::from_bytes(bytes), &ReadOptions::default());
    let items = reader.by_ref().collect();
    (items, reader.channels().names().map(String::from).collect(), reader.time_base())
}

pub fn items(format: Format, text: &str) -> Items {
    read(format, text.as_bytes()).0
}

/// The only record of a capture of one line.
pub fn one(format: Format, text: &str) -> Record {
    let mut items = items(format, text);
    assert_eq!(items.len(), 1, "{text}: {items:?}");
    items.remove(0).unwrap_or_else(|damage| panic!("{text}: {damage}"))
}

/// The only damage of a capture of one line.
pub fn damage(format: Format, text: &str) -> Damage {
    let mut items = items(format, text);
    assert_eq!(items.len(), 1, "{text}: {items:?}");
    items.remove(0).expect_err(text)
}

#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// The bytes that a writer makes of records, and its losses.
pub fn written(format: Format, records: &[Record], channels: &Channels, time_base: TimeBase) -> (Vec<u8>, Losses) {
    let sink = Shared::default();
    let mut writer =
        format.create(Box::new(sink.clone()), &WriteOptions { time_base, ..WriteOptions::default() }).unwrap();
    for record in records {
        writer.write(record, channels).unwrap();
    }
    writer.finish().unwrap();
    let bytes = sink.0.borrow().clone();
    (bytes, writer.losses().clone())
}

/// The records without their places, which differ between files.
pub fn without_places(records: impl IntoIterator<Item = Record>) -> Vec<Record> {
    records.into_iter().map(|record| record.at(0, 0)).collect()
}

pub fn channels(names: &[&str]) -> Channels {
    let mut channels = Channels::new();
    for name in names {
        channels.intern(name);
    }
    channels
}

pub fn id() -> impl Strategy<Value = CanId> {
    prop_oneof![
        3 => (0..=0x7FF_u32).prop_map(CanId::standard_masked),
        1 => (0..=0x1FFF_FFFF_u32).prop_map(CanId::extended_masked),
    ]
}

fn at_zero(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId(0), frame)
}

pub fn classical() -> impl Strategy<Value = Record> {
    prop_oneof![
        6 => (id(), vec(any::<u8>(), 0..=8)).prop_map(|(id, data)| at_zero(Frame::new(id, &data).unwrap())),
        1 => (id(), any::<[u8; 8]>(), 9..=15_u8)
            .prop_map(|(id, data, dlc)| at_zero(Frame::full(id, data).with_raw_dlc(dlc))),
        1 => (id(), 0..=8_u8).prop_map(|(id, len)| at_zero(Frame::remote(id, len).unwrap())),
    ]
}

pub fn fd() -> impl Strategy<Value = Record> {
    (id(), vec(any::<u8>(), 64), 0..16_usize, 0..4_u8).prop_map(|(id, data, dlc, flags)| {
        let data = &data[..usize::from(Frame::FD_LENGTHS[dlc])];
        Record::fd(Timestamp::ZERO, ChannelId(0), id, Flags::from_bits(flags), data).unwrap()
    })
}

pub fn error() -> impl Strategy<Value = Record> {
    (0..0x2000_0000_u32, vec(any::<u8>(), 0..=8))
        .prop_map(|(class, data)| at_zero(Frame::error(ErrorClass(class), &data).unwrap()))
}

pub fn xl() -> impl Strategy<Value = Record> {
    let header = (any::<u8>(), any::<bool>(), any::<bool>(), any::<u8>(), any::<u32>())
        .prop_map(|(vcid, sec, rrs, sdt, af)| XlHeader { vcid, sec, rrs, sdt, af });
    (0..=0x7FF_u32, header, vec(any::<u8>(), 1..=64)).prop_map(|(priority, header, data)| {
        Record::xl(Timestamp::ZERO, ChannelId(0), CanId::standard_masked(priority), header, &data).unwrap()
    })
}

pub fn any_frame() -> impl Strategy<Value = Record> {
    prop_oneof![4 => classical(), 2 => fd(), 1 => error(), 1 => xl()]
}

pub fn direction() -> impl Strategy<Value = Direction> {
    prop_oneof![Just(Direction::Unknown), Just(Direction::Rx), Just(Direction::Tx)]
}

/// Records with times from `times`, on two channels, in any direction.
pub fn records(
    frame: impl Strategy<Value = Record>,
    times: impl Strategy<Value = u64>,
    direction: impl Strategy<Value = Direction>,
) -> impl Strategy<Value = Vec<Record>> {
    let record = (frame, times, 0..2_u16, direction).prop_map(|(mut record, nanos, channel, direction)| {
        record.timestamp = Timestamp(nanos);
        record.channel = ChannelId(channel);
        record.with_direction(direction)
    });
    vec(record, 0..20)
}
