//! Captures of random CANopen traffic, in every format.

use crate::sink::Shared;
use canvass_traces::{
    CanId, ChannelId, Channels, ChunkCompression, ErrorClass, Flags, Format, Frame, Record, Timestamp, WriteOptions,
};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

const SECOND: u64 = 1_000_000_000;
const BEGIN: u64 = 1_738_061_235 * SECOND;
/// The COB-IDs to which PDOs and other services move.
const PLACES: [u32; 8] = [0x181, 0x182, 0x1A0, 0x281, 0x105, 0x106, 0x6A0, 0x080];

/// Random numbers that are the same on all machines (xorshift64*).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) % end.max(1)
    }

    pub fn byte(&mut self) -> u8 {
        self.below(256) as u8
    }

    pub fn of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len() as u64) as usize]
    }
}

/// The frames of a bus while they are generated.
struct Bus {
    random: Random,
    now: u64,
    records: Vec<Record>,
    channels: u64,
}

/// The frames of a network of a few nodes, with the errors that such networks have.
pub fn traffic(seed: u64, frames: usize, kinds: Kinds) -> Vec<Record> {
    let mut random = Random::new(seed);
    let channels = 1 + random.below(kinds.channels);
    let mut bus = Bus { random, now: BEGIN, records: Vec::new(), channels };
    for node in 1..=3 {
        bus.node_begins(node);
    }
    while bus.records.len() < frames {
        bus.something(kinds);
    }
    bus.records
}

/// The kinds of records that a format can hold.
#[derive(Clone, Copy)]
pub struct Kinds {
    pub channels: u64,
    pub fd: bool,
    pub errors: bool,
    pub comments: bool,
}

impl Bus {
    fn record(&mut self, frame: Frame) -> Record {
        // Every format can hold times in whole milliseconds; now and then the clock steps back.
        self.now += (1 + self.random.below(20)) * 1_000_000;
        if self.random.below(400) == 0 {
            self.now -= 50_000_000;
        }
        if self.random.below(300) == 0 {
            self.now += 3 * SECOND;
        }
        Record::new(Timestamp(self.now), ChannelId(self.random.below(self.channels) as u16), frame)
    }

    fn send(&mut self, id: u32, data: &[u8]) {
        let frame = Frame::new(CanId::standard_masked(id), data).unwrap();
        let record = self.record(frame);
        self.records.push(record);
    }

    /// A node boots up. Its identity and the mapping of a PDO are read now, or only later in the capture.
    fn node_begins(&mut self, node: u32) {
        self.send(0x700 + node, &[0]);
        let identity = [0x13_u32, 0x5868_2001, 0x0001_0002, 77 + node];
        for (sub, value) in (1_u8..).zip(identity) {
            self.upload(node, 0x1018, sub, value.to_le_bytes());
        }
        self.upload(node, 0x1A00, 0, [2, 0, 0, 0]);
        self.upload(node, 0x1A00, 1, [0x20, 0, 0x04, 0x60]);
        self.upload(node, 0x1A00, 2, [0x10, 0, 0x30, 0x60]);
        self.upload(node, 0x1800, 1, (0x180 + node).to_le_bytes());
        self.send(0, &[1, node as u8]);
    }

    fn upload(&mut self, node: u32, index: u16, sub: u8, value: [u8; 4]) {
        let [low, high] = index.to_le_bytes();
        self.send(0x600 + node, &[0x40, low, high, sub, 0, 0, 0, 0]);
        self.send(0x580 + node, &[&[0x43, low, high, sub], &value[..]].concat());
    }

