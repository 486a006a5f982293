//! pcap, tcpdump's format, with CAN frames in its packets (see [`socketcan`](super::socketcan)).
//!
//! ```text
//! file header     magic, version 2.4, time zone (unused), accuracy (unused), snapshot length, link type
//! packet header   seconds, fraction, captured length, original length; then the captured bytes
//! ```
//!
//! All fields of 32 bits (the version: twice 16) in the byte order of the magic number: A1B2C3D4h for
//! microseconds, A1B23C4Dh for nanoseconds. Easily got wrong: the upper half of the link type is not part of it
//! (it may tell the length of a frame check sequence); a snapshot length of 0 means none; a packet whose captured
//! length is below its original length was cut.
//!
//! The format names no channel: all frames are on [`CHANNEL`], but with SLL2 the interface's index tells them
//! apart (`if5`).

use super::socketcan::{self, LINK_TYPES, LinkType};
use crate::{
    ChannelId, Channels, Damage, DamageKind, Direction, Loss, Losses, Place, ReadOptions, Reader, Record, Source,
    TimeBase, Timestamp, WriteError, WriteOptions, Writer,
};
use nom::number::Endianness;
use nom::number::complete::{u16, u32};
use nom::{IResult, Parser};
use std::io::Write;

const MICROSECONDS: u32 = 0xA1B2_C3D4;
const NANOSECONDS: u32 = 0xA1B2_3C4D;
const FILE_HEADER: usize = 24;
const PACKET_HEADER: usize = 16;
/// What tcpdump and Wireshark take for the longest packet. A longer one is a damaged length, behind which
/// nothing can be made sense of.
const LONGEST: u32 = 262_144;
/// The channel of all frames: SocketCAN's usual name of the only bus.
pub(crate) const CHANNEL: &str = "can0";

/// What the magic number tells: the byte order, and how many nanoseconds the fraction counts.
fn magic(head: &[u8]) -> Option<(Endianness, u64)> {
    let head: [u8; 4] = head.get(..4)?.try_into().ok()?;
    let of = |number| match number {
        MICROSECONDS => Some(1_000),
        NANOSECONDS => Some(1),
        _ => None,
    };
    let little = of(u32::from_le_bytes(head)).map(|unit| (Endianness::Little, unit));
    little.or_else(|| of(u32::from_be_bytes(head)).map(|unit| (Endianness::Big, unit)))
}

pub(crate) fn sniff(head: &[u8]) -> bool {
    magic(head).is_some()
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(PcapReader { source, file: None, channels: Channels::new(), number: 0, done: false })
}

struct PcapReader {
    source: Source,
    /// `None` until the file header was read.
    file: Option<File>,
    channels: Channels,
    /// Of the packet read last.
    number: u64,
    done: bool,
}

/// What the file header says.
#[derive(Clone, Copy)]
struct File {
    order: Endianness,
    /// Nanoseconds that the fraction counts.
    unit: u64,
    link: LinkType,
    channel: ChannelId,
}

/// A packet's header.
struct Packet {
    seconds: u32,
    fraction: u32,
    captured: u32,
    original: u32,
}

impl Packet {
    #[inline]
    fn timestamp(&self, file: File) -> Timestamp {
        Timestamp(u64::from(self.seconds) * 1_000_000_000 + u64::from(self.fraction) * file.unit)
    }
}

#[inline]
fn packet_header(order: Endianness, i: &[u8]) -> IResult<&[u8], Packet> {
    (u32(order), u32(order), u32(order), u32(order))
        .map(|(seconds, fraction, captured, original)| Packet { seconds, fraction, captured, original })
        .parse(i)
}

impl PcapReader {
    fn place(&self) -> Place {
        Place { number: self.number, offset: self.source.offset() }
    }

    fn fatal(&self, expected: impl Into<std::borrow::Cow<'static, str>>, found: &str) -> Damage {
        Damage::new(DamageKind::Fatal, self.place(), expected, found.as_bytes())
    }

    fn file_header(&mut self) -> Result<File, Damage> {
        if !self.source.fill_to(FILE_HEADER).map_err(|error| Damage::source(&error, self.place()))? {
            let found = format!("{} bytes", self.source.window().len());
            return Err(self.fatal("a pcap header of 24 bytes", &found));
        }
        let window = self.source.window();
        let Some((order, unit)) = magic(window) else {
            return Err(self.fatal("a pcap magic number", ""));
        };
        let parsed: IResult<_, _> =
            (u16(order), u16(order), u32(order), u32(order), u32(order), u32(order)).parse(&window[4..]);
        let Ok((_, (major, _, _, _, _, link))) = parsed else {
            return Err(self.fatal("a pcap header of 24 bytes", ""));
        };
        if major != 2 {
            return Err(self.fatal("pcap version 2", &major.to_string()));
        }
        // The upper half has other uses.
        let number = (link & 0xFFFF) as u16;
        let Some(link) = LinkType::from_number(number) else {
            return Err(self.fatal(LINK_TYPES, &format!("link type {number}")));
        };
        self.source.consume(FILE_HEADER);
        Ok(File { order, unit, link, channel: self.channels.intern(CHANNEL) })
    }

    /// The next packet, if it is a whole one at hand with a common frame: the same as [`PcapReader::packet`] gives,
    /// but quickly.
    #[inline]
    fn common_packet(&mut self, file: File) -> Option<Record> {
        let window = self.source.window();
        let (header, rest) = window.split_first_chunk::<PACKET_HEADER>()?;
        let (_, packet) = packet_header(file.order, header).ok()?;
        if packet.captured != packet.original || file.link != LinkType::SocketCan {
            return None;
        }
        let frame = socketcan::common_frame(rest.get(..packet.captured as usize)?)?;
        self.number += 1;
        let mut record = Record::new(packet.timestamp(file), file.channel, frame);
        record.place = self.place();
        self.source.consume(PACKET_HEADER + packet.captured as usize);
        Some(record)
    }

