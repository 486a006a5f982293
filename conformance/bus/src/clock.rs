//! The clock of live buses: steady as the monotonic clock, counted from 1970 as the kernel's timestamps are.

use canvass_traces::{Duration, Timestamp};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// A clock that starts at the system's time and does not jump when that is set.
#[derive(Clone, Debug)]
pub(super) struct SteadyClock {
    started: Instant,
    epoch: Timestamp,
}

/// What to add to a time of the system's clock to get one of a [`SteadyClock`], in nanoseconds.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Correction(i64);

/// Below that, a difference of the clocks is the uncertainty of comparing them.
const STEP: u64 = 1_000_000;

/// A comparison of the clocks that took longer than this was interrupted and says little.
const BRACKET: std::time::Duration = std::time::Duration::from_micros(100);

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

    /// Whether the system's clock has been set since the last look; the correction from now on.
    pub fn correction(&self, known: Correction) -> Correction {
        for _ in 0..3 {
            let before = Instant::now();
            let system = system_time();
            if before.elapsed() < BRACKET {
                return known.revised(self.at(before), system);
            }
        }
        known
    }
}

impl Correction {
    fn revised(self, steady: Timestamp, system: Timestamp) -> Self {
        let difference = (i128::from(steady.0) - i128::from(system.0)) as i64;
        if difference.abs_diff(self.0) > STEP { Self(difference) } else { self }
    }

    /// A time of the system's clock as the steady clock counts it.
    pub fn apply(self, system: Timestamp) -> Timestamp {
        Timestamp(system.0.saturating_add_signed(self.0))
    }
}

pub(super) fn duration(span: std::time::Duration) -> Duration {
    Duration(u64::try_from(span.as_nanos()).unwrap_or(u64::MAX))
}

fn system_time() -> Timestamp {
    // Before 1970 the clock was never set: time counts from there.
    Timestamp::ZERO + duration(SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_step_of_the_systems_clock_is_corrected() {
        let at = |ms: u64| Timestamp(1_700_000_000_000_000_000 + ms * 1_000_000);
        let none = Correction::default();
        assert_eq!(none.revised(at(5), Timestamp(at(5).0 + 900_000)), none, "too little to tell from uncertainty");
        let forward = none.revised(at(5), at(3_605_000));
        assert_eq!(forward.apply(at(3_605_000)), at(5), "the clock was set an hour ahead");
        let back = forward.revised(at(6), at(1));
        assert_eq!(back.apply(at(1)), at(6), "and back again");
    }

    #[test]
    fn time_is_counted_from_the_start() {
        let clock = SteadyClock::start();
        let later = clock.started + std::time::Duration::from_millis(1_500);
        assert_eq!(clock.at(later).since(clock.epoch), Duration::from_millis(1_500));
    }
}
