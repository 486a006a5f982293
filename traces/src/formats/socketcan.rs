//! CAN frames as SocketCAN hands them to packet captures: the payload of pcap and pcapng packets.
//!
//! | link type | header before the frame | identifier, CAN XL priority |
//! |---|---|---|
//! | 227 `LINKTYPE_CAN_SOCKETCAN` | none | big-endian |
//! | 113 `LINKTYPE_LINUX_SLL` | 16 bytes, big-endian | byte order of the file or section |
//! | 276 `LINKTYPE_LINUX_SLL2` | 20 bytes, big-endian | byte order of the file or section |
//!
//! A frame (`struct can_frame`, `canfd_frame`):
//!
//! ```text
//! 0  identifier, with 8000 0000h extended, 4000 0000h remote, 2000 0000h error
//! 4  length      5  flags: BRS 1, ESI 2, FDF 4      6  reserved      7  reserved, or raw DLC 9..15 (classical)
//! 8  payload, filled up to 8 (classical) or 64 bytes (CAN FD); the filling may be absent
//! ```
//!
//! A CAN XL frame (`struct canxl_frame`), recognised by bit 80h in byte 4:
//!
//! ```text
//! 0  reserved, VCID, priority (32 bits: 00vv 0pppb)   4  flags: XLF 80h, SEC 1, RRS 2   5  SDT
//! 6  length, little-endian                            8  acceptance field, little-endian    12  payload
//! ```
//!
//! In a cooked capture the protocol distinguishes classical and CAN FD frames (000Ch CAN, 000Dh CAN FD, 000Eh CAN XL),
//! otherwise the length of the packet does: the kernel gives 16 or 72 bytes. **The byte of the flags does not:** in a
//! classical frame it is filling, which contains garbage if a program does not clear its `struct can_frame`, and older
//! kernels did not set FDF. FDF is reliable only in a packet without filling, which no kernel writes.
//!
//! The raw DLC and the flags BRS and ESI count only if the bytes beside them are zero: then a program has set the bytes
//! on purpose.

use crate::damage::{Damage, Flaw};
use crate::{CanId, ChannelId, Direction, ErrorClass, Flags, Frame, Place, Record, Timestamp, XlHeader};
use nom::number::Endianness;
use nom::number::complete::{be_u16, be_u32, u8, u16, u32};
use nom::{IResult, Parser};

/// The byte order of this machine.
const NATIVE: Endianness = if cfg!(target_endian = "big") { Endianness::Big } else { Endianness::Little };
const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;
const ERROR: u32 = Frame::ERROR_FLAG;
/// Bytes before the payload of a classical or CAN FD frame.
const HEADER: usize = 8;
const CLASSICAL_SIZE: usize = HEADER + 8;
const FD_SIZE: usize = HEADER + 64;
const XL_HEADER: usize = 12;
const XLF: u8 = 0x80;
const SEC: u8 = 0x01;
const RRS: u8 = 0x02;

/// The link types that carry CAN frames.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum LinkType {
    SocketCan,
    Sll,
    Sll2,
}

/// The expected text if a link type does not carry CAN frames.
pub(crate) const LINK_TYPES: &str = "link type 227 (SocketCAN), 113 (Linux SLL) or 276 (Linux SLL2)";

impl LinkType {
    /// The length of a packet whose frame has no payload.
    pub(crate) const fn shortest_packet(self) -> usize {
        match self {
            Self::SocketCan => HEADER,
            Self::Sll => 16 + HEADER,
            Self::Sll2 => 20 + HEADER,
        }
    }

    pub(crate) const fn from_number(number: u16) -> Option<Self> {
        match number {
            227 => Some(Self::SocketCan),
            113 => Some(Self::Sll),
            276 => Some(Self::Sll2),
            _ => None,
        }
    }
}

/// The structure of a frame, which the frame's own bytes do not show.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Protocol {
    Classical,
    Fd,
    Xl,
}

