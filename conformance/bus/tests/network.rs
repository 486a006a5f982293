//! Tests of buses over a network. Each test plays the program at the other end.

// `cfg(test)` changes nothing here, but tells clippy that a test may unwrap.
#![cfg(test)]

use canvass_bus::network::{Carrier, NetworkAddress, NetworkBus, NetworkError};
use canvass_bus::{Bus, BusError};
use canvass_traces::{CanId, Direction, Duration, Frame, Record};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::thread;

fn frame(id: u32, data: &[u8]) -> Frame {
    Frame::new(CanId::standard(id).unwrap(), data).unwrap()
}

fn open(carrier: Carrier) -> Result<NetworkBus, NetworkError> {
    NetworkBus::open(&NetworkAddress { carrier, bit_rate: Some(250_000) })
}

/// The next frame of another participant.
fn received(bus: &mut NetworkBus) -> Option<Record> {
    let deadline = bus.now() + Duration::from_secs(10);
    loop {
        let record = bus.receive(deadline).unwrap()?;
        if record.direction == Direction::Rx {
            return Some(record);
        }
    }
}

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = std::time::Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < std::time::Duration::from_secs(20), "{what}");
        thread::sleep(std::time::Duration::from_millis(5));
    }
}

/// Reads an element `< … >`.
fn element(stream: &mut TcpStream) -> String {
    let (mut text, mut byte) = (String::new(), [0]);
    while !text.ends_with('>') && stream.read(&mut byte).is_ok_and(|n| n == 1) {
        text.push(char::from(byte[0]));
    }
    text
}

/// Lets a client in, as socketcand does.
fn greet(stream: &mut TcpStream) {
    stream.write_all(b"< hi >").unwrap();
    assert_eq!(element(stream), "< open can0 >");
    stream.write_all(b"< ok >").unwrap();
    assert_eq!(element(stream), "< rawmode >");
}

fn socketcand(listener: &TcpListener) -> Carrier {
    let server = listener.local_addr().unwrap().to_string();
    Carrier::Socketcand { server, interface: "can0".to_owned() }
}

#[test]
fn socketcand_is_opened_again_after_it_was_lost() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let carrier = socketcand(&listener);
    let server = thread::spawn(move || {
        for id in [0x705, 0x706] {
            let (mut stream, _) = listener.accept().unwrap();
            greet(&mut stream);
            // The first frame may come together with the answer.
            stream.write_all(format!("< ok >< frame {id:03X} 1700000000.000001 00 >").as_bytes()).unwrap();
            assert_eq!(element(&mut stream), "< send 605 8 40 18 10 01 00 00 00 00 >");
            // Leaving the block closes the connection.
        }
    });
    let mut bus = open(carrier).unwrap();
    let request = frame(0x605, &[0x40, 0x18, 0x10, 1, 0, 0, 0, 0]);
    assert_eq!(received(&mut bus).unwrap().frame, frame(0x705, &[0]));
    bus.send(&request).unwrap();
    assert_eq!(received(&mut bus).unwrap().frame, frame(0x706, &[0]), "it has connected again");
    bus.send(&request).unwrap();
    server.join().unwrap();
    until("the loss is noticed", || bus.is_interrupted());
    let refused = bus.send(&request).unwrap_err();
    assert!(refused.is_interruption() && refused.to_string().contains("connects again by itself"), "{refused}");
    assert_eq!((bus.health().interruptions, bus.bit_rate()), (2, Some(250_000)));
    let remote = Frame::remote(CanId::standard(0x705).unwrap(), 1).unwrap();
    assert!(matches!(bus.send(&remote), Err(BusError::Unsendable { .. })), "socketcand has no remote frames");
}

#[test]
fn what_socketcand_refuses_is_told() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let carrier = socketcand(&listener);
    let server = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.write_all(b"< hi >").unwrap();
        element(&mut stream);
        stream.write_all(b"< error could not open bus >").unwrap();
    });
    let error = open(carrier.clone()).err().unwrap().to_string();
    assert!(error.contains("answered \"error could not open bus\""), "{error}");
    server.join().unwrap();
    let error = open(carrier).err().unwrap().to_string();
    assert!(error.contains("no program listens there"), "{error}");
}

#[test]
fn cannelloni_over_tcp() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let server = listener.local_addr().unwrap().to_string();
    let other_end = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.write_all(b"CANNELLONIv1\0\0\x07\x05\x01\x05").unwrap();
        let mut heard = [0; 12 + 7];
        stream.read_exact(&mut heard).unwrap();
        heard
    });
    let mut bus = open(Carrier::CannelloniTcp { server }).unwrap();
    assert_eq!(received(&mut bus).unwrap().frame, frame(0x705, &[5]));
    bus.send(&frame(0x000, &[1, 5])).unwrap();
    assert_eq!(&other_end.join().unwrap(), b"CANNELLONIv1\0\0\0\0\x02\x01\x05");
}

#[test]
fn another_program_is_not_taken_for_cannelloni() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let server = listener.local_addr().unwrap().to_string();
    let other_end = thread::spawn(move || {
        listener.accept().unwrap().0.write_all(b"SSH-2.0-OpenSSH_9.6\r\n").unwrap();
    });
    let error = open(Carrier::CannelloniTcp { server }).err().unwrap().to_string();
    assert!(error.contains("answered \"SSH-2.0-Open\""), "{error}");
    other_end.join().unwrap();
}

#[test]
fn cannelloni_by_datagrams() {
    let other_end = UdpSocket::bind("127.0.0.1:0").unwrap();
    let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let remote = other_end.local_addr().unwrap().to_string();
    let mut bus = open(Carrier::CannelloniUdp { remote, local: free }).unwrap();
    for number in 0..2 {
        bus.send(&frame(0x000, &[1, 5])).unwrap();
        let mut bytes = [0; 64];
        let length = other_end.recv(&mut bytes).unwrap();
        assert_eq!(bytes[..length], [2, 0, number, 0, 1, 0, 0, 0, 0, 2, 1, 5]);
    }
    other_end.send_to(&[2, 0, 200, 0, 1, 0, 0, 7, 5, 1, 5], ("127.0.0.1", free)).unwrap();
    assert_eq!(received(&mut bus).unwrap().frame, frame(0x705, &[5]));
    // A stranger is not heard.
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    stranger.send_to(&[2, 0, 201, 0, 1, 0, 0, 7, 6, 1, 5], ("127.0.0.1", free)).unwrap();
    other_end.send_to(&[2, 0, 203, 0, 1, 0, 0, 7, 7, 1, 5], ("127.0.0.1", free)).unwrap();
    assert_eq!(received(&mut bus).unwrap().frame, frame(0x707, &[5]));
    assert_eq!(bus.health().lost, 2, "datagrams 201 and 202");
}

/// Each member of the group gets the frames of the others, and its own ones once.
#[test]
fn members_of_a_group() {
    let group = "239.74.163.77:43177".parse().unwrap();
    let join = || open(Carrier::Multicast { group }).unwrap();
    let (mut first, mut second, mut third) = (join(), join(), join());
    first.send(&frame(0x605, &[0x40, 0x18, 0x10, 1, 0, 0, 0, 0])).unwrap();
    for other in [&mut second, &mut third] {
        assert_eq!(received(other).unwrap().frame.id().raw(), 0x605);
    }
    second.send(&frame(0x585, &[0x43])).unwrap();
    assert_eq!(received(&mut first).unwrap().frame, frame(0x585, &[0x43]), "not its own frame");
    assert_eq!(received(&mut third).unwrap().frame, frame(0x585, &[0x43]));
}
