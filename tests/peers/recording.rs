//! The recording that is exchanged with the peers, and captures of it.

use canvass_traces::{
    CanId, Capture, Channels, ChunkCompression, Compression, Direction, Format, ReadOptions, Reader, Record, Recording,
    TimeBase, Timestamp, WriteOptions, Writer, parse_frame,
};
use std::fmt;
use std::fs::File;
use std::io::{Seek, Write};
use std::path::Path;

pub const FRAMES: usize = 6_000;

/// 2023-11-14 12:00 UTC. TRC and ASC begin with a date in days or milliseconds, which python-can computes in floating
/// point: half a day is exact everywhere.
pub const START: u64 = 1_699_963_200_000_000_000;

/// A received frame with the name of its channel.
#[derive(Clone, Debug)]
pub struct Seen {
    pub channel: String,
    pub record: Record,
}

/// `NANOSECONDS CHANNEL FRAME[ Rx| Tx]`, FRAME in candump's notation: the form in which frames are compared, and passed
/// to the peers that are Python libraries.
impl fmt::Display for Seen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Record { timestamp, direction, .. } = self.record;
        write!(f, "{} {} {}", timestamp.nanos(), self.channel, self.record.notation())?;
        if direction == Direction::Unknown { Ok(()) } else { write!(f, " {direction}") }
    }
}

/// A recording that never changes: standard, extended, remote, error and CAN FD frames of all lengths, directions known
/// and not, on three channels, with times of a nanosecond.
pub fn recording() -> Vec<Seen> {
    let mut random = Random(0x2545_F491_4F6C_DD1D);
    let mut nanos = START;
    (0..FRAMES)
        .map(|n| {
            // The channels appear in this order, so that all programs which number them agree.
            let channel = ["can0", "can1", "can2"][if n < 3 { n } else { random.below(3) as usize }];
            let direction = [Direction::Unknown, Direction::Rx, Direction::Tx][random.below(3) as usize];
            let mut record = parse_frame(&frame(&mut random)).unwrap().with_direction(direction);
            record.timestamp = Timestamp(nanos);
            nanos += 1 + random.below(2_000_000);
            Seen { channel: channel.into(), record }
        })
        .collect()
}

fn frame(random: &mut Random) -> String {
    let id = match random.below(3) {
        0 => format!("{:08X}", random.below(1 + u64::from(CanId::MAX_EXTENDED))),
        _ => format!("{:03X}", random.below(0x800)),
    };
    let mut bytes = |len: u64| (0..len).map(|_| format!("{:02X}", random.below(256))).collect::<String>();
    let (data, long) = (bytes(8), bytes(64));
    match random.below(20) {
        0 => format!("{id}#R"),
        1 => format!("{id}#R{}", 1 + random.below(8)),
        2 => format!("{:08X}#{data}", 0x2000_0001 + random.below(0x1FF)),
        3..=7 => {
            let len = canvass_traces::Frame::FD_LENGTHS[random.below(16) as usize];
            format!("{id}##{:X}{}", 4 + random.below(4), &long[..2 * usize::from(len)])
        }
        _ => format!("{id}#{}", &data[..2 * random.below(9) as usize]),
    }
}

/// Random numbers that are the same on all machines (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % limit
    }
}

/// Writes a capture as `canvass convert` does.
pub fn write(path: &Path, format: Format, chunk_compression: ChunkCompression, frames: &[Seen]) {
    let options = WriteOptions { time_base: TimeBase::Utc, chunk_compression, ..WriteOptions::default() };
    let mut file = File::create(path).unwrap();
    let mut recording =
        Recording::create(Box::new(file.try_clone().unwrap()), format, Compression::None, &options).unwrap();
    let mut channels = Channels::new();
    for seen in frames {
        let mut record = seen.record.clone();
        record.channel = channels.intern(&seen.channel);
        recording.write(&record, &channels).unwrap();
    }
    recording.finish().unwrap();
    if let Some(beginning) = recording.beginning() {
        file.rewind().unwrap();
        file.write_all(beginning).unwrap();
    }
}

/// All frames of a capture, whose format must be recognised and which must be undamaged.
pub fn read(path: &Path, format: Format) -> Result<Vec<String>, String> {
    let mut capture = Capture::open(path, &ReadOptions::default()).map_err(|error| error.to_string())?;
    assert_eq!(capture.format(), format);
    let mut frames = Vec::new();
    while let Some(item) = capture.next() {
        let record = item.map_err(|damage| format!("line {}: {damage}", damage.place.number))?;
        let channel = capture.channels().name(record.channel).to_owned();
        frames.push(Seen { channel, record: record.at(0, 0) }.to_string());
    }
    Ok(frames)
}

impl Seen {
    /// The same data with another record.
    pub fn with_record(self, record: Record) -> Self {
        let Record { timestamp, direction, .. } = self.record;
        let mut record = record.with_direction(direction);
        record.timestamp = timestamp;
        Self { record, ..self }
    }
}
