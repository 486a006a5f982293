//! For any frame on the bus the analyzer writes one line without control characters, and goes on.

#[cfg(test)]
mod trace;

use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice, eds};
use canvass_analyzer::{NodeId, Service};
use canvass_traces::{CanId, ChannelId, ErrorClass, Flags, Frame, Record, Timestamp};
use proptest::prelude::*;
use std::sync::LazyLock;
use trace::Trace;

/// CAN-IDs of all services and of few nodes, so that frames concern the same nodes and transfers.
fn can_id() -> impl Strategy<Value = u32> {
    let of_nodes = (0_u32..16, 0_u32..4).prop_map(|(function, node)| function << 7 | node);
    let single = prop_oneof![
        Just(0x000),
        Just(0x001),
        0x070_u32..0x078,
        Just(0x080),
        Just(0x100),
        0x101_u32..0x108,
        Just(0x7E4),
        Just(0x7E5),
        Just(0x7FF)
    ];
    prop_oneof![4 => of_nodes, 2 => single, 1 => 0_u32..0x800]
}

/// Payloads, many of which are SDO commands to objects that move CAN-IDs and mappings.
fn payload() -> impl Strategy<Value = Vec<u8>> {
    let command =
        prop_oneof![any::<u8>(), Just(0x23), Just(0x2F), Just(0x40), Just(0x43), Just(0x60), Just(0xA0), Just(0xC6)];
    let index = prop_oneof![
        any::<u16>(),
        0x1000_u16..0x1030,
        0x1200_u16..0x1203,
        0x1400_u16..0x1402,
        0x1600_u16..0x1602,
        0x1800_u16..0x1803,
        0x1A00_u16..0x1A03,
        0x6000_u16..0x6010
    ];
    let value =
        prop_oneof![any::<u32>(), can_id(), 0_u32..9, Just(0xFE), Just(0xFF), Just(0x6004_0020), Just(0x0007_0020)];
    let access = (command, index, 0_u8..5, value).prop_map(|(command, index, sub, value)| {
        let [low, high] = index.to_le_bytes();
        let mut bytes = vec![command, low, high, sub];
        bytes.extend_from_slice(&value.to_le_bytes());
        bytes
    });
    prop_oneof![3 => access, 1 => proptest::collection::vec(any::<u8>(), 0..=8)]
}

fn record() -> impl Strategy<Value = Record> {
    (can_id(), payload(), 0_u8..40).prop_map(|(id, payload, kind)| {
        let standard = CanId::standard_masked(id);
        let frame = match kind {
            0 => Frame::remote(standard, payload.len() as u8),
            1 => Frame::error(ErrorClass(id), &payload),
            2 => Frame::new(CanId::extended_masked(id << 18 | id), &payload),
            3 => Frame::fd(standard, Flags::BRS, &payload),
            _ => Frame::new(standard, &payload),
        };
        Record::new(Timestamp::ZERO, ChannelId(0), frame.unwrap_or_else(|| Frame::full(standard, [0; 8])))
    })
}

/// Asserts that the text of a record is one line.
#[cfg(test)]
fn say(trace: &mut Trace, record: &Record) {
    let said = trace.record(record.clone());
    assert!(!said.text.is_empty() && !said.text.contains(char::is_control), "{:?}", said.text);
    assert!(Service::ALL.iter().any(|service| service.name() == said.service()));
}

proptest! {
    #[test]
    fn of_unknown_nodes(records in proptest::collection::vec(record(), 0..150)) {
        let mut trace = Trace::new();
        records.iter().for_each(|record| say(&mut trace, record));
    }

    #[test]
    fn of_described_nodes(records in proptest::collection::vec(record(), 0..100)) {
        static SENDIX: LazyLock<DeviceDescription> = LazyLock::new(|| {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../conformance/device/models/kuebler-sendix-58x8.eds");
            eds::read(&std::fs::read(path).unwrap()).unwrap()
        });
        let mut trace = Trace::new();
        for node in 1..=2 {
            trace.network.describe(NodeId::new(node).unwrap(), KnownDevice::described(SENDIX.clone()));
        }
        records.iter().for_each(|record| say(&mut trace, record));
    }
}

/// Every CAN-ID is tested with many first bytes; the CAN-IDs of the first nodes and the highest CAN-IDs are tested with
/// every first byte.
#[test]
fn every_can_id_with_every_command() {
    let mut trace = Trace::new();
    trace.say("000#81 00");
    for id in 0..0x800 {
        for command in (0..=255_u8).step_by(if id % 0x80 < 2 || id >= 0x7E0 { 1 } else { 37 }) {
            let frame = Frame::full(CanId::standard_masked(id), [command, 0x1B, 0x5B, 0x01, 0x0A, 0xFF, 0, 7]);
            say(&mut trace, &Record::new(Timestamp::ZERO, ChannelId(0), frame));
        }
    }
}
