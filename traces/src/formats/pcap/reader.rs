//! Reads pcap.

use super::{CHANNEL, LONGEST};
use crate::formats::socketcan::{self, LINK_TYPES, LinkType};
use crate::{
    ChannelId, Channels, Damage, DamageKind, Place, ReadOptions, Reader, Record, Source, SourceError, TimeBase,
    Timestamp,
};
use byteorder::{BigEndian, LittleEndian};
use pcap_file::Endianness;
use pcap_file::pcap::{PcapHeader, PcapParseError, PcapTsResolution, RawPcapPacket};
use std::borrow::Cow;

const FILE_HEADER: usize = 24;
const PACKET_HEADER: usize = 16;
/// Limit of the time between the last packet and one found by searching, in seconds.
const NEAR: u32 = 86_400;

pub(crate) fn sniff(head: &[u8]) -> bool {
    let magic = head.get(..4).unwrap_or_default();
    let magics = [b"\xA1\xB2\xC3\xD4", b"\xD4\xC3\xB2\xA1", b"\xA1\xB2\x3C\x4D", b"\x4D\x3C\xB2\xA1"];
    magics.iter().any(|known| magic == *known)
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(PcapReader { source, file: None, channels: Channels::new(), number: 0, seconds: None, done: false })
}

struct PcapReader {
    source: Source,
    /// The file header; `None` until it was read.
    file: Option<File>,
    channels: Channels,
    /// Number of the last packet.
    number: u64,
    /// Time of the last frame.
    seconds: Option<u32>,
    done: bool,
}

/// The content of the file header.
#[derive(Clone, Copy)]
struct File {
    format: PacketFormat,
    channel: ChannelId,
}

/// The layout of packets.
#[derive(Clone, Copy)]
struct PacketFormat {
    order: Endianness,
    link: LinkType,
    /// Number of nanoseconds per unit of the fraction.
    unit: u32,
}

impl PacketFormat {
    /// Parses the packet at the beginning of the bytes.
    #[inline]
    fn packet(self, bytes: &[u8]) -> Result<(&[u8], RawPcapPacket<'_>), PcapParseError> {
        match self.order {
            Endianness::Big => RawPcapPacket::from_slice::<BigEndian>(bytes),
            Endianness::Little => RawPcapPacket::from_slice::<LittleEndian>(bytes),
        }
    }

    #[inline]
    fn timestamp(self, packet: &RawPcapPacket<'_>) -> Timestamp {
        let nanos = u64::from(packet.ts_frac) * u64::from(self.unit);
        Timestamp(u64::from(packet.ts_sec) * 1_000_000_000 + nanos)
    }

    /// Number of units of the fraction in a second.
    const fn limit(self) -> u32 {
        1_000_000_000 / self.unit
    }

    /// The contradiction in a packet's header, if there is one.
    fn contradiction(self, packet: &Header) -> Option<(&'static str, String)> {
        if packet.captured > packet.original {
            let found = format!("{} of {} bytes", packet.captured, packet.original);
            return Some(("a packet with no more bytes captured than sent", found));
        }
        let limit = self.limit();
        (packet.fraction >= limit).then(|| ("a fraction of a second", format!("{} of {limit}", packet.fraction)))
    }

    /// Whether a packet's header is plausible.
    fn is_likely(self, packet: &Header) -> bool {
        let frame = self.link.shortest_packet() <= packet.captured as usize;
        frame && packet.original <= LONGEST && self.contradiction(packet).is_none()
    }

    fn header(self, bytes: [u8; PACKET_HEADER]) -> Header {
        let [seconds, fraction, captured, original] = *bytes.as_chunks::<4>().0 else { return Header::default() };
        let number = |bytes| match self.order {
            Endianness::Big => u32::from_be_bytes(bytes),
            Endianness::Little => u32::from_le_bytes(bytes),
        };
        Header {
            seconds: number(seconds),
            fraction: number(fraction),
            captured: number(captured),
            original: number(original),
        }
    }
}

/// The header of a packet that is not read yet.
#[derive(Default)]
struct Header {
    seconds: u32,
    fraction: u32,
    captured: u32,
    original: u32,
}

impl Header {
    fn of(packet: &RawPcapPacket<'_>) -> Self {
        Self { seconds: packet.ts_sec, fraction: packet.ts_frac, captured: packet.incl_len, original: packet.orig_len }
    }
}

impl PcapReader {
    fn place(&self) -> Place {
        Place { number: self.number, offset: self.source.offset() }
    }

