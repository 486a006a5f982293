//! Times in buckets whose widths grow with the times: quantiles of any number of values in constant memory.
//!
//! ```text
//! each power of two of nanoseconds has 16 buckets of equal width: a quantile is off by at most 1/16
//! ```

use canvass_traces::Duration;

/// Buckets in each power of two, as a power of two.
const SUB_BITS: u32 = 4;
const SUB: u64 = 1 << SUB_BITS;
const BUCKETS: usize = ((64 - SUB_BITS as usize) + 1) << SUB_BITS;

/// How often which times occurred.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Histogram {
    buckets: Box<[u32]>,
    count: u64,
    max: Duration,
    min: Duration,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { buckets: vec![0; BUCKETS].into(), count: 0, max: Duration::ZERO, min: Duration(u64::MAX) }
    }
}

impl Histogram {
    /// Counts a time.
    pub fn add(&mut self, time: Duration) {
        let bucket = &mut self.buckets[bucket(time.nanos())];
        *bucket = bucket.saturating_add(1);
        self.count += 1;
        self.max = self.max.max(time);
        self.min = self.min.min(time);
    }

    /// How many times were counted.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The longest; `None` of none.
    pub fn max(&self) -> Option<Duration> {
        (self.count > 0).then_some(self.max)
    }

    /// The shortest; `None` of none.
    pub fn min(&self) -> Option<Duration> {
        (self.count > 0).then_some(self.min)
    }

    /// The time that `percent` of all do not exceed, to within 1/16; `None` of none.
    pub fn quantile(&self, percent: u64) -> Option<Duration> {
        let wanted = (self.count * percent.min(100)).div_ceil(100).max(1);
        let mut seen = 0;
        for (at, &count) in self.buckets.iter().enumerate() {
            seen += u64::from(count);
            if seen >= wanted && self.count > 0 {
                return Some(Duration(upper_bound(at)).min(self.max));
            }
        }
        self.max()
    }

    /// The buckets that are not empty: the longest time of each, and how many.
    pub fn rows(&self) -> impl Iterator<Item = (Duration, u32)> {
        let filled = self.buckets.iter().enumerate().filter(|(_, count)| **count > 0);
        filled.map(|(at, &count)| (Duration(upper_bound(at)), count))
    }
}

fn bucket(nanos: u64) -> usize {
    if nanos < SUB {
        return nanos as usize;
    }
    let shift = 63 - nanos.leading_zeros() - SUB_BITS;
    // The leading bit and the four behind it.
    (u64::from(shift + 1) * SUB + (nanos >> shift) - SUB) as usize
}

/// The largest time in a bucket.
fn upper_bound(bucket: usize) -> u64 {
    let (octave, within) = (bucket as u64 / SUB, bucket as u64 % SUB);
    match octave.checked_sub(1) {
        None => within,
        Some(shift) => (u128::from(SUB + within + 1) << shift).saturating_sub(1).min(u128::from(u64::MAX)) as u64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn quantiles() {
        let mut histogram = Histogram::default();
        assert_eq!((histogram.quantile(50), histogram.max()), (None, None));
        for ms in 1..=100 {
            histogram.add(Duration::from_millis(ms));
        }
        let near = |percent: u64, ms: u64| {
            let found = histogram.quantile(percent).unwrap().nanos();
            found >= ms * 1_000_000 && found <= ms * 1_000_000 * 17 / 16
        };
        assert!(near(50, 50) && near(95, 95) && near(99, 99));
        assert_eq!(histogram.quantile(100), Some(Duration::from_millis(100)));
        assert_eq!(histogram.rows().map(|row| u64::from(row.1)).sum::<u64>(), 100);
    }

    proptest! {
        #[test]
        fn each_time_is_in_its_bucket(nanos: u64) {
            let at = bucket(nanos);
            prop_assert!(at < BUCKETS);
            prop_assert!(nanos <= upper_bound(at));
            prop_assert!(at == 0 || nanos > upper_bound(at - 1));
        }
    }
}
