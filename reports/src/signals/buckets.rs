//! Values over time in a bounded number of buckets. When all buckets are in use, each two neighbouring buckets become
//! one.

use canvass_traces::{Duration, Timestamp};

/// The merge of two neighbouring buckets.
pub trait Merge {
    /// Merges the later bucket into this one.
    fn merge(&mut self, later: Self);
}

/// At most `MOST` buckets of equal width, from a start time on.
#[derive(Debug)]
pub(crate) struct Buckets<T, const MOST: usize> {
    start: Timestamp,
    width: Duration,
    /// Maximum number of buckets, which is `MOST` or less.
    most: usize,
    slots: Vec<Option<T>>,
}

impl<T: Merge, const MOST: usize> Buckets<T, MOST> {
    /// Empty buckets. They begin at `start`, and each is `width` (more than 0) wide.
    pub const fn new(start: Timestamp, width: Duration) -> Self {
        Self { start, width, most: MOST, slots: Vec::new() }
    }

    /// Limits the number of buckets to `most`, and to at least one.
    pub(crate) fn limited_to(self, most: usize) -> Self {
        Self { most: most.clamp(1, MOST), ..self }
    }

    /// Adds a value with its time. A value before the start is added to the first bucket.
    pub fn add(&mut self, now: Timestamp, value: T) {
        let elapsed = now.since(self.start).nanos();
        let mut at = elapsed / self.width.nanos();
        while at >= self.most as u64 {
            self.double();
            at = elapsed / self.width.nanos();
        }
        let at = at as usize;
        if self.slots.len() <= at {
            self.slots.resize_with(at + 1, || None);
        }
        match &mut self.slots[at] {
            Some(slot) => slot.merge(value),
            empty => *empty = Some(value),
        }
    }

    #[cold]
    fn double(&mut self) {
        let mut merged = Vec::with_capacity(self.most);
        let mut slots = std::mem::take(&mut self.slots).into_iter();
        while let Some(first) = slots.next() {
            merged.push(match (first, slots.next().flatten()) {
                (Some(mut first), Some(second)) => {
                    first.merge(second);
                    Some(first)
                }
                (first, second) => first.or(second),
            });
        }
        self.slots = merged;
        self.width = self.width.times(2);
    }

    /// The values in the order of time.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.slots.iter().flatten()
    }
}

/// The lowest and the highest of several samples, each with its time.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Extremes {
    least: (Timestamp, f64),
    most: (Timestamp, f64),
}

impl Extremes {
    /// The extremes of a single sample.
    pub const fn of(time: Timestamp, value: f64) -> Self {
        Self { least: (time, value), most: (time, value) }
    }

    /// The extremes as one or two samples, in the order of time.
    pub fn samples(&self) -> impl Iterator<Item = (Timestamp, f64)> {
        let (first, second) =
            if self.least.0 <= self.most.0 { (self.least, self.most) } else { (self.most, self.least) };
        std::iter::once(first).chain((first != second).then_some(second))
    }
}

impl Merge for Extremes {
    fn merge(&mut self, later: Self) {
        if later.least.1 < self.least.1 {
            self.least = later.least;
        }
        // The last of equal samples is kept, so that a line reaches to the last sample.
        if later.most.1 >= self.most.1 {
            self.most = later.most;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_peak_stays() {
        let mut buckets: Buckets<Extremes, 64> = Buckets::new(Timestamp(5), Duration(10));
        for n in 0..100_000_u64 {
            let value = match n {
                77_777 => 1000.0,
                33_333 => -1000.0,
                _ => (n % 10) as f64,
            };
            let now = Timestamp(5 + n);
            buckets.add(now, Extremes::of(now, value));
        }
        let samples: Vec<_> = buckets.iter().flat_map(|extremes| extremes.samples().collect::<Vec<_>>()).collect();
        assert!(samples.len() <= 128);
        assert!(samples.contains(&(Timestamp(77_782), 1000.0)) && samples.contains(&(Timestamp(33_338), -1000.0)));
        assert!(samples.is_sorted_by_key(|sample| sample.0));
    }

    #[test]
    fn fewer_buckets_take_as_much() {
        let mut buckets: Buckets<Extremes, 64> = Buckets::new(Timestamp(0), Duration(10)).limited_to(4);
        for n in 0..100_u64 {
            buckets.add(Timestamp(n), Extremes::of(Timestamp(n), if n == 41 { 7.0 } else { 0.0 }));
        }
        assert!(buckets.iter().count() <= 4);
        let samples: Vec<_> = buckets.iter().flat_map(Extremes::samples).collect();
        assert!(samples.contains(&(Timestamp(41), 7.0)) && samples.last().unwrap().0 >= Timestamp(80), "{samples:?}");
    }

    #[test]
    fn few_samples_stay_as_they_are() {
        let mut buckets: Buckets<Extremes, 64> = Buckets::new(Timestamp(0), Duration(10));
        let seen = [(Timestamp(3), 1.0), (Timestamp(15), 2.0), (Timestamp(17), 1.5), (Timestamp(633), 9.0)];
        for (now, value) in seen {
            buckets.add(now, Extremes::of(now, value));
        }
        let samples: Vec<_> = buckets.iter().flat_map(|extremes| extremes.samples().collect::<Vec<_>>()).collect();
        assert_eq!(samples[..1], seen[..1]);
        assert_eq!(samples.last(), Some(&seen[3]));
        assert_eq!(samples.len(), 4);
    }
}
