//! Interrupts the connection to an SLCAN adapter in different ways, and checks that it works again afterwards.

use canvass_bus::slcan::SlCan;
use canvass_bus::{Bus, BusError};
use canvass_traces::{CanId, Frame};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time;

fn frame() -> Frame {
    Frame::full(CanId::standard_masked(0x123), [1; 8])
}

const LINE: &str = "t12380101010101010101";

/// Waits until a condition holds.
fn until(bus: &mut SlCan, what: &str, mut is_so: impl FnMut(&mut SlCan) -> bool) {
    let begun = time::Instant::now();
    while !is_so(bus) {
        assert!(begun.elapsed() < time::Duration::from_secs(20), "{what}: {:?}", bus.health());
        std::thread::sleep(time::Duration::from_millis(5));
    }
}

/// Answers commands like an adapter, until a line that `ends` recognises or the end of the connection; returns the
/// frames.
fn serve(line: &mut (impl Read + Write), mut ends: impl FnMut(&str) -> bool) -> Vec<String> {
    let (mut text, mut byte, mut frames) = (String::new(), [0], Vec::new());
    while line.read(&mut byte).is_ok_and(|n| n == 1) {
        if byte[0] != b'\r' {
            text.push(char::from(byte[0]));
            continue;
        }
        let command = std::mem::take(&mut text);
        if ends(&command) {
            break;
        }
        let answer: &[u8] = if command == "F" { b"F00\r" } else { b"\r" };
        if command.starts_with('t') {
            frames.push(command);
        } else if line.write_all(answer).is_err() {
            break;
        }
    }
    frames
}

fn listener() -> std::io::Result<(TcpListener, String)> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let place = format!("tcp://{}", listener.local_addr()?);
    Ok((listener, place))
}

#[test]
fn a_frame_is_refused_until_the_channel_is_open_again() {
    let (listener, place) = listener().unwrap();
    let (opened, opening) = std::sync::mpsc::channel();
    let adapter = std::thread::spawn(move || {
        // The adapter closes the connection, and opens its channel again only after a while.
        serve(&mut listener.accept().unwrap().0, |line| line == LINE);
        let mut again = listener.accept().unwrap().0;
        let mut is_slow = true;
        serve(&mut again, |line| {
            if line == "O" && std::mem::take(&mut is_slow) {
                std::thread::sleep(time::Duration::from_millis(400));
                opened.send(()).unwrap();
            }
            false
        })
    });
    let mut bus = SlCan::open(&place, Some(250_000)).unwrap();
    bus.send(&frame()).unwrap();
    until(&mut bus, "it is interrupted", |bus| bus.is_interrupted());
    let refused = bus.send(&frame()).unwrap_err();
    assert!(refused.is_interruption(), "{refused}");
    until(&mut bus, "it is back", |bus| !bus.is_interrupted());
    opening.try_recv().expect("the channel is open before the bus is back");
    bus.send(&frame()).unwrap();
    assert_eq!(bus.health().interruptions, 1);
    drop(bus);
    assert_eq!(adapter.join().unwrap(), [LINE], "none went to the closed channel");
}

/// The other end of a connection loses its supply: no more bytes come, and the connection does not end.
#[test]
fn a_connection_without_a_sign_of_life_is_made_anew() {
    let (listener, place) = listener().unwrap();
    let adapter = std::thread::spawn(move || {
        let mut dead = listener.accept().unwrap().0;
        let mut asked = 0;
        // The adapter answers the query of the status flags once, and then falls silent.
        serve(&mut dead, |line| {
            asked += u32::from(line == "F");
            asked == 2
        });
        let frames = serve(&mut listener.accept().unwrap().0, |_| false);
        drop(dead);
        frames
    });
    let mut bus = SlCan::open(&place, None).unwrap();
    until(&mut bus, "it is interrupted", |bus| bus.health().interruptions == 1);
    let trouble = bus.health().trouble.unwrap();
    assert!(trouble.contains("the adapter no longer answers"), "{trouble}");
    until(&mut bus, "it is back", |bus| !bus.is_interrupted());
    bus.send(&frame()).unwrap();
    drop(bus);
    assert_eq!(adapter.join().unwrap(), [LINE]);
}

/// An adapter that sends and does not read: the connection takes no more bytes.
#[test]
fn a_connection_that_takes_nothing_is_made_anew() {
    let (listener, place) = listener().unwrap();
    let adapter = std::thread::spawn(move || {
        let mut deaf = listener.accept().unwrap().0;
        serve(&mut deaf, |line| line == LINE);
        let talks = deaf.try_clone().unwrap();
        std::thread::spawn(move || chatter(talks));
        drop(serve(&mut listener.accept().unwrap().0, |line| line == LINE));
        drop(deaf);
    });
    let mut bus = SlCan::open(&place, None).unwrap();
    let refused = loop {
        if let Err(refused) = bus.send(&frame()) {
            break refused;
        }
    };
    assert!(matches!(&refused, BusError::SlCan(_)) && refused.is_interruption(), "{refused}");
    until(&mut bus, "it is back", |bus| bus.health().interruptions == 1 && !bus.is_interrupted());
    bus.send(&frame()).unwrap();
    drop(bus);
    adapter.join().unwrap();
}

/// Sends frames as from a bus until the connection ends.
fn chatter(mut stream: TcpStream) {
    while stream.write_all(b"t7011\x30\x35\r").is_ok() {
        std::thread::sleep(time::Duration::from_millis(20));
    }
}

/// A serial adapter is unplugged and plugged in again: its port disappears and comes back.
#[cfg(all(target_os = "linux", feature = "serial"))]
#[test]
fn a_serial_port_is_opened_again() {
    use nix::fcntl::OFlag;
    use nix::pty::{PtyMaster, grantpt, posix_openpt, ptsname_r, unlockpt};
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("ttyACM0");
    let plug = || {
        let adapter = posix_openpt(OFlag::O_RDWR | OFlag::O_NOCTTY).unwrap();
        grantpt(&adapter).unwrap();
        unlockpt(&adapter).unwrap();
        std::os::unix::fs::symlink(ptsname_r(&adapter).unwrap(), &port).unwrap();
        adapter
    };
    // The adapter is unplugged when it gets the query of its status after its first frame.
    let serve_one = |mut adapter: PtyMaster| {
        std::thread::spawn(move || {
            let mut got = false;
            serve(&mut adapter, |line| {
                got |= line == LINE;
                got && line == "F"
            });
            got
        })
    };
    let first = serve_one(plug());
    let mut bus = SlCan::open(port.to_str().unwrap(), Some(500_000)).unwrap();
    bus.send(&frame()).unwrap();
    assert!(first.join().unwrap());
    std::fs::remove_file(&port).unwrap();
    until(&mut bus, "it is unplugged", |bus| bus.is_interrupted());
    assert!(bus.send(&frame()).unwrap_err().is_interruption());
    let second = serve_one(plug());
    until(&mut bus, "it is plugged in", |bus| !bus.is_interrupted());
    assert_eq!(bus.health().interruptions, 1);
    bus.send(&frame()).unwrap();
    assert!(second.join().unwrap());
}
