//! A histogram of times, rounded to three digits: quantiles of any number of values in constant memory, exact in
//! the displayed digits.
//!
//! ```text
//! 1 to 999 ns as they are; then 900 buckets from each power of ten to the next: 1.00 to 9.99 µs, 10.0 to 99.9 µs, ...
//! ```

use crate::room::Room;
use canvass_traces::Duration;

/// Number of buckets per decade: the digits from 100 to 999.
const BUCKETS: usize = 900;
/// Maximum number of digits after the first three.
const DECADES: usize = 18;

/// The number of occurrences of each time.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Histogram {
    /// Times below 100 ns, then the decades; each is allocated at its first use.
    short: Vec<u32>,
    decades: [Vec<u32>; DECADES],
    count: u64,
    /// Number of times whose decade had no room.
    unplaced: u64,
    max: Duration,
    min: Option<Duration>,
}

impl Histogram {
    /// Counts a time; a decade takes its memory from `room`.
    pub(super) fn add(&mut self, time: Duration, room: &Room) {
        let (decade, digits) = rounded(time.nanos());
        let (row, at, length) = match digits.checked_sub(100) {
            Some(at) => (self.decades.get_mut(decade), at, BUCKETS),
            None => (Some(&mut self.short), digits, 100),
        };
        if let Some(row) = row {
            if row.is_empty() && room.take(length * size_of::<u32>()) {
                row.resize(length, 0);
            }
            match row.get_mut(at) {
                Some(bucket) => *bucket = bucket.saturating_add(1),
                None => self.unplaced += 1,
            }
        }
        self.count += 1;
        self.max = self.max.max(time);
        self.min = Some(self.min.map_or(time, |min| min.min(time)));
    }

    /// Number of times.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The longest time; `None` if there is none.
    pub fn max(&self) -> Option<Duration> {
        (self.count > 0).then_some(self.max)
    }

    /// The shortest time; `None` if there is none.
    pub const fn min(&self) -> Option<Duration> {
        self.min
    }

    /// The time that `percent` of all times do not exceed, rounded to three digits; `None` if there is none, or room
    /// was missing.
    pub fn quantile(&self, percent: u64) -> Option<Duration> {
        if self.unplaced > 0 {
            return None;
        }
        let wanted = (self.count * percent.min(100)).div_ceil(100).max(1);
        let mut seen = 0;
        let mut rows = self.rows();
        let found = rows.find(|(_, count)| {
            seen += u64::from(*count);
            seen >= wanted
        });
        found.map(|(time, _)| time).or(self.max())
    }

    /// The times rounded to three digits, with the number of each.
    pub fn rows(&self) -> impl Iterator<Item = (Duration, u32)> {
        let short = self.short.iter().enumerate().map(|(nanos, count)| (Duration(nanos as u64), *count));
        let long = (0_u32..).zip(&self.decades).flat_map(|(decade, row)| {
            let unit = 10_u64.saturating_pow(decade);
            (100_u64..).zip(row).map(move |(digits, count)| (Duration(digits.saturating_mul(unit)), *count))
        });
        short.chain(long).filter(|(_, count)| *count > 0)
    }
}

/// The first three digits of a number, rounded, and the number of digits after them.
fn rounded(nanos: u64) -> (usize, usize) {
    let decade = nanos.checked_ilog10().unwrap_or(0).saturating_sub(2);
    let unit = 10_u64.pow(decade);
    let digits = nanos / unit + u64::from(nanos % unit >= unit.div_ceil(2) && unit > 1);
    // 999.5 rounds to 1000, the first bucket of the next decade.
    if digits < 1000 { (decade as usize, digits as usize) } else { (decade as usize + 1, 100) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn quantiles() {
        let mut histogram = Histogram::default();
        assert_eq!((histogram.quantile(50), histogram.max(), histogram.min()), (None, None, None));
        for ms in 1..=100 {
            histogram.add(Duration(ms * 1_000_000 + 1_234), &Room::new(1 << 20));
        }
        // 1.00 to 100 ms, to three digits.
        let of = |percent| histogram.quantile(percent).unwrap();
        assert_eq!((of(50), of(95), of(99)), (Duration(50_000_000), Duration(95_000_000), Duration(99_000_000)));
        assert_eq!(of(100), Duration(100_000_000));
        assert_eq!(histogram.max(), Some(Duration(100_001_234)));
        assert_eq!(histogram.rows().map(|row| u64::from(row.1)).sum::<u64>(), 100);
    }

    /// Quantiles of only a part of the times would be wrong.
    #[test]
    fn without_room_there_are_no_quantiles() {
        let (mut histogram, room) = (Histogram::default(), Room::new(4_000));
        histogram.add(Duration(1_500_000), &room);
        assert_eq!(histogram.quantile(50), Some(Duration(1_500_000)));
        histogram.add(Duration(15_000_000), &room);
        assert_eq!((histogram.quantile(50), histogram.count()), (None, 2));
        assert_eq!(histogram.max(), Some(Duration(15_000_000)));
    }

    #[test]
    fn three_digits() {
        assert_eq!((rounded(0), rounded(7), rounded(99), rounded(100)), ((0, 0), (0, 7), (0, 99), (0, 100)));
        assert_eq!((rounded(999), rounded(1_004), rounded(1_005)), ((0, 999), (1, 100), (1, 101)));
        assert_eq!((rounded(9_994), rounded(9_995), rounded(884_499)), ((1, 999), (2, 100), (3, 884)));
        assert!(rounded(u64::MAX).0 < DECADES);
    }

    proptest! {
        /// The quantile is that of the sorted times, rounded.
        #[test]
        fn quantiles_are_exact_to_three_digits(times in proptest::collection::vec(any::<u32>(), 1..200), percent in 1..100_u64) {
            let mut histogram = Histogram::default();
            times.iter().for_each(|&nanos| histogram.add(Duration(u64::from(nanos)), &Room::new(1 << 20)));
            let mut sorted = times;
            sorted.sort_unstable();
            let at = (sorted.len() as u64 * percent).div_ceil(100).max(1) - 1;
            let (decade, digits) = rounded(u64::from(sorted[at as usize]));
            prop_assert_eq!(histogram.quantile(percent), Some(Duration(digits as u64 * 10_u64.pow(decade as u32))));
        }
    }
}
