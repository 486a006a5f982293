//! Messages that TPDOs may follow: SYNC and RPDOs.

use canvass_traces::{Duration, Timestamp};

/// The times of messages of one kind.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beats {
    last: Option<Timestamp>,
    count: u32,
    interval: Duration,
    /// Begin and end of the last long pause.
    pause: Option<(Timestamp, Timestamp)>,
}

/// The messages whose pauses may explain the silence of a node's TPDOs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reasons {
    /// SYNC.
    pub sync: Beats,
    /// The RPDOs to the node.
    pub received: Beats,
}

impl Beats {
    /// An interval is a pause if it is longer than this time, and longer than four times the interval before it.
    const PAUSE: Duration = Duration::from_secs(1);

    /// Handles a message.
    pub(super) fn beat(&mut self, now: Timestamp) {
        self.count = self.count.saturating_add(1);
        let Some(last) = self.last.replace(now) else { return };
        let interval = now.since(last);
        if interval > Self::PAUSE && interval > self.interval.times(4) {
            self.pause = Some((last, now));
        }
        self.interval = interval;
    }

    /// Number of messages so far.
    pub(super) const fn count(&self) -> u32 {
        self.count
    }

    /// Whether the messages had a pause from `since` to `until`, or stopped at `since` and had not come again for most
    /// of this time. The times may differ by `margin`.
    fn explains(&self, since: Timestamp, until: Timestamp, margin: Duration) -> bool {
        let near = |a: Timestamp, b: Timestamp| a.since(b).max(b.since(a)) <= margin;
        let is_silent = |last: Timestamp| near(last, since) && until.since(last).times(2) > until.since(since);
        let paused = self.pause.is_some_and(|(begin, end)| near(begin, since) && near(end, until));
        paused || self.last.is_some_and(is_silent)
    }
}

impl Reasons {
    /// Whether SYNC was silent from `since` to `until` too, or RPDOs of which many had come before.
    pub fn explain(&self, since: Timestamp, until: Timestamp, margin: Duration) -> bool {
        const OFTEN: u32 = 20;
        let received = self.received.count >= OFTEN && self.received.explains(since, until, margin);
        received || self.sync.explains(since, until, margin)
    }
}
