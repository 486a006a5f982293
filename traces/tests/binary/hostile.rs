//! Captures that are cut, changed or hostile: no panic, no hang, bounded memory, no invented frame.

use crate::shown::{self, SAMPLES, read};
use canvass_traces::{Capture, DamageKind, ReadOptions, Source};
use proptest::prelude::*;
use std::io::{self, Read};

#[test]
fn a_sample_cut_at_any_byte_gives_its_first_frames_and_says_so() {
    for name in SAMPLES {
        let whole = shown::bytes(name);
        let (frames, _) = read(&whole);
        for end in 0..whole.len() {
            let (some, damages) = read(&whole[..end]);
            // In MF4 each kind of frames has records of its own, which follow each other.
            let is_first = if name.ends_with(".mf4") { is_part(&some, &frames) } else { frames.starts_with(&some) };
            assert!(is_first, "{name} cut at {end}: {some:#?}");
            // pcap and pcapng files have no end mark: a file that is cut between two packets is complete.
            let endless = name.contains(".pcap");
            assert!(endless || !damages.is_empty() || shown::open(&whole[..end]).is_err(), "{name} cut at {end}");
        }
    }
}

/// Whether `all` has the frames of `some` in their order.
fn is_part(some: &[String], all: &[String]) -> bool {
    let mut all = all.iter();
    some.iter().all(|frame| all.any(|other| other == frame))
}

#[test]
fn a_pcap_cut_in_a_packet_is_truncated() {
    for name in ["tcpdump-ns.pcap", "three-sections.pcapng"] {
        let whole = shown::bytes(name);
        let (frames, damages) = read(&whole[..whole.len() - 1]);
        assert_eq!((frames.len(), damages.len()), (23, 1), "{name}");
        assert_eq!(damages[0].kind, DamageKind::Truncated, "{name}");
    }
}

#[test]
fn an_mcap_without_footer_is_unfinished() {
    let whole = shown::bytes("ros2-unchunked.mcap");
    // The end-of-data record follows the last message.
    let end = memchr::memmem::rfind(&whole, b"\x0F\x04\0\0\0\0\0\0\0").unwrap();
    let (frames, damages) = read(&whole[..end]);
    assert_eq!(frames.len(), 24);
    assert_eq!(damages.iter().map(|damage| damage.kind).collect::<Vec<_>>(), [DamageKind::Unfinished]);
}

#[test]
fn a_chunk_whose_checksum_is_wrong_gives_no_frames() {
    let mut changed = shown::bytes("ros2-plain.mcap");
    let (all, _) = read(&changed);
    let at = memchr::memmem::find(&changed, b"\x40\0\x60\0\0\0\0\0").unwrap();
    changed[at + 2] ^= 1;
    let (frames, damages) = read(&changed);
    assert!(frames.len() < all.len() && !frames.is_empty());
    assert!(frames.iter().all(|frame| all.contains(frame)));
    assert!(damages.iter().any(|damage| damage.to_string().contains("checksum")), "{damages:?}");
}

#[test]
fn a_compressed_capture_that_ends_early_is_read_up_to_there() {
    let plain = shown::bytes("tcpdump-ns.pcap");
    let frames = read(&plain).0;
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
    io::Write::write_all(&mut gzip, &plain).unwrap();
    let gzip = gzip.finish().unwrap();
    assert_eq!(read(&gzip), (frames.clone(), vec![]));
    let (some, damages) = read(&gzip[..gzip.len() - 300]);
    assert!(frames.starts_with(&some) && !some.is_empty());
    assert_eq!(damages.len(), 1);
    assert_eq!(damages[0].kind, DamageKind::Unfinished);
    assert!(damages[0].to_string().contains("gzip"));
    assert_eq!(read(&zstd::encode_all(&plain[..], 3).unwrap()), (frames, vec![]));
}

/// Reads an endless or huge source; gives the frames and the damages' texts.
fn read_hostile(head: Vec<u8>, tail: impl Read + Send + 'static) -> (usize, Vec<String>) {
    let source = Source::new(io::Cursor::new(head).chain(tail));
    let (mut frames, mut damages) = (0, Vec::new());
    match Capture::from_source("hostile", source, &ReadOptions::default()) {
        Ok(capture) => {
            for next in capture {
                match next {
                    Ok(_) => frames += 1,
                    Err(damage) => damages.push(damage.to_string()),
                }
            }
        }
        Err(error) => damages.push(error.to_string()),
    }
    (frames, damages)
}

/// Zeros, more than the window of a source may hold.
fn zeros() -> io::Take<io::Repeat> {
    io::repeat(0).take(5_000_000)
}

