//! The bit rate of a bus, inferred from frames that follow each other without a pause.
//!
//! When several nodes wait for the bus, the next frame begins right after the intermission: the distance of two time
//! stamps is then the length of the second frame in bits, divided by the bit rate. Such pairs agree on one of the
//! usual bit rates; all other pairs are further apart and agree on none.

use super::peak::Peak;
use canvass_traces::{Duration, Timestamp};

/// The usual bit rates of CANopen buses in bit/s, the fastest first.
pub const RATES: [u32; 9] = [1_000_000, 800_000, 500_000, 250_000, 125_000, 100_000, 50_000, 20_000, 10_000];

/// The duration of a bit at each rate of [`RATES`], in nanoseconds.
const BIT_TIMES: [u64; RATES.len()] = [1_000, 1_250, 2_000, 4_000, 8_000, 10_000, 20_000, 50_000, 100_000];

/// The borders between the durations in [`BIT_TIMES`], in nanoseconds.
const BETWEEN: [u32; RATES.len() - 1] = [1_120, 1_600, 3_000, 6_000, 9_000, 15_000, 35_000, 75_000];

/// Infers the bit rate.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct BitRate {
    last: Option<Timestamp>,
    votes: [u32; RATES.len()],
    /// The rate with the latest vote.
    guess: usize,
    /// For each rate, the number of pairs that were closer than the rate allows, while the rate was the guess.
    too_close: [u32; RATES.len()],
}

impl BitRate {
    /// Least number of agreeing pairs.
    const ENOUGH: u32 = 20;
    /// The best rate needs this many times more votes than any other.
    const CLEAR: u32 = 4;
    /// A rate is rejected if one pair in this number contradicts it by being too close: a master that always leaves
    /// the same pause looks like a slow bus.
    const CONTRADICTED: u32 = 20;

    /// Handles a frame with its length in bits, intermission included.
    #[inline]
    pub fn frame(&mut self, now: Timestamp, bits: u32) {
        let Some(last) = self.last.replace(now) else { return };
        let elapsed = now.since(last).nanos();
        // At the usual rates a frame of 44 to 160 bits takes a time within these limits.
        if bits == 0 || !(40_000..=20_000_000).contains(&elapsed) {
            return;
        }
        if !fits(self.guess, bits, elapsed) {
            // A clear margin, because the clocks of interfaces jitter.
            let closer = elapsed < u64::from(bits) * BIT_TIMES[self.guess] / 8 * 7;
            self.too_close[self.guess] = self.too_close[self.guess].saturating_add(u32::from(closer));
            let bit_time = elapsed as u32 / bits;
            // The only possible rate: the tolerance is far smaller than the distance between rates.
            let nearest = BETWEEN.iter().map(|between| usize::from(bit_time > *between)).sum();
            if !fits(nearest, bits, elapsed) {
                return;
            }
            self.guess = nearest;
        }
        self.votes[self.guess] = self.votes[self.guess].saturating_add(1);
    }

    /// Tells that the next frame does not directly follow the last one.
    pub const fn pause(&mut self) {
        self.last = None;
    }

    /// The bit rate, if enough frames agree and the times are fine enough. `slack` is the error of the times, and
    /// `fullest` is the highest number of bits within [`Peak::WINDOW`]. If the rate with the most votes has no room for
    /// `fullest` bits, returns the next higher rate that has.
    pub fn inferred(&self, slack: Duration, fullest: u64) -> Option<u32> {
        const FINE: Duration = Duration::from_micros(20);
        if slack >= FINE {
            return None;
        }
        let contradicted = |at: usize| self.too_close[at] > self.votes[at] / Self::CONTRADICTED;
        let possible = std::array::from_fn(|at| if contradicted(at) { 0 } else { self.votes[at] });
        let best = elected(possible).or_else(|| elected(self.votes).filter(|rate| fullest > Peak::most(*rate)))?;
        RATES.into_iter().rev().find(|rate| *rate >= best && fullest <= Peak::most(*rate))
    }
}

