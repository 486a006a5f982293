//! The fullest moment of a part of the traffic.

use super::load::Load;
use canvass_traces::{Duration, Timestamp};

/// The window with the most bits, of windows that follow each other.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Peak {
    /// When the window under way began.
    begin: Timestamp,
    bits: u64,
    best: Option<(Timestamp, u64)>,
}

impl Peak {
    /// How long a window is, beginning at times that are multiples of it.
    pub const WINDOW: Duration = Duration::from_millis(100);

    /// Adds the bits of a frame.
    #[inline]
    pub fn add(&mut self, now: Timestamp, bits: u32) {
        if now.since(self.begin) >= Self::WINDOW || now < self.begin {
            self.turn(now);
        }
        self.bits += u64::from(bits);
    }

    fn turn(&mut self, now: Timestamp) {
        self.best = self.best();
        self.begin = Timestamp(now.nanos() / Self::WINDOW.nanos() * Self::WINDOW.nanos());
        self.bits = 0;
    }

    /// The begin of the fullest window and its bits; `None` where there was no frame at all.
    pub fn best(&self) -> Option<(Timestamp, u64)> {
        let fuller = self.best.is_none_or(|best| self.bits > best.1);
        if fuller && self.bits > 0 { Some((self.begin, self.bits)) } else { self.best }
    }

    /// How many bits a window can hold at a bit rate: one frame may have begun before it.
    pub const fn most(bit_rate: u32) -> u64 {
        const LONGEST_FRAME: u64 = 160;
        Self::WINDOW.nanos() / 1_000 * bit_rate as u64 / 1_000_000 + LONGEST_FRAME
    }

    /// The begin of the fullest window and its load in percent of what fits at that bit rate.
    pub fn percent(&self, bit_rate: u32) -> Option<(Timestamp, f64)> {
        let (at, bits) = self.best()?;
        let percent = Load::percent(bits, Self::WINDOW, bit_rate);
        // What is beyond 100 % only because of the frame that has begun before is a full bus.
        Some((at, if bits <= Self::most(bit_rate) { percent.min(100.0) } else { percent }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fullest_window_is_kept_over_hours() {
        let mut peak = Peak::default();
        assert_eq!(peak.best(), None);
        for second in 0..100_000_u64 {
            peak.add(Timestamp(second * 1_000_000_000), 100);
            if second == 77 {
                peak.add(Timestamp(second * 1_000_000_000 + 99_999_999), 12_400);
                peak.add(Timestamp(second * 1_000_000_000 + 100_000_000), 12_400);
            }
        }
        assert_eq!(peak.best(), Some((Timestamp(77_000_000_000), 12_500)));
        assert_eq!(peak.percent(250_000), Some((Timestamp(77_000_000_000), 50.0)));
        assert_eq!(peak.percent(124_900), Some((Timestamp(77_000_000_000), 100.0)));
        assert_eq!(peak.percent(100_000), Some((Timestamp(77_000_000_000), 125.0)));
    }
}
