//! The fullest window of a part of the traffic.

use super::load::Load;
use canvass_traces::{Duration, Timestamp};

/// The window with the most bits, among consecutive windows.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Peak {
    /// The bits of all ended windows.
    before: u64,
    best: Option<(Timestamp, u64)>,
}

impl Peak {
    /// Length of a window; windows begin at multiples of this length.
    pub const WINDOW: Duration = Duration::from_millis(100);

    /// The begin of the window that contains a time.
    pub const fn begin(now: Timestamp) -> Timestamp {
        Timestamp(now.nanos() / Self::WINDOW.nanos() * Self::WINDOW.nanos())
    }

    /// Ends the window that begins at `begin`; `total` is the number of bits of all windows so far.
    pub fn end(&mut self, begin: Timestamp, total: u64) {
        self.best = self.with(begin, total);
        self.before = total;
    }

    /// The begin of the fullest window and its bits, including the current window; `None` if there was no frame.
    pub const fn with(&self, begin: Timestamp, total: u64) -> Option<(Timestamp, u64)> {
        let bits = total - self.before;
        match self.best {
            Some(best) if best.1 >= bits => Some(best),
            None if bits == 0 => None,
            _ => Some((begin, bits)),
        }
    }

    /// The begin of the fullest ended window and its bits.
    pub const fn best(&self) -> Option<(Timestamp, u64)> {
        self.best
    }

    /// Capacity of a window in bits at a bit rate, including a frame that began before the window.
    pub const fn most(bit_rate: u32) -> u64 {
        const LONGEST_FRAME: u64 = 160;
        Self::WINDOW.nanos() / 1_000 * bit_rate as u64 / 1_000_000 + LONGEST_FRAME
    }

    /// The begin of the fullest window and its load as a percentage of the capacity at this bit rate.
    pub fn percent(&self, bit_rate: u32) -> Option<(Timestamp, f64)> {
        let (at, bits) = self.best()?;
        let percent = Load::percent(bits, Self::WINDOW, bit_rate);
        // If only a frame that began before the window makes the load exceed 100 %, the bus is just full.
        Some((at, if bits <= Self::most(bit_rate) { percent.min(100.0) } else { percent }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fullest_window_is_kept_over_hours() {
        let (mut peak, mut total) = (Peak::default(), 0);
        assert_eq!(peak.with(Timestamp(0), 0), None);
        for second in 0..100_000_u64 {
            total += if second == 77 { 12_500 } else { 100 };
            peak.end(Timestamp(second * 1_000_000_000), total);
        }
        assert_eq!(peak.best(), Some((Timestamp(77_000_000_000), 12_500)));
        let now = Timestamp(100_000_123_456_789);
        assert_eq!(Peak::begin(now), Timestamp(100_000_100_000_000));
        assert_eq!(peak.with(Peak::begin(now), total + 12_500), peak.best(), "the first of several");
        assert_eq!(peak.with(Peak::begin(now), total + 12_501), Some((Peak::begin(now), 12_501)));
        assert_eq!(peak.percent(250_000), Some((Timestamp(77_000_000_000), 50.0)));
        assert_eq!(peak.percent(124_900), Some((Timestamp(77_000_000_000), 100.0)));
        assert_eq!(peak.percent(100_000), Some((Timestamp(77_000_000_000), 125.0)));
    }
}
