//! Converts times of the controller's own clock to the system's clock.

use canvass_traces::Timestamp;

/// Learns the difference between a controller's clock and the system's. A frame reaches the kernel some time after its
/// end on the bus, never before; so the smallest difference that was seen is the best estimate.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HardwareClock {
    best: Option<Best>,
}

#[derive(Clone, Copy, Debug)]
struct Best {
    /// System time minus hardware time, in nanoseconds.
    difference: i128,
    /// The hardware time of the frame with this difference.
    at: Timestamp,
}

/// Maximum drift between quartzes in parts per million, by which the difference may have grown.
const DRIFT_PPM: i128 = 100;

/// Limit of a change of the difference, in nanoseconds: a larger change means a reset clock, or another adapter.
const JUMP: i128 = 1_000_000_000;

impl HardwareClock {
    /// The system time at which the hardware received the frame; the kernel received it at `software`.
    pub fn system_time(&mut self, hardware: Timestamp, software: Timestamp) -> Timestamp {
        let seen = i128::from(software.0) - i128::from(hardware.0);
        let difference = match self.best {
            Some(best) if hardware >= best.at && (seen - best.difference).abs() < JUMP => {
                let grown = i128::from(hardware.since(best.at).0) * DRIFT_PPM / 1_000_000;
                seen.min(best.difference + grown)
            }
            _ => seen,
        };
        self.best = Some(Best { difference, at: hardware });
        let time = i128::from(hardware.0) + difference;
        // The frame was on the bus before the kernel received it.
        Timestamp(u64::try_from(time).unwrap_or(0)).min(software)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR: u64 = 3_600_000_000_000;

    /// The hardware receives a frame every millisecond, and the kernel gets it with a delay of up to 300 µs.
    #[test]
    fn delays_of_the_kernel_do_not_show() {
        let mut clock = HardwareClock::default();
        let times: Vec<u64> = (0..1_000_u64)
            .map(|n| {
                let (hardware, delay) = (n * 1_000_000, 20_000 + (n * 7919 % 100) * 3_000);
                clock.system_time(Timestamp(hardware), Timestamp(HOUR + hardware + delay)).0
            })
            .collect();
        let periods: Vec<u64> = times[200..].windows(2).map(|pair| pair[1] - pair[0]).collect();
        let worst = periods.iter().map(|period| period.abs_diff(1_000_000)).max();
        assert!(worst.is_some_and(|worst| worst < 10_000), "{worst:?} ns");
    }

    #[test]
    fn a_clock_that_runs_off_or_is_reset_is_followed() {
        let mut clock = HardwareClock::default();
        for n in 0..10_000_u64 {
            // The hardware's clock is 50 ppm slow: the difference grows by 50 ns each millisecond.
            let (hardware, system) = (n * 1_000_000, HOUR + n * 1_000_050 + 20_000);
            let time = clock.system_time(Timestamp(hardware), Timestamp(system));
            assert!(Timestamp(system).since(time).0 < 1_000, "{n}");
        }
        let after_reset = clock.system_time(Timestamp(5), Timestamp(2 * HOUR));
        assert_eq!(after_reset, Timestamp(2 * HOUR));
    }
}