/// The bit rate with a clear majority of votes.
fn elected(votes: [u32; RATES.len()]) -> Option<u32> {
    let (best, most) = RATES.into_iter().zip(votes).max_by_key(|row| row.1)?;
    let second = RATES.into_iter().zip(votes).filter(|row| row.0 != best).map(|row| row.1).max().unwrap_or(0);
    (most >= BitRate::ENOUGH && most / BitRate::CLEAR >= second).then_some(best)
}

/// Whether this number of bits takes the time `elapsed`, in nanoseconds, at the rate with this index.
#[inline]
fn fits(rate: usize, bits: u32, elapsed: u64) -> bool {
    let exact = u64::from(bits) * BIT_TIMES[rate];
    exact.abs_diff(elapsed) <= 1_500 + exact / 500
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_without_a_pause_show_the_bit_rate() {
        let mut rate = BitRate::default();
        let mut now = Timestamp(0);
        for n in 0..200_u64 {
            let bits = 60 + (n * 7 % 70) as u32;
            now += Duration(u64::from(bits) * 4_000);
            if n % 3 == 0 {
                now += Duration(1_234_567 + n * 9_871);
            }
            rate.frame(now, bits);
        }
        assert_eq!(rate.inferred(Duration::from_micros(2), 24_000), Some(250_000));
        assert_eq!(rate.inferred(Duration::from_millis(1), 24_000), None, "times are too coarse");
    }

    #[test]
    fn frames_with_pauses_show_none() {
        let mut rate = BitRate::default();
        for n in 0..500_u64 {
            rate.frame(Timestamp(n * 10_000_000 + n * n % 97 * 1000), 111);
        }
        assert_eq!(rate.inferred(Duration::from_micros(2), 0), None);
    }

    #[test]
    fn what_does_not_fit_on_the_bus_shows_a_higher_one() {
        let mut rate = BitRate::default();
        for n in 0..100 {
            // Each frame comes after the same pause, and the distance of the frames happens to be the length of a frame
            // at half the bit rate.
            rate.frame(Timestamp(n * 4_000 * 120), 120);
        }
        let slack = Duration::from_micros(2);
        assert_eq!(rate.inferred(slack, 25_000), Some(250_000));
        assert_eq!(rate.inferred(slack, 25_120), Some(250_000), "a frame has begun before the window");
        assert_eq!(rate.inferred(slack, 26_000), Some(500_000));
        assert_eq!(rate.inferred(slack, 51_000), Some(800_000));
        assert_eq!(rate.inferred(slack, 110_000), None, "no bus carries that");
    }

    #[test]
    fn a_constant_pause_is_no_slow_bus() {
        let mut rate = BitRate::default();
        let mut now = Timestamp(0);
        // Two frames at 250 kbit/s, and then a third frame that comes when it would come at 50 kbit/s, again and again.
        for n in 0..200_u64 {
            now += Duration(9_000_000 + n * n % 97 * 10_000);
            rate.frame(now, 111);
            now += Duration(111 * 20_000);
            rate.frame(now, 111);
            now += Duration(80 * if n % 9 == 0 { 4_000 } else { 9_300 });
            rate.frame(now, 80);
        }
        assert_eq!(rate.inferred(Duration::from_micros(2), 24_000), Some(250_000));
    }

    #[test]
    fn each_rate_votes_for_itself() {
        for (at, bit_time) in BIT_TIMES.into_iter().enumerate() {
            for bits in [47_u64, 111, 163] {
                let mut rate = BitRate::default();
                for n in 0..=20 {
                    rate.frame(Timestamp(1 + n * (bits * bit_time + 1_400)), bits as u32);
                }
                assert_eq!(rate.inferred(Duration::ZERO, 0), Some(RATES[at]), "{bits} bits of {bit_time} ns");
            }
        }
    }
}
