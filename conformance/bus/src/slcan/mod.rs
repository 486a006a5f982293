//! SLCAN: CAN adapters with LAWICEL's ASCII protocol over a serial port or TCP.
//!
//! Both ends are implemented: [`SlCan`] uses an adapter, [`SlCanHub`] is one, for any number of other programs.

mod codec;
mod hub;
pub mod python;
mod reader;
mod stamps;

#[cfg(windows)]
pub use crate::connection::link::ports;
pub use codec::{BIT_RATES, Command, Decoder, Message, MinuteClock, Status, write_frame};
pub use hub::SlCanHub;

use super::clock::SteadyClock;
use super::inbox::{Inbox, receives_by_inbox};
use super::{Bus, BusError};
use crate::connection::link::Place;
use crate::connection::way::Way;
use canvass_traces::{ChannelId, Direction, Frame, Record, Timestamp};
use reader::Reader;
use std::io;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// An SLCAN adapter.
pub struct SlCan {
    shared: Arc<Shared>,
    reader: Option<JoinHandle<()>>,
    bit_rate: Option<u32>,
    /// The Python program that is the adapter, for a bus of python-can.
    bridge: Option<python::Bridge>,
}

/// State shared by the bus and its reading thread.
struct Shared {
    name: String,
    clock: SteadyClock,
    inbox: Inbox,
    way: Way,
    /// A request to change the bit rate. The reading thread handles it, because that thread receives the adapter's
    /// answers.
    change: Mutex<Option<Change>>,
}

/// A change of the bit rate, as an index into [`BIT_RATES`], and the channel for its result.
struct Change {
    index: u8,
    /// Whether the adapter then only listens.
    listens: bool,
    done: Sender<Result<(), SlCanError>>,
}

/// Maximum duration of a change of the bit rate: four commands, and four to return to the old one. Each may time out on
/// an adapter that has answered before.
const CHANGE: Duration = Duration::from_secs(18);

/// Why an adapter does not work, with a remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SlCanError {
    /// The port or connection can't be opened.
    #[error("can't open {name}: {source}{}", remedy(source))]
    Open {
        /// The port or address.
        name: String,
        /// The system's error.
        source: io::Error,
    },
    /// SLCAN has no code for the bit rate.
    #[error("SLCAN has no bit rate of {0} bit/s: expected one of 10k, 20k, 50k, 100k, 125k, 250k, 500k, 800k, 1M")]
    BitRate(u32),
    /// The adapter refuses a command.
    #[error("{name} refuses to {action}: it may be in use, have another protocol, or lack that bit rate")]
    Refused {
        /// The port or address.
        name: String,
        /// The refused action.
        action: &'static str,
    },
    /// No program has connected to this end.
    #[error(
        "no program has connected to {name} within {waited}: start the program or adapter that connects to it, or \
         set how long to wait"
    )]
    NoClient {
        /// The address.
        name: String,
        /// The time waited.
        waited: canvass_traces::Duration,
    },
    /// python-can can't open the bus.
    #[error("{name}: {reason}")]
    Python {
        /// The address.
        name: String,
        /// The error of Python, with a remedy.
        reason: String,
    },
    /// All programs have left this end.
    #[error("no program is connected to {name}: start one that connects to it")]
    Nobody {
        /// The address.
        name: String,
    },
    /// The connection is lost at the moment.
    #[error("{name} is not connected: plug it in; canvass opens it again by itself")]
    NotConnected {
        /// The port or address.
        name: String,
    },
}

fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::PermissionDenied => ": join the port's group, usually `usermod -aG dialout $USER`",
        // Windows gives a port to only one program, and reports a used port as missing.
        io::ErrorKind::NotFound if cfg!(windows) => {
            ": is it plugged in, and does no other program have it? (canvass doctor lists the ports)"
        }
        io::ErrorKind::NotFound => ": is it plugged in? (canvass doctor lists the ports)",
        io::ErrorKind::ConnectionRefused => ": no program listens there",
        _ => "",
    }
}

/// Opens the bus at `place`: an adapter at a serial port's path or at `tcp://host:port`, or `listen://host:port` for
/// programs that use this end as their adapter. `listen://port` accepts programs on this machine only.
///
/// # Errors
/// [`SlCanError`] with a remedy.
pub fn open(place: &str, bit_rate: Option<u32>) -> Result<Box<dyn Bus + Send>, SlCanError> {
    match place.strip_prefix("listen://") {
        Some(address) => Ok(Box::new(SlCanHub::listen(place, address, bit_rate)?)),
        None => Ok(Box::new(SlCan::open(place, bit_rate)?)),
    }
}

