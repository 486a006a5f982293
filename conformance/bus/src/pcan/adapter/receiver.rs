//! The thread that fetches frames from the library, and reopens the channel after the adapter was unplugged.

use super::bit_rate::registers;
use super::library::Parameter;
use super::message::{Content, Stamp, is_error};
use super::wake::Wake;
use super::{Change, Shared};
use crate::hardware_clock::HardwareClock;
use crate::pcan::{PcanError, Status};
use canvass_traces::{ChannelId, Direction, ErrorClass, Frame, Record, Timestamp};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

/// Maximum wait for frames, after which the thread checks whether it must end.
const LOOK: Duration = Duration::from_millis(20);

/// Interval between two queries of the state of the bus.
const STATE: Duration = Duration::from_millis(50);

/// Interval between two attempts to find a lost adapter.
const RETRY: Duration = Duration::from_millis(200);

/// Maximum number of messages that are fetched before they are delivered.
const BATCH: usize = 256;

pub(super) struct Receiver {
    shared: Arc<Shared>,
    bit_rate: u32,
    /// Whether the adapter only listens for the time being, besides what its address says.
    listens: bool,
    /// The wake-up signal; `None` while the channel is closed.
    wake: Option<Wake>,
    hardware: HardwareClock,
    records: Vec<Record>,
    /// Time and result of the last query of the state of the bus.
    asked: Instant,
    state: BusState,
    /// Whether the last status reported lost frames: the next status may report the same loss again.
    told_of_losses: bool,
}

/// The state of the controller, from good to bad.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum BusState {
    Active,
    Warning,
    Passive,
    Off,
}

impl BusState {
    fn of(status: Status) -> Self {
        if status.has(Status::BUS_OFF) {
            Self::Off
        } else if status.has(Status::BUS_PASSIVE) {
            Self::Passive
        } else if status.has(Status::BUS_HEAVY.and(Status::BUS_LIGHT)) {
            Self::Warning
        } else {
            Self::Active
        }
    }
}

/// Classes of Linux's error frames for bus-off, and for the end of bus-off.
const BUS_OFF: ErrorClass = ErrorClass(0x40);
const RESTARTED: ErrorClass = ErrorClass(0x100);

impl Receiver {
    /// Opens the channel.
    pub fn open(shared: Arc<Shared>, bit_rate: u32) -> Result<Self, PcanError> {
        let mut receiver = Self {
            shared,
            bit_rate,
            listens: false,
            wake: None,
            hardware: HardwareClock::default(),
            records: Vec::with_capacity(BATCH),
            asked: Instant::now(),
            state: BusState::Active,
            told_of_losses: false,
        };
        receiver.connect(bit_rate)?;
        Ok(receiver)
    }

    fn connect(&mut self, bit_rate: u32) -> Result<(), PcanError> {
        let registers = registers(bit_rate).ok_or(PcanError::BitRate(bit_rate))?;
        let Shared { library, channel, listen_only, .. } = &*self.shared;
        let (channel, listens) = (*channel, *listen_only || self.listens);
        let failed = |action| move |status| PcanError::Failed { channel, action, status };
        let done = |status: Status| if status.failure() == Status::OK { Ok(()) } else { Err(status) };
        // Listen-only is set before the channel is opened, so that the adapter never acknowledges a frame.
        let silent = library.set(channel, Parameter::LISTEN_ONLY, &u32::from(listens).to_ne_bytes());
        if listens {
            done(silent).map_err(failed("make a listener of"))?;
        }
        done(library.initialize(channel, registers)).map_err(failed("open"))?;
        // Older libraries and some adapters lack one of these parameters; the bus works without them.
        for wanted in [Parameter::ALLOW_STATUS_FRAMES, Parameter::ALLOW_ERROR_FRAMES, Parameter::BUS_OFF_RESET] {
            library.switch_on(channel, wanted);
        }
        match Wake::of(library, channel) {
            Ok(wake) => self.wake = Some(wake),
            Err(source) => {
                library.uninitialize(channel);
                return Err(PcanError::Wait { channel, source });
            }
        }
        (self.bit_rate, self.hardware, self.told_of_losses) = (bit_rate, HardwareClock::default(), false);
        Ok(())
    }

    fn disconnect(&mut self) {
        self.shared.library.uninitialize(self.shared.channel);
        // The library sets the signal only while the channel is open.
        self.wake = None;
    }

    /// Receives until the inbox is closed.
    pub fn run(mut self) {
        #[cfg(target_os = "linux")]
        crate::socketcan::wake_precisely();
        let shared = Arc::clone(&self.shared);
        while !shared.inbox.is_closed() {
            let change = shared.change.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(Change { bit_rate, listens, done }) = change {
                // The caller may have stopped waiting.
                let _ = done.send(self.change_bit_rate(bit_rate, listens));
            }
            let Some(wake) = &self.wake else {
                std::thread::sleep(RETRY);
                // The adapter is not back; the next round tries again.
                if self.connect(self.bit_rate).is_ok() {
                    self.note_back();
                }
                continue;
            };
            if let Err(error) = wake.wait(LOOK) {
                self.lose(&format!("waiting for frames failed: {error}"));
                continue;
            }
            shared.inbox.set_delivering(true);
            self.fetch();
            shared.inbox.set_delivering(false);
            if self.asked.elapsed() >= STATE {
                self.ask();
            }
        }
        self.disconnect();
    }

