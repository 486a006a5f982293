//! cannelloni: a tunnel for CAN frames, as datagrams with several frames (UDP, format 2) or as a stream of frames (TCP,
//! `CANNELLONIv1`). All numbers are big-endian; the identifier has the flags of SocketCAN.

use super::bus::{Arrived, Connect, Failure, Protocol, Read, Stamped, Write};
use crate::connection::link::{Link, connect, datagrams, is_silence};
use canvass_traces::{CanId, ErrorClass, Flags, Frame};
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs as _, UdpSocket};
use std::time::{Duration, Instant};

/// What both ends of a TCP connection send first.
const GREETING: &[u8] = b"CANNELLONIv1";
/// Timeout of the other end's greeting.
const ANSWER: Duration = Duration::from_secs(3);
/// The first two bytes of a datagram: the version of the format, and the operation code for frames.
const VERSION: u8 = 2;
const DATA: u8 = 0;
/// The flags of an identifier (`linux/can.h`).
const EXTENDED: u32 = 1 << 31;
const REMOTE: u32 = 1 << 30;
const ERROR: u32 = 1 << 29;
/// The bit of the length that marks a CAN FD frame.
const FD: u8 = 0x80;

/// TCP to `HOST:PORT`.
pub(super) fn over_tcp(server: &str) -> Protocol {
    Protocol {
        connect: Box::new(Client { server: server.to_owned() }),
        read: Box::new(Stream::default()),
        write: Box::new(Stream::default()),
    }
}

/// UDP to `HOST:PORT`, from and to a port of this computer.
pub(super) fn over_udp(remote: &str, local: u16) -> Protocol {
    Protocol {
        connect: Box::new(Peer { remote: remote.to_owned(), local }),
        read: Box::new(Packets::default()),
        write: Box::new(Packets::default()),
    }
}

struct Client {
    server: String,
}

impl Connect for Client {
    fn connect(&mut self) -> Result<(Link, Vec<u8>), Failure> {
        let mut link = connect(&self.server)?;
        link.writer.write_all(GREETING)?;
        let (begun, mut heard, mut bytes) = (Instant::now(), Vec::new(), [0; 64]);
        while heard.len() < GREETING.len() {
            match link.reader.read(&mut bytes) {
                Ok(0) => return Err(io::Error::from(io::ErrorKind::ConnectionReset).into()),
                Ok(n) => heard.extend_from_slice(bytes.get(..n).unwrap_or_default()),
                Err(error) if !is_silence(&error) => return Err(error.into()),
                Err(_) if begun.elapsed() > ANSWER => return Err(io::Error::from(io::ErrorKind::TimedOut).into()),
                Err(_) => {}
            }
        }
        let rest = heard.split_off(GREETING.len());
        if heard != GREETING {
            return Err(Failure::Refused(String::from_utf8_lossy(&heard).into_owned()));
        }
        Ok((link, rest))
    }
}

struct Peer {
    remote: String,
    local: u16,
}

impl Connect for Peer {
    fn connect(&mut self) -> Result<(Link, Vec<u8>), Failure> {
        let remote = self.remote.to_socket_addrs()?.next();
        let remote = remote.ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "the name has no address"))?;
        let local = match remote {
            SocketAddr::V4(_) => SocketAddr::from((Ipv4Addr::UNSPECIFIED, self.local)),
            SocketAddr::V6(_) => SocketAddr::from((Ipv6Addr::UNSPECIFIED, self.local)),
        };
        let socket = UdpSocket::bind(local)?;
        // The socket accepts datagrams from this address only, as cannelloni itself does.
        socket.connect(remote)?;
        Ok((datagrams(socket.try_clone()?, socket)?, Vec::new()))
    }
}

/// Frames one after the other.
#[derive(Default)]
struct Stream {
    waiting: Vec<u8>,
}

impl Write for Stream {
    fn write(&mut self, frame: &Frame, bytes: &mut Vec<u8>) -> Result<(), &'static str> {
        write(frame, bytes)
    }
}

