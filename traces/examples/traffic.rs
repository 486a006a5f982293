//! Writes FRAMES frames of a machine's bus to standard output, for benchmarks.
//!
//! `cargo run --release -p canvass-traces --example traffic -- FORMAT FRAMES [BUSES]`

use canvass_traces::{
    CanId, ChannelId, Channels, ChunkCompression, Format, Frame, Record, Timestamp, WriteError, WriteOptions,
};
use std::io;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let format = args.next().and_then(|id| Format::by_id(&id)).ok_or("expected a format, such as candump")?;
    let frames: u64 = args.next().ok_or("expected a number of frames")?.parse()?;
    let buses: u16 = args.next().as_deref().unwrap_or("1").parse()?;
    match write(format, frames, buses.max(1)) {
        // The reader has closed its end: it needs no more frames.
        Err(WriteError::Io(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => Ok(written?),
    }
}

fn write(format: Format, frames: u64, buses: u16) -> Result<(), WriteError> {
    let mut channels = Channels::new();
    for bus in 0..buses {
        channels.intern(&format!("can{bus}"));
    }
    let options = WriteOptions { chunk_compression: ChunkCompression::None, ..WriteOptions::default() };
    let sink = io::BufWriter::with_capacity(1 << 20, io::stdout());
    let mut writer = format.create(Box::new(sink), &options)?;
    let mut traffic = Traffic { random: 0x2545_F491_4F6C_DD1D, time_us: 1_700_000_000_000_000, pending: None };
    for _ in 0..frames {
        let frame = traffic.next_frame();
        let channel = ChannelId((traffic.random() % u64::from(buses)) as u16);
        writer.write(&Record::new(Timestamp(traffic.time_us * 1_000), channel, frame), &channels)?;
    }
    writer.finish()
}

/// The traffic of an eight-node bus as in machines: mostly PDOs, then SDO dialogues, heartbeats and SYNC.
struct Traffic {
    random: u64,
    time_us: u64,
    pending: Option<Frame>,
}

impl Traffic {
    /// Random numbers that are the same in every run (xorshift64), good enough for traffic.
    const fn random(&mut self) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random
    }

    fn next_frame(&mut self) -> Frame {
        self.time_us += 100 + self.random() % 800;
        self.pending.take().unwrap_or_else(|| self.fresh_frame())
    }

    fn fresh_frame(&mut self) -> Frame {
        let node = (self.random() % 8 + 1) as u32;
        let payload = self.random().to_le_bytes();
        let frame = |id: u32, data: &[u8]| {
            let id = CanId::standard_masked(id);
            Frame::new(id, data).unwrap_or(Frame::full(id, payload))
        };
        match self.random() % 100 {
            0..60 => frame(0x180 + node, &payload),
            60..72 => frame(0x280 + node, &payload[..4]),
            72..80 => frame(0x700 + node, &[0x05]),
            80..86 => frame(0x080, &[]),
            _ => {
                self.pending = Some(frame(0x580 + node, &[0x43, 0x04, 0x60, 0, payload[0], payload[1], 0, 0]));
                frame(0x600 + node, &[0x40, 0x04, 0x60, 0, 0, 0, 0, 0])
            }
        }
    }
}
