//! The period of a recurring message: given by a parameter, or learned from the intervals.

use super::percent::Percent;
use canvass_traces::{Duration, Timestamp};

/// Number of intervals that are remembered.
const WINDOW: usize = 8;
/// Number of intervals from which the period counts as learned.
const ENOUGH: usize = 4;

/// Follows a periodic message.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rhythm {
    last: Option<Timestamp>,
    /// Whether the period may restart within the current interval.
    shifted: bool,
    window: [u64; WINDOW],
    filled: usize,
    next: usize,
    told: Option<Duration>,
}

/// The time between two messages.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Interval {
    /// The length of the interval.
    pub length: Duration,
    /// The expected length, if known.
    pub expected: Option<Duration>,
    /// Whether the period may have restarted within the interval, which may then be up to one period longer.
    pub shifted: bool,
}

impl Rhythm {
    /// Sets the period from a parameter; `None` if it is unknown from now on.
    pub const fn tell(&mut self, period: Option<Duration>) {
        self.told = period;
    }

    /// Handles a message; returns the interval that ends with it.
    pub fn beat(&mut self, now: Timestamp) -> Option<Interval> {
        let shifted = std::mem::take(&mut self.shifted);
        let last = self.last.replace(now)?;
        let interval = Interval { length: now.since(last), expected: self.period(), shifted };
        if shifted {
            return Some(interval);
        }
        self.window[self.next] = interval.length.nanos();
        self.next = (self.next + 1) % WINDOW;
        self.filled = (self.filled + 1).min(WINDOW);
        Some(interval)
    }

    /// The period: from the parameter, else learned.
    pub fn period(&self) -> Option<Duration> {
        self.told.or_else(|| self.learned())
    }

    /// The median of the latest intervals, if most of them are near it.
    pub fn learned(&self) -> Option<Duration> {
        if self.filled < ENOUGH {
            return None;
        }
        let mut sorted = self.window;
        sorted[self.filled..].fill(u64::MAX);
        sort(&mut sorted);
        let median = sorted[(self.filled - 1) / 2];
        let near = |length: u64| length.abs_diff(median) <= (median / 4).max(2_000_000);
        let agreeing: usize = sorted[..self.filled].iter().map(|&length| usize::from(near(length))).sum();
        (median > 0 && agreeing * 4 >= self.filled * 3).then_some(Duration(median))
    }

    /// Tells that the period may restart within the current interval.
    pub const fn shift(&mut self) {
        self.shifted = true;
    }

    /// Begins the interval anew, so that the next message ends none: it may be delayed for a known reason, or frames
    /// are missing.
    pub const fn pause(&mut self) {
        self.last = None;
    }

    /// Forgets the learned period.
    pub fn restart(&mut self) {
        *self = Self { told: self.told, ..Self::default() };
    }
}

/// Sorts with Batcher's network, which compares the same places for any values. A processor would often mispredict the
/// branches of another sort, as the intervals are in random order.
fn sort(values: &mut [u64; WINDOW]) {
    let [mut a, mut b, mut c, mut d, mut e, mut f, mut g, mut h] = *values;
    let order = |low: &mut u64, high: &mut u64| (*low, *high) = ((*low).min(*high), (*low).max(*high));
    // Sorts pairs, then groups of four.
    order(&mut a, &mut b);
    order(&mut c, &mut d);
    order(&mut e, &mut f);
    order(&mut g, &mut h);
    order(&mut a, &mut c);
    order(&mut b, &mut d);
    order(&mut e, &mut g);
    order(&mut f, &mut h);
    order(&mut b, &mut c);
    order(&mut f, &mut g);
    // Merges the two groups of four.
    order(&mut a, &mut e);
    order(&mut b, &mut f);
    order(&mut c, &mut g);
    order(&mut d, &mut h);
    order(&mut c, &mut e);
    order(&mut d, &mut f);
    order(&mut b, &mut c);
    order(&mut d, &mut e);
    order(&mut f, &mut g);
    *values = [a, b, c, d, e, f, g, h];
}

impl Interval {
    /// Whether the interval is longer than the share `percent` of the expected length plus `slack`; returns the period.
    pub fn exceeds(self, percent: Percent, slack: Duration) -> Option<Duration> {
        let expected = self.expected?;
        let shift = if self.shifted { expected } else { Duration::ZERO };
        let limit = percent.of(expected) + slack + shift;
        (self.length > limit).then_some(expected)
    }

    /// Whether messages are missing. As [`Interval::exceeds`], but a coarse clock hides at most a tenth of the period,
    /// so that twice the period is always recognised.
    pub fn misses(self, percent: Percent, slack: Duration) -> Option<Duration> {
        let tenth = Duration(self.expected?.nanos() / 10);
        self.exceeds(percent, slack.min(tenth))
    }
}

