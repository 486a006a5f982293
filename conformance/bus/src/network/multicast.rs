//! python-can's `udp_multicast`: each frame is a datagram to a group of computers, as a msgpack map with the names of
//! python-can's `Message`.

use super::bus::{Arrived, Connect, Failure, Protocol, Read, Stamped, Write};
use crate::clock::system_time;
use crate::connection::link::{Link, datagrams};
use canvass_traces::{CanId, ErrorClass, Flags, Frame};
use rmpv::Value;
use socket2::{Domain, SockAddr, Socket, Type};
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::{Arc, Mutex, PoisonError};

/// The group, `ADDRESS:PORT`.
pub(super) fn protocol(group: SocketAddr) -> Protocol {
    let own = Arc::new(Mutex::new(None));
    Protocol {
        connect: Box::new(Group { group, own: Arc::clone(&own) }),
        read: Box::new(Messages),
        write: Box::new(Messages),
    }
}

struct Group {
    group: SocketAddr,
    own: Own,
}

/// The address from which this program sends. Its own frames come back, as to all members of the group.
type Own = Arc<Mutex<Option<SocketAddr>>>;

impl Connect for Group {
    fn connect(&mut self) -> Result<(Link, Vec<u8>), Failure> {
        let any = match self.group {
            SocketAddr::V4(_) => IpAddr::V4(Ipv4Addr::UNSPECIFIED),
            SocketAddr::V6(_) => IpAddr::V6(Ipv6Addr::UNSPECIFIED),
        };
        let receives = Socket::new(Domain::for_address(self.group), Type::DGRAM, None)?;
        // Other programs on this computer are members, too.
        receives.set_reuse_address(true)?;
        #[cfg(unix)]
        receives.set_reuse_port(true)?;
        receives.bind(&SockAddr::from(SocketAddr::new(any, self.group.port())))?;
        match self.group.ip() {
            IpAddr::V4(group) => receives.join_multicast_v4(&group, &Ipv4Addr::UNSPECIFIED)?,
            IpAddr::V6(group) => receives.join_multicast_v6(&group, 0)?,
        }
        let sends = UdpSocket::bind(SocketAddr::new(any, 0))?;
        sends.connect(self.group)?;
        *self.own.lock().unwrap_or_else(PoisonError::into_inner) = sends.local_addr().ok();
        let mut link = datagrams(UdpSocket::from(receives.try_clone()?), sends)?;
        link.reader = Box::new(Others { socket: receives.into(), own: Arc::clone(&self.own) });
        Ok((link, Vec::new()))
    }
}

/// The datagrams of other programs.
struct Others {
    socket: UdpSocket,
    own: Own,
}

impl io::Read for Others {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let (length, from) = self.socket.recv_from(buffer)?;
        let own = *self.own.lock().unwrap_or_else(PoisonError::into_inner);
        let is_own = own.is_some_and(|own| (own.ip(), own.port()) == (from.ip(), from.port()));
        // No bytes would mean the end of a stream.
        if length == 0 || is_own { Err(io::ErrorKind::Interrupted.into()) } else { Ok(length) }
    }
}

struct Messages;

impl Write for Messages {
    fn write(&mut self, frame: &Frame, bytes: &mut Vec<u8>) -> Result<(), &'static str> {
        if frame.is_error() || frame.is_xl() {
            return Err("expected a data or remote frame");
        }
        let (id, flags) = (frame.id(), frame.flags());
        let seconds = system_time().nanos() as f64 / 1e9;
        let fields: [(&str, Value); 11] = [
            ("timestamp", seconds.into()),
            ("arbitration_id", id.raw().into()),
            ("is_extended_id", id.is_extended().into()),
            ("is_remote_frame", frame.is_remote().into()),
            ("is_error_frame", false.into()),
            ("channel", Value::Nil),
            ("dlc", frame.len().into()),
            ("data", Value::Binary(frame.data().to_vec())),
            ("is_fd", frame.is_fd().into()),
            ("bitrate_switch", flags.contains(Flags::BRS).into()),
            ("error_state_indicator", flags.contains(Flags::ESI).into()),
        ];
        let map = fields.into_iter().map(|(name, value)| (name.into(), value)).collect();
        // Writing to memory does not fail.
        rmpv::encode::write_value(bytes, &Value::Map(map)).map_err(|_| "expected a frame of CAN")
    }
}