    fn damage(&self, kind: DamageKind, expected: impl Into<Cow<'static, str>>, found: &str) -> Damage {
        Damage::new(kind, self.place(), expected, found.as_bytes())
    }

    fn failed(&mut self, error: &SourceError) -> Damage {
        self.done = true;
        Damage::source(error, self.place())
    }

    fn file_header(&mut self) -> Result<File, Damage> {
        self.source.fill_to(FILE_HEADER).map_err(|error| self.failed(&error))?;
        let header = match PcapHeader::from_slice(self.source.window()) {
            Ok((_, header)) => header,
            Err(PcapParseError::IncompleteBuffer(_, found)) => {
                return Err(self.damage(DamageKind::Fatal, "a pcap header of 24 bytes", &format!("{found} bytes")));
            }
            Err(PcapParseError::Validation(_)) => {
                return Err(self.damage(DamageKind::Fatal, "a pcap magic number", ""));
            }
        };
        if header.version_major != 2 {
            return Err(self.damage(DamageKind::Fatal, "pcap version 2", &header.version_major.to_string()));
        }
        // The upper half of the field has other uses.
        let number = u32::from(header.datalink) as u16;
        let Some(link) = LinkType::from_number(number) else {
            return Err(self.damage(DamageKind::Fatal, LINK_TYPES, &format!("link type {number}")));
        };
        self.source.consume(FILE_HEADER);
        let unit = if header.ts_resolution == PcapTsResolution::NanoSecond { 1 } else { 1_000 };
        let format = PacketFormat { order: header.endianness, link, unit };
        Ok(File { format, channel: self.channels.intern(CHANNEL) })
    }

    /// A quick reader for a complete packet with a common frame; gives the same as [`PcapReader::packet`].
    #[inline]
    fn common_packet(&mut self, file: File) -> Option<Record> {
        let window = self.source.window();
        let (rest, packet) = file.format.packet(window).ok()?;
        let whole = packet.incl_len == packet.orig_len && packet.ts_frac < file.format.limit();
        if !whole || file.format.link != LinkType::SocketCan {
            return None;
        }
        let mut record =
            Record::new(file.format.timestamp(&packet), file.channel, socketcan::common_frame(&packet.data)?);
        let size = window.len() - rest.len();
        (self.number, self.seconds) = (self.number + 1, Some(packet.ts_sec));
        record.place = self.place();
        self.source.consume(size);
        Some(record)
    }

    /// The next packet; `None` at the end.
    fn packet(&mut self, file: File) -> Option<Result<Record, Damage>> {
        loop {
            let window = self.source.window();
            let missing = match file.format.packet(window) {
                Ok((rest, packet)) if packet.incl_len <= LONGEST => {
                    let size = window.len() - rest.len();
                    // If two lengths contradict each other, the next packet may follow at the smaller one.
                    let likely = size.min((packet.orig_len as usize).saturating_add(PACKET_HEADER));
                    let place = Place { number: self.number + 1, offset: self.source.offset() };
                    let record = record(file, &mut self.channels, &packet, place);
                    self.number += 1;
                    if let Err(damage) = record {
                        return Some(Err(self.damaged(file.format, likely, damage)));
                    }
                    self.seconds = Some(packet.ts_sec);
                    self.source.consume(size);
                    return Some(record);
                }
                Ok((_, packet)) => packet.incl_len as usize,
                Err(PcapParseError::IncompleteBuffer(PACKET_HEADER, _)) if window.len() < PACKET_HEADER => 0,
                Err(PcapParseError::IncompleteBuffer(missing, _)) => missing,
                Err(PcapParseError::Validation(_)) => return None,
            };
            let (held, wanted) = (window.len(), PACKET_HEADER + missing);
            if missing > LONGEST as usize {
                self.number += 1;
                let expected = format!("a packet of at most {LONGEST} bytes");
                let damage = self.damage(DamageKind::Malformed, expected, &format!("{missing} bytes"));
                return Some(Err(self.search(file.format, damage)));
            }
            match self.source.fill_to(wanted) {
                Ok(true) => {}
                Ok(false) if held == 0 => return None,
                Ok(false) => return Some(Err(self.cut(file.format, missing))),
                Err(error) => return Some(Err(self.failed(&error))),
            }
        }
    }

    /// Reports a packet that the file's end cuts, or a damaged length if another packet follows.
    fn cut(&mut self, format: PacketFormat, length: usize) -> Damage {
        self.number += 1;
        let found = format!("the end of the file after {}", self.source.window().len());
        let expected = match length {
            0 => "a packet header of 16 bytes".into(),
            _ => format!("a packet of {length} bytes"),
        };
        let mut damage = self.search(format, self.damage(DamageKind::Malformed, expected, &found));
        if damage.kind.is_fatal() {
            damage.kind = DamageKind::Truncated;
        }
        damage
    }