/// A record of a sent frame, and its line.
fn frame_line(now: Timestamp, frame: &Frame) -> Result<(Record, Vec<u8>), BusError> {
    // The protocol does not give the time at which a frame was on the bus; this time is the earliest possible one.
    let record = Record::new(now, ChannelId(0), *frame).with_direction(Direction::Tx);
    let mut line = Vec::with_capacity(32);
    if frame.is_head() || write_frame(&record, &mut line).is_none() {
        let reason = "expected a classical data or remote frame, or a CAN FD frame of up to 16 bytes";
        return Err(BusError::Unsendable { frame: *frame, reason });
    }
    Ok((record, line))
}

impl SlCan {
    /// Opens the adapter at `place`: a serial port's path, or `tcp://host:port`.
    ///
    /// # Errors
    /// [`SlCanError`] with a remedy.
    pub fn open(place: &str, bit_rate: Option<u32>) -> Result<Self, SlCanError> {
        let index = bit_rate.map(index_of).transpose()?;
        let failed = |source| SlCanError::Open { name: place.to_owned(), source };
        let shared = Arc::new(Shared {
            name: place.to_owned(),
            clock: SteadyClock::start(),
            inbox: Inbox::new(),
            way: Way::default(),
            change: Mutex::default(),
        });
        let place = Place::parse(place);
        let mut reader = Reader::new(Arc::clone(&shared), place, index);
        reader.connect()?;
        let thread = std::thread::Builder::new().name(format!("receive {}", shared.name));
        let reader = thread.spawn(move || reader.run()).map_err(failed)?;
        Ok(Self { shared, reader: Some(reader), bit_rate, bridge: None })
    }
}

/// The number of the command `S` for a bit rate.
fn index_of(bit_rate: u32) -> Result<u8, SlCanError> {
    let index = (0_u8..).zip(BIT_RATES).find(|(_, known)| *known == bit_rate);
    index.map(|(index, _)| index).ok_or(SlCanError::BitRate(bit_rate))
}

impl Shared {
    fn not_connected(&self) -> SlCanError {
        SlCanError::NotConnected { name: self.name.clone() }
    }

    /// Sends a command to the adapter, or the answer to a command.
    fn tell(&self, line: &[u8]) -> Result<(), SlCanError> {
        self.way.tell(line).map_err(|_| self.not_connected())
    }
}

impl Bus for SlCan {
    receives_by_inbox!();

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let (record, line) = frame_line(self.now(), frame)?;
        let shared = &*self.shared;
        let sent = shared.inbox.send(&record, &shared.clock, || shared.way.send(&line));
        Ok(sent.map_err(|_| shared.not_connected())?)
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bit_rate
    }

    /// Closes the adapter's channel, sets the bit rate and reopens the channel.
    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        if self.bridge.is_some() {
            return Err(BusError::FixedBitRate { bit_rate });
        }
        self.change(bit_rate, false)
    }

    fn listen_at(&mut self, bit_rate: u32) -> Result<(), BusError> {
        if self.bridge.is_some() {
            return Err(BusError::NeverSilent);
        }
        self.change(bit_rate, true)
    }
}

impl SlCan {
    /// Lets the reading thread close the channel and open it again.
    fn change(&mut self, bit_rate: u32, listens: bool) -> Result<(), BusError> {
        let (done, answer) = channel();
        let change = Change { index: index_of(bit_rate)?, listens, done };
        *self.shared.change.lock().unwrap_or_else(PoisonError::into_inner) = Some(change);
        let Ok(changed) = answer.recv_timeout(CHANGE) else {
            // The change must not happen later, when the caller no longer expects it.
            self.shared.change.lock().unwrap_or_else(PoisonError::into_inner).take();
            return Err(self.shared.not_connected().into());
        };
        changed?;
        self.bit_rate = Some(bit_rate);
        Ok(())
    }
}

