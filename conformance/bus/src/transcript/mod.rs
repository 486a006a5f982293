//! A tester's view of a bus in addition to its frames; with it, a run can be judged again from its recording alone.
//!
//! A tester asks a bus for the time, the next frame and the health. The recording has the frames. The transcript has
//! the rest: the number of timeouts before each frame, times that do not follow from the frames, and the health. On a
//! simulated bus, almost nothing remains for the transcript.
//!
//! - [`Transcriber`] is between a tester and a bus, and writes the transcript;
//! - [`Replay`] is the bus for a tester that repeats the run.

mod replay;
mod text;
mod transcriber;

pub use replay::{Divergence, Replay};
pub use text::NotATranscript;
pub use transcriber::Transcriber;

use super::Health;
use canvass_traces::{Record, Timestamp};

/// A tester's view of a bus, except its frames.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Transcript {
    /// Whether the time of the bus was real.
    pub is_live: bool,
    /// The bit rate in bit/s at the begin, if known.
    pub bit_rate: Option<u32>,
    /// Time of the begin.
    pub begin: Timestamp,
    /// For each frame, the number of timeouts before it.
    waits: Vec<u64>,
    /// The answers about the time that do not follow from the frames, each with the number of predictable answers
    /// before it.
    clock: Vec<(u64, Timestamp)>,
    /// Changes of the health, each with the number of unchanged answers before it.
    health: Vec<(u64, Health)>,
    /// For each change of the bit rate, whether it succeeded.
    bit_rates: Vec<bool>,
    /// An event that can't be repeated, if there was one.
    trouble: Option<String>,
}

impl Transcript {
    /// Why the run can't be repeated: an error of the bus, which the recording does not contain.
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }
}

/// The time that follows from the frames; recording and replay compute it in the same way.
#[derive(Clone, Copy, Debug)]
struct Clock(Timestamp);

impl Clock {
    /// Handles a frame, or a timeout at the deadline.
    fn advance(&mut self, received: Option<&Record>, deadline: Timestamp) {
        let to = received.map_or(deadline, |record| record.timestamp);
        // A wait without deadline may still end; it then gives no time.
        if to < Timestamp::MAX {
            self.0 = self.0.max(to);
        }
    }
}

#[cfg(test)]
mod tests;