    /// Decides by the bytes after a damaged packet of this size, header included, whether the lengths of the packet are
    /// right.
    fn damaged(&mut self, format: PacketFormat, size: usize, damage: Damage) -> Damage {
        match self.may_begin(format, size) {
            Ok(true) => self.source.consume(size),
            Ok(false) => return self.search(format, damage),
            Err(error) => return self.failed(&error),
        }
        damage
    }

    /// Whether a packet may begin at `at`, or the file ends at `at`.
    fn may_begin(&mut self, format: PacketFormat, at: usize) -> Result<bool, SourceError> {
        self.source.fill_to(at + PACKET_HEADER)?;
        let behind = self.source.window().get(at..).unwrap_or_default();
        // A cut header can't be checked.
        Ok(behind.first_chunk().is_none_or(|&header| format.is_likely(&format.header(header))))
    }

    /// Skips the beginning of an invalid packet, up to the next valid one. If there is none, the damage is fatal.
    fn search(&mut self, format: PacketFormat, damage: Damage) -> Damage {
        match self.next_likely(format) {
            Ok(true) => damage,
            Ok(false) => {
                self.done = true;
                Damage { kind: DamageKind::Fatal, ..damage }
            }
            Err(error) => self.failed(&error),
        }
    }

    /// Moves to the next bytes that are certainly a packet; returns whether it found any.
    fn next_likely(&mut self, format: PacketFormat) -> Result<bool, SourceError> {
        self.source.consume(1);
        while self.source.fill_to(PACKET_HEADER)? {
            let window = self.source.window();
            let header = |bytes: &[u8]| bytes.first_chunk().map(|&bytes| format.header(bytes));
            let candidate = window.windows(PACKET_HEADER).position(|bytes| {
                header(bytes).is_some_and(|header| {
                    let near = self.seconds.is_none_or(|last| last.abs_diff(header.seconds) <= NEAR);
                    near && format.is_likely(&header)
                })
            });
            let Some(at) = candidate else {
                self.source.consume(window.len() - PACKET_HEADER + 1);
                continue;
            };
            self.source.consume(at);
            if self.is_packet(format)? {
                return Ok(true);
            }
            self.source.consume(1);
        }
        Ok(false)
    }

    /// Whether the window begins with a packet that has a frame, and another packet may follow.
    fn is_packet(&mut self, format: PacketFormat) -> Result<bool, SourceError> {
        let Some(&header) = self.source.window().first_chunk() else { return Ok(false) };
        let header = format.header(header);
        let size = PACKET_HEADER + header.captured as usize;
        if header.captured != header.original || !self.source.fill_to(size)? {
            return Ok(false);
        }
        let packet = self.source.window().get(PACKET_HEADER..size).unwrap_or_default();
        Ok(socketcan::decode(format.link, order(format.order), packet).is_ok() && self.may_begin(format, size)?)
    }
}

const fn order(order: Endianness) -> nom::number::Endianness {
    match order {
        Endianness::Big => nom::number::Endianness::Big,
        Endianness::Little => nom::number::Endianness::Little,
    }
}

/// The frame of a complete packet.
fn record(file: File, channels: &mut Channels, packet: &RawPcapPacket<'_>, place: Place) -> Result<Record, Damage> {
    let format = file.format;
    if packet.incl_len < packet.orig_len {
        let expected = format!("a packet of {} bytes", packet.orig_len);
        let found = format!("cut to {}", packet.incl_len);
        return Err(Damage::new(DamageKind::Truncated, place, expected, found.as_bytes()));
    }
    let seen = socketcan::decode(format.link, order(format.order), &packet.data).map_err(|flaw| flaw.damage(place))?;
    let channel = match seen.interface {
        Some(index) => channels.intern(&format!("if{index}")),
        None => file.channel,
    };
    let mut record = seen.record;
    (record.timestamp, record.channel, record.place) = (format.timestamp(packet), channel, place);
    match format.contradiction(&Header::of(packet)) {
        Some((expected, found)) => {
            Err(Damage::new(DamageKind::Malformed, place, expected, found.as_bytes()).with_salvaged(record))
        }
        None => Ok(record),
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
            Some(Ok(_)) => false,
            Some(Err(damage)) => damage.kind.is_fatal(),
            None => true,
        };
        next
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
