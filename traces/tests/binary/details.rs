//! Details that the samples of other programs lack: rare blocks, losses reported by recorders, topics.

use crate::shown::{self, read};
use canvass_traces::{Capture, DamageKind, ReadOptions, Reader, Source, TimeBase};

/// A little-endian pcapng block.
fn block(kind: u32, body: &[u8]) -> Vec<u8> {
    let length = (12 + body.len().next_multiple_of(4)) as u32;
    let mut block = [kind.to_le_bytes(), length.to_le_bytes()].concat();
    block.extend(body);
    block.resize(length as usize - 4, 0);
    block.extend(length.to_le_bytes());
    block
}

/// A section header, and an interface of link type 227 without a name.
fn section(snapshot: u32) -> Vec<u8> {
    let mut file = block(0x0A0D_0D0A, b"\x4D\x3C\x2B\x1A\x01\0\0\0\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF");
    file.extend(block(1, &[[227, 0, 0, 0], snapshot.to_le_bytes()].concat()));
    file
}

const PACKET: &[u8] = b"\0\0\x01\x81\x02\0\0\0\xAB\xCD\0\0\0\0\0\0";

/// An enhanced packet block with options, at 5 µs.
fn enhanced(options: &[u8]) -> Vec<u8> {
    block(6, &[&[0, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 16, 0, 0, 0, 16, 0, 0, 0], PACKET, options].concat())
}

#[test]
fn simple_packets_have_no_time() {
    let simple = |original: u32| block(3, &[&original.to_le_bytes()[..], PACKET].concat());
    let mut capture = shown::open([section(0), simple(16)].concat()).unwrap();
    let record = capture.next().unwrap().unwrap();
    assert_eq!(shown::shown(&record, capture.channels()), "0.000000000 can0 181#ABCD");
    assert_eq!(capture.time_base(), TimeBase::None);
    // The packet was cut to the snapshot length, from which alone the captured length follows.
    let (frames, damages) = read(&[section(16), simple(17)].concat());
    assert_eq!((frames.len(), damages[0].kind), (0, DamageKind::Truncated));
    // Among packets with times, a packet without time gets the time before it.
    let (frames, _) = read(&[section(0), enhanced(&[]), simple(16)].concat());
    assert_eq!(frames, ["0.000005000 can0 181#ABCD"; 2]);
}

#[test]
fn the_obsolete_packet_block_tells_direction_time_and_drops() {
    let body = [&[0, 0, 3, 0, 0, 0, 0, 0, 9, 0, 0, 0, 16, 0, 0, 0, 16, 0, 0, 0], PACKET].concat();
    let (frames, damages) = read(&[section(0), block(2, &body)].concat());
    assert_eq!(frames, ["0.000009000 can0 181#ABCD"]);
    assert_eq!(damages.iter().map(|damage| damage.kind).collect::<Vec<_>>(), [DamageKind::Dropped(3)]);
}

#[test]
fn losses_are_told_once() {
    let drops = b"\x04\0\x08\0\x02\0\0\0\0\0\0\0";
    let statistics = |dropped: u8| block(5, &[&[0; 12][..], &[5, 0, 8, 0, dropped, 0, 0, 0, 0, 0, 0, 0]].concat());
    let file =
        [section(0), enhanced(drops), statistics(2), enhanced(b"\x02\0\x04\0\x02\0\0\0"), statistics(7)].concat();
    let (frames, damages) = read(&file);
    assert_eq!(frames, ["0.000005000 can0 181#ABCD", "0.000005000 can0 181#ABCD Tx"]);
    let kinds: Vec<_> = damages.iter().map(|damage| damage.kind).collect();
    assert_eq!(kinds, [DamageKind::Dropped(2), DamageKind::Dropped(5)]);
}

#[test]
fn blocks_that_do_not_fit_are_passed_over() {
    let mut bad_trailer = enhanced(&[]);
    let end = bad_trailer.len() - 4;
    bad_trailer[end] ^= 4;
    let no_interface = block(6, &[&[9, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 16, 0, 0, 0, 16, 0, 0, 0], PACKET].concat());
    let too_long = block(6, &[&[0, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 99, 0, 0, 0, 99, 0, 0, 0], PACKET].concat());
    let other_link = block(1, &[1, 0, 0, 0, 0, 0, 0, 0]);
    let ethernet = block(6, &[&[1, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 16, 0, 0, 0, 16, 0, 0, 0], PACKET].concat());
    let file = [
        section(0),
        bad_trailer,
        no_interface,
        too_long,
        enhanced(b"\x02\0\xFF\0"),
        other_link,
        ethernet,
        enhanced(&[]),
    ];
    let (frames, damages) = read(&file.concat());
    assert_eq!(frames.len(), 2);
    let kinds: Vec<_> = damages.iter().map(|damage| damage.kind).collect();
    let malformed = DamageKind::Malformed;
    assert_eq!(kinds, [malformed, malformed, malformed, malformed, DamageKind::Unsupported]);
}