impl Protocol {
    /// The protocol in the header of a cooked capture.
    const fn from_number(number: u16) -> Option<Self> {
        match number {
            0x000C => Some(Self::Classical),
            0x000D => Some(Self::Fd),
            0x000E => Some(Self::Xl),
            _ => None,
        }
    }

    /// The protocol by the length of the packet; without filling, by the length and the flags of the frame.
    const fn of_packet(packet: usize, len: u8, flags: Flags) -> Self {
        match packet {
            _ if len & XLF != 0 => Self::Xl,
            CLASSICAL_SIZE => Self::Classical,
            FD_SIZE => Self::Fd,
            _ if len > 8 || flags.contains(Flags::FDF) => Self::Fd,
            _ => Self::Classical,
        }
    }
}

/// A packet's frame, before time, channel and place are set.
#[derive(Debug)]
pub(crate) struct Seen {
    pub(crate) record: Record,
    /// The index of the network interface, if the header has it (SLL2).
    pub(crate) interface: Option<u32>,
}

/// A quick decoder for a classical data frame in a packet of link type 227, without filling or with all eight bytes;
/// most packets have this form. Gives the same frame as [`decode`].
#[inline(always)]
pub(crate) fn common_frame(packet: &[u8]) -> Option<Frame> {
    let &[a, b, c, d, len @ 0..=8, 0, 0, 0, ref data @ ..] = packet else { return None };
    let (id, len) = (u32::from_be_bytes([a, b, c, d]), usize::from(len));
    if id & (REMOTE | ERROR) != 0 {
        return None;
    }
    let Some(filled) = data.first_chunk::<8>().filter(|_| data.len() == 8) else {
        return if data.len() == len { Frame::new(can_id(id), data) } else { None };
    };
    // The bytes are masked as one number: copying a variable number of bytes would take longer than the rest of the
    // decoder.
    let payload = u64::from_le_bytes(*filled) & u64::MAX.checked_shr(64 - 8 * len as u32).unwrap_or(0);
    Some(Frame::short(can_id(id), payload.to_le_bytes(), len))
}

/// The frame in a complete packet; `order` is the byte order of the file or section.
pub(crate) fn decode(link: LinkType, order: Endianness, packet: &[u8]) -> Result<Seen, Flaw> {
    let (protocol, direction, interface, rest) = match link {
        LinkType::SocketCan => {
            return Ok(Seen { record: frame(Endianness::Big, Endianness::Little, None, packet)?, interface: None });
        }
        LinkType::Sll => {
            let (rest, (kind, hardware, _, _, protocol)) = sll(packet).map_err(|_| short("a header", 16, packet))?;
            check_hardware(hardware)?;
            (protocol, direction(kind), None, rest)
        }
        LinkType::Sll2 => {
            let (rest, (protocol, _, index, hardware, kind, _, _)) =
                sll2(packet).map_err(|_| short("a header", 20, packet))?;
            check_hardware(hardware)?;
            (protocol, direction(u16::from(kind)), Some(index), rest)
        }
    };
    let Some(told) = Protocol::from_number(protocol) else {
        return Err(Flaw::unsupported("protocol 000Ch, 000Dh or 000Eh (CAN)", format!("{protocol:04X}h")));
    };
    let record = frame(order, order, Some(told), rest)?.with_direction(direction);
    Ok(Seen { record, interface })
}

type Sll = (u16, u16, u16, u64, u16);

/// Parses the SLL header: packet type, ARPHRD type, address length, address, protocol.
fn sll(i: &[u8]) -> IResult<&[u8], Sll> {
    (be_u16, be_u16, be_u16, nom::number::complete::be_u64, be_u16).parse(i)
}

type Sll2 = (u16, u16, u32, u16, u8, u8, u64);

/// Parses the SLL2 header: protocol, reserved, interface index, ARPHRD type, packet type, address length, address.
fn sll2(i: &[u8]) -> IResult<&[u8], Sll2> {
    (be_u16, be_u16, be_u32, be_u16, u8, u8, nom::number::complete::be_u64).parse(i)
}

