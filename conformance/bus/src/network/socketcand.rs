//! socketcand: a program that serves the CAN interfaces of a Linux machine over TCP, with lines of text such as
//! `< frame 123 23.424242 11223344 >`.
//!
//! It sends no remote frames, and takes none.

use super::bus::{Arrived, Connect, Failure, Protocol, Read, Stamped, Write};
use crate::connection::link::{Link, connect, is_silence};
use canvass_traces::{CanId, ErrorClass, Frame, Timestamp};
use std::io;
use std::time::{Duration, Instant};

/// Timeout of an answer.
const ANSWER: Duration = Duration::from_secs(3);
/// Maximum length of an element. The longest one of today has less than 100 bytes.
const LONGEST: usize = 4096;

/// The protocol for an interface, such as `can0`, of a server `HOST:PORT`.
pub(super) fn protocol(server: &str, interface: &str) -> Protocol {
    Protocol {
        connect: Box::new(Client { server: server.to_owned(), interface: interface.to_owned() }),
        read: Box::new(Elements::default()),
        write: Box::new(Sender),
    }
}

struct Client {
    server: String,
    interface: String,
}

impl Connect for Client {
    fn connect(&mut self) -> Result<(Link, Vec<u8>), Failure> {
        let mut link = connect(&self.server)?;
        let mut elements = Elements::default();
        expect(&mut link, &mut elements, "hi")?;
        for command in [format!("< open {} >", self.interface), "< rawmode >".to_owned()] {
            link.writer.write_all(command.as_bytes())?;
            expect(&mut link, &mut elements, "ok")?;
        }
        Ok((link, elements.waiting))
    }
}

