//! Losses that earlier versions did not report: each is reported, and the frames beside it are read.

use crate::shown::{self, read};
use canvass_traces::{Damage, DamageKind};

fn kinds(damages: &[Damage]) -> Vec<DamageKind> {
    damages.iter().map(|damage| damage.kind).collect()
}

/// All `.pcap` samples of 24 packets; the flag tells their byte order.
const PCAPS: [(&str, bool); 4] =
    [("tcpdump-us.pcap", false), ("tcpdump-ns.pcap", false), ("cooked.pcap", false), ("big-endian.pcap", true)];

fn number(big: bool, number: u32) -> [u8; 4] {
    if big { number.to_be_bytes() } else { number.to_le_bytes() }
}

/// The offset of the packet with this number, from 0.
fn packet(bytes: &[u8], big: bool, wanted: usize) -> usize {
    (0..wanted).fold(24, |at, _| {
        let length = bytes[at + 8..at + 12].try_into().unwrap();
        at + 16 + if big { u32::from_be_bytes(length) } else { u32::from_le_bytes(length) } as usize
    })
}

#[test]
fn a_damaged_length_of_a_pcap_packet_costs_that_packet_alone() {
    for (name, big) in PCAPS {
        let whole = shown::bytes(name);
        let (all, _) = read(&whole);
        for length in [0, 1, 15, 17, 40, 1_000, 262_144, 262_145, 0x7FFF_FFFF, u32::MAX] {
            for field in [8, 12] {
                let mut bytes = whole.clone();
                let at = packet(&bytes, big, 7) + field;
                bytes[at..at + 4].copy_from_slice(&number(big, length));
                let (frames, damages) = read(&bytes);
                let expected = [&all[..7], &all[8..]].concat();
                assert_eq!((frames, damages.len()), (expected, 1), "{name}, {length} at {field}: {damages:?}");
            }
        }
    }
}

#[test]
fn bytes_between_two_packets_are_passed_over() {
    for (name, big) in PCAPS {
        let mut bytes = shown::bytes(name);
        let (all, _) = read(&bytes);
        let at = packet(&bytes, big, 7);
        bytes.splice(at..at, *b"not a packet, but more than a header of one");
        let (frames, damages) = read(&bytes);
        assert_eq!((frames, damages.len()), (all, 1), "{name}: {damages:?}");
    }
}

#[test]
fn a_fraction_of_a_second_that_is_none_is_told() {
    for (name, fraction) in [("tcpdump-us.pcap", 1_000_000), ("tcpdump-ns.pcap", 1_000_000_000)] {
        let mut bytes = shown::bytes(name);
        bytes[28..32].copy_from_slice(&u32::to_le_bytes(fraction));
        let (frames, damages) = read(&bytes);
        assert_eq!((frames.len(), kinds(&damages)), (23, vec![DamageKind::Malformed]), "{name}");
        assert!(damages[0].to_string().contains(&format!("a fraction of a second, found \"{fraction} of")));
        assert!(damages[0].salvaged.is_some(), "the frame itself is not damaged");
        bytes[28..32].copy_from_slice(&u32::to_le_bytes(fraction - 1));
        assert_eq!(read(&bytes).1, [], "{name}");
    }
}

/// The offset of each block of a little-endian pcapng file, with its type.
fn blocks(bytes: &[u8]) -> Vec<(usize, u32)> {
    let (mut at, mut blocks) = (0, Vec::new());
    while at < bytes.len() {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        blocks.push((at, word(at)));
        at += word(at + 4) as usize;
    }
    blocks
}

/// The offset of the seventh enhanced packet block.
fn seventh(bytes: &[u8]) -> usize {
    blocks(bytes).into_iter().filter(|block| block.1 == 6).nth(6).unwrap().0
}

#[test]
fn a_damaged_pcapng_block_costs_that_block_alone() {
    let whole = shown::bytes("two-interfaces.pcapng");
    let (all, _) = read(&whole);
    let at = seventh(&whole);
    for (field, value) in
        [(0, 7), (0, 0x8000_0006), (4, 0), (4, 52), (4, 1_000_000), (4, 0xFFFF_FFF0), (8, 9), (20, 99), (24, 1)]
    {
        let mut bytes = whole.clone();
        bytes[at + field..at + field + 4].copy_from_slice(&u32::to_le_bytes(value));
        let (frames, damages) = read(&bytes);
        let expected = [&all[..6], &all[7..]].concat();
        assert_eq!((frames, damages.len()), (expected, 1), "{value} at {field}: {damages:?}");
    }
}

#[test]
fn a_time_that_no_record_can_hold_is_told() {
    // The first interface counts nanoseconds, but its resolution says microseconds.
    let mut bytes = shown::bytes("two-interfaces.pcapng");
    let resolution = memchr::memmem::find(&bytes, b"\x09\0\x01\0\x09").unwrap() + 4;
    bytes[resolution] = 6;
    let (frames, damages) = read(&bytes);
    assert_eq!(frames.len() + damages.len(), 24);
    assert!(damages.len() > 5 && damages.iter().all(|damage| damage.salvaged.is_some()), "{damages:?}");
    assert!(damages[0].to_string().contains("expected a time from 1970 to 2554, found \"1700000000000000000 units"));
    // The offset of the third section's times is changed to a date before 1970.
    let mut bytes = shown::bytes("three-sections.pcapng");
    let offset = memchr::memmem::rfind(&bytes, b"\x0E\0\x08\0").unwrap() + 4;
    bytes[offset..offset + 8].copy_from_slice(&(-1_000_000_000_000_i64).to_le_bytes());
    let (frames, damages) = read(&bytes);
    assert_eq!(frames.len() + damages.len(), 24);
    assert!(damages.len() > 1 && damages.iter().all(|damage| damage.to_string().contains("a time from 1970")));
}

