//! What a busy firmware does wrong: a watchdog that resets it under load, and memory that is never given back.

use crate::{Fault, Firmware};
use canvass_traces::{Duration, Timestamp};

/// Counts what the device had to do.
#[derive(Clone, Debug)]
pub(super) struct Overload {
    /// When the count began.
    since: Timestamp,
    frames: u32,
}

/// Counts SDO requests since power-on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Requests(u32);

/// So many frames within [`WINDOW`] are too much for a watchdog that is fed by the main loop.
const MOST_FRAMES: u32 = 80;
const WINDOW: Duration = Duration::from_millis(100);
/// After so many requests a heap that loses a block with each is full.
const MOST_REQUESTS: u32 = 500;

impl Overload {
    /// At power-on.
    pub const fn new() -> Self {
        Self { since: Timestamp::ZERO, frames: 0 }
    }

    /// A frame for the device came; whether the watchdog bites.
    pub fn on_frame(&mut self, now: Timestamp, firmware: &Firmware) -> bool {
        if !firmware.has(Fault::WatchdogResetUnderLoad) {
            return false;
        }
        if now > self.since + WINDOW {
            (self.since, self.frames) = (now, 0);
        }
        self.frames += 1;
        let bites = self.frames > MOST_FRAMES;
        if bites {
            self.frames = 0;
        }
        bites
    }
}

impl Requests {
    /// At power-on.
    pub const fn new() -> Self {
        Self(0)
    }

    /// A request came; whether there is memory left for it.
    pub fn count(&mut self, firmware: &Firmware) -> bool {
        self.0 = self.0.saturating_add(1);
        !firmware.has(Fault::SdoMemoryLeak) || self.0 <= MOST_REQUESTS
    }
}
