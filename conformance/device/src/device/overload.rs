//! Faults of an overloaded firmware: a watchdog that resets the device under load, and leaked memory.

use crate::{Fault, Firmware};
use canvass_traces::{Duration, Timestamp};

/// Counts the frames that the device has to handle.
#[derive(Clone, Debug)]
pub(super) struct Overload {
    /// Begin of the period in which frames are counted.
    since: Timestamp,
    frames: u32,
}

/// Number of SDO requests since power-on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Requests(u32);

/// Maximum number of frames within [`WINDOW`] that leave the main loop enough time to feed the watchdog.
const MOST_FRAMES: u32 = 80;
const WINDOW: Duration = Duration::from_millis(100);
/// Number of requests after which the simulated heap is exhausted; each request leaks one block.
const MOST_REQUESTS: u32 = 500;

impl Overload {
    /// The state at power-on.
    pub const fn new() -> Self {
        Self { since: Timestamp::ZERO, frames: 0 }
    }

    /// Counts a frame for the device; returns whether the watchdog resets the device.
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
    /// The state at power-on.
    pub const fn new() -> Self {
        Self(0)
    }

    /// Counts a request; returns whether memory is left for it.
    pub fn count(&mut self, firmware: &Firmware) -> bool {
        self.0 = self.0.saturating_add(1);
        !firmware.has(Fault::SdoMemoryLeak) || self.0 <= MOST_REQUESTS
    }
}
