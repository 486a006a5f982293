//! Packets as Wireshark and tshark print them with their bytes: "Export Packet Dissections as Plain Text", `tshark -V -x`,
//! and `tshark -P -x`.
//!
//! ```text
//! Frame 2: 16 bytes on wire (128 bits), 16 bytes captured (128 bits) on interface can0, id 0
//!     Encapsulation type: SocketCAN (125)
//!     Epoch Time: 1700000000.001250000 seconds
//!
//! 0000  00 00 07 7f 01 00 00 00 00 00 00 00 00 00 00 00   ................
//! ```
//!
//! or, before the bytes or the details, a row with number, time, addresses, protocol, length and meaning:
//!
//! ```text
//!     2 0.001250000              →              CANopen 16 NMT Boot-up
//! ```
//!
//! The bytes are those of the packet, as in pcap. What Wireshark says of them is not read but for time, interface and
//! encapsulation. A packet whose bytes were not printed is damage.

use crate::formats::socketcan::{LinkType, decode};
use crate::grammar::seconds;
use crate::lines::{Line, LineFormat, TextReader, head_lines};
use crate::{Channels, Damage, DamageKind, Place, ReadOptions, Reader, Record, Source, TimeBase, Timestamp};
use nom::number::Endianness;

/// The channel of packets whose interface is not told.
const CHANNEL: &str = "can0";
/// Number of bytes in a line of bytes.
const IN_A_LINE: usize = 16;
/// Maximum length of a packet in bytes. The longest one has a CAN XL frame behind the header of a cooked capture.
const LONGEST: usize = 2_100;

pub(crate) fn sniff(head: &[u8]) -> bool {
    let is_of_can = |line: &[u8]| {
        let row = row(line).is_some_and(|row| row.is_can);
        row || line.starts_with(b"Controller Area Network") || encapsulation(line).is_some()
    };
    let is_packet = |line: &[u8]| described(line).is_some() || row(line).is_some();
    let any = |wanted: &dyn Fn(&[u8]) -> bool| head_lines(head).any(|(line, _)| wanted(line));
    any(&is_packet) && any(&is_of_can) && any(&|line| bytes(line).is_some_and(|(at, _)| at == 0))
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(TextReader::new(source, WiresharkText::default()))
}

#[derive(Default)]
struct WiresharkText {
    packet: Option<Packet>,
    base: Option<TimeBase>,
    /// Whether the next bytes are those of a message that Wireshark has reassembled from several packets.
    is_reassembled: bool,
}

/// A packet whose bytes are not complete.
#[derive(Default)]
struct Packet {
    number: u64,
    place: Place,
    /// Number of bytes that were captured.
    length: usize,
    bytes: Vec<u8>,
    /// The time since the first packet, and the time since 1970.
    since_first: Option<u64>,
    date: Option<u64>,
    interface: Option<String>,
    link: Option<LinkType>,
}

/// The first line of a packet's details: its number, number of captured bytes, and interface.
struct Described<'a> {
    number: u64,
    length: usize,
    interface: Option<&'a str>,
}

fn described(line: &[u8]) -> Option<Described<'_>> {
    let text = str::from_utf8(line.strip_prefix(b"Frame ")?).ok()?;
    let (number, rest) = text.split_once(": ")?;
    let (_, captured) = rest.split_once("), ").filter(|(wire, _)| wire.contains(" on wire ("))?;
    let (length, rest) = captured.split_once(" byte")?;
    let interface = rest.split_once(" on interface ").map(|(_, named)| named.split(", id").next().unwrap_or(named));
    Some(Described { number: number.parse().ok()?, length: length.parse().ok()?, interface })
}

/// The row of a packet: number, time, and the number of captured bytes behind the protocol.
struct Row {
    number: u64,
    since_first: u64,
    length: usize,
    is_can: bool,
}