fn read_topics(name: &str, topics: &[&str]) -> (Vec<String>, Vec<String>) {
    let options =
        ReadOptions { topics: topics.iter().map(|&topic| topic.to_owned()).collect(), ..ReadOptions::default() };
    let mut capture = Capture::from_source(name, Source::from_bytes(shown::bytes(name)), &options).unwrap();
    let (mut frames, mut damages) = (Vec::new(), Vec::new());
    while let Some(next) = capture.next() {
        match next {
            Ok(record) => frames.push(shown::shown(&record, capture.channels())),
            Err(damage) => damages.push(damage.to_string()),
        }
    }
    (frames, damages)
}

#[test]
fn topics_can_be_named() {
    let (frames, damages) = read_topics("ros2-zstd.mcap", &["/can1/fd"]);
    assert!(frames.iter().all(|frame| frame.contains(" can1 ") && frame.contains("##4")));
    assert_eq!((frames.len(), damages.len()), (3, 0));
    let (frames, damages) = read_topics("ros2-zstd.mcap", &["/rosout", "/nowhere"]);
    assert_eq!((frames.len(), damages.len()), (0, 2));
    assert!(damages[0].contains("on the topic /rosout, found \"std_msgs/msg/String\""), "{damages:?}");
    assert!(damages[1].contains("expected the topic /nowhere, found \"topics /rosout, /can0"), "{damages:?}");
}

#[test]
fn an_mcap_without_can_frames_says_so() {
    let mut plain = shown::bytes("ros2-unchunked.mcap");
    // Without a field named `data` no schema is that of a CAN frame.
    for name in [&b"uint8[8] data"[..], b"uint8[<=64] data"] {
        while let Some(at) = memchr::memmem::find(&plain, name) {
            plain[at + name.len() - 1] = b'x';
        }
    }
    let (frames, damages) = read(&plain);
    assert_eq!(frames.len(), 0);
    assert!(damages[0].to_string().contains("an identifier and data, found \"schema can_msgs/msg/Frame\""));
    // With its usual name the message would be a CAN frame; another name proves nothing.
    for (name, other) in [("can_msgs/msg/Frame", "cat_pics/msg/Image"), ("/msg/FdFrame", "/msg/Picture")] {
        while let Some(at) = memchr::memmem::find(&plain, name.as_bytes()) {
            plain[at..at + name.len()].copy_from_slice(other.as_bytes());
        }
    }
    let (frames, damages) = read(&plain);
    assert_eq!((frames.len(), damages.len()), (0, 1), "{damages:?}");
    assert!(damages[0].to_string().contains("a topic with CAN frames, found \"topics /rosout, /can0"));
}

#[test]
fn a_message_of_an_unknown_channel_is_a_damage() {
    let whole = shown::bytes("ros2-unchunked.mcap");
    // The message record has 22 bytes of header and a frame of 36 bytes.
    let at = memchr::memmem::find(&whole, b"\x05\x3A\0\0\0\0\0\0\0").unwrap();
    let mut changed = whole;
    changed[at + 9] = 99;
    let (frames, damages) = read(&changed);
    assert_eq!((frames.len(), damages.len()), (23, 2));
    assert!(damages[0].to_string().contains("found \"channel 99\""), "{damages:?}");
    assert!(damages[1].to_string().contains("as the file's statistics say"), "{damages:?}");
}

#[test]
fn a_damaged_container_does_not_join_its_neighbours() {
    let mut changed = shown::bytes("python-can-small-containers.blf");
    let (all, _) = read(&changed);
    // The deflated bytes of the third container.
    let mut containers = memchr::memmem::find_iter(&changed[..], b"LOBJ\x10\0\x01\0").collect::<Vec<_>>().into_iter();
    let at = containers.nth(2).unwrap();
    changed[at + 40] ^= 0x55;
    let (frames, damages) = read(&changed);
    assert!(frames.len() < all.len() && frames.len() > 15, "{frames:#?}");
    assert!(frames.iter().all(|frame| all.contains(frame)), "{frames:#?}");
    assert!(damages.iter().any(|damage| damage.to_string().contains("a container")), "{damages:?}");
}
