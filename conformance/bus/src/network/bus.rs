//! [`NetworkBus`], and the traits that each protocol implements.

use super::reader::Reader;
use super::{Carrier, NetworkAddress, NetworkError, cannelloni, multicast, socketcand};
use crate::clock::SteadyClock;
use crate::connection::link::Link;
use crate::connection::way::Way;
use crate::inbox::{Inbox, receives_by_inbox};
use crate::{Bus, BusError};
use canvass_traces::{ChannelId, Direction, Frame, Record, Timestamp};
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
pub(super) struct Shared {
    pub name: String,
    pub clock: SteadyClock,
    pub inbox: Inbox,
    pub way: Way,
}

/// Opens a connection, at the beginning and after it was lost.
pub(super) trait Connect {
    /// Opens the connection and exchanges greetings. Returns the bytes that came after the greeting.
    fn connect(&mut self) -> Result<(Link, Vec<u8>), Failure>;
}

/// Turns frames into bytes.
pub(super) trait Write {
    /// Appends the bytes of a frame.
    fn write(&mut self, frame: &Frame, bytes: &mut Vec<u8>) -> Result<(), &'static str>;
}

/// Turns bytes into frames.
pub(super) trait Read {
    /// Decodes the bytes of one read; a rest waits for the next read.
    fn read(&mut self, bytes: &[u8], arrived: &mut Arrived) -> Result<(), String>;
}

/// What one read has brought.
#[derive(Default, Debug, PartialEq, Eq)]
pub(super) struct Arrived {
    pub frames: Vec<Stamped>,
    /// Number of frames that were lost or unreadable.
    pub lost: u64,
}

/// A frame, with its time on the other computer's clock if that is sent.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Stamped {
    pub frame: Frame,
    pub time: Option<Timestamp>,
}

/// The parts of a protocol.
pub(super) struct Protocol {
    pub connect: Box<dyn Connect + Send>,
    pub read: Box<dyn Read + Send>,
    pub write: Box<dyn Write + Send>,
}

/// Why a connection can't be opened.
pub(super) enum Failure {
    Io(io::Error),
    /// The other end has refused, with these words.
    Refused(String),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
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
            Carrier::Multicast { group } => multicast::protocol(*group),
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
    receives_by_inbox!();

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let mut bytes = Vec::with_capacity(128);
        let unsendable = |reason| BusError::Unsendable { frame: *frame, reason };
        if frame.is_head() {
            return Err(unsendable("expected a CAN FD frame of up to 16 bytes"));
        }
        self.writer.write(frame, &mut bytes).map_err(unsendable)?;
        // The other end does not tell when the frame was on the bus; this time is the earliest possible one.
        let record = Record::new(self.now(), ChannelId(0), *frame).with_direction(Direction::Tx);
        let shared = &*self.shared;
        let sent = shared.inbox.send(&record, &shared.clock, || shared.way.send(&bytes));
        Ok(sent.map_err(|_| NetworkError::NotConnected { name: shared.name.clone() })?)
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bit_rate
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