fn row(line: &[u8]) -> Option<Row> {
    let text = str::from_utf8(line).ok()?;
    let mut words = text.split_whitespace();
    let number = words.next()?.parse().ok()?;
    let time = words.next().filter(|time| time.contains('.'))?;
    let (rest, since_first) = seconds(time.as_bytes()).ok()?;
    let mut before = "";
    let length = words.find_map(|word| {
        let length = word.parse::<usize>().ok();
        before = if length.is_some() { before } else { word };
        length
    })?;
    rest.is_empty().then_some(Row { number, since_first, length, is_can: before.starts_with("CAN") })
}

/// A line of bytes: its offset and its bytes, of which the characters follow behind three blanks.
fn bytes(line: &[u8]) -> Option<(usize, Vec<u8>)> {
    let text = str::from_utf8(line).ok()?;
    let (offset, rest) = text.split_once("  ").filter(|(offset, _)| offset.len() >= 4)?;
    let offset = usize::from_str_radix(offset, 16).ok()?;
    let pairs = rest.split("  ").next().unwrap_or(rest).split(' ').take(IN_A_LINE);
    let byte = |pair: &str| u8::from_str_radix(pair, 16).ok().filter(|_| pair.len() == 2);
    Some((offset, pairs.map(byte).collect::<Option<Vec<u8>>>()?))
}

fn encapsulation(line: &[u8]) -> Option<LinkType> {
    let kind = line.trim_ascii().strip_prefix(b"Encapsulation type: ")?;
    match () {
        () if kind.starts_with(b"SocketCAN") => Some(LinkType::SocketCan),
        () if kind.starts_with(b"Linux cooked-mode capture v1") => Some(LinkType::Sll),
        () if kind.starts_with(b"Linux cooked-mode capture v2") => Some(LinkType::Sll2),
        () => None,
    }
}

/// The time since 1970 in a packet's details.
fn date(line: &[u8]) -> Option<u64> {
    let line = line.trim_ascii();
    let time = line.strip_prefix(b"Epoch Time: ").or_else(|| line.strip_prefix(b"Epoch Arrival Time: "))?;
    Some(seconds(time).ok()?.1)
}

impl Packet {
    /// The link type, as the encapsulation or the bytes tell it.
    fn link(&self) -> LinkType {
        /// The number of CAN among the kinds of hardware, in the headers of cooked captures.
        const ARPHRD_CAN: &[u8] = &[0x01, 0x18];
        self.link.unwrap_or(match () {
            () if self.bytes.len() >= 32 && self.bytes.get(2..4) == Some(ARPHRD_CAN) => LinkType::Sll,
            () if self.bytes.len() >= 36 && self.bytes.get(8..10) == Some(ARPHRD_CAN) => LinkType::Sll2,
            () => LinkType::SocketCan,
        })
    }

    fn incomplete(&self) -> Damage {
        let expected = format!("the {} bytes of packet {}, printed below it", self.length, self.number);
        Damage::new(DamageKind::Malformed, self.place, expected, format!("{} bytes", self.bytes.len()).as_bytes())
    }
}

impl WiresharkText {
    /// Begins a packet, unless it has begun with its row; returns the damage of the packet before it.
    fn begin(&mut self, number: u64, length: usize, place: Place) -> Option<Damage> {
        if let Some(packet) = &mut self.packet
            && packet.number == number
            && packet.bytes.is_empty()
        {
            packet.length = length;
            return None;
        }
        self.is_reassembled = false;
        let before = self.packet.replace(Packet { number, place, length, ..Packet::default() });
        before.map(|packet| packet.incomplete())
    }

    /// Takes a line of bytes; returns the packet if it is complete.
    fn take(&mut self, line: &Line<'_>, offset: usize, bytes: &[u8]) -> Option<Result<Packet, Damage>> {
        let Some(packet) = &mut self.packet else {
            let is_other = self.is_reassembled || offset > 0;
            return (!is_other).then(|| Err(line.malformed("the first line of a packet before its bytes")));
        };
        if offset != packet.bytes.len() || packet.length > LONGEST {
            let damage = line.malformed(format!("byte {:04x} of a packet of at most {LONGEST}", packet.bytes.len()));
            self.packet = None;
            return Some(Err(damage));
        }
        packet.bytes.extend_from_slice(bytes);
        if packet.bytes.len() < packet.length {
            return None;
        }
        self.packet.take().map(Ok)
    }

