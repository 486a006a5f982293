//! The clock of live buses: steady as the monotonic clock, counted from 1970 like the kernel's timestamps.

use canvass_traces::{Duration, Timestamp};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// A clock that starts at the system's time and does not jump when the system's clock is set.
#[derive(Clone, Debug)]
pub(super) struct SteadyClock {
    started: Instant,
    epoch: Timestamp,
}

impl SteadyClock {
    pub fn start() -> Self {
        Self { started: Instant::now(), epoch: system_time() }
    }

    pub fn now(&self) -> Timestamp {
        self.at(Instant::now())
    }

    pub fn at(&self, instant: Instant) -> Timestamp {
        self.epoch + duration(instant.saturating_duration_since(self.started))
    }
}

pub(super) fn duration(span: std::time::Duration) -> Duration {
    Duration(u64::try_from(span.as_nanos()).unwrap_or(u64::MAX))
}

/// The time of the system's clock, which can be set.
pub(super) fn system_time() -> Timestamp {
    // A clock before 1970 was never set; time then counts from 1970.
    Timestamp::ZERO + duration(SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_counted_from_the_start() {
        let clock = SteadyClock::start();
        let later = clock.started + std::time::Duration::from_millis(1_500);
        assert_eq!(clock.at(later).since(clock.epoch), Duration::from_millis(1_500));
    }
}
