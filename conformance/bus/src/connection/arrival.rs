//! Times of arrival of frames without a time stamp, on a machine whose processors may be busy.

use crate::Health;
use crate::clock::SteadyClock;
use crate::processor_wait::ProcessorWait;
use canvass_traces::{Duration, Timestamp};

/// Maximum time between two consecutive calls if the thread did not wait between them.
const AT_ONCE: Duration = Duration::from_micros(100);

/// The times at which one reading thread reads.
pub struct Arrivals {
    wait: ProcessorWait,
    /// The wait since the read before.
    away: Duration,
}

/// The arrival of the messages of one read.
#[derive(Clone, Copy)]
pub struct Arrival {
    /// The time at which the read ended.
    pub now: Timestamp,
    late: Late,
}

/// Times for which the reading thread waited for a processor while bytes may have arrived.
#[derive(Clone, Copy)]
struct Late {
    /// The wait from the arrival of bytes until the thread woke.
    waking: Duration,
    /// The wait between two reads, or just after one.
    away: Duration,
}

impl Arrivals {
    pub fn of_this_thread() -> Self {
        Self { wait: ProcessorWait::of_this_thread(), away: Duration::ZERO }
    }

    /// Notes that a read begins.
    pub fn begin(&mut self) {
        self.away = self.wait.since_last();
    }

    /// The arrival of what the read has given.
    pub fn end(&mut self, clock: &SteadyClock) -> Arrival {
        let now = clock.now();
        let waking = self.wait.since_last();
        // A wait between these two lines came after `now`, so it counts as time away from reading.
        let between = clock.now().since(now);
        let away = if between > AT_ONCE { self.away + between } else { self.away };
        Arrival { now, late: Late { waking, away } }
    }
}

impl Arrival {
    /// The arrival time of a message by its position among the messages of one read. The first message woke the thread;
    /// the arrival times of the others are unknown.
    pub fn of(self, at: usize) -> Timestamp {
        if at == 0 { Timestamp(self.now.0.saturating_sub(self.late.waking.0)) } else { self.now }
    }

    /// Counts the remaining uncertainty of arrival times.
    pub fn note(self, messages: usize, health: &mut Health) {
        let Late { waking, away } = self.late;
        let unknown = if messages > 1 { waking } else { Duration::ZERO };
        if messages > 0 && away.max(unknown) > Duration::ZERO {
            health.stamping.add(away.max(unknown));
        }
    }
}