    fn record(&mut self, packet: &Packet, channels: &mut Channels) -> Result<Record, Damage> {
        // A cooked capture has the byte order of its machine, which the text does not tell: all common ones are
        // little-endian.
        let seen = decode(packet.link(), Endianness::Little, &packet.bytes);
        let mut record = seen.map_err(|flaw| flaw.damage(packet.place))?.record;
        self.base.get_or_insert(if packet.date.is_some() { TimeBase::Utc } else { TimeBase::Start });
        record.timestamp = Timestamp(packet.date.or(packet.since_first).unwrap_or_default());
        record.channel = channels.intern(packet.interface.as_deref().unwrap_or(CHANNEL));
        record.place = packet.place;
        Ok(record)
    }
}

impl LineFormat for WiresharkText {
    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        if let Some((offset, bytes)) = bytes(line.bytes) {
            let packet = self.take(line, offset, &bytes)?;
            return Some(packet.and_then(|packet| self.record(&packet, channels)));
        }
        if let Some(Described { number, length, interface }) = described(line.bytes) {
            let damage = self.begin(number, length, line.place);
            if let Some(packet) = &mut self.packet {
                packet.interface = interface.map(ToOwned::to_owned);
            }
            return damage.map(Err);
        }
        if let Some(Row { number, since_first, length, .. }) = row(line.bytes) {
            let damage = self.begin(number, length, line.place);
            if let Some(packet) = &mut self.packet {
                packet.since_first = Some(since_first);
            }
            return damage.map(Err);
        }
        self.is_reassembled |= line.bytes.ends_with(b" bytes):") && !line.bytes.starts_with(b"Frame (");
        let Some(packet) = &mut self.packet else {
            // The first line of a packet may go on behind the end of the file.
            let is_cut = !line.ended && !line.bytes.trim_ascii().is_empty();
            return is_cut.then(|| Err(line.cut("the whole line of a packet")));
        };
        packet.link = encapsulation(line.bytes).or(packet.link);
        packet.date = date(line.bytes).or(packet.date);
        None
    }

    fn end(&mut self) -> Option<Damage> {
        self.packet.take().map(|packet| Damage { kind: DamageKind::Truncated, ..packet.incomplete() })
    }

    fn time_base(&self) -> TimeBase {
        self.base.unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_packets() {
        let line = b"Frame 12: 16 bytes on wire (128 bits), 16 bytes captured (128 bits) on interface can0, id 0";
        let Described { number, length, interface } = described(line).unwrap();
        assert_eq!((number, length, interface), (12, 16, Some("can0")));
        let Row { number, since_first, length, is_can } =
            row("    2 0.001250000              →              CANopen 16 NMT Boot-up 5".as_bytes()).unwrap();
        assert_eq!((number, since_first, length, is_can), (2, 1_250_000, 16, true));
        assert!(row(b"    2 packets received").is_none());
        let of = |text: &str| bytes(text.as_bytes());
        assert_eq!(of("0010  de ad   .."), Some((16, vec![0xDE, 0xAD])));
        assert_eq!(
            of("0000  00 00 06 05 08 00 00 00 40 00 10 00 00 00 00 00   ........@......."),
            Some((0, vec![0, 0, 6, 5, 8, 0, 0, 0, 0x40, 0, 0x10, 0, 0, 0, 0, 0]))
        );
        assert!(of("No.     Time").is_none() && of("0000  zz").is_none() && of("00  00").is_none());
        assert_eq!(date(b"    Epoch Time: 1700000000.001250000 seconds"), Some(1_700_000_000_001_250_000));
        assert_eq!(encapsulation(b"    Encapsulation type: SocketCAN (125)"), Some(LinkType::SocketCan));
    }
}