impl Read for Stream {
    fn read(&mut self, bytes: &[u8], arrived: &mut Arrived) -> Result<(), String> {
        self.waiting.extend_from_slice(bytes);
        let mut at = 0;
        while let Some((frame, length)) = parse(self.waiting.get(at..).unwrap_or_default())? {
            keep(frame, arrived);
            at += length;
        }
        self.waiting.drain(..at);
        Ok(())
    }
}

/// Datagrams, each with a header and a number of frames.
#[derive(Default)]
struct Packets {
    /// The number of the next datagram.
    next: Option<u8>,
}

impl Write for Packets {
    fn write(&mut self, frame: &Frame, bytes: &mut Vec<u8>) -> Result<(), &'static str> {
        let number = self.next.unwrap_or(0);
        bytes.extend([VERSION, DATA, number, 0, 1]);
        write(frame, bytes)?;
        self.next = Some(number.wrapping_add(1));
        Ok(())
    }
}

impl Read for Packets {
    fn read(&mut self, bytes: &[u8], arrived: &mut Arrived) -> Result<(), String> {
        let &[VERSION, DATA, number, high, low, ref frames @ ..] = bytes else {
            // Another program's datagram does not end the connection.
            arrived.lost += 1;
            return Ok(());
        };
        // Each lost datagram held at least one frame. A lower number means that another datagram has overtaken this one.
        let missing = self.next.map_or(0, |next| number.wrapping_sub(next));
        if missing < 128 {
            arrived.lost += u64::from(missing);
            self.next = Some(number.wrapping_add(1));
        }
        let (count, mut rest) = (u16::from_be_bytes([high, low]), frames);
        for read in 0..count {
            let Ok(Some((frame, length))) = parse(rest) else {
                arrived.lost += u64::from(count - read);
                return Ok(());
            };
            keep(frame, arrived);
            rest = rest.get(length..).unwrap_or_default();
        }
        Ok(())
    }
}

/// Keeps a frame; `None` stands for a frame that CAN does not have, and counts as lost.
fn keep(frame: Option<Frame>, arrived: &mut Arrived) {
    match frame {
        Some(frame) => arrived.frames.push(Stamped { frame, time: None }),
        None => arrived.lost += 1,
    }
}

/// Appends a frame: identifier, length, the flags of CAN FD, payload.
fn write(frame: &Frame, bytes: &mut Vec<u8>) -> Result<(), &'static str> {
    if frame.is_error() || frame.is_xl() {
        return Err("expected a data or remote frame");
    }
    let id = frame.id();
    let flags = if id.is_extended() { EXTENDED } else { 0 } | if frame.is_remote() { REMOTE } else { 0 };
    bytes.extend((id.raw() | flags).to_be_bytes());
    // A frame has 64 bytes at most.
    bytes.push(frame.len() as u8 | if frame.is_fd() { FD } else { 0 });
    if frame.is_fd() {
        bytes.push(frame.flags().bits() & 3);
    }
    bytes.extend_from_slice(frame.data());
    Ok(())
}

