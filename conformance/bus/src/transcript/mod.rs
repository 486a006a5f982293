//! What a tester saw of a bus beside its frames, so that a run can be judged again from its recording alone.
//!
//! A tester asks a bus for the time, for the next frame and for how well it works. Which frame came is in the recording. This
//! holds the rest: how often there was none before it, what the clock said where that does not follow from the frames, and
//! how well the bus worked. On a simulated bus almost nothing is left to hold.
//!
//! - [`Transcriber`] stands between a tester and a bus and writes it down;
//! - [`Replay`] is the bus of a tester that does the same again.

mod replay;
mod text;
mod transcriber;

pub use replay::{Divergence, Replay};
pub use text::NotATranscript;
pub use transcriber::Transcriber;

use super::Health;
use canvass_traces::{Record, Timestamp};

/// What a tester saw of a bus beside its frames.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Transcript {
    /// Whether time went by on it as it does for people.
    pub is_live: bool,
    /// The bit rate in bit/s at the begin, where it was known.
    pub bit_rate: Option<u32>,
    /// When it began.
    pub begin: Timestamp,
    /// For each frame, how often there was none before it.
    waits: Vec<u64>,
    /// Where the time does not follow from the frames: after how many questions that did, and what it was.
    clock: Vec<(u64, Timestamp)>,
    /// Where the health had changed: after how many questions without change, and what it was.
    health: Vec<(u64, Health)>,
    /// For each change of the bit rate, whether this end of the bus could make it.
    bit_rates: Vec<bool>,
    /// What can't be done again, if something can't.
    trouble: Option<String>,
}

impl Transcript {
    /// Why the run can't be done again: what went wrong on the bus, which no recording holds.
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }
}

/// The time as it follows from what came, on both sides the same.
#[derive(Clone, Copy, Debug)]
struct Clock(Timestamp);

impl Clock {
    /// A frame came, or there was none until the deadline.
    fn advance(&mut self, received: Option<&Record>, deadline: Timestamp) {
        let to = received.map_or(deadline, |record| record.timestamp);
        // A wait without end that ends has no time of its own.
        if to < Timestamp::MAX {
            self.0 = self.0.max(to);
        }
    }
}

#[cfg(test)]
mod tests;