#[test]
fn mcap_chunks_of_any_claimed_size_take_no_memory() {
    let chunk = |record: u64, uncompressed: u64, compressed: u64, compression: &[u8]| {
        let mut file = mcap::MAGIC.to_vec();
        file.push(6);
        file.extend(record.to_le_bytes());
        file.extend([0; 16]);
        file.extend(uncompressed.to_le_bytes());
        file.extend([0; 4]);
        file.extend((compression.len() as u32).to_le_bytes());
        file.extend(compression);
        file.extend(compressed.to_le_bytes());
        file
    };
    for compression in [&b""[..], b"zstd", b"lz4", b"other"] {
        for (record, uncompressed, compressed) in
            [(1 << 63, 1 << 63, 1 << 62), (u64::MAX, u64::MAX, u64::MAX), (1 << 40, 1000, 1 << 39), (50, 50, u64::MAX)]
        {
            let (frames, damages) = read_hostile(chunk(record, uncompressed, compressed, compression), zeros());
            assert_eq!(frames, 0);
            assert!(!damages.is_empty() && damages.len() < 10, "{damages:?}");
        }
    }
    // A chunk whose unpacked content is longer than stated.
    let bomb = zstd::encode_all(io::repeat(0).take(5_000_000), 1).unwrap();
    let mut file = chunk(44 + bomb.len() as u64, 1000, bomb.len() as u64, b"zstd");
    file.extend(bomb);
    let (_, damages) = read_hostile(file, io::empty());
    assert!(damages[0].contains("expected a chunk of 1000 bytes, uncompressed, found \"more\""), "{damages:?}");
}

#[test]
fn pcapng_blocks_of_any_length() {
    let head = shown::bytes("two-interfaces.pcapng");
    let frames = read(&head).0.len();
    for (length, expected) in [
        (0, "expected a block of at least 12 bytes, found \"length 0\""),
        (11, "expected a block of at least 12 bytes"),
        (u32::MAX, "expected a block of 4294967296 bytes"),
        (0x8000_0000, "expected a block of 2147483648 bytes"),
    ] {
        let mut file = head.clone();
        file.extend(6u32.to_le_bytes());
        file.extend(length.to_le_bytes());
        let (read, damages) = read_hostile(file, zeros());
        assert_eq!((read, damages.len()), (frames, 1));
        assert!(damages[0].contains(expected), "{damages:?}");
    }
}

#[test]
fn pcap_packets_of_any_length() {
    let mut file = shown::bytes("tcpdump-us.pcap");
    file.extend([0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]);
    let (read, damages) = read_hostile(file, zeros());
    assert_eq!((read, damages.len()), (24, 1));
    assert!(damages[0].contains("at most 262144 bytes, found \"4294967295 bytes\""));
}

#[test]
fn blf_containers_that_inflate_without_end() {
    let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    io::copy(&mut io::repeat(0).take(5_000_000), &mut zlib).unwrap();
    let bomb = zlib.finish().unwrap();
    for (claimed, expected) in [(1000u32, "found \"more\""), (u32::MAX, "of at most 33554432 bytes")] {
        let mut file = shown::bytes("python-can.blf")[..144].to_vec();
        file.extend(b"LOBJ\x10\0\x01\0");
        file.extend((32 + bomb.len() as u32).to_le_bytes());
        file.extend([10, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0]);
        file.extend(claimed.to_le_bytes());
        file.extend([0; 4]);
        file.extend(&bomb);
        let (frames, damages) = read_hostile(file, io::empty());
        assert_eq!(frames, 0);
        assert!(damages[0].contains(expected), "{damages:?}");
    }
}

#[test]
fn compression_bombs_are_streamed() {
    let zstd = zstd::encode_all(zeros(), 1).unwrap();
    let (_, damages) = read_hostile(zstd, io::empty());
    assert!(damages[0].contains("has no known format"));
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    io::Write::write_all(&mut gzip, &shown::bytes("tcpdump-us.pcap")).unwrap();
    io::Write::write_all(&mut gzip, &[0xFF; 16]).unwrap();
    io::copy(&mut zeros(), &mut gzip).unwrap();
    let (frames, damages) = read_hostile(gzip.finish().unwrap(), io::empty());
    assert_eq!((frames, damages.len()), (24, 1));
}

proptest! {

    /// Changed bytes may change or lose frames near them, but add none and cause neither panic nor hang.
    #[test]
    fn a_changed_sample_is_read_somehow(
        name in prop::sample::select(SAMPLES),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = shown::bytes(name);
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let (frames, _) = read(&bytes);
        prop_assert!(frames.len() <= 24 + 4, "{} frames", frames.len());
        read(&bytes[..cut.index(bytes.len())]);
    }

    /// Any bytes after a magic number.
    #[test]
    fn noise_is_no_capture(
        name in prop::sample::select(SAMPLES),
        head in 0usize..200,
        noise in prop::collection::vec(any::<u8>(), 0..2000),
    ) {
        let sample = shown::bytes(name);
        let mut bytes = sample[..head.min(sample.len())].to_vec();
        bytes.extend(noise);
        read(&bytes);
    }
}