/// The first frame and its length in bytes; `None` if it is not complete, an error if a length is impossible.
fn parse(bytes: &[u8]) -> Result<Option<(Option<Frame>, usize)>, String> {
    let &[a, b, c, d, length, ref rest @ ..] = bytes else { return Ok(None) };
    let (id, is_fd) = (u32::from_be_bytes([a, b, c, d]), length & FD != 0);
    let length = usize::from(length & !FD);
    if length > if is_fd { 64 } else { 8 } {
        return Err(format!("what it sends is no stream of cannelloni: a frame of {length} bytes"));
    }
    let (flags, rest) = match rest.split_first() {
        Some((&flags, rest)) if is_fd => (flags, rest),
        None if is_fd => return Ok(None),
        _ => (0, rest),
    };
    // The length of a remote frame is that of the answer.
    let held = if id & REMOTE == 0 { length } else { 0 };
    let Some(data) = rest.get(..held) else { return Ok(None) };
    let can_id =
        if id & EXTENDED == 0 { CanId::standard(id & !(REMOTE | ERROR)) } else { CanId::extended(id & 0x1FFF_FFFF) };
    let frame = match can_id {
        _ if id & ERROR != 0 => Frame::error(ErrorClass(id & 0x1FFF_FFFF), data),
        Some(can_id) if is_fd => Frame::fd(can_id, Flags::from_bits(flags & 3), data),
        Some(can_id) if id & REMOTE != 0 => u8::try_from(length).ok().and_then(|length| Frame::remote(can_id, length)),
        Some(can_id) => Frame::new(can_id, data),
        None => None,
    };
    Ok(Some((frame, 5 + usize::from(is_fd) + held)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frames(arrived: &Arrived) -> Vec<Frame> {
        arrived.frames.iter().map(|stamped| stamped.frame).collect()
    }

    /// The example of the description of the format: a datagram with three frames.
    #[test]
    fn a_datagram() {
        let id = |id: u32| CanId::standard(id).unwrap();
        let expected = [
            Frame::new(id(0x123), &[1, 2]).unwrap(),
            Frame::remote(id(0x705), 1).unwrap(),
            Frame::new(CanId::extended(0x123).unwrap(), &[]).unwrap(),
        ];
        let mut arrived = Arrived::default();
        let packet = [2, 0, 9, 0, 3, 0, 0, 1, 0x23, 2, 1, 2, 0x40, 0, 7, 5, 1, 0x80, 0, 1, 0x23, 0];
        Packets::default().read(&packet, &mut arrived).unwrap();
        assert_eq!((frames(&arrived), arrived.lost), (expected.to_vec(), 0));
    }

    #[test]
    fn lost_datagrams_are_counted() {
        let (mut packets, mut arrived) = (Packets::default(), Arrived::default());
        for number in [254, 255, 0, 3, 2] {
            packets.read(&[2, 0, number, 0, 0], &mut arrived).unwrap();
        }
        assert_eq!(arrived.lost, 2, "1 and 2; 2 came late");
        packets.read(&[2, 0, 4, 0, 2, 0, 0, 1, 0x23, 0], &mut arrived).unwrap();
        packets.read(b"something else", &mut arrived).unwrap();
        assert_eq!((arrived.lost, arrived.frames.len()), (4, 1), "the second frame of the datagram, and the other one");
    }

    #[test]
    fn what_is_no_stream_ends_the_connection() {
        assert!(Stream::default().read(b"HTTP/1.1 400", &mut Arrived::default()).is_err());
    }

    fn any_frame() -> impl Strategy<Value = Frame> {
        (0_u32..0x2000_0000, any::<bool>(), 0_usize..3, prop::collection::vec(any::<u8>(), 0..=8), 0_u8..4).prop_map(
            |(id, extended, kind, data, flags)| {
                let id = if extended { CanId::extended(id).unwrap() } else { CanId::standard_masked(id) };
                match kind {
                    0 => Frame::new(id, &data).unwrap(),
                    1 => Frame::remote(id, data.len() as u8).unwrap(),
                    _ => Frame::fd(id, Flags::from_bits(flags), &data).unwrap(),
                }
            },
        )
    }

    proptest! {
        #[test]
        fn a_frame_is_written_as_it_is_read(sent in prop::collection::vec(any_frame(), 0..20), cut in any::<prop::sample::Index>()) {
            let (mut stream, mut bytes) = (Stream::default(), Vec::new());
            let (mut packets, mut reader, mut apart) = (Packets::default(), Packets::default(), Arrived::default());
            for frame in &sent {
                stream.write(frame, &mut bytes).unwrap();
                let mut datagram = Vec::new();
                packets.write(frame, &mut datagram).unwrap();
                reader.read(&datagram, &mut apart).unwrap();
            }
            let mut together = Arrived::default();
            let (first, second) = bytes.split_at(cut.index(bytes.len() + 1));
            stream.read(first, &mut together).unwrap();
            stream.read(second, &mut together).unwrap();
            prop_assert_eq!(frames(&together), sent.clone());
            prop_assert_eq!(frames(&apart), sent);
        }

        #[test]
        fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..100)) {
            let _ = Stream::default().read(&bytes, &mut Arrived::default());
            Packets::default().read(&[&[2, 0, 0, 0, 9][..], &bytes].concat(), &mut Arrived::default()).unwrap();
        }
    }
}