/// Waits for an answer.
fn expect(link: &mut Link, elements: &mut Elements, expected: &str) -> Result<(), Failure> {
    let (begun, mut bytes) = (Instant::now(), [0; 256]);
    loop {
        match elements.next() {
            Some(element) if element == expected => return Ok(()),
            Some(element) => return Err(Failure::Refused(element)),
            None if begun.elapsed() > ANSWER => return Err(io::Error::from(io::ErrorKind::TimedOut).into()),
            None => {}
        }
        match link.reader.read(&mut bytes) {
            Ok(0) => return Err(io::Error::from(io::ErrorKind::ConnectionReset).into()),
            Ok(n) => elements.waiting.extend_from_slice(bytes.get(..n).unwrap_or_default()),
            Err(error) if is_silence(&error) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

struct Sender;

impl Write for Sender {
    fn write(&mut self, frame: &Frame, bytes: &mut Vec<u8>) -> Result<(), &'static str> {
        if frame.is_remote() || frame.is_fd() || frame.is_xl() || frame.is_error() {
            return Err("socketcand takes only classical data frames");
        }
        let id = frame.id();
        let digits = if id.is_extended() { 8 } else { 3 };
        bytes.extend(format!("< send {:0digits$X} {:X} ", id.raw(), frame.len()).bytes());
        frame.data().iter().for_each(|byte| bytes.extend(format!("{byte:02X} ").bytes()));
        bytes.push(b'>');
        Ok(())
    }
}

/// Divides what arrives into elements `< … >`.
#[derive(Default)]
struct Elements {
    waiting: Vec<u8>,
}

impl Elements {
    /// The next element without its brackets; `None` if it has not arrived completely.
    fn next(&mut self) -> Option<String> {
        let end = self.waiting.iter().position(|&byte| byte == b'>')?;
        let element: Vec<u8> = self.waiting.drain(..=end).collect();
        let begin = element.iter().rposition(|&byte| byte == b'<').map_or(0, |at| at + 1);
        let inner = element.get(begin..end).unwrap_or_default();
        Some(String::from_utf8_lossy(inner).trim().to_owned())
    }
}

impl Read for Elements {
    fn read(&mut self, bytes: &[u8], arrived: &mut Arrived) -> Result<(), String> {
        self.waiting.extend_from_slice(bytes);
        while let Some(element) = self.next() {
            match frame(&element) {
                Some(stamped) => arrived.frames.push(stamped),
                // The answer to something else.
                None if matches!(&*element, "ok" | "hi" | "echo") => {}
                None => arrived.lost += 1,
            }
        }
        if self.waiting.len() > LONGEST {
            return Err("what it sends is no text of socketcand".to_owned());
        }
        Ok(())
    }
}

/// `frame ID SECONDS.MICROSECONDS DATA` or `error CLASS SECONDS.MICROSECONDS`.
fn frame(element: &str) -> Option<Stamped> {
    let mut words = element.split_ascii_whitespace();
    let (kind, id) = (words.next()?, words.next()?);
    let time = words.next().and_then(seconds)?;
    let number = u32::from_str_radix(id, 16).ok()?;
    let frame = match kind {
        "frame" => {
            let id = if id.len() == 3 { CanId::standard(number) } else { CanId::extended(number) };
            // Older versions put spaces between the bytes.
            let digits: String = words.collect();
            Frame::new(id?, &canvass_traces::hex::parse(&digits)?)
        }
        "error" => Frame::error(ErrorClass(number), &[]),
        _ => None,
    }?;
    Some(Stamped { frame, time: Some(time) })
}

/// `23.424242` in seconds and millionths.
fn seconds(text: &str) -> Option<Timestamp> {
    let (whole, micros) = text.split_once('.')?;
    let micros = if micros.len() == 6 { micros.parse::<u64>().ok()? } else { return None };
    let nanos = whole.parse::<u64>().ok()?.checked_mul(1_000_000_000)?.checked_add(micros * 1_000)?;
    Some(Timestamp(nanos))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str) -> Arrived {
        let mut arrived = Arrived::default();
        Elements::default().read(text.as_bytes(), &mut arrived).unwrap();
        arrived
    }

    fn data(id: u32, bytes: &[u8]) -> Frame {
        let id = if id > 0x7FF { CanId::extended(id) } else { CanId::standard(id) };
        Frame::new(id.unwrap(), bytes).unwrap()
    }

    /// Frames as the documentation of socketcand shows them, with spaces, and as the program prints them, without.
    #[test]
    fn frames_with_and_without_spaces() {
        let arrived = read("< frame 123 23.424242 11 22 33 44 >< frame 18FF0001 1.000001 AB >< frame 080 2.000000  >");
        let frames: Vec<Frame> = arrived.frames.iter().map(|stamped| stamped.frame).collect();
        assert_eq!(frames, [data(0x123, &[0x11, 0x22, 0x33, 0x44]), data(0x18FF_0001, &[0xAB]), data(0x80, &[])]);
        assert_eq!(arrived.frames[0].time, Some(Timestamp(23_424_242_000)));
        assert_eq!(arrived.lost, 0);
    }

    #[test]
    fn errors_of_the_bus_and_of_the_protocol() {
        let arrived = read("< error 004 5.000000 >< ok >< error unknown command >");
        assert!(arrived.frames[0].frame.is_error() && arrived.frames.len() == 1);
        assert_eq!(arrived.lost, 1, "the server did not understand a frame of ours");
        assert!(Elements::default().read(&[b'x'; 5000], &mut Arrived::default()).is_err());
    }

    proptest! {
        #[test]
        fn a_frame_is_written_as_it_is_read(id in 0_u32..0x2000_0000, extended: bool, bytes in prop::collection::vec(any::<u8>(), 0..=8)) {
            let id = if extended { CanId::extended(id).unwrap() } else { CanId::standard_masked(id) };
            let frame = Frame::new(id, &bytes).unwrap();
            let mut line = Vec::new();
            Sender.write(&frame, &mut line).unwrap();
            // The commands to send and the frames differ by the length and the time.
            let text = String::from_utf8(line).unwrap();
            let mut words: Vec<&str> = text.split(' ').collect();
            (words[1], words[3]) = ("frame", "7.000000");
            prop_assert_eq!(read(&words.join(" ")).frames, vec![Stamped { frame, time: Some(Timestamp(7_000_000_000)) }]);
        }

        #[test]
        fn any_bytes_are_survived_in_any_pieces(bytes in prop::collection::vec(prop::sample::select(b"< >frame0123.AF\xFF".to_vec()), 0..200), cut in 0_usize..200) {
            let (mut whole, mut pieces) = (Arrived::default(), Arrived::default());
            Elements::default().read(&bytes, &mut whole).unwrap();
            let (first, second) = bytes.split_at(cut.min(bytes.len()));
            let mut elements = Elements::default();
            elements.read(first, &mut pieces).unwrap();
            elements.read(second, &mut pieces).unwrap();
            prop_assert_eq!(whole, pieces);
        }
    }
}