    fn something(&mut self, kinds: Kinds) {
        let node = 1 + self.random.below(4) as u32;
        match self.random.below(32) {
            0..6 => {
                let data: Vec<u8> = (0..6 + self.random.below(3)).map(|_| self.random.byte()).collect();
                self.send(0x180 + node, &data[..6]);
            }
            6..9 => {
                let state = *self.random.of(&[5, 5, 5, 0x7F, 4]);
                self.send(0x700 + node, &[state]);
            }
            9 => self.send(0x80, &[]),
            10 => self.emcy(node),
            11..14 => {
                let value = [self.random.byte(), self.random.byte(), 0, 0];
                let index = *self.random.of(&[0x1000, 0x6004, 0x6030, 0x2000]);
                self.upload(node, index, 0, value);
            }
            14 => self.segmented(node),
            15 => self.abort(node),
            16 => {
                let command = *self.random.of(&[1, 2, 0x80, 0x81, 0x82]);
                let node = self.random.below(3) as u8 + 1;
                self.send(0, &[command, node]);
            }
            17 => {
                let mode = self.random.below(2) as u8;
                self.send(0x7E5, &[4, mode, 0, 0, 0, 0, 0, 0]);
            }
            18 => {
                let length = self.random.below(9) as usize;
                let data: Vec<u8> = (0..length).map(|_| self.random.byte()).collect();
                self.send(self.random.0 as u32 & 0x7FF, &data);
            }
            19 => self.foreign(kinds),
            20 => self.send(0x700 + node, &[0]),
            21 => self.send(0x100, &[0, 0, 0, 0, 0x10, 0x3A]),
            22 => self.comment(kinds),
            23 => self.moved(node),
            24..26 => {
                let id = *self.random.of(&PLACES);
                let data = [self.random.byte(), 0x04, 0x60, 0, 1, 2, 3, 4];
                self.send(id, &data);
            }
            26 => self.copies(),
            27 => self.guarded(node),
            28 => self.safe(),
            29 => self.renamed(node),
            30 => self.mapped(node),
            _ => self.download(node),
        }
    }

    /// Writes a COB-ID of a PDO, EMCY, SYNC, a further SDO server or an SRDO, so that the COB-ID moves or becomes
    /// invalid.
    fn moved(&mut self, node: u32) {
        let objects = [(0x1800, 1), (0x1801, 1), (0x1400, 1), (0x1014, 0), (0x1005, 0), (0x1201, 1), (0x1201, 2)];
        let (index, sub) = *self.random.of(&[&objects[..], &[(0x1301, 1), (0x1301, 5), (0x1301, 6)]].concat());
        let invalid = if self.random.below(5) == 0 { 0x8000_0000 } else { 0 };
        let place = *self.random.of(&PLACES) | invalid;
        let value = if (index, sub) == (0x1301, 1) { 1 } else { place };
        self.write(node, index, sub, value);
    }

    /// A PDO gets another mapping, or becomes a multiplexed PDO.
    fn mapped(&mut self, node: u32) {
        let count = *self.random.of(&[0, 1, 2, 0xFE, 0xFF]);
        self.write(node, 0x1A00, 1, 0x6004_0020);
        self.write(node, 0x1A00, 2, 0x6030_0110);
        self.write(node, 0x1A00, 0, count);
    }

    fn write(&mut self, node: u32, index: u16, sub: u8, value: u32) {
        let [low, high] = index.to_le_bytes();
        self.send(0x600 + node, &[&[0x23, low, high, sub], &value.to_le_bytes()[..]].concat());
        self.send(0x580 + node, &[0x60, low, high, sub, 0, 0, 0, 0]);
    }

    /// Repeats the last frames, as interfaces do that record their own frames.
    fn copies(&mut self) {
        let begin = self.records.len().saturating_sub(3);
        let again = self.records[begin..].to_vec();
        self.records.extend(again.into_iter().filter(|record| record.comment().is_none()));
    }

    /// A master guards a node, which answers with a toggle bit.
    fn guarded(&mut self, node: u32) {
        let asked = self.record(Frame::remote(CanId::standard_masked(0x700 + node), 1).unwrap());
        self.records.push(asked);
        let toggle = self.random.byte() & 0x80;
        self.send(0x700 + node, &[5 | toggle]);
    }

    /// Sends the two halves of an SRDO.
    fn safe(&mut self) {
        let byte = self.random.byte();
        self.send(0x105, &[byte, 1]);
        self.send(0x106, &[!byte, !1]);
    }

    /// LSS gives a device another node-ID, and the device starts; or a device reports its start as before CiA 301 V4.
    fn renamed(&mut self, node: u32) {
        if self.random.below(2) == 0 {
            return self.send(0x80 + node, &[]);
        }
        self.send(0x7E5, &[0x11, node as u8, 0, 0, 0, 0, 0, 0]);
        self.send(0x7E4, &[0x11, 0, 0, 0, 0, 0, 0, 0]);
        self.send(0x700 + node, &[0]);
    }

    fn emcy(&mut self, node: u32) {
        let code: u16 = *self.random.of(&[0, 0x8130, 0x5000, 0x4310, 0xFF01]);
        let [low, high] = code.to_le_bytes();
        self.send(0x80 + node, &[low, high, u8::from(code != 0), 1, 2, 3, 4, 5]);
    }

