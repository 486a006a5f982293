//! SocketCAN: the CAN interfaces of Linux.
//!
//! Another thread receives, so that slow processing does not overflow the kernel's queue. Times are those of the
//! controller if it has a clock, else those of the kernel.

mod bit_rate;
mod correction;
mod error;
mod link;
mod receiver;
mod sys;

pub use error::SocketCanError;
pub use link::{ControllerState, Link};
pub(super) use sys::wake_precisely;

use super::clock::SteadyClock;
use super::inbox::Inbox;
use super::{Bus, BusError, Health};
use canvass_traces::{ChannelId, Duration, Frame, Record, Timestamp, to_socket};
use receiver::Receiver;
use std::cell::Cell;
use std::collections::VecDeque;
use std::io::{self, PipeWriter};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use sys::{Filter, RawSocket};

/// A CAN interface of Linux.
pub struct SocketCan {
    shared: Arc<Shared>,
    receiver: Option<JoinHandle<()>>,
    /// The sending end of a pipe. The receiving thread holds the other end, and ends when this one is closed.
    open: Option<PipeWriter>,
    bit_rate: Option<u32>,
    /// Whether this program has made a listener of the interface.
    listens: bool,
    losses: Cell<Losses>,
    /// The value of the unused bytes of sent frames.
    padding: u8,
}

/// Counts the frames that were lost before any socket received them.
#[derive(Clone, Copy)]
struct Losses {
    /// The interface's count at the last update.
    counted: u64,
    /// Number of frames lost since this bus was opened.
    lost: u64,
}

impl Losses {
    /// Updates the number from the interface's current count, which restarts when the interface is created anew.
    fn at(self, counted: u64) -> Self {
        let new = counted.checked_sub(self.counted).unwrap_or(counted);
        Self { counted, lost: self.lost + new }
    }
}

/// State shared by the bus and its receiving thread.
struct Shared {
    interface: String,
    socket: RawSocket,
    clock: SteadyClock,
    inbox: Inbox,
    /// The sending times of the frames whose echo has not arrived yet.
    sent: Mutex<VecDeque<Timestamp>>,
    /// The receive filters, which the kernel forgets when the interface is removed.
    filters: Mutex<Vec<Filter>>,
    /// Whether this program itself takes the interface down.
    goes_down: AtomicBool,
}

/// Size of the kernel's receive queue: at about 1 KiB per frame, a third of a second of a full bus at 1 Mbit/s.
const RECEIVE_QUEUE: i32 = 8 << 20;

/// Maximum wait if the transmit queue is full. The longest frame takes 16 ms at 10 kbit/s.
const PATIENCE: Duration = Duration::from_millis(2_000);

/// Maximum wait until the receiving thread has noticed that the interface is down.
const DOWN: Duration = Duration::from_millis(500);

/// Maximum number of frames without echo; the delays of further ones are not measured.
const UNACCOUNTED: usize = 4_096;

impl SocketCan {
    /// Opens the interface of that name.
    ///
    /// # Errors
    /// [`SocketCanError`] with a remedy.
    pub fn open(interface: &str) -> Result<Self, SocketCanError> {
        let failed = |action| move |error| SocketCanError::of(interface, action, error);
        let socket = RawSocket::new().map_err(failed("open"))?;
        let link = SocketCanError::check(interface, Link::find(interface).map_err(failed("find"))?)?;
        socket.enlarge_receive_queue(RECEIVE_QUEUE);
        socket.ask_for_all().map_err(failed("configure a socket for"))?;
        socket.bind(link.index).map_err(failed("open"))?;
        let shared = Arc::new(Shared {
            interface: interface.to_owned(),
            socket,
            clock: SteadyClock::start(),
            inbox: Inbox::new(),
            sent: Mutex::default(),
            filters: Mutex::new(vec![(0, 0)]),
            goes_down: AtomicBool::new(false),
        });
        let losses = Cell::new(Losses { counted: link.lost, lost: 0 });
        let (end, open) = io::pipe().map_err(failed("receive from"))?;
        let receiver = Receiver::new(Arc::clone(&shared), end);
        let thread = std::thread::Builder::new().name(format!("receive {interface}"));
        let receiver = thread.spawn(move || receiver.run()).map_err(failed("receive from"))?;
        Ok(Self {
            shared,
            receiver: Some(receiver),
            open: Some(open),
            bit_rate: link.bit_rate,
            listens: false,
            losses,
            padding: 0,
        })
    }

