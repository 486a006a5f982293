//! Converts the kernel's times to the clock of the bus, which never jumps. The kernel uses the system's clock, which
//! can be set.

use crate::clock::{SteadyClock, system_time};
use canvass_traces::Timestamp;
use std::time::{Duration, Instant};

/// The offset from the system's clock to a [`SteadyClock`], in nanoseconds.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Correction(i64);

/// Minimum change of the offset that counts: a smaller one is the uncertainty of the comparison.
const STEP: u64 = 1_000_000;

/// Maximum duration of a comparison of the clocks: a longer one was interrupted and is not used.
const BRACKET: Duration = Duration::from_micros(100);

impl Correction {
    /// The offset from now on: a new one if the system's clock was set since the last comparison.
    pub(crate) fn looked_up(self, clock: &SteadyClock) -> Self {
        for _ in 0..3 {
            let before = Instant::now();
            let system = system_time();
            if before.elapsed() < BRACKET {
                return self.revised(clock.at(before), system);
            }
        }
        self
    }

    fn revised(self, steady: Timestamp, system: Timestamp) -> Self {
        let difference = (i128::from(steady.0) - i128::from(system.0)) as i64;
        if difference.abs_diff(self.0) > STEP { Self(difference) } else { self }
    }

    /// Converts a time of the system's clock.
    pub fn apply(self, system: Timestamp) -> Timestamp {
        Timestamp(system.0.saturating_add_signed(self.0))
    }
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
}
