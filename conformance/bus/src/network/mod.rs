//! Buses that are reached over a network: socketcand, cannelloni, and python-can's multicast.

mod address;
mod cannelloni;
#[cfg(not(target_family = "wasm"))]
mod multicast;
mod reader;
mod socketcand;

pub use address::{Carrier, NetworkAddress};

use crate::clock::SteadyClock;
use crate::connection::link::Link;
use crate::connection::way::Way;
use crate::inbox::Inbox;
use crate::{Bus, BusError, Health};
use canvass_traces::{ChannelId, Direction, Frame, Record, Timestamp};
use reader::Reader;
use std::io;
use std::sync::Arc;
use std::thread::JoinHandle;

/// A bus of another computer or program.
pub struct NetworkBus {
    shared: Arc<Shared>,
    reader: Option<JoinHandle<()>>,
    writer: Box<dyn Write + Send>,
    bit_rate: Option<u32>,
}

/// State shared by the bus and its reading thread.
struct Shared {
    name: String,
    clock: SteadyClock,
    inbox: Inbox,
    way: Way,
}

/// Opens a connection, at the beginning and after it was lost.
trait Connect {
    /// Opens the connection, and whatever the other end must do before frames can pass. Returns what the other end has
    /// sent after that.
    fn connect(&mut self) -> Result<(Link, Vec<u8>), Failure>;
}

/// Turns frames into bytes.
trait Write {
    /// Appends a frame to what is written at once.
    fn write(&mut self, frame: &Frame, bytes: &mut Vec<u8>) -> Result<(), &'static str>;
}

/// Turns bytes into frames.
trait Read {
    /// Takes what one read has given.
    fn read(&mut self, bytes: &[u8], arrived: &mut Arrived) -> Result<(), String>;
}

/// What one read has brought.
#[derive(Default, Debug, PartialEq, Eq)]
struct Arrived {
    frames: Vec<Stamped>,
    /// Number of frames that were lost or unreadable.
    lost: u64,
}

/// A frame, with its time on the other computer's clock if that is sent.
#[derive(Debug, PartialEq, Eq)]
struct Stamped {
    frame: Frame,
    time: Option<Timestamp>,
}

/// The parts of a protocol.
struct Protocol {
    connect: Box<dyn Connect + Send>,
    read: Box<dyn Read + Send>,
    write: Box<dyn Write + Send>,
}

/// Why a connection can't be opened.
enum Failure {
    Io(io::Error),
    /// The other end has refused, with these words.
    Refused(String),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Why a bus over a network does not work, with a remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// The connection can't be opened.
    #[error("can't open {name}: {source}{}", remedy(source))]
    Open {
        /// The address.
        name: String,
        /// The system's error.
        source: io::Error,
    },
    /// The other end refuses.
    #[error("{name}: the other end answered \"{answer}\"")]
    Refused {
        /// The address.
        name: String,
        /// Its answer.
        answer: String,
    },
    /// The connection is lost at the moment.
    #[error("{name} is not connected; canvass connects again by itself")]
    NotConnected {
        /// The address.
        name: String,
    },
}

fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::ConnectionRefused => ": no program listens there",
        io::ErrorKind::AddrInUse => ": another program has this port",
        _ => "",
    }
}

impl NetworkBus {
    /// Opens the bus at an address.
    ///
    /// # Errors
    /// [`NetworkError`] with a remedy.
    pub fn open(address: &NetworkAddress) -> Result<Self, NetworkError> {
        let name = address.to_string();
        let protocol = match &address.carrier {
            Carrier::Socketcand { server, interface } => socketcand::protocol(server, interface),
            Carrier::CannelloniTcp { server } => cannelloni::over_tcp(server),
            Carrier::CannelloniUdp { remote, local } => cannelloni::over_udp(remote, *local),
            #[cfg(not(target_family = "wasm"))]
            Carrier::Multicast { group } => multicast::protocol(*group),
            #[cfg(target_family = "wasm")]
            Carrier::Multicast { .. } => {
                return Err(NetworkError::Open { name, source: io::ErrorKind::Unsupported.into() });
            }
        };
        let shared = Arc::new(Shared {
            name: name.clone(),
            clock: SteadyClock::start(),
            inbox: Inbox::new(),
            way: Way::default(),
        });
        let mut reader = Reader::new(Arc::clone(&shared), protocol.connect, protocol.read);
        reader.connect()?;
        let thread = std::thread::Builder::new().name(format!("receive {name}"));
        let reader = thread.spawn(move || reader.run()).map_err(|source| NetworkError::Open { name, source })?;
        Ok(Self { shared, reader: Some(reader), writer: protocol.write, bit_rate: address.bit_rate })
    }
}

impl Bus for NetworkBus {
    fn now(&self) -> Timestamp {
        self.shared.clock.now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let mut bytes = Vec::with_capacity(128);
        let unsendable = |reason| BusError::Unsendable { frame: *frame, reason };
        if frame.is_head() {
            return Err(unsendable("expected a CAN FD frame of up to 16 bytes"));
        }
        self.writer.write(frame, &mut bytes).map_err(unsendable)?;
        // The other end does not tell when the frame was on the bus; this time is the earliest possible one. The frame
        // is recorded before it is written: the answer may arrive before this thread continues.
        let record = Record::new(self.now(), ChannelId(0), *frame).with_direction(Direction::Tx);
        self.shared.inbox.deliver(&mut vec![record.clone()]);
        if self.shared.way.send(&bytes).is_err() {
            self.shared.inbox.retract(&record);
            return Err(NetworkError::NotConnected { name: self.shared.name.clone() }.into());
        }
        let took = self.now().since(record.timestamp);
        self.shared.inbox.note(|health| health.transmit.add(took));
        Ok(())
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        Ok(self.shared.inbox.take(&self.shared.clock, deadline, || false))
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bit_rate
    }

    fn is_live(&self) -> bool {
        true
    }

    fn health(&self) -> Health {
        self.shared.inbox.health()
    }

    fn is_interrupted(&self) -> bool {
        self.shared.inbox.is_interrupted()
    }

    fn limit_backlog(&mut self, frames: usize) {
        self.shared.inbox.limit(frames);
    }
}

impl Drop for NetworkBus {
    fn drop(&mut self) {
        self.shared.inbox.close();
        if let Some(reader) = self.reader.take() {
            // A panic of the thread does not matter any more.
            let _ = reader.join();
        }
    }
}
