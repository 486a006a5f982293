//! The bit rate of a bus, inferred from frames that follow each other without a pause.
//!
//! When several nodes wait for the bus, the next frame begins right behind the intermission: the distance of two time
//! stamps is then the number of bits of the second frame, taken at the bit rate. Such pairs agree on one of the usual
//! bit rates; all other pairs are further apart and agree on nothing.

use canvass_traces::{Duration, Timestamp};

/// The bit rates that CANopen buses have, in bit/s.
const RATES: [u32; 9] = [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

/// Infers the bit rate.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct BitRate {
    last: Option<Timestamp>,
    votes: [u32; RATES.len()],
}

impl BitRate {
    /// So many pairs of frames must agree.
    const ENOUGH: u32 = 20;
    /// And so many times more than on any other bit rate.
    const CLEAR: u32 = 4;

    /// Takes a frame with its bits, intermission included.
    pub fn frame(&mut self, now: Timestamp, bits: u32) {
        let Some(last) = self.last.replace(now) else { return };
        let elapsed = now.since(last).nanos();
        // No frame of 44 to 160 bits takes less or more at these rates.
        if !(40_000..=20_000_000).contains(&elapsed) {
            return;
        }
        for (rate, votes) in RATES.iter().zip(&mut self.votes) {
            let exact = u64::from(bits) * 1_000_000_000 / u64::from(*rate);
            if exact.abs_diff(elapsed) <= 1_500 + exact / 500 {
                *votes = votes.saturating_add(1);
            }
        }
    }

    /// The next frame does not follow the last one.
    pub const fn pause(&mut self) {
        self.last = None;
    }

    /// The bit rate, if enough frames agree and times are fine enough: `slack` is how far they may be off.
    pub fn inferred(&self, slack: Duration) -> Option<u32> {
        const FINE: Duration = Duration::from_micros(20);
        let (best, votes) = RATES.iter().zip(self.votes).max_by_key(|row| row.1)?;
        let second = RATES.iter().zip(self.votes).filter(|row| row.0 != best).map(|row| row.1).max().unwrap_or(0);
        let clear = votes >= Self::ENOUGH && votes / Self::CLEAR >= second;
        (slack < FINE && clear).then_some(*best)
    }
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
        assert_eq!(rate.inferred(Duration::from_micros(2)), Some(250_000));
        assert_eq!(rate.inferred(Duration::from_millis(1)), None, "times are too coarse");
    }

    #[test]
    fn frames_with_pauses_show_none() {
        let mut rate = BitRate::default();
        for n in 0..500_u64 {
            rate.frame(Timestamp(n * 10_000_000 + n * n % 97 * 1000), 111);
        }
        assert_eq!(rate.inferred(Duration::from_micros(2)), None);
    }
}