/// Checks that the packet is of a CAN interface, `ARPHRD_CAN` = 280: a capture of `any` also has packets of other
/// interfaces.
fn check_hardware(hardware: u16) -> Result<(), Flaw> {
    if hardware == 280 {
        return Ok(());
    }
    Err(Flaw::unsupported("a packet of a CAN interface (ARPHRD 280)", format!("ARPHRD {hardware}")))
}

/// The direction by the packet type; `PACKET_OUTGOING` is 4.
const fn direction(packet_type: u16) -> Direction {
    if packet_type == 4 { Direction::Tx } else { Direction::Rx }
}

fn short(what: &str, len: usize, found: &[u8]) -> Flaw {
    Flaw::malformed(format!("{what} of {len} bytes"), format!("{} bytes", found.len()))
}

/// Parses identifier, length or XL flags, flags, reserved, reserved or raw DLC.
fn header(order: Endianness, i: &[u8]) -> IResult<&[u8], (u32, u8, u8, u8, u8)> {
    (u32(order), u8, u8, u8, u8).parse(i)
}

fn frame(order: Endianness, xl_order: Endianness, told: Option<Protocol>, packet: &[u8]) -> Result<Record, Flaw> {
    let (payload, (id, len, flags, reserved, raw_dlc)) =
        header(order, packet).map_err(|_| short("a frame header", HEADER, packet))?;
    let zero = |bytes: [u8; 2]| bytes == [0; 2];
    let fd_flags = if zero([reserved, raw_dlc]) { Flags::from_bits(flags & 7) } else { Flags::NONE };
    match told.unwrap_or(Protocol::of_packet(packet.len(), len, fd_flags)) {
        Protocol::Xl if len & XLF == 0 => Err(Flaw::malformed("the flag XLF of CAN XL", format!("{len:02X}h"))),
        Protocol::Xl => xl(id, xl_order, packet),
        _ if id & ERROR != 0 => error(id, data(payload, len, 8)?),
        Protocol::Fd => fd(can_id(id), fd_flags, data(payload, len, 64)?),
        Protocol::Classical => {
            let raw_dlc = if zero([flags, reserved]) { raw_dlc } else { 0 };
            classical(id, len, raw_dlc, payload)
        }
    }
}

fn classical(id: u32, len: u8, raw_dlc: u8, payload: &[u8]) -> Result<Record, Flaw> {
    let frame =
        if id & REMOTE != 0 { Frame::remote(can_id(id), len) } else { Frame::new(can_id(id), data(payload, len, 8)?) };
    let frame = frame.ok_or_else(|| Flaw::malformed("a length of at most 8", len.to_string()))?;
    Ok(untimed(frame.with_raw_dlc(raw_dlc)))
}

/// The identifier of the frame. Bits beyond it are ignored, as in the kernel.
const fn can_id(id: u32) -> CanId {
    if id & EXTENDED != 0 { CanId::extended_masked(id) } else { CanId::standard_masked(id) }
}

fn untimed(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId::default(), frame)
}

/// The payload without its filling.
fn data(payload: &[u8], len: u8, max: u8) -> Result<&[u8], Flaw> {
    if len > max {
        return Err(Flaw::malformed(format!("a length of at most {max}"), len.to_string()));
    }
    payload.get(..usize::from(len)).ok_or_else(|| short("a payload", usize::from(len), payload))
}

fn error(id: u32, data: &[u8]) -> Result<Record, Flaw> {
    let frame = Frame::error(ErrorClass(id & CanId::MAX_EXTENDED), data);
    frame.map(untimed).ok_or_else(|| Flaw::malformed("a length of at most 8", data.len().to_string()))
}

fn fd(id: CanId, flags: Flags, data: &[u8]) -> Result<Record, Flaw> {
    Record::fd(Timestamp::ZERO, ChannelId::default(), id, flags, data)
        .ok_or_else(|| Flaw::malformed("a length that CAN FD has", data.len().to_string()))
}