/// Finds a message that comes beside the regular ones.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Additional {
    /// The last two intervals, the later one last; 0 where there was none.
    before: [u64; 2],
    /// Number of intervals since the last period that was divided.
    since: u8,
}

impl Additional {
    /// Handles an interval. Returns the two parts of a period that an additional message has divided; the period before
    /// was whole, or divided, too. Equal halves show a period that has changed.
    pub fn beat(&mut self, interval: Interval) -> Option<(Duration, Duration)> {
        let [earlier, first] = self.before;
        self.before = [first, interval.length.nanos()];
        self.since = self.since.saturating_add(1);
        let period = interval.expected.filter(|_| !interval.shifted)?.nanos();
        let (second, close) = (interval.length.nanos(), period / 16 + 2_000_000.min(period / 16));
        let is_whole = |length: u64| length.abs_diff(period) <= close;
        let is_divided = first != 0 && is_whole(first + second) && !is_whole(second) && !is_whole(first);
        let is_regular = is_whole(earlier) || self.since == 2;
        if !is_divided || !is_regular || first.abs_diff(second) <= period / 8 {
            return None;
        }
        self.since = 0;
        Some((Duration(first), Duration(second)))
    }

    /// Begins anew: the next message may come at any time.
    pub fn restart(&mut self) {
        *self = Self::default();
    }
}

/// Statistics of early and late messages.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Jitter {
    intervals: u64,
    off: u64,
    /// The largest deviation.
    pub worst: Duration,
    /// Time of the largest deviation.
    pub worst_at: Timestamp,
}

impl Jitter {
    /// Counts an interval. An interval with a missing message is no jitter.
    pub fn count(&mut self, now: Timestamp, interval: Interval, percent: Percent, slack: Duration) {
        let Some(expected) = interval.expected.filter(|_| !interval.shifted) else { return };
        let deviation = interval.length.nanos().abs_diff(expected.nanos());
        if interval.length > expected.times(2) {
            return;
        }
        self.intervals += 1;
        if deviation > (percent.of(expected) + slack).nanos() {
            self.off += 1;
            if deviation > self.worst.nanos() {
                (self.worst, self.worst_at) = (Duration(deviation), now);
            }
        }
    }

    /// Share of deviating intervals, if there are enough for a judgement.
    pub fn share(&self) -> Option<Percent> {
        const ENOUGH: u64 = 20;
        (self.intervals >= ENOUGH).then(|| Percent(self.off * 100 / self.intervals))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sorts_as_the_standard_library(values: [u64; WINDOW]) {
            let (mut ours, mut theirs) = (values, values);
            sort(&mut ours);
            theirs.sort_unstable();
            prop_assert_eq!(ours, theirs);
        }
    }

    /// A network that sorts all sequences of zeros and ones sorts everything (Knuth, 5.3.4, theorem Z).
    #[test]
    fn sorts_all_zeros_and_ones() {
        for bits in 0..1_u32 << WINDOW {
            let mut values = std::array::from_fn(|at| u64::from(bits >> at & 1));
            sort(&mut values);
            assert!(values.is_sorted(), "{bits:b}");
        }
    }

    fn ms(n: u64) -> Timestamp {
        Timestamp(n * 1_000_000)
    }

    #[test]
    fn a_period_is_learned_and_a_pause_does_not_change_it() {
        let mut rhythm = Rhythm::default();
        for n in 0..10 {
            rhythm.beat(ms(n * 100));
        }
        let late = rhythm.beat(ms(1100)).unwrap();
        assert_eq!((late.length, late.expected), (Duration::from_millis(200), Some(Duration::from_millis(100))));
        assert_eq!(late.exceeds(Percent(150), Duration::ZERO), Some(Duration::from_millis(100)));
        assert_eq!(rhythm.period(), Some(Duration::from_millis(100)));
    }

    #[test]
    fn what_has_no_period_has_none() {
        let mut rhythm = Rhythm::default();
        for at in [0, 5, 100, 120, 700, 701, 900, 1500, 1510] {
            rhythm.beat(ms(at));
        }
        assert_eq!(rhythm.period(), None);
    }

    #[test]
    fn a_told_period_is_known_at_once() {
        let mut rhythm = Rhythm::default();
        rhythm.tell(Some(Duration::from_millis(50)));
        rhythm.beat(ms(0));
        assert!(rhythm.beat(ms(51)).unwrap().exceeds(Percent(150), Duration::ZERO).is_none());
        assert!(rhythm.beat(ms(151)).unwrap().exceeds(Percent(150), Duration::ZERO).is_some());
    }
}
