//! How fast captures are read, in million frames per second on one thread, or, with a file's name, what is in it.
//!
//! `cargo run --release -p canvass-traces --example read_speed [FILE]`

use canvass_traces::{
    CanId, Capture, ChannelId, Channels, ChunkCompression, Format, Frame, ReadOptions, Record, Source, Timestamp,
    WriteError, WriteOptions,
};
use std::io::{self, Write};
use std::path::Path;
use std::sync::mpsc::{Sender, channel};
use std::time::Instant;

const FRAMES: u64 = 1_000_000;

/// Hands what is written to the reader's side.
struct Sink(Sender<Vec<u8>>);

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.send(bytes.to_vec()).map_err(io::Error::other)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A capture of SDO and PDO traffic on two channels.
fn capture(format: Format, chunk_compression: ChunkCompression) -> Result<Vec<u8>, WriteError> {
    let mut channels = Channels::new();
    let buses = [channels.intern("can0"), channels.intern("can1")];
    let (sender, receiver) = channel();
    let collected = std::thread::spawn(move || receiver.into_iter().flatten().collect::<Vec<u8>>());
    let options = WriteOptions { chunk_compression, ..WriteOptions::default() };
    let mut writer = format.create(Box::new(io::BufWriter::with_capacity(1 << 20, Sink(sender))), &options)?;
    for n in 0..FRAMES {
        let id = CanId::standard_masked(0x181 + (n % 5) as u32 * 0x80);
        let frame = Frame::full(id, n.wrapping_mul(0x9E37_79B9_7F4A_7C15).to_le_bytes());
        let channel = buses.get((n % 7 == 0) as usize).copied().unwrap_or(ChannelId(0));
        writer.write(&Record::new(Timestamp(1_700_000_000_000_000_000 + n * 120_000), channel, frame), &channels)?;
    }
    writer.finish()?;
    drop(writer);
    collected.join().map_err(|_| WriteError::Io(io::Error::other("the collector failed")))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = io::stdout();
    if let Some(path) = std::env::args().nth(1) {
        let start = Instant::now();
        let (mut frames, mut damages) = (0u64, 0u64);
        for next in Capture::open(Path::new(&path), &ReadOptions::default())? {
            match next {
                Ok(_) => frames += 1,
                Err(_) => damages += 1,
            }
        }
        writeln!(out, "{frames} frames, {damages} damages, {:?}", start.elapsed())?;
        return Ok(());
    }
    for (format, compression) in [
        (Format::Pcap, ChunkCompression::None),
        (Format::Pcapng, ChunkCompression::None),
        (Format::Mcap, ChunkCompression::None),
        (Format::Mcap, ChunkCompression::Lz4),
        (Format::Mcap, ChunkCompression::Zstd),
    ] {
        let bytes = capture(format, compression)?;
        let mut best = f64::MAX;
        for _ in 0..10 {
            let source = Source::from_bytes(bytes.clone());
            let start = Instant::now();
            let mut sum = 0;
            let mut capture = Capture::from_source("speed", source, &ReadOptions::default())?;
            while let Some(Ok(record)) = capture.next() {
                sum += record.timestamp.nanos() ^ record.frame.len() as u64;
            }
            best = best.min(start.elapsed().as_secs_f64());
            std::hint::black_box(sum);
        }
        writeln!(out, "{format} {compression:?}: {:.1} M frames/s", FRAMES as f64 / best / 1e6)?;
    }
    Ok(())
}