#[test]
fn a_section_that_ends_early_is_told() {
    let whole = shown::bytes("two-interfaces.pcapng");
    let header = u32::from_le_bytes(whole[4..8].try_into().unwrap()) as usize;
    let last = blocks(&whole).last().unwrap().0;
    let length = whole.len() - header;
    for (length, end, expected) in
        [(length, whole.len(), vec![]), (length, last, vec![DamageKind::Unfinished]), (4, last, vec![])]
    {
        let mut bytes = whole[..end].to_vec();
        bytes[16..24].copy_from_slice(&(length as u64).to_le_bytes());
        assert_eq!(kinds(&read(&bytes).1), expected, "{length} to {end}");
    }
}

/// The offsets of a BLF file's containers.
fn containers(bytes: &[u8]) -> Vec<usize> {
    memchr::memmem::find_iter(bytes, b"LOBJ\x10\0\x01\0").collect()
}

#[test]
fn a_damaged_type_of_a_container_is_told_with_what_is_missing() {
    for name in ["python-can.blf", "python-can-small-containers.blf", "python-can-plain.blf"] {
        let whole = shown::bytes(name);
        let (all, _) = read(&whole);
        for kind in [0, 1, 11, 50, 200] {
            let mut bytes = whole.clone();
            let at = containers(&bytes)[0];
            bytes[at + 12] = kind;
            let (frames, damages) = read(&bytes);
            assert!(!damages.is_empty(), "{name}, type {kind}");
            let missing = damages.iter().any(|damage| damage.to_string().contains("24 objects, as the file's header"));
            assert_eq!(missing, frames.len() < all.len(), "{name}, type {kind}: {damages:?}");
        }
    }
}

#[test]
fn a_container_that_is_said_to_be_longer_does_not_swallow_the_next() {
    let whole = shown::bytes("python-can-small-containers.blf");
    let (all, _) = read(&whole);
    let places = containers(&whole);
    let mut bytes = whole;
    // The stated size reaches to the end of the next container.
    let longer = (places[3] - places[1]) as u32;
    bytes[places[1] + 8..places[1] + 12].copy_from_slice(&longer.to_le_bytes());
    let (frames, damages) = read(&bytes);
    assert_eq!((frames, kinds(&damages)), (all, vec![DamageKind::Malformed]), "{damages:?}");
}

#[test]
fn an_object_that_is_said_to_be_longer_does_not_swallow_the_next() {
    let whole = shown::bytes("python-can-plain.blf");
    let (all, _) = read(&whole);
    // The second object is a CAN message of 48 bytes.
    let at = memchr::memmem::find_iter(&whole, b"LOBJ\x20\0\x01\0").nth(1).unwrap();
    for size in [96_u32, 144, 10_000, 60_000] {
        let mut bytes = whole.clone();
        bytes[at + 8..at + 12].copy_from_slice(&size.to_le_bytes());
        let (frames, damages) = read(&bytes);
        let expected = [&all[..1], &all[2..]].concat();
        assert_eq!(frames, expected, "{size}: {damages:?}");
        assert!(damages.iter().any(|damage| damage.to_string().contains("with another object in them")), "{size}");
    }
}

/// A record of MCAP.
fn record(code: u8, content: &[u8]) -> Vec<u8> {
    [&[code][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

#[test]
fn a_text_of_four_gibibytes_takes_no_memory() {
    let huge = u32::MAX.to_le_bytes();
    let schema = record(3, &[&b"\x01\0"[..], &huge, b"name"].concat());
    let encoding = record(3, &[&b"\x01\0\x01\0\0\0n"[..], &huge].concat());
    let topic = record(4, &[&b"\x01\0\0\0"[..], &huge, b"/can0"].concat());
    let metadata = record(4, &[&b"\x01\0\0\0\x01\0\0\0t\0\0\0\0\x08\0\0\0"[..], &huge, &huge].concat());
    let other = record(0x0C, &[&huge[..], b"name"].concat());
    let file = [mcap::MAGIC, &schema, &encoding, &topic, &metadata, &other].concat();
    let mut seen = (Vec::new(), Vec::new());
    let taken = allocation_counter::measure(|| seen = read(&file));
    assert!(taken.bytes_max < 4 << 20, "{} bytes", taken.bytes_max);
    let (frames, damages) = seen;
    assert_eq!(frames.len(), 0);
    let told: Vec<_> = damages.iter().map(ToString::to_string).collect();
    assert!(told[0].contains("a schema") && told[1].contains("a schema"), "{told:?}");
    assert!(told[2].contains("a channel") && told[3].contains("a channel") && told[4].contains("0Ch"), "{told:?}");
}

#[test]
fn a_message_whose_code_is_damaged_is_told() {
    let whole = shown::bytes("ros2-unchunked.mcap");
    let (all, _) = read(&whole);
    let at = memchr::memmem::find(&whole, b"\x05\x3A\0\0\0\0\0\0\0").unwrap();
    for code in (1..=u8::MAX).filter(|&code| code != 5) {
        let mut bytes = whole.clone();
        bytes[at] = code;
        let (frames, damages) = read(&bytes);
        assert_eq!(frames.len(), all.len() - 1, "code {code}: {damages:?}");
        assert!(damages.len() >= 2 && damages.last().unwrap().to_string().contains("statistics say"), "code {code}");
    }
}
