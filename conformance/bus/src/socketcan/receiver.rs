//! The thread that fetches frames from the kernel, and continues after a loss of the interface.

use super::Shared;
use super::correction::Correction;
use super::link::Link;
use super::sys::{BATCH, Batch, Received};
use crate::hardware_clock::HardwareClock;
use canvass_traces::{ChannelId, Direction, Frame, Record, Timestamp, from_socket};
use std::io::{self, PipeReader};
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

/// Interval between two checks whether a lost interface is back.
const LOOK: Duration = Duration::from_millis(50);

/// The class bit of error frames for bus-off (`CAN_ERR_BUSOFF`).
const BUS_OFF: u32 = 0x40;

pub(super) struct Receiver {
    shared: Arc<Shared>,
    /// The other end of this pipe is closed with the inbox; nothing else wakes a thread that waits for a frame.
    end: PipeReader,
    correction: Correction,
    hardware: HardwareClock,
    /// The kernel's last count of lost frames.
    dropped: u32,
    records: Vec<Record>,
    /// The reason why the interface is unusable at the moment; `None` if it is usable.
    away: Option<Away>,
}

/// Why an interface can't be used.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Away {
    /// The interface is down, or its controller is bus-off: the socket works again afterwards.
    Down,
    /// The interface was removed: the socket is bound to no interface.
    Removed,
}

impl Receiver {
    pub fn new(shared: Arc<Shared>, end: PipeReader) -> Self {
        let (correction, hardware) = (Correction::default(), HardwareClock::default());
        Self { shared, end, correction, hardware, dropped: 0, records: Vec::with_capacity(64), away: None }
    }

    /// Receives until the inbox is closed.
    pub fn run(mut self) {
        super::wake_precisely();
        let shared = Arc::clone(&self.shared);
        let mut batch = Batch::new();
        while !shared.inbox.is_closed() {
            if let Some(away) = self.away {
                self.find_again(away);
            }
            match shared.socket.wait_readable_or_closed(&self.end, self.away.map(|_| LOOK)) {
                Ok(true) => self.fetch(&mut batch),
                Ok(false) => {}
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => self.interrupted(format!("receiving failed: {error}")),
            }
        }
    }

    /// Fetches all waiting frames of the kernel.
    fn fetch(&mut self, batch: &mut Batch) {
        let shared = Arc::clone(&self.shared);
        shared.inbox.set_delivering(true);
        self.correction = self.correction.looked_up(&shared.clock);
        let mut is_full = false;
        while !shared.inbox.is_closed() {
            match shared.socket.receive(batch) {
                Ok(0) => break,
                Ok(frames) => {
                    (0..frames)
                        .filter_map(|at| batch.get(at))
                        .for_each(|(packet, received)| self.take(packet, received));
                    shared.inbox.deliver(&mut self.records);
                    if frames < BATCH {
                        break;
                    }
                    is_full = true;
                }
                Err(error) => {
                    self.failed(&error);
                    break;
                }
            }
        }
        // While the queue is short, the kernel drops no frame.
        if is_full && let Some(dropped) = shared.socket.dropped() {
            self.note_dropped(dropped);
        }
        shared.inbox.set_delivering(false);
    }

    fn take(&mut self, packet: &[u8], received: Received) {
        if let Some(dropped) = received.dropped {
            self.note_dropped(dropped);
        }
        let at = self.time(&received);
        // The kernel delivers only frames, so there is no error.
        let Ok(mut record) = from_socket(packet) else { return };
        (record.timestamp, record.channel) = (at, ChannelId(0));
        record.direction = if received.own { Direction::Tx } else { Direction::Rx };
        if record.frame.is_error() {
            self.on_error_frame(&record.frame);
        } else if received.own {
            self.on_sent(at);
        }
        self.records.push(record);
    }

    /// Counts the lost frames by the kernel's count, which may overflow.
    fn note_dropped(&mut self, dropped: u32) {
        let lost = dropped.wrapping_sub(self.dropped);
        // A frame that waited in the queue carries an older count than the socket has.
        if lost != 0 && lost < u32::MAX / 2 {
            self.dropped = dropped;
            self.shared.inbox.note(|health| health.lost += u64::from(lost));
        }
    }

    fn time(&mut self, received: &Received) -> Timestamp {
        let Some(software) = received.software else { return self.shared.clock.now() };
        let system = match received.hardware {
            Some(hardware) => self.hardware.system_time(hardware, software),
            None => software,
        };
        self.correction.apply(system)
    }

    /// Handles the echo of an own frame.
    fn on_sent(&self, at: Timestamp) {
        let handed_over = self.shared.sent.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        if let Some(handed_over) = handed_over {
            self.shared.inbox.note(|health| health.transmit.add(at.since(handed_over)));
        }
    }

    fn on_error_frame(&mut self, frame: &Frame) {
        self.shared.inbox.note(|health| health.error_frames += 1);
        if frame.error_class().is_some_and(|class| class.0 & BUS_OFF != 0) {
            let link = Link::find(&self.shared.interface).ok().flatten();
            let state = link.map(|link| format!(" ({link})")).unwrap_or_default();
            self.went_away(Away::Down, format!("{}: the controller went bus-off{state}", self.shared.interface));
        }
    }

    fn failed(&mut self, error: &io::Error) {
        let interface = &self.shared.interface;
        match error.raw_os_error() {
            Some(libc::EAGAIN | libc::EINTR) => {}
            Some(libc::ENETDOWN) if self.shared.goes_down.swap(false, Ordering::SeqCst) => {}
            Some(libc::ENETDOWN) => self.went_away(Away::Down, format!("{interface} went down")),
            Some(libc::ENODEV) => self.went_away(Away::Removed, format!("{interface} was removed")),
            _ => {
                self.interrupted(format!("{interface}: receiving failed: {error}"));
                // An error that recurs at once must not use up a processor.
                std::thread::sleep(LOOK);
            }
        }
    }

    fn went_away(&mut self, away: Away, trouble: String) {
        // A removed interface goes down first.
        self.away = self.away.filter(|before| *before == Away::Removed).or(Some(away));
        self.forget_sent();
        let now = self.shared.clock.now();
        self.shared.inbox.note(|health| health.went_away(now, trouble));
    }

    fn interrupted(&self, trouble: String) {
        self.forget_sent();
        self.shared.inbox.note(|health| health.was_interrupted(trouble));
    }

    /// Forgets the frames without echo: they may never have been sent.
    fn forget_sent(&self) {
        self.shared.sent.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// Finds an interface that is up again, or a new one of the same name, perhaps of the same adapter.
    fn find_again(&mut self, away: Away) {
        let link = Link::find(&self.shared.interface).ok().flatten();
        let Some(link) = link.filter(Link::is_usable) else { return };
        if away == Away::Removed {
            let filters = self.shared.filters.lock().unwrap_or_else(PoisonError::into_inner);
            let bound = self.shared.socket.set_filters(&filters).and_then(|()| self.shared.socket.bind(link.index));
            if bound.is_err() {
                return;
            }
        }
        self.away = None;
        let now = self.shared.clock.now();
        self.shared.inbox.note(|health| health.came_back(now));
    }
}