fn xl(priority: u32, order: Endianness, packet: &[u8]) -> Result<Record, Flaw> {
    let parsed: IResult<_, _> = (u8, u8, u16(order), u32(order)).parse(packet.get(4..).unwrap_or_default());
    let (payload, (flags, sdt, len, af)) = parsed.map_err(|_| short("a CAN XL header", XL_HEADER, packet))?;
    let data = payload.get(..usize::from(len)).ok_or_else(|| short("a payload", usize::from(len), payload))?;
    let header = XlHeader { vcid: (priority >> 16) as u8, sec: flags & SEC != 0, rrs: flags & RRS != 0, sdt, af };
    let priority = CanId::standard_masked(priority);
    Record::xl(Timestamp::ZERO, ChannelId::default(), priority, header, data)
        .ok_or_else(|| Flaw::malformed("a CAN XL length of 1 to 2048", len.to_string()))
}

/// The frame in a packet of a `CAN_RAW` socket, in this machine's byte order; the caller sets time and channel.
///
/// # Errors
/// [`Damage`] if the bytes are no frame.
pub fn from_socket(packet: &[u8]) -> Result<Record, Damage> {
    frame(NATIVE, NATIVE, None, packet).map_err(|flaw| flaw.damage(Place::default()))
}

/// Appends a frame in the form of a `CAN_RAW` socket, in this machine's byte order. CAN XL is not supported.
pub fn to_socket(record: &Record, packet: &mut Vec<u8>) {
    let start = packet.len();
    encode(record, packet);
    if let Some(id) = packet.get_mut(start..start + 4) {
        id.copy_from_slice(&number(&record.frame).to_ne_bytes());
    }
}

/// Appends the record's frame as a packet of link type 227.
pub(crate) fn encode(record: &Record, packet: &mut Vec<u8>) {
    let frame = &record.frame;
    let data = record.data();
    if let Some(xl) = record.xl_header() {
        encode_xl(frame.id(), xl, data, packet);
        return;
    }
    packet.extend_from_slice(&number(frame).to_be_bytes());
    // Classical and CAN FD frames have at most 64 bytes.
    packet.push(frame.len() as u8);
    packet.push(frame.flags().bits() & 7);
    packet.push(0);
    packet.push(if !frame.is_fd() && frame.dlc() > 8 { frame.dlc() } else { 0 });
    packet.extend_from_slice(data);
    let size = if frame.is_fd() { FD_SIZE } else { CLASSICAL_SIZE };
    packet.resize(packet.len() + size - HEADER - data.len(), 0);
}

/// The identifier with its flags, as SocketCAN has it.
fn number(frame: &Frame) -> u32 {
    if frame.is_error() {
        return frame.printed_id();
    }
    let extended = if frame.id().is_extended() { EXTENDED } else { 0 };
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    frame.id().raw() | extended | remote
}

