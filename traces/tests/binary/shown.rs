//! Reads captures in tests, and shows frames as the samples' `.frames` files do.

use canvass_traces::{Capture, Channels, Damage, OpenError, ReadOptions, Reader, Record, Source};
use std::path::PathBuf;

/// The path of a file in `samples/`.
pub fn sample(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("samples").join(name)
}

/// The content of a sample.
pub fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(sample(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Opens a capture in memory, of any format.
pub fn open(bytes: impl Into<Vec<u8>>) -> Result<Capture, OpenError> {
    Capture::from_source("test", Source::from_bytes(bytes), &ReadOptions::default())
}

/// The texts of all frames, and all damages.
pub fn read(bytes: &[u8]) -> (Vec<String>, Vec<Damage>) {
    let Ok(mut capture) = open(bytes) else { return (Vec::new(), Vec::new()) };
    let (mut frames, mut damages) = (Vec::new(), Vec::new());
    while let Some(next) = capture.next() {
        match next {
            Ok(record) => frames.push(shown(&record, capture.channels())),
            Err(damage) => damages.push(damage),
        }
    }
    assert!(capture.next().is_none(), "the end is the end");
    (frames, damages)
}

/// All frames and damages of a sample.
pub fn read_file(name: &str) -> (Vec<String>, Vec<Damage>) {
    read(&bytes(name))
}

/// Checks that a sample gives the frames of its `.frames` file, without any damage.
pub fn reads_as_others_do(name: &str) {
    let (frames, damages) = read_file(name);
    let expected = std::fs::read_to_string(sample(&format!("{name}.frames"))).unwrap();
    assert_eq!(damages, [], "{name}");
    for (n, (frame, expected)) in frames.iter().zip(expected.lines()).enumerate() {
        assert_eq!(frame, expected, "{name}, frame {}", n + 1);
    }
    assert_eq!(frames.len(), expected.lines().count(), "{name}");
}

/// A record as `SECONDS.NANOS CHANNEL FRAME[ DIRECTION]`, with the whole payload.
pub fn shown(record: &Record, channels: &Channels) -> String {
    use std::fmt::Write;
    let frame = record.frame.to_string();
    let mut text = format!("{} {} ", record.timestamp, channels.name(record.channel));
    if let Some(xl) = record.xl_header() {
        let _ = write!(text, "{:02X}{:03X}#{xl:?}#", xl.vcid, record.frame.id().raw());
    }
    match frame.strip_suffix('…') {
        Some(head) => {
            let prefix = head.len() - 2 * record.frame.data().len();
            text.push_str(&head[..prefix]);
            record.data().iter().for_each(|byte| {
                let _ = write!(text, "{byte:02X}");
            });
        }
        None => text.push_str(&frame),
    }
    let direction = record.direction.to_string();
    if !direction.is_empty() {
        let _ = write!(text, " {direction}");
    }
    text
}

/// The binary samples.
pub const SAMPLES: &[&str] = &[
    "tcpdump-us.pcap",
    "tcpdump-ns.pcap",
    "big-endian.pcap",
    "cooked.pcap",
    "cooked-big-endian.pcap",
    "cooked-v2.pcap",
    "unclean-filling.pcap",
    "two-interfaces.pcapng",
    "three-sections.pcapng",
    "ros2-zstd.mcap",
    "ros2-lz4.mcap",
    "ros2-plain.mcap",
    "ros2-unchunked.mcap",
    "vendor.mcap",
    "ros1.mcap",
    "json.mcap",
    "protobuf.mcap",
    "python-can.blf",
    "python-can-plain.blf",
    "python-can-small-containers.blf",
    "python-can.mf4",
    "python-can-deflated.mf4",
    "python-can-plain.mf4",
    "python-can.db",
    "python-can-small-pages.db",
    "long-rows.sqlite",
];
