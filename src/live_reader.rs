//! A live bus as a capture without end, so that commands for captures work on buses.

use crate::interrupt::Interrupt;
use crate::live::{channel_name, time_base};
use crate::output::{Output, diagnostic};
use canvass_bus::{Bus, Health, Interruptions};
use canvass_traces::{
    Capture, Channels, Damage, DamageKind, Duration, Format, Place, Reader, Record, TimeBase, Timestamp,
};
use std::sync::{Arc, Mutex, PoisonError};

/// Reads a bus until its end or Ctrl-C; `output` is flushed before each wait.
pub struct LiveReader {
    bus: Box<dyn Bus + Send>,
    channels: Channels,
    end: Timestamp,
    output: Output,
    interrupt: Interrupt,
    /// The health of the bus at the last check for losses.
    health: Health,
    looked: Timestamp,
    /// Number of records since the last look at the clock.
    read: u32,
    interruptions: Interrupted,
    state: ReaderState,
}

/// The interruptions of a bus, known after its reader has ended.
#[derive(Clone, Default)]
pub struct Interrupted(Arc<Mutex<Option<Interruptions>>>);

impl Interrupted {
    /// The interruptions; `None` if there were none, or the reader has not ended.
    pub fn take(&self) -> Option<Interruptions> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn set(&self, interruptions: Option<Interruptions>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = interruptions;
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ReaderState {
    Reading,
    /// Reading has ended; the last losses are still to be reported.
    Ending,
    Ended,
}

/// Interval between two checks for Ctrl-C while no frame comes.
const LOOK: Duration = Duration::from_millis(50);

/// Interval between two checks for losses while frames come without a pause; each check that finds losses prints one
/// line.
const LOSSES: Duration = Duration::from_millis(250);

/// Number of records between two looks at the clock: one look costs more than a record.
const CLOCK: u32 = 64;

impl LiveReader {
    pub fn new(
        address: &str,
        bus: Box<dyn Bus + Send>,
        span: Option<Duration>,
        output: &Output,
        interrupt: &Interrupt,
    ) -> Self {
        let (now, health) = (bus.now(), bus.health());
        let mut channels = Channels::new();
        channels.intern(channel_name(address));
        Self {
            bus,
            channels,
            end: span.map_or(Timestamp::MAX, |span| now + span),
            output: output.clone(),
            interrupt: interrupt.clone(),
            health,
            looked: now,
            read: 0,
            interruptions: Interrupted::default(),
            state: ReaderState::Reading,
        }
    }

    /// The interruptions, for use after the reader has ended.
    pub fn interruptions(&self) -> Interrupted {
        self.interruptions.clone()
    }

    /// Makes a capture named after the bus.
    pub fn capture(self, address: &str) -> Capture {
        // The source text of a frame is the line that candump would have logged, as no file holds the frame.
        Capture::from_reader(address, Format::Candump, Box::new(self))
    }

    /// The frames lost since the last check, as damage.
    fn losses(&mut self) -> Option<Damage> {
        let health = self.bus.health();
        let since = health.since(&self.health);
        (self.health, self.read, self.looked) = (health, 0, self.bus.now());
        if let Some(trouble) = since.trouble {
            diagnostic(&format!("canvass: {trouble}"));
        }
        lost(since.lost)
    }

    /// The losses while frames come without a pause; `None` if the last check was less than [`LOSSES`] ago.
    fn losses_meanwhile(&mut self) -> Option<Damage> {
        self.read += 1;
        if !self.read.is_multiple_of(CLOCK) || self.bus.now().since(self.looked) < LOSSES {
            return None;
        }
        self.losses()
    }

    /// The losses up to the end. After Ctrl-C they include frames that were received and not yet printed: the user
    /// does not want to wait for them.
    fn last_losses(&mut self) -> Option<Damage> {
        self.state = ReaderState::Ended;
        let waiting = if self.interrupt.came() { self.count_waiting() } else { 0 };
        let health = self.bus.health();
        self.interruptions.set(health.interruptions(self.bus.now()));
        lost(health.since(&self.health).lost + waiting)
    }

    fn count_waiting(&mut self) -> u64 {
        let (now, mut waiting) = (self.bus.now(), 0);
        while matches!(self.bus.receive(now), Ok(Some(record)) if record.timestamp <= now) {
            waiting += 1;
        }
        waiting
    }

    fn fail(&mut self, reason: &str) -> Damage {
        self.state = ReaderState::Ended;
        Damage::new(DamageKind::Fatal, Place::default(), "a working bus", reason.as_bytes())
    }

    /// The next record while the bus is read; `None` at its end.
    fn read(&mut self) -> Option<Result<Record, Damage>> {
        if let Some(damage) = self.losses_meanwhile() {
            return Some(Err(damage));
        }
        let mut waiting = false;
        while !self.interrupt.came() {
            let now = self.bus.now();
            let deadline = if waiting { self.end.min(now + LOOK) } else { now };
            match self.bus.receive(deadline) {
                Ok(Some(record)) if record.timestamp <= self.end => return Some(Ok(record)),
                Ok(Some(_)) => return None,
                Ok(None) => {}
                Err(error) => return Some(Err(self.fail(&error.to_string()))),
            }
            if let Some(damage) = self.losses() {
                return Some(Err(damage));
            }
            if self.bus.now() >= self.end {
                return None;
            }
            if !waiting && let Err(error) = self.output.flush() {
                return Some(Err(self.fail(&error.to_string())));
            }
            waiting = true;
        }
        None
    }
}

fn lost(frames: u64) -> Option<Damage> {
    (frames > 0).then(|| Damage::new(DamageKind::Dropped(frames), Place::default(), "all frames", b""))
}

impl Iterator for LiveReader {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.state == ReaderState::Reading {
            let next = self.read();
            if next.is_some() {
                return next;
            }
            self.state = ReaderState::Ending;
        }
        if self.state == ReaderState::Ending { self.last_losses().map(Err) } else { None }
    }
}

impl Reader for LiveReader {
    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn time_base(&self) -> TimeBase {
        time_base(self.bus.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_bus::BusError;
    use canvass_traces::{CanId, ChannelId, Frame};

    /// A bus that never falls silent: it has a frame each millisecond and loses every second frame.
    struct Flood {
        milliseconds: u64,
        waiting: u64,
    }

    impl Bus for Flood {
        fn now(&self) -> Timestamp {
            Timestamp(self.milliseconds * 1_000_000)
        }

        fn send(&mut self, _: &Frame) -> Result<(), BusError> {
            Ok(())
        }

        fn receive(&mut self, _: Timestamp) -> Result<Option<Record>, BusError> {
            if self.waiting == 0 {
                return Ok(None);
            }
            self.waiting -= 1;
            self.milliseconds += 1;
            let frame = Frame::full(CanId::standard_masked(1), [0; 8]);
            Ok(Some(Record::new(Timestamp(self.milliseconds), ChannelId(0), frame)))
        }

        fn bit_rate(&self) -> Option<u32> {
            None
        }

        fn health(&self) -> Health {
            Health { lost: self.milliseconds / 2, ..Health::default() }
        }
    }

    /// The number of records read, the number of frames reported as lost, and the number of lines that report losses.
    fn read(interrupt_after: Option<usize>, span: Option<Duration>) -> (usize, u64, usize) {
        let interrupt = Interrupt::default();
        let bus = Box::new(Flood { milliseconds: 0, waiting: 10_000 });
        let mut reader = LiveReader::new("can0", bus, span, &Output::text(false), &interrupt);
        let (mut records, mut lost, mut told) = (0, 0, 0);
        for item in reader.by_ref() {
            match item {
                Ok(_) => records += 1,
                Err(Damage { kind: DamageKind::Dropped(frames), .. }) => (lost, told) = (lost + frames, told + 1),
                Err(damage) => panic!("{damage}"),
            }
            if interrupt_after.is_some_and(|after| records == after) {
                interrupt.request();
            }
        }
        assert!(reader.next().is_none());
        (records, lost, told)
    }

    #[test]
    fn losses_are_told_while_frames_come_and_at_the_end() {
        let (records, lost, told) = read(None, Some(Duration::from_secs(9)));
        assert_eq!((records, lost), (10_000, 5_000));
        assert!((20..50).contains(&told), "{told} lines in ten seconds");
    }

    #[test]
    fn what_was_not_shown_before_an_interruption_counts_as_lost() {
        let (records, lost, _) = read(Some(1_001), None);
        assert_eq!((records, lost), (1_001, 5_000 + 8_999), "half of all, and what waited");
    }
}