impl Drop for SlCan {
    fn drop(&mut self) {
        let mut line = Vec::new();
        Command::Close.write(&mut line);
        // If the adapter is lost, its channel need not be closed.
        let _ = self.shared.tell(&line);
        self.shared.inbox.close();
        if let Some(reader) = self.reader.take() {
            // A panic of the thread does not matter any more.
            let _ = reader.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::StampTrouble;
    use canvass_traces::{CanId, Duration};
    use std::io::{Read, Write};
    use std::net::TcpListener;

    fn address() -> String {
        // The port is free again once this listener is gone.
        TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string()
    }

    fn frame(n: u32) -> Frame {
        Frame::new(CanId::standard(n).unwrap(), &n.to_le_bytes()).unwrap()
    }

    /// An adapter without 800 kbit/s, which reports the error after a delay. Returns the lines that it received.
    fn adapter(listener: TcpListener) -> JoinHandle<Vec<String>> {
        std::thread::spawn(move || {
            let (mut stream, mut told, mut line) = (listener.accept().unwrap().0, Vec::new(), String::new());
            let mut byte = [0];
            while stream.read(&mut byte).is_ok_and(|n| n == 1) {
                if byte[0] != b'\r' {
                    line.push(char::from(byte[0]));
                    continue;
                }
                if line == "S7" {
                    std::thread::sleep(std::time::Duration::from_millis(500));
                }
                // The client may have closed the connection before the answer.
                let answered = stream.write_all(if line == "S7" { b"\x07" } else { b"\r" });
                assert!(answered.is_ok() || matches!(&*line, "C" | "F"), "{line}: {answered:?}");
                told.push(std::mem::take(&mut line));
            }
            told
        })
    }

    /// An adapter whose clock shows the time since it was opened, and stops after a while. It sends a frame every 40
    /// ms.
    fn stamping(listener: TcpListener, stands_still_after: u64) -> JoinHandle<()> {
        std::thread::spawn(move || {
            let mut stream = listener.accept().unwrap().0;
            let mut answers = stream.try_clone().unwrap();
            std::thread::spawn(move || {
                let (mut byte, mut asked) = ([0], stream.try_clone().unwrap());
                while asked.read(&mut byte).is_ok_and(|n| n == 1) {
                    // The client may have closed the connection before the answer.
                    let _ = (byte[0] == b'\r').then(|| stream.write_all(b"\r"));
                }
            });
            std::thread::sleep(std::time::Duration::from_millis(100));
            let begun = std::time::Instant::now();
            for n in 0_u64.. {
                std::thread::sleep(std::time::Duration::from_millis(40));
                let stamp = (begun.elapsed().as_millis() as u64).min(if n < stands_still_after { u64::MAX } else { 9 });
                if answers.write_all(format!("t12310F{stamp:04X}\r").as_bytes()).is_err() {
                    break;
                }
            }
        })
    }

    #[test]
    fn time_stamps_that_stand_still_are_told_and_not_used() {
        for (after, trouble) in [(0, Some(StampTrouble::Still)), (u64::MAX, None)] {
            let listener = TcpListener::bind("127.0.0.1:0").unwrap();
            let address = listener.local_addr().unwrap();
            let adapter = stamping(listener, after);
            let mut bus = SlCan::open(&format!("tcp://{address}"), Some(250_000)).unwrap();
            let (begun, mut times) = (bus.now(), Vec::new());
            while times.len() < 15 && bus.now().since(begun) < Duration::from_secs(30) {
                let deadline = bus.now() + Duration::from_secs(1);
                times.extend(bus.receive(deadline).unwrap().map(|record| record.timestamp));
            }
            assert_eq!(bus.health().stamps, trouble);
            let spans: Vec<u64> = times.windows(2).map(|pair| pair[1].since(pair[0]).0 / 1_000_000).collect();
            assert!(spans[8..].iter().all(|&span| span > 0), "frames have times of their own: {spans:?}");
            drop(bus);
            adapter.join().unwrap();
        }
    }

    #[test]
    fn the_bit_rate_is_changed_while_the_channel_is_closed() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let adapter = adapter(listener);
        let mut bus = SlCan::open(&format!("tcp://{address}"), Some(250_000)).unwrap();
        bus.set_bit_rate(500_000).unwrap();
        assert_eq!(bus.bit_rate(), Some(500_000));
        assert!(bus.set_bit_rate(123_456).unwrap_err().to_string().contains("10k, 20k"));
        let refused = bus.set_bit_rate(800_000).unwrap_err().to_string();
        assert!(refused.contains("refuses to set the bit rate"), "{refused}");
        assert_eq!(bus.bit_rate(), Some(500_000));
        bus.listen_at(125_000).unwrap();
        assert_eq!(bus.bit_rate(), Some(125_000));
        bus.set_bit_rate(500_000).unwrap();
        bus.send(&frame(5)).unwrap();
        assert_eq!(bus.health().interruptions, 0);
        drop(bus);
        let told = adapter.join().unwrap();
        let told: Vec<&str> = told.iter().map(String::as_str).filter(|line| !matches!(*line, "" | "F")).collect();
        let changes = [
            &["C", "S5", "Z1", "O", "C", "S6", "Z1", "O", "C", "S7", "C", "S6", "Z1", "O"][..],
            // It only listens, and takes part again.
            &["C", "S4", "Z1", "L", "C", "S6", "Z1", "O", "t005405000000", "C"],
        ];
        assert_eq!(told, changes.concat());
    }

    #[test]
    fn errors_name_the_remedy() {
        let error = |place: &str, rate| SlCan::open(place, rate).err().unwrap().to_string();
        assert!(error("/dev/no-such-port", Some(123_456)).contains("250k"));
        assert!(error(&format!("tcp://{}", address()), None).contains("no program listens there"));
        assert!(error("/dev/no-such-port", None).contains("/dev/no-such-port"));
        assert!(error("COM97", None).contains("is it plugged in"), "{}", error("COM97", None));
    }
}