    /// The next packet; `None` at the end.
    fn packet(&mut self, file: File) -> Result<Option<Record>, Damage> {
        self.number += 1;
        if !self.has(PACKET_HEADER)? {
            let window = self.source.window();
            return if window.is_empty() { Ok(None) } else { Err(self.cut("a packet header of 16 bytes".into())) };
        }
        let Ok((_, packet)) = packet_header(file.order, self.source.window()) else {
            return Err(self.cut("a packet header of 16 bytes".into()));
        };
        if packet.captured > LONGEST {
            let expected = format!("a packet of at most {LONGEST} bytes");
            return Err(self.fatal(expected, &format!("{} bytes", packet.captured)));
        }
        let end = PACKET_HEADER + packet.captured as usize;
        if !self.has(end)? {
            return Err(self.cut(format!("a packet of {} bytes", packet.captured)));
        }
        let place = self.place();
        let record = self.record(file, &packet, place);
        self.source.consume(end);
        record.map(Some)
    }

    #[inline]
    fn has(&mut self, n: usize) -> Result<bool, Damage> {
        match self.source.fill_to(n) {
            Ok(has) => Ok(has),
            Err(error) => {
                self.done = true;
                Err(Damage::source(&error, self.place()))
            }
        }
    }

    /// The file ends in a packet.
    fn cut(&mut self, expected: String) -> Damage {
        self.done = true;
        let found = format!("the end of the file after {}", self.source.window().len());
        Damage::new(DamageKind::Truncated, self.place(), expected, found.as_bytes())
    }

    fn record(&mut self, file: File, packet: &Packet, place: Place) -> Result<Record, Damage> {
        if packet.captured < packet.original {
            let expected = format!("a packet of {} bytes", packet.original);
            let found = format!("cut to {}", packet.captured);
            return Err(Damage::new(DamageKind::Truncated, place, expected, found.as_bytes()));
        }
        let bytes = self.source.window().get(PACKET_HEADER..PACKET_HEADER + packet.captured as usize);
        let seen =
            socketcan::decode(file.link, file.order, bytes.unwrap_or_default()).map_err(|flaw| flaw.damage(place))?;
        let channel = match seen.interface {
            Some(index) => self.channels.intern(&format!("if{index}")),
            None => file.channel,
        };
        let mut record = seen.record;
        (record.timestamp, record.channel, record.place) = (packet.timestamp(file), channel, place);
        Ok(record)
    }
}

impl Iterator for PcapReader {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        let file = match self.file {
            Some(file) => file,
            None => match self.file_header() {
                Ok(file) => *self.file.insert(file),
                Err(damage) => {
                    self.done = true;
                    return Some(Err(damage));
                }
            },
        };
        if let Some(record) = self.common_packet(file) {
            return Some(Ok(record));
        }
        let next = self.packet(file);
        self.done |= match &next {
            Ok(record) => record.is_none(),
            Err(damage) => damage.kind.is_fatal(),
        };
        next.transpose()
    }
}

impl Reader for PcapReader {
    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn time_base(&self) -> TimeBase {
        TimeBase::Utc
    }
}

/// Writes little-endian, nanoseconds, link type 227.
struct PcapWriter {
    sink: Box<dyn Write>,
    /// The packet under way.
    packet: Vec<u8>,
    time_base: TimeBase,
    losses: Losses,
}

pub(crate) fn create(mut sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    let mut header = Vec::with_capacity(FILE_HEADER);
    header.extend_from_slice(&NANOSECONDS.to_le_bytes());
    header.extend_from_slice(&[2, 0, 4, 0]);
    header.extend_from_slice(&[0; 8]);
    header.extend_from_slice(&LONGEST.to_le_bytes());
    header.extend_from_slice(&u32::from(socketcan::WRITTEN_LINK_TYPE).to_le_bytes());
    sink.write_all(&header)?;
    Ok(Box::new(PcapWriter { sink, packet: Vec::new(), time_base: options.time_base, losses: Losses::default() }))
}

impl Writer for PcapWriter {
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError> {
        if channels.name(record.channel) != CHANNEL {
            self.losses.count(Loss::ChannelName);
        }
        if record.direction != Direction::Unknown {
            self.losses.count(Loss::Direction);
        }
        self.losses.count_any(Loss::of_utc(self.time_base));
        let nanos = record.timestamp.nanos();
        // 32 bits of seconds last until 2106.
        let seconds = u32::try_from(nanos / 1_000_000_000).unwrap_or_else(|_| {
            self.losses.count(Loss::Date);
            u32::MAX
        });
        self.packet.clear();
        self.packet.extend_from_slice(&seconds.to_le_bytes());
        self.packet.extend_from_slice(&((nanos % 1_000_000_000) as u32).to_le_bytes());
        self.packet.extend_from_slice(&[0; 8]);
        socketcan::encode(record, &mut self.packet);
        let length = ((self.packet.len() - PACKET_HEADER) as u32).to_le_bytes();
        for at in [8, 12] {
            self.packet[at..at + 4].copy_from_slice(&length);
        }
        Ok(self.sink.write_all(&self.packet)?)
    }

    fn flush(&mut self) -> Result<(), WriteError> {
        Ok(self.sink.flush()?)
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        self.flush()
    }

    fn losses(&self) -> &Losses {
        &self.losses
    }
}
