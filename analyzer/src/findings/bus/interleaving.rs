//! Detection of two senders with the same period on one CAN-ID: the intervals between their messages alternate.

use canvass_traces::{Duration, Timestamp};

/// Detects intervals that alternate between a long and a short one with a constant sum.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Interleaving {
    last: Option<Timestamp>,
    /// The last two intervals, the later one last.
    before: [u64; 2],
    alternations: u32,
}

impl Interleaving {
    /// Number of consecutive alternations that prove two senders.
    const ENOUGH: u32 = 8;
    /// If the shorter interval is more than this percentage of the sum, one sender with a coarse tick may cause it.
    const ALIASED: u64 = 38;

    /// Handles a message. Returns the two intervals once they have alternated often enough to prove two senders.
    pub fn beat(&mut self, now: Timestamp, slack: Duration) -> Option<(Duration, Duration)> {
        let length = now.since(self.last.replace(now)?).nanos();
        let [earlier, previous] = self.before;
        self.before = [previous, length];
        let period = length + previous;
        // Jitter must neither look like an alternation nor hide one.
        let close = (period / 50).max(1_000_000) + slack.nanos();
        let apart = (period / 8).max(3 * close);
        // A sender whose clock ticks every 20 ms sends every 40 and 60 ms instead of every 50.
        let ticks = length.min(previous) * 100 > period * Self::ALIASED;
        let alternates =
            !ticks && earlier > 0 && length.abs_diff(earlier) <= close && length.abs_diff(previous) >= apart;
        self.alternations = if alternates { self.alternations + 1 } else { 0 };
        (self.alternations >= Self::ENOUGH).then_some((Duration(previous), Duration(length)))
    }

    /// Resets the detection.
    pub fn restart(&mut self) {
        *self = Self::default();
    }
}