    fn segmented(&mut self, node: u32) {
        self.send(0x600 + node, &[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
        self.send(0x580 + node, &[0x41, 0x08, 0x10, 0, 7, 0, 0, 0]);
        self.send(0x600 + node, &[0x60, 0, 0, 0, 0, 0, 0, 0]);
        // Now and then the toggle bit is wrong.
        let toggle = if self.random.below(4) == 0 { 0x10 } else { 0 };
        self.send(0x580 + node, &[&[1 | toggle], &b"Kuebler"[..]].concat());
    }

    fn abort(&mut self, node: u32) {
        self.send(0x600 + node, &[0x40, 0x34, 0x12, 5, 0, 0, 0, 0]);
        let code: u32 = *self.random.of(&[0x0602_0000, 0x0609_0011, 0x0504_0000, 0x1234_5678]);
        self.send(0x580 + node, &[&[0x80, 0x34, 0x12, 5], &code.to_le_bytes()[..]].concat());
    }

    fn download(&mut self, node: u32) {
        self.send(0x600 + node, &[0x2B, 0x17, 0x10, 0, 0xE8, 3, 0, 0]);
        // Now and then the server does not answer.
        if self.random.below(3) > 0 {
            self.send(0x580 + node, &[0x60, 0x17, 0x10, 0, 0, 0, 0, 0]);
        }
    }

    fn foreign(&mut self, kinds: Kinds) {
        let frame = match self.random.below(4) {
            0 if kinds.errors => Frame::error(ErrorClass(4), &[0, 8, 0, 0, 0, 0, 0, 0]).unwrap(),
            1 => Frame::remote(CanId::standard_masked(0x701), 1).unwrap(),
            2 if kinds.fd => Frame::fd(CanId::standard_masked(0x321), Flags::BRS, &[1, 2, 3, 4]).unwrap(),
            _ => Frame::new(CanId::extended_masked(0x18FF_0102), &[self.random.byte(); 3]).unwrap(),
        };
        let record = self.record(frame);
        self.records.push(record);
    }

    fn comment(&mut self, kinds: Kinds) {
        let frame = Frame::new(CanId::standard_masked(0x80), &[]).unwrap();
        let record = self.record(frame);
        let record = if kinds.comments { record.with_comment("case 301/boot-up/every-time begins") } else { record };
        self.records.push(record);
    }
}

/// Writes a file of this format with random frames; some files are compressed. Returns its path.
pub fn write(folder: &Path, format: Format, seed: u64) -> PathBuf {
    let kinds = kinds(format);
    let records = traffic(seed, 120 + (seed % 7) as usize * 60, kinds);
    let content = match format {
        Format::CandumpConsole => console(&records).into_bytes(),
        Format::Pasted => console(&records).lines().map(|line| format!(">{line}\n")).collect::<String>().into_bytes(),
        Format::MiniMon => minimon(&records).into_bytes(),
        Format::Blf => blf(&records),
        _ if !format.is_written() => sample(format),
        _ => written(format, &records, seed),
    };
    let ending = format.extensions()[0];
    let (content, compression) = match seed % 5 {
        3 => (gzip(&content), ".gz"),
        4 => (zstd(&content), ".zst"),
        _ => (content, ""),
    };
    let path = folder.join(format!("{}-{seed}.{ending}{compression}", format.id()));
    std::fs::write(&path, content).unwrap();
    path
}

/// Writes a candump log of `frames` frames, and returns its path.
pub fn log(folder: &Path, seed: u64, frames: usize) -> PathBuf {
    let path = folder.join(format!("long-{seed}.log"));
    let records = traffic(seed, frames, kinds(Format::Candump));
    std::fs::write(&path, written(Format::Candump, &records, seed)).unwrap();
    path
}

const fn kinds(format: Format) -> Kinds {
    match format {
        Format::MiniMon => Kinds { channels: 1, fd: false, errors: false, comments: false },
        Format::Blf => Kinds { channels: 2, fd: false, errors: false, comments: false },
        Format::Trc => Kinds { channels: 2, fd: false, errors: true, comments: false },
        Format::CandumpConsole | Format::Pasted => Kinds { channels: 2, fd: false, errors: false, comments: false },
        Format::Candump | Format::Pcapng => Kinds { channels: 3, fd: true, errors: true, comments: true },
        _ => Kinds { channels: 2, fd: true, errors: true, comments: false },
    }
}

fn channels() -> Channels {
    let mut channels = Channels::new();
    ["can0", "can1", "can2"].iter().for_each(|name| {
        channels.intern(name);
    });
    channels
}

fn written(format: Format, records: &[Record], seed: u64) -> Vec<u8> {
    let chunks = [ChunkCompression::Zstd, ChunkCompression::Lz4, ChunkCompression::None];
    let chunk_compression = chunks[(seed % 3) as usize];
    let (sink, options) = (Shared::default(), WriteOptions { chunk_compression, ..WriteOptions::default() });
    let mut writer = format.create(Box::new(sink.clone()), &options).unwrap();
    records.iter().for_each(|record| writer.write(record, &channels()).unwrap());
    writer.finish().unwrap();
    let beginning = writer.beginning().map(<[u8]>::to_vec).unwrap_or_default();
    drop(writer);
    let mut bytes = sink.0.lock().unwrap().clone();
    bytes[..beginning.len()].copy_from_slice(&beginning);
    bytes
}

/// Formats records as candump prints them on a console.
fn console(records: &[Record]) -> String {
    let mut text = String::new();
    for record in records {
        let (nanos, id) = (record.timestamp.nanos(), record.frame.id());
        let digits = if id.is_extended() { format!("{:08X}", id.raw()) } else { format!("{:03X}", id.raw()) };
        let (seconds, micros, channel) = (nanos / SECOND, nanos % SECOND / 1000, record.channel.0);
        write!(text, " ({seconds}.{micros:06})  can{channel}  {digits}   [{}]  ", record.frame.len()).unwrap();
        if record.frame.is_remote() {
            text.push_str("remote request");
        }
        record.data().iter().for_each(|byte| write!(text, "{byte:02X} ").unwrap());
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text
}

fn minimon(records: &[Record]) -> String {
    let mut text = "ASCII Trace IXXAT MiniMon V3  Version: 1.1.4.4533\nDate: 28.01.2025\nStart time: 10:47:15\nStop \
                    time: 23:00:00\nOverruns: 0\nBaudrate: 250 kbit/s\n\"Time\";\"Identifier \
                    (hex)\";\"Format\";\"Flags\";\"Data (hex)\"\n"
        .to_owned();
    for record in records {
        let millis = (record.timestamp.nanos() - BEGIN) / 1_000_000 + (10 * 3600 + 47 * 60 + 15) * 1000;
        let (hours, minutes, seconds) = (millis / 3_600_000, millis / 60_000 % 60, millis / 1000 % 60);
        let (id, kind) = (record.frame.id(), if record.frame.id().is_extended() { "Ext" } else { "Std" });
        let flags = if record.frame.is_remote() { "Rtr" } else { "" };
        let data: String = record.data().iter().map(|byte| format!("{byte:02X} ")).collect();
        let time = format!("{hours}:{minutes:02}:{seconds:02}.{:03}", millis % 1000);
        writeln!(text, "\"{time}\";\"{:X}\";\"{kind}\";\"{flags}\";\"{data}\"", id.raw()).unwrap();
    }
    text
}

/// Makes a BLF file: a file header, and plain CAN messages one after the other.
fn blf(records: &[Record]) -> Vec<u8> {
    let mut objects = Vec::new();
    for record in records {
        let id = record.frame.id();
        let raw = id.raw() | if id.is_extended() { 0x8000_0000 } else { 0 };
        let mut body = (record.channel.0 + 1).to_le_bytes().to_vec();
        body.extend([if record.frame.is_remote() { 0x80 } else { 0 }, record.frame.len() as u8]);
        body.extend(raw.to_le_bytes());
        body.extend(record.frame.bytes());
        objects.extend(b"LOBJ\x20\0\x01\0");
        objects.extend((32 + body.len() as u32).to_le_bytes());
        objects.extend([1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0]);
        objects.extend((record.timestamp.nanos() - BEGIN).to_le_bytes());
        objects.extend(body);
    }
    let mut file = b"LOGG".to_vec();
    file.extend(144_u32.to_le_bytes());
    file.extend([0; 8]);
    file.extend((144 + objects.len() as u64).to_le_bytes());
    file.extend((144 + objects.len() as u64).to_le_bytes());
    file.extend((records.len() as u32).to_le_bytes());
    file.extend([0; 4]);
    // Year, month, day of the week, day, hour, minute, second, millisecond.
    for _ in 0..2 {
        [2025_u16, 1, 2, 28, 10, 47, 15, 0].iter().for_each(|part| file.extend(part.to_le_bytes()));
    }
    file.resize(144, 0);
    file.extend(objects);
    file
}

/// A sample of a format that nothing here writes.
fn sample(format: Format) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/samples");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let mut samples = files.iter().map(|path| std::fs::read(path).unwrap());
    samples.find(|bytes| Format::sniff(bytes) == Some(format)).unwrap()
}

fn gzip(content: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(content).unwrap();
    encoder.finish().unwrap()
}

fn zstd(content: &[u8]) -> Vec<u8> {
    zstd::encode_all(content, 1).unwrap()
}
