//! The bus: opens a channel and sends; another thread receives.

mod bit_rate;
mod inventory;
mod library;
mod message;
mod receiver;
mod wake;

pub use inventory::{Condition, Installed, Present, installed};

use super::{Channel, Opening, PcanError, Status};
use crate::clock::SteadyClock;
use crate::inbox::{Inbox, receives_by_inbox};
use crate::{Bus, BusError};
use canvass_traces::{ChannelId, Direction, Duration, Frame, Record, Timestamp};
use library::Library;
use message::Message;
use receiver::Receiver;
use std::path::Path;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// A channel of an adapter of PEAK.
pub struct Pcan {
    shared: Arc<Shared>,
    receiver: Option<JoinHandle<()>>,
    bit_rate: u32,
}

/// State shared by the bus and its receiving thread.
struct Shared {
    library: Library,
    channel: Channel,
    listen_only: bool,
    clock: SteadyClock,
    inbox: Inbox,
    /// A request to change the bit rate. The receiving thread handles it, because the channel must be closed while that
    /// thread does not read from it.
    change: Mutex<Option<Change>>,
}

/// A change of the bit rate, in bit/s, and the channel for its result.
struct Change {
    bit_rate: u32,
    /// Whether the adapter then only listens.
    listens: bool,
    done: Sender<Result<(), PcanError>>,
}

/// Maximum wait if the transmit queue is full. The longest frame takes 16 ms at 10 kbit/s.
const PATIENCE: Duration = Duration::from_millis(2_000);

/// Interval between two attempts to send. A frame of 8 bytes takes 0.1 ms at 1 Mbit/s.
const ROOM: std::time::Duration = std::time::Duration::from_micros(500);

/// Maximum duration of a change of the bit rate: closing and opening the channel, and doing so again to return to the
/// old bit rate.
const CHANGE: std::time::Duration = std::time::Duration::from_secs(5);

impl Pcan {
    /// Opens a channel, with the installed library.
    ///
    /// # Errors
    /// [`PcanError`] with a remedy.
    pub fn open(opening: Opening) -> Result<Self, PcanError> {
        Self::with(Library::installed()?, opening)
    }

    /// Opens a channel like [`Pcan::open`], with the library in the file `library`.
    ///
    /// # Errors
    /// [`PcanError`] with a remedy.
    pub fn open_with(library: &Path, opening: Opening) -> Result<Self, PcanError> {
        Self::with(Library::at(library)?, opening)
    }

    fn with(library: Library, opening: Opening) -> Result<Self, PcanError> {
        let Opening { channel, bit_rate, listen_only } = opening;
        let shared = Arc::new(Shared {
            library,
            channel,
            listen_only,
            clock: SteadyClock::start(),
            inbox: Inbox::new(),
            change: Mutex::default(),
        });
        let receiver = Receiver::open(Arc::clone(&shared), bit_rate)?;
        let thread = std::thread::Builder::new().name(format!("receive {channel}"));
        let receiver = thread.spawn(move || receiver.run()).map_err(|source| PcanError::Wait { channel, source })?;
        Ok(Self { shared, receiver: Some(receiver), bit_rate })
    }

    /// Puts a message into the transmit queue, and waits for room in it.
    fn write(&self, message: Message, began: Timestamp) -> Result<(), PcanError> {
        let Shared { library, channel, .. } = &*self.shared;
        let channel = *channel;
        loop {
            let status = library.write(channel, message);
            if status.has(Status::BUS_OFF) {
                return Err(PcanError::Failed { channel, action: "send on", status });
            }
            match status.failure() {
                // The receiving thread reports the state of the bus.
                Status::OK => return Ok(()),
                failure if !failure.is_full() => {
                    return Err(PcanError::Failed { channel, action: "send on", status: failure });
                }
                _ if self.now().since(began) >= PATIENCE => {
                    let full = PcanError::QueueFull { channel, waited: PATIENCE, status: library.status(channel) };
                    self.shared.inbox.note_stuck(self.now(), full.to_string());
                    return Err(full);
                }
                _ => {
                    self.shared.inbox.note(|health| health.waits += 1);
                    std::thread::sleep(ROOM);
                }
            }
        }
    }
}

impl Bus for Pcan {
    receives_by_inbox!();

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let Some(message) = Message::to_send(frame) else {
            return Err(BusError::Unsendable { frame: *frame, reason: "expected a classical data or remote frame" });
        };
        if self.shared.listen_only {
            return Err(PcanError::ListenOnly { channel: self.shared.channel }.into());
        }
        let began = self.now();
        // The frame is recorded before it is written: the answer may arrive before this thread continues.
        let record = Record::new(began, ChannelId(0), *frame).with_direction(Direction::Tx);
        self.shared.inbox.deliver(&mut vec![record.clone()]);
        if let Err(error) = self.write(message, began) {
            self.shared.inbox.retract(&record);
            return Err(error.into());
        }
        let now = self.now();
        self.shared.inbox.note_taken(now);
        self.shared.inbox.note(|health| health.transmit.add(now.since(began)));
        Ok(())
    }

    fn bit_rate(&self) -> Option<u32> {
        Some(self.bit_rate)
    }

    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.change(bit_rate, false)
    }

    fn listen_at(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.change(bit_rate, true)
    }
}

impl Pcan {
    /// Lets the receiving thread close the channel and open it again.
    fn change(&mut self, bit_rate: u32, listens: bool) -> Result<(), BusError> {
        let (done, answer) = channel();
        let change = Change { bit_rate, listens, done };
        *self.shared.change.lock().unwrap_or_else(PoisonError::into_inner) = Some(change);
        let Ok(changed) = answer.recv_timeout(CHANGE) else {
            // The change must not happen later, when the caller no longer expects it.
            self.shared.change.lock().unwrap_or_else(PoisonError::into_inner).take();
            let status = self.shared.library.status(self.shared.channel);
            let action = "change the bit rate of";
            return Err(PcanError::Failed { channel: self.shared.channel, action, status }.into());
        };
        changed?;
        self.bit_rate = bit_rate;
        Ok(())
    }
}

impl Drop for Pcan {
    fn drop(&mut self) {
        self.shared.inbox.close();
        if let Some(receiver) = self.receiver.take() {
            // A panic of the thread does not matter any more.
            let _ = receiver.join();
        }
    }
}