    /// Checks the kernel's support, independently of interfaces.
    ///
    /// # Errors
    /// [`SocketCanError`], which names the missing part.
    pub fn support() -> Result<(), SocketCanError> {
        RawSocket::new().map(|_| ()).map_err(|error| SocketCanError::of("a socket", "open", error))
    }

    /// Waits until the kernel has room for another frame.
    fn wait_for_room(&self, error: &io::Error) -> io::Result<()> {
        self.shared.inbox.note(|health| health.waits += 1);
        if error.raw_os_error() == Some(libc::ENOBUFS) {
            // The interface's queue is full, which poll() does not show. A frame of 8 bytes takes 0.1 ms at 1 Mbit/s.
            std::thread::sleep(std::time::Duration::from_micros(200));
            return Ok(());
        }
        self.shared.socket.wait_writable(std::time::Duration::from_millis(10)).map(|_| ())
    }

    fn queue_full(&self) -> SocketCanError {
        let interface = self.shared.interface.clone();
        let state = match Link::find(&interface) {
            Ok(Some(link)) => link.to_string(),
            _ => "its state is unknown".to_owned(),
        };
        SocketCanError::QueueFull { interface, waited: PATIENCE, state }
    }

    fn remember_sent(&self, at: Timestamp) {
        let mut sent = self.shared.sent.lock().unwrap_or_else(PoisonError::into_inner);
        if sent.len() >= UNACCOUNTED {
            sent.clear();
        }
        sent.push_back(at);
    }

    fn forget_last_sent(&self) {
        self.shared.sent.lock().unwrap_or_else(PoisonError::into_inner).pop_back();
    }
}

/// A value for unused bytes, as if they had not been cleared. Read as flags of CAN FD, its bits mean: a CAN FD frame,
/// sent by a device in error passive state.
const DIRT: u8 = 0xA7;

/// Fills the unused bytes of a classical frame: the three bytes after the length, and the rest of the data.
fn pad(packet: &mut [u8], length: usize, padding: u8) {
    const CLASSICAL: usize = 16;
    if packet.len() != CLASSICAL || padding == 0 {
        return;
    }
    let carries_nothing = |at: usize| matches!(at, 5..8) || at >= 8 + length;
    for (_, byte) in packet.iter_mut().enumerate().filter(|(at, _)| carries_nothing(*at)) {
        *byte = padding;
    }
}

impl Bus for SocketCan {
    fn now(&self) -> Timestamp {
        self.shared.clock.now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        if frame.is_error() || frame.is_xl() || frame.is_head() {
            let reason = "expected a classical data or remote frame, or a CAN FD frame of up to 16 bytes";
            return Err(BusError::Unsendable { frame: *frame, reason });
        }
        let mut packet = Vec::with_capacity(72);
        to_socket(&Record::new(Timestamp::ZERO, ChannelId(0), *frame), &mut packet);
        pad(&mut packet, frame.data().len(), self.padding);
        let started = self.now();
        // The time is stored before sending: the echo may arrive before this thread continues.
        self.remember_sent(started);
        loop {
            let Err(error) = self.shared.socket.send(&packet) else {
                self.shared.inbox.note_taken(started);
                return Ok(());
            };
            let waits = matches!(error.raw_os_error(), Some(libc::ENOBUFS | libc::EAGAIN | libc::EINTR));
            if waits && self.now().since(started) < PATIENCE && self.wait_for_room(&error).is_ok() {
                continue;
            }
            self.forget_last_sent();
            if !waits {
                return Err(SocketCanError::of(&self.shared.interface, "send on", error).into());
            }
            let full = self.queue_full();
            self.shared.inbox.note_stuck(self.now(), full.to_string());
            return Err(full.into());
        }
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        let pending = || self.shared.socket.wait_readable(std::time::Duration::ZERO).unwrap_or(false);
        Ok(self.shared.inbox.take(&self.shared.clock, deadline, pending))
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bit_rate
    }

