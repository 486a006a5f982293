//! Writes FRAMES frames of a healthy machine of eight nodes on a half-loaded bus of 500 kbit/s: boot-up, configuration,
//! and then SYNC with synchronous PDOs every 10 ms, heartbeats, TIME and SDO reads.
//!
//! `cargo run --release -p canvass-traces --example machine -- FORMAT FRAMES`

use canvass_traces::{
    CanId, ChannelId, Channels, Format, Frame, INTERMISSION, Record, Timestamp, WriteError, WriteOptions, Writer,
    bit_length,
};
use std::io;

const NODES: u32 = 8;
/// The time of a bit at 500 kbit/s, in ns.
const BIT: u64 = 2_000;
const MILLISECOND: u64 = 1_000_000;
const CYCLE: u64 = 10 * MILLISECOND;
const BEGIN: u64 = 1_700_000_000_000_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let format = args.next().and_then(|id| Format::by_id(&id)).ok_or("expected a format, such as candump")?;
    let frames: u64 = args.next().ok_or("expected a number of frames")?.parse()?;
    let mut channels = Channels::new();
    channels.intern("can0");
    let sink = io::BufWriter::with_capacity(1 << 20, io::stdout());
    let writer = format.create(Box::new(sink), &WriteOptions::default())?;
    let mut bus = Bus { writer, channels, left: frames, free: BEGIN };
    let run = match bus.start() {
        Ok(()) => bus.operate(),
        error => error,
    };
    match run.and_then(|()| bus.writer.finish()) {
        // The reader has closed its end: it needs no more frames.
        Err(WriteError::Io(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => Ok(written?),
    }
}

struct Bus {
    writer: Box<dyn Writer>,
    channels: Channels,
    left: u64,
    /// The time at which the bus is free for the next frame.
    free: u64,
}

impl Bus {
    /// Sends a frame at this time, or when the bus is free.
    fn send(&mut self, at: u64, id: u32, data: &[u8]) -> Result<(), WriteError> {
        let Some(frame) = Frame::new(CanId::standard_masked(id), data) else { return Ok(()) };
        let end = self.free.max(at) + u64::from(bit_length(&frame).unwrap_or(0)) * BIT;
        self.free = end + u64::from(INTERMISSION) * BIT;
        self.left = self.left.saturating_sub(1);
        self.writer.write(&Record::new(Timestamp(end), ChannelId(0), frame), &self.channels)
    }

    /// Sends a request, and its answer a millisecond later.
    fn sdo(&mut self, at: u64, node: u32, request: [u8; 8], answer: [u8; 8]) -> Result<(), WriteError> {
        self.send(at, 0x600 + node, &request)?;
        self.send(at + MILLISECOND, 0x580 + node, &answer)
    }

    fn write(&mut self, at: u64, node: u32, object: (u16, u8), value: u32, length: u8) -> Result<(), WriteError> {
        let ([low, high], sub, [a, b, c, d]) = (object.0.to_le_bytes(), object.1, value.to_le_bytes());
        let request = [0x23 | (4 - length) << 2, low, high, sub, a, b, c, d];
        self.sdo(at, node, request, [0x60, low, high, sub, 0, 0, 0, 0])
    }

    /// Starts and configures the nodes.
    fn start(&mut self) -> Result<(), WriteError> {
        for node in 1..=NODES {
            let at = BEGIN + u64::from(node) * 50 * MILLISECOND;
            self.send(at, 0x700 + node, &[0])?;
            self.sdo(at + 5 * MILLISECOND, node, [0x40, 0, 0x10, 0, 0, 0, 0, 0], [0x43, 0, 0x10, 0, 0x96, 1, 2, 0])?;
            self.write(at + 10 * MILLISECOND, node, (0x1017, 0), 100, 2)?;
            self.write(at + 15 * MILLISECOND, node, (0x1800, 2), 1, 1)?;
            self.write(at + 20 * MILLISECOND, node, (0x1801, 2), 1, 1)?;
            self.write(at + 25 * MILLISECOND, node, (0x1A00, 0), 0, 1)?;
            self.write(at + 30 * MILLISECOND, node, (0x1A00, 1), 0x6004_0020, 4)?;
            self.write(at + 35 * MILLISECOND, node, (0x1A00, 2), 0x6030_0120, 4)?;
            self.write(at + 40 * MILLISECOND, node, (0x1A00, 0), 2, 1)?;
        }
        self.send(BEGIN + 900 * MILLISECOND, 0x000, &[0x01, 0x00])
    }

    /// Runs one cycle after the other.
    fn operate(&mut self) -> Result<(), WriteError> {
        let mut n = 0_u64;
        while self.left > 0 {
            let at = BEGIN + 1_000 * MILLISECOND + n * CYCLE;
            self.send(at, 0x080, &[])?;
            for node in 1..=NODES {
                let position = (u64::from(node) * 10_000 + n * 40) % 0x0100_0000;
                let mut data = (position as u32).to_le_bytes().to_vec();
                data.extend(30_u32.to_le_bytes());
                self.send(at + MILLISECOND / 5, 0x180 + node, &data)?;
            }
            for node in 1..=NODES {
                self.send(at + MILLISECOND / 5, 0x280 + node, &n.wrapping_mul(0x9E37_79B9_7F4A_7C15).to_le_bytes())?;
            }
            for node in 1..=NODES / 2 {
                self.send(at + MILLISECOND / 5, 0x200 + node, &(!n).to_le_bytes())?;
            }
            self.rarely(at, n)?;
            n += 1;
        }
        Ok(())
    }

    /// Sends messages that do not come in every cycle.
    fn rarely(&mut self, at: u64, n: u64) -> Result<(), WriteError> {
        let node = (n % 10) as u32;
        if (1..=NODES).contains(&node) {
            self.send(at + 6 * MILLISECOND, 0x700 + node, &[0x05])?;
        }
        if node == 0 {
            let server = (n / 10 % u64::from(NODES)) as u32 + 1;
            let [a, b, ..] = n.to_le_bytes();
            self.sdo(at + 6 * MILLISECOND, server, [0x40, 4, 0x60, 0, 0, 0, 0, 0], [0x43, 4, 0x60, 0, a, b, 0, 0])?;
        }
        if n % 100 == 50 {
            let [a, b, c, d, ..] = (36_000_000 + n * 10 % 40_000_000).to_le_bytes();
            self.send(at + 8 * MILLISECOND, 0x100, &[a, b, c, d, 0x10, 0x39])?;
        }
        Ok(())
    }
}
