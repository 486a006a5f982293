//! A live bus as a capture without end: what is done with captures is done with buses.

use crate::interrupt::Interrupt;
use crate::live::{channel_name, time_base};
use crate::output::{Output, diagnostic};
use canvass_bus::{Bus, Health};
use canvass_traces::{
    Capture, Channels, Damage, DamageKind, Duration, Format, Place, Reader, Record, TimeBase, Timestamp,
};

/// Reads a bus until an end, or until interrupted; `output` is flushed before each wait.
pub struct LiveReader {
    bus: Box<dyn Bus>,
    channels: Channels,
    end: Timestamp,
    output: Output,
    interrupt: Interrupt,
    health: Health,
    failed: bool,
}

/// How often an interruption is looked for while nothing comes.
const LOOK: Duration = Duration::from_millis(50);

impl LiveReader {
    pub fn new(
        address: &str,
        bus: Box<dyn Bus>,
        span: Option<Duration>,
        output: &Output,
        interrupt: &Interrupt,
    ) -> Self {
        let end = span.map_or(Timestamp::MAX, |span| bus.now() + span);
        let mut channels = Channels::new();
        channels.intern(channel_name(address));
        let health = bus.health();
        Self { bus, channels, end, output: output.clone(), interrupt: interrupt.clone(), health, failed: false }
    }

    /// As a capture of that name.
    pub fn capture(self, address: &str) -> Capture {
        // In no file, a frame of a bus is what candump would have logged of it.
        Capture::from_reader(address, Format::Candump, Box::new(self))
    }

    /// What was lost since the last look, as damage.
    fn losses(&mut self) -> Option<Damage> {
        let health = self.bus.health();
        let since = health.since(&self.health);
        self.health = health;
        if let Some(trouble) = since.trouble {
            diagnostic(&format!("canvass: {trouble}"));
        }
        (since.lost > 0).then(|| Damage::new(DamageKind::Dropped(since.lost), Place::default(), "all frames", b""))
    }

    fn fail(&mut self, reason: &str) -> Damage {
        self.failed = true;
        Damage::new(DamageKind::Fatal, Place::default(), "a bus that works", reason.as_bytes())
    }
}

impl Iterator for LiveReader {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut waiting = false;
        while !self.failed && !self.interrupt.came() {
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

impl Reader for LiveReader {
    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn time_base(&self) -> TimeBase {
        time_base(self.bus.as_ref())
    }
}
