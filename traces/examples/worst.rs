//! Writes traffic of the highest cost for an analyzer, as a broken machine or an attacker may send it.
//!
//! `cargo run --release -p canvass-traces --example worst -- KIND FRAMES`

use canvass_traces::{CanId, ChannelId, Channels, Format, Frame, Record, Timestamp, WriteError, WriteOptions};
use std::io;

/// A kind of traffic: its name, number of channels, distance of two frames in microseconds, and the n-th frame.
type Kind = (&'static str, u16, u64, fn(u64) -> Frame);

const KINDS: [Kind; 11] = [
    ("boot-ups", 1, 1_000, |_| frame(0x705, &[0])),
    ("reboots", 1, 250, |n| frame(0x701 + n % 127, &[0])),
    ("commands", 1, 250, |n| frame(0, &[if n % 2 == 0 { 0x81 } else { 0x01 }, 0])),
    ("guarding", 1, 250, |n| remote(0x701 + n % 127)),
    ("requests", 1, 250, |n| frame(0x601 + n % 127, &[0x40, low(n), 0x10, high(n), 0, 0, 0, 0])),
    ("errors", 1, 250, |n| frame(0x081 + n % 127, &[low(n), high(n) | 1, 1, 0, 0, 0, 0, 0])),
    ("cob-ids", 1, 250, cob_ids),
    ("cobs-64", 64, 100, |n| cob_ids(n / 64)),
    ("consumers", 1, 100, consumers),
    ("channels", 5_000, 10, |n| frame(0x181 + n % 8, &[1, 2, 3, 4, 5, 6, 7, 8])),
    ("identifiers", 64, 10, identifiers),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let kind = args.next().and_then(|name| KINDS.into_iter().find(|kind| kind.0 == name));
    let kind = kind.ok_or_else(|| format!("expected one of {:?}", KINDS.map(|kind| kind.0)))?;
    let frames: u64 = args.next().ok_or("expected a number of frames")?.parse()?;
    match write(kind, frames) {
        // The reader has closed its end: it needs no more frames.
        Err(WriteError::Io(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => Ok(written?),
    }
}

fn write((_, buses, micros, frame): Kind, frames: u64) -> Result<(), WriteError> {
    const BEGIN: u64 = 1_700_000_000_000_000_000;
    let mut channels = Channels::new();
    for bus in 0..buses {
        channels.intern(&format!("can{bus}"));
    }
    let sink = io::BufWriter::with_capacity(1 << 20, io::stdout());
    let mut writer = Format::Candump.create(Box::new(sink), &WriteOptions::default())?;
    for n in 0..frames {
        let channel = ChannelId((n % u64::from(buses)) as u16);
        writer.write(&Record::new(Timestamp(BEGIN + n * micros * 1_000), channel, frame(n)), &channels)?;
    }
    writer.finish()
}

fn frame(id: u64, data: &[u8]) -> Frame {
    let id = CanId::standard_masked(id as u32);
    Frame::new(id, data).unwrap_or(Frame::full(id, [0; 8]))
}

fn remote(id: u64) -> Frame {
    let id = CanId::standard_masked(id as u32);
    Frame::remote(id, 1).unwrap_or(Frame::full(id, [0; 8]))
}

const fn low(n: u64) -> u8 {
    n as u8
}

const fn high(n: u64) -> u8 {
    (n >> 8) as u8
}

/// Gives COB-IDs to all possible TPDOs of all nodes.
fn cob_ids(n: u64) -> Frame {
    let (exchange, [id, id_high, ..]) = (n / 2, (0x181 + n / 2 % 0x3FF).to_le_bytes());
    let (node, [index, index_high, ..]) = (1 + exchange % 127, (0x1800 + exchange / 127 % 512).to_le_bytes());
    match n % 2 {
        0 => frame(0x600 + node, &[0x23, index, index_high, 1, id, id_high, 0, 0]),
        _ => frame(0x580 + node, &[0x60, index, index_high, 1, 0, 0, 0, 0]),
    }
}

/// Configures every node to consume the heartbeats of all nodes, which then send them.
fn consumers(n: u64) -> Frame {
    let (entry, node) = (n / 2 % 127 + 1, n / 254 + 1);
    match n % 2 {
        _ if node > 127 => frame(0x701 + n % 127, &[5]),
        0 => frame(0x600 + node, &[0x23, 0x16, 0x10, entry as u8, 100, 0, entry as u8, 0]),
        _ => frame(0x580 + node, &[0x60, 0x16, 0x10, entry as u8, 0, 0, 0, 0]),
    }
}

/// Every CAN-ID on every channel, with messages that change the states of all nodes and raise errors.
fn identifiers(n: u64) -> Frame {
    let (round, id) = (n / 64 / 2_048, n / 64 % 2_048);
    match id {
        // The states of all nodes, in turn.
        0x701..=0x77F => frame(id, &[[0x05, 0x7F, 0x04][round as usize % 3]]),
        0 => frame(id, &[0x80, 0]),
        _ => frame(id, &[low(round), high(round) | 1, low(n), 4, 5, 6, 7, 8]),
    }
}