    fn dirty_padding(&mut self) {
        self.padding = DIRT;
    }

    fn is_live(&self) -> bool {
        true
    }

    fn health(&self) -> Health {
        let mut health = self.shared.inbox.health();
        self.losses.set(self.losses.get().at(Link::lost(&self.shared.interface)));
        health.lost += self.losses.get().lost;
        health
    }

    fn is_interrupted(&self) -> bool {
        self.shared.inbox.is_interrupted()
    }

    fn limit_backlog(&mut self, frames: usize) {
        self.shared.inbox.limit(frames);
    }

    fn only(&mut self, cob_ids: &[(u16, u16)]) -> Result<(), BusError> {
        /// The bits of extended and remote frames in the mask of a kernel's filter.
        const FORMAT: u32 = 0xC000_0000;
        let filter = |&(id, mask): &(u16, u16)| (u32::from(id), u32::from(mask) | FORMAT);
        let filters: Vec<Filter> = cob_ids.iter().map(filter).collect();
        let set = self.shared.socket.set_filters(&filters);
        *self.shared.filters.lock().unwrap_or_else(PoisonError::into_inner) = filters;
        set.map_err(|error| SocketCanError::of(&self.shared.interface, "filter frames of", error).into())
    }

    /// Needs the capability to configure the network (`CAP_NET_ADMIN`). The interface keeps the new bit rate after this
    /// program ends.
    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        // An interface that somebody else has made a listener remains one.
        self.change(bit_rate, self.listens.then_some(false))
    }

    /// As [`Bus::set_bit_rate`]: the interface would only listen after the end of this program, too.
    fn listen_at(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.change(bit_rate, Some(true))
    }
}

impl SocketCan {
    fn change(&mut self, bit_rate: u32, listens: Option<bool>) -> Result<(), BusError> {
        let set = bit_rate::set(&self.shared.interface, bit_rate, listens, &self.shared.goes_down);
        let end = self.now() + DOWN;
        // The receiving thread notices a little later that the interface went down.
        while self.shared.goes_down.load(Ordering::SeqCst) && self.now() < end {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        self.shared.goes_down.store(false, Ordering::SeqCst);
        set?;
        self.bit_rate = Some(bit_rate);
        self.listens = listens.unwrap_or(self.listens);
        Ok(())
    }
}

impl Drop for SocketCan {
    fn drop(&mut self) {
        self.shared.inbox.close();
        drop(self.open.take());
        if let Some(receiver) = self.receiver.take() {
            // A panic of the thread does not matter any more.
            let _ = receiver.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::CanId;

    #[test]
    fn what_an_interface_lost_before_is_not_counted_and_a_new_one_counts_from_zero() {
        let losses = Losses { counted: 40, lost: 0 };
        assert_eq!(losses.at(40).lost, 0);
        assert_eq!(losses.at(47).lost, 7);
        assert_eq!(losses.at(47).at(2).at(3).lost, 10);
    }

    #[test]
    fn dirt_stands_where_a_frame_says_nothing_and_is_not_read() {
        let id = CanId::standard(0x58B).unwrap();
        let record = Record::new(Timestamp::ZERO, ChannelId(0), Frame::new(id, &[0x43, 0, 0x10]).unwrap());
        let mut packet = Vec::new();
        to_socket(&record, &mut packet);
        let clean = packet.clone();
        pad(&mut packet, 3, 0);
        assert_eq!(packet, clean);
        pad(&mut packet, 3, DIRT);
        assert_eq!((&packet[..5], &packet[5..8], &packet[8..11]), (&clean[..5], &[DIRT; 3][..], &clean[8..11]));
        assert_eq!(packet[11..], [DIRT; 5]);
    }
}
