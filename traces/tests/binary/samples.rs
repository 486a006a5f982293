//! Captures that other programs wrote, compared with the frames that other programs read in them.

use crate::shown::{self, read, reads_as_others_do};
use canvass_traces::{DamageKind, TimeBase};

#[test]
fn pcap() {
    reads_as_others_do("tcpdump-us.pcap");
    reads_as_others_do("tcpdump-ns.pcap");
    reads_as_others_do("big-endian.pcap");
}

#[test]
fn pcap_cooked() {
    reads_as_others_do("cooked.pcap");
    reads_as_others_do("cooked-big-endian.pcap");
    reads_as_others_do("cooked-v2.pcap");
}

/// The filling of `struct can_frame` is garbage; the protocol field shows that these are classical frames.
#[test]
fn pcap_of_a_program_that_does_not_clear_its_frames() {
    reads_as_others_do("unclean-filling.pcap");
}

#[test]
fn pcapng() {
    reads_as_others_do("two-interfaces.pcapng");
    reads_as_others_do("three-sections.pcapng");
}

#[test]
fn mcap_of_ros_2() {
    reads_as_others_do("ros2-zstd.mcap");
    reads_as_others_do("ros2-lz4.mcap");
    reads_as_others_do("ros2-plain.mcap");
    reads_as_others_do("ros2-unchunked.mcap");
}

#[test]
fn mcap_of_others() {
    reads_as_others_do("vendor.mcap");
    reads_as_others_do("ros1.mcap");
    reads_as_others_do("json.mcap");
    reads_as_others_do("protobuf.mcap");
}

#[test]
fn places_are_packet_numbers_and_offsets() {
    let mut capture = shown::open(shown::bytes("tcpdump-ns.pcap")).unwrap();
    let places: Vec<_> = capture.by_ref().take(3).map(|record| record.unwrap().place).collect();
    assert_eq!(
        places.iter().map(|place| (place.number, place.offset)).collect::<Vec<_>>(),
        [(1, 24), (2, 56), (3, 88)]
    );
    assert_eq!(canvass_traces::Reader::time_base(&capture), TimeBase::Utc);
}

#[test]
fn link_types_that_carry_no_frames_are_named() {
    let mut ethernet = shown::bytes("tcpdump-ns.pcap");
    ethernet[20] = 1;
    let (frames, damages) = read(&ethernet);
    assert!(frames.is_empty());
    assert_eq!(damages.len(), 1);
    assert!(damages[0].to_string().contains("found \"link type 1\""));
    assert_eq!(damages[0].kind, DamageKind::Fatal);
    // The upper half of the field is not part of the link type.
    let mut upper = shown::bytes("tcpdump-ns.pcap");
    upper[23] = 0xF0;
    assert_eq!(read(&upper).0.len(), 24);
}

#[test]
fn a_packet_that_the_recorder_cut_is_no_shorter_frame() {
    let mut cut = shown::bytes("tcpdump-ns.pcap");
    cut[24 + 12] = 17;
    let (frames, damages) = read(&cut);
    assert_eq!((frames.len(), damages.len()), (23, 1));
    assert_eq!(damages[0].kind, DamageKind::Truncated);
    assert_eq!(damages[0].place.number, 1);
}

#[test]
fn blf() {
    reads_as_others_do("python-can.blf");
    reads_as_others_do("python-can-plain.blf");
    reads_as_others_do("python-can-small-containers.blf");
}

#[test]
fn mf4() {
    reads_as_others_do("python-can.mf4");
    reads_as_others_do("python-can-deflated.mf4");
    reads_as_others_do("python-can-plain.mf4");
}

#[test]
fn sqlite() {
    reads_as_others_do("python-can.db");
    reads_as_others_do("python-can-small-pages.db");
    reads_as_others_do("long-rows.sqlite");
}