    /// Opens the channel at another bit rate, or at the old one if the new one fails.
    fn change_bit_rate(&mut self, bit_rate: u32, listens: bool) -> Result<(), PcanError> {
        let before = (self.bit_rate, self.listens);
        registers(bit_rate).ok_or(PcanError::BitRate(bit_rate))?;
        self.disconnect();
        self.listens = listens;
        let changed = self.connect(bit_rate);
        if changed.is_err() {
            self.listens = before.1;
            self.connect(before.0)?;
        }
        changed
    }

    /// Fetches all messages in the library's queue.
    fn fetch(&mut self) {
        let shared = Arc::clone(&self.shared);
        let mut has_lost = false;
        loop {
            let (status, message, stamp) = shared.library.read(shared.channel);
            has_lost |= status.has_lost();
            if status.failure() != Status::OK {
                self.lose(&status.failure().to_string());
                break;
            }
            if status.has(Status::EMPTY) {
                break;
            }
            match message.content() {
                Content::Frame(frame) => self.take(frame, message.kind, stamp),
                Content::Status(status) => {
                    has_lost |= status.has_lost();
                    self.note_state(BusState::of(status), status);
                }
                // The message is no frame; a status without a message ends the queue.
                Content::Nothing if status.news() != Status::OK => {
                    self.note_state(BusState::of(status), status);
                    break;
                }
                Content::Nothing => shared.inbox.note(|health| health.lost += 1),
            }
            if self.records.len() >= BATCH {
                shared.inbox.deliver(&mut self.records);
            }
        }
        if has_lost {
            self.note_losses();
        }
        shared.inbox.deliver(&mut self.records);
    }

    fn take(&mut self, frame: Frame, kind: u8, stamp: Stamp) {
        let own = kind & super::message::kind::ECHO != 0;
        if frame.is_error() && is_error(&frame) {
            self.shared.inbox.note(|health| health.error_frames += 1);
        }
        // An own frame was delivered when it was sent.
        if !own {
            let time = self.time(stamp);
            self.push(frame, time);
        }
    }

    fn push(&mut self, frame: Frame, time: Timestamp) {
        self.records.push(Record::new(time, ChannelId(0), frame).with_direction(Direction::Rx));
    }

    /// The time of a frame on the system's clock. A library without time stamps leaves them at zero.
    fn time(&mut self, stamp: Stamp) -> Timestamp {
        let now = self.shared.clock.now();
        if stamp == Stamp::default() { now } else { self.hardware.system_time(stamp.time(), now) }
    }

    /// Queries the state of the bus.
    fn ask(&mut self) {
        self.asked = Instant::now();
        let status = self.shared.library.status(self.shared.channel);
        if status.failure().without(Status::TRANSMIT_BUFFER_FULL.and(Status::TRANSMIT_QUEUE_FULL)) != Status::OK {
            self.lose(&status.failure().to_string());
            return;
        }
        if status.has_lost() && !self.told_of_losses {
            self.note_losses();
        }
        self.told_of_losses = status.has_lost();
        self.note_state(BusState::of(status), status);
        self.shared.inbox.deliver(&mut self.records);
    }

    /// Counts a loss of frames as one: the library does not report the number of lost frames.
    fn note_losses(&self) {
        let channel = self.shared.channel;
        self.shared.inbox.note(|health| {
            health.lost += 1;
            health.trouble = Some(format!("{channel}: at least one received frame was not fetched in time"));
        });
    }

    fn note_state(&mut self, state: BusState, status: Status) {
        let before = std::mem::replace(&mut self.state, state);
        if state == before {
            return;
        }
        let now = self.shared.clock.now();
        let told = match (before, state) {
            (_, BusState::Off) => Frame::error(BUS_OFF, &[0; 8]),
            (BusState::Off, _) => Frame::error(RESTARTED, &[0; 8]),
            _ => None,
        };
        if let Some(frame) = told {
            self.push(frame, now);
        }
        if state > before {
            let trouble = format!("{}: {}", self.shared.channel, status.news().without(Status::EMPTY));
            self.shared.inbox.note(|health| match state {
                BusState::Off => {
                    health.error_frames += 1;
                    health.went_away(now, trouble);
                }
                _ => health.trouble = Some(trouble),
            });
        } else if before == BusState::Off {
            self.note_back();
        }
    }

    fn note_back(&self) {
        let now = self.shared.clock.now();
        self.shared.inbox.note(|health| health.came_back(now));
    }

    fn lose(&mut self, reason: &str) {
        self.disconnect();
        self.state = BusState::Active;
        let trouble = format!("{} was disconnected: {reason}", self.shared.channel);
        let now = self.shared.clock.now();
        self.shared.inbox.note(|health| health.went_away(now, trouble));
    }
}