fn encode_xl(priority: CanId, xl: XlHeader, data: &[u8], packet: &mut Vec<u8>) {
    packet.extend_from_slice(&(u32::from(xl.vcid) << 16 | priority.raw()).to_be_bytes());
    packet.push(XLF | if xl.sec { SEC } else { 0 } | if xl.rrs { RRS } else { 0 });
    packet.push(xl.sdt);
    // The length is at most 2048.
    packet.extend_from_slice(&(data.len() as u16).to_le_bytes());
    packet.extend_from_slice(&xl.af.to_le_bytes());
    packet.extend_from_slice(data);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(link: LinkType, order: Endianness, packet: &[u8]) -> String {
        match decode(link, order, packet) {
            Ok(seen) => format!("{} {}", seen.record.frame, seen.record.direction),
            Err(flaw) => flaw.damage(Place::default()).to_string(),
        }
    }

    fn plain(packet: &[u8]) -> String {
        shown(LinkType::SocketCan, Endianness::Little, packet)
    }

    #[test]
    fn the_kinds_of_frames() {
        assert_eq!(plain(b"\0\0\x06\x3F\x04\0\0\0\x40\0\x60\0\0\0\0\0"), "63F#40006000 ");
        assert_eq!(plain(b"\x98\xFE\xCA\x01\x01\0\0\0\xAA"), "18FECA01#AA ", "without filling");
        assert_eq!(plain(b"\x40\0\x07\x01\x01\0\0\0"), "701#R1 ");
        assert_eq!(plain(b"\x20\0\0\x04\x08\0\0\0\0\x08\0\0\0\0\x60\0"), "20000004#0008000000006000 ");
        assert_eq!(plain(b"\0\0\x01\x23\x08\0\0\x0F12345678"), "123#3132333435363738_F ");
    }

    #[test]
    fn what_a_socket_takes_it_gives() {
        let fd = Record::fd(Timestamp::ZERO, ChannelId(0), can_id(0x123), Flags::BRS, &[7; 20]).unwrap();
        let short = untimed(Frame::new(can_id(0x63F), &[0x40, 0, 0x60]).unwrap());
        for (record, size) in [(fd, FD_SIZE), (short, CLASSICAL_SIZE)] {
            let mut packet = vec![0xA5];
            to_socket(&record, &mut packet);
            assert_eq!(packet.len(), 1 + size, "the kernel takes no other sizes");
            assert_eq!(packet[1..5], number(&record.frame).to_ne_bytes());
            assert_eq!(from_socket(&packet[1..]).unwrap(), record);
        }
        assert!(from_socket(&[0; 3]).is_err());
    }

    #[test]
    fn seventy_two_bytes_are_can_fd_whatever_the_flags_say() {
        let mut packet = [0; FD_SIZE];
        packet[3] = 0x55;
        packet[4] = 2;
        assert_eq!(plain(&packet), "055##40000 ");
        packet[5] = 1;
        assert_eq!(plain(&packet), "055##50000 ");
        packet[6] = 0xCC;
        assert_eq!(plain(&packet), "055##40000 ", "garbage in the reserved bytes: the flags are garbage too");
        packet[4] = 13;
        assert!(plain(&packet).contains("expected a length that CAN FD has, found \"13\""));
    }

    #[test]
    fn the_filling_of_a_classical_frame_tells_nothing() {
        for filling in 0..=u8::MAX {
            for packet in [
                [0, 0, 7, 1, 1, filling, 0, 0, 5, filling, 0, 0, 0, 0, 0, filling],
                [0, 0, 7, 1, 1, filling, filling, filling, 5, 0, 0, 0, 0, 0, 0, 0],
            ] {
                assert_eq!(plain(&packet), "701#05 ", "filling {filling:02X}h");
            }
        }
        let eight = [0, 0, 5, 0x81, 8, 4, 0, 0x0F, 1, 2, 3, 4, 5, 6, 7, 8];
        assert_eq!(plain(&eight), "581#0102030405060708 ", "nor is there a raw DLC among garbage");
        assert!(plain(&[0, 0, 7, 1, 9, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0]).contains("at most 8, found \"9\""));
        assert_eq!(plain(b"\0\0\x07\x01\x01\x05\0\0\x05"), "701##505 ", "no kernel leaves out the filling");
        assert_eq!(plain(b"\0\0\x07\x01\x01\x05\0\x01\x05"), "701#05 ");
    }

    #[test]
    fn the_protocol_of_a_cooked_capture_tells_the_kind() {
        let cooked = |protocol: u8, frame: &[u8]| {
            let header = [0, 0, 1, 0x18, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, protocol];
            shown(LinkType::Sll, Endianness::Big, &[&header, frame].concat())
        };
        let short = [0, 0, 7, 1, 1, 4, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0];
        let long = [&short[..], &[0; FD_SIZE - CLASSICAL_SIZE]].concat();
        assert_eq!(cooked(0x0C, &short), "701#05 Rx");
        assert_eq!(cooked(0x0C, &long), "701#05 Rx");
        assert_eq!(cooked(0x0D, &short), "701##405 Rx");
        assert_eq!(cooked(0x0D, &long), "701##405 Rx");
        assert!(cooked(0x0E, &short).contains("expected the flag XLF"));
        assert!(cooked(0x0C, b"\0\x45\x01\x23\x81\x03\x05\0\x78\x56\x34\x12hello").contains("at most 8"));
    }

    #[test]
    fn cooked_frames_follow_the_order_of_the_section() {
        let sll = b"\0\x04\x01\x18\0\0\0\0\0\0\0\0\0\0\0\x0C\x81\x01\0\0\x01\0\0\0\xEE\0\0\0\0\0\0\0";
        assert_eq!(shown(LinkType::Sll, Endianness::Little, sll), "181#EE Tx");
        let sll2 = b"\0\x0C\0\0\0\0\0\x05\x01\x18\0\0\0\0\0\0\0\0\0\0\0\0\x01\x81\x01\0\0\0\xEE\0\0\0\0\0\0\0";
        assert_eq!(shown(LinkType::Sll2, Endianness::Big, sll2), "181#EE Rx");
        assert_eq!(decode(LinkType::Sll2, Endianness::Big, sll2).unwrap().interface, Some(5));
        let mut other = *sll;
        other[14..16].copy_from_slice(b"\x08\0");
        assert!(shown(LinkType::Sll, Endianness::Little, &other).starts_with("unsupported"));
    }

    #[test]
    fn xl_mixes_the_byte_orders() {
        let packet = b"\0\x45\x01\x23\x81\x03\x05\0\x78\x56\x34\x12hello";
        let record = decode(LinkType::SocketCan, Endianness::Big, packet).unwrap().record;
        let header = XlHeader { vcid: 0x45, sec: true, rrs: false, sdt: 3, af: 0x1234_5678 };
        assert_eq!((record.frame.id().raw(), record.xl_header(), record.data()), (0x123, Some(header), &b"hello"[..]));
        let mut again = Vec::new();
        encode(&record, &mut again);
        assert_eq!(again, packet);
    }

    #[test]
    fn the_short_way_gives_the_same() {
        for packet in [*b"\0\0\x06\x3F\x08\0\0\0\x40\0\x60\0\0\0\0\0", *b"\x98\xFE\xCA\x01\x08\0\0\0abcdefgh"] {
            let whole = decode(LinkType::SocketCan, Endianness::Big, &packet).unwrap().record.frame;
            assert_eq!(common_frame(&packet), Some(whole));
        }
        for len in 0..=8_u8 {
            let filled = [0, 0, 6, 0x3F, len, 0, 0, 0, 0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7, 0xA8];
            for packet in [&filled[..], &filled[..8 + usize::from(len)]] {
                let whole = decode(LinkType::SocketCan, Endianness::Big, packet).unwrap().record.frame;
                assert_eq!(common_frame(packet), Some(whole), "{packet:02X?}");
            }
        }
        for other in [&b"\x40\0\x07\x01\x08\0\0\0abcdefgh"[..], b"\0\0\x07\x01\x08\0\0\0abcdefg", &[0; FD_SIZE]] {
            assert_eq!(common_frame(other), None);
        }
    }

    #[test]
    fn what_is_not_all_there_is_no_shorter_frame() {
        assert!(plain(b"\0\0\x06\x3F\x08\0\0\0\x40\0\x60").starts_with("malformed: expected a payload of 8 bytes"));
        assert!(plain(b"\0\0\x06\x3F\x08\0\0").starts_with("malformed: expected a frame header of 8 bytes"));
        assert!(plain(b"\0\x45\x01\x23\x81\x03\x05\0\x78").starts_with("malformed: expected a CAN XL header"));
        assert!(
            plain(b"\0\x45\x01\x23\x81\x03\0\0\x78\x56\x34\x12").starts_with("malformed: expected a CAN XL length")
        );
        assert!(plain(b"\x40\0\x07\x01\x09\0\0\0").starts_with("malformed"));
    }
}