impl Read for Messages {
    fn read(&mut self, mut bytes: &[u8], arrived: &mut Arrived) -> Result<(), String> {
        match rmpv::decode::read_value(&mut bytes).ok().as_ref().and_then(frame) {
            Some(frame) => arrived.frames.push(Stamped { frame, time: None }),
            None => arrived.lost += 1,
        }
        Ok(())
    }
}

/// The frame of a message; `None` if a field is missing or impossible.
fn frame(message: &Value) -> Option<Frame> {
    let fields = message.as_map()?;
    let field = |name: &str| fields.iter().find(|(key, _)| key.as_str() == Some(name)).map(|(_, value)| value);
    let is = |name: &str| field(name).and_then(Value::as_bool).unwrap_or(false);
    let number = field("arbitration_id").and_then(Value::as_u64).and_then(|id| u32::try_from(id).ok())?;
    let id = if is("is_extended_id") { CanId::extended(number) } else { CanId::standard(number) };
    let data = field("data").and_then(Value::as_slice).unwrap_or_default();
    if is("is_error_frame") {
        return Frame::error(ErrorClass(number), data);
    }
    if is("is_remote_frame") {
        let length = field("dlc").and_then(Value::as_u64).and_then(|length| u8::try_from(length).ok())?;
        return Frame::remote(id?, length);
    }
    if is("is_fd") {
        let flag = |name, flag: Flags| if is(name) { flag } else { Flags::default() };
        return Frame::fd(
            id?,
            flag("bitrate_switch", Flags::BRS).with(flag("error_state_indicator", Flags::ESI)),
            data,
        );
    }
    Frame::new(id?, data)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What python-can 4.6 sends for `Message(arbitration_id=0x18FF1234, data=[1, 2])`.
    const OF_PYTHON_CAN: &str = "8ba974696d657374616d70cb0000000000000000ae6172626974726174696f6e5f6964ce18ff1234ae69\
        735f657874656e6465645f6964c3af69735f72656d6f74655f6672616d65c2ae69735f6572726f725f6672616d65c2a76368616e6e656cc0\
        a3646c6302a464617461c4020102a569735f6664c2ae626974726174655f737769746368c2b56572726f725f73746174655f696e64696361\
        746f72c2";

    fn read(bytes: &[u8]) -> Arrived {
        let mut arrived = Arrived::default();
        Messages.read(bytes, &mut arrived).unwrap();
        arrived
    }

    #[test]
    fn a_message_of_python_can() {
        let arrived = read(&canvass_traces::hex::parse(OF_PYTHON_CAN).unwrap());
        let expected = Frame::new(CanId::extended(0x18FF_1234).unwrap(), &[1, 2]).unwrap();
        assert_eq!(arrived.frames, [Stamped { frame: expected, time: None }]);
    }

    proptest! {
        #[test]
        fn a_frame_is_written_as_it_is_read(id in 0_u32..0x2000_0000, extended: bool, kind in 0..3, data in prop::collection::vec(any::<u8>(), 0..=8), flags in 0_u8..4) {
            let id = if extended { CanId::extended(id).unwrap() } else { CanId::standard_masked(id) };
            let frame = match kind {
                0 => Frame::new(id, &data).unwrap(),
                1 => Frame::remote(id, data.len() as u8).unwrap(),
                _ => Frame::fd(id, Flags::from_bits(flags), &data).unwrap(),
            };
            let mut bytes = Vec::new();
            Messages.write(&frame, &mut bytes).unwrap();
            prop_assert_eq!(read(&bytes).frames, vec![Stamped { frame, time: None }]);
        }

        #[test]
        fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let arrived = read(&bytes);
            prop_assert_eq!(arrived.frames.len() as u64 + arrived.lost, 1);
        }
    }
}
