//! Intervals without recorded frames.

use super::Sighting;
use crate::{Duration, Place, Timestamp};

/// Intervals between frames that are far longer than usual.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Gaps {
    /// Number of gaps.
    pub count: u64,
    /// The largest gap.
    pub largest: Option<Gap>,
    /// The interval that about 99 of 100 intervals do not exceed, in nanoseconds.
    usual: u64,
}

/// One gap.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Gap {
    /// Length of the gap.
    pub length: Duration,
    /// The usual interval before the gap.
    pub usual: Duration,
    /// The frame after the gap.
    pub end: Sighting,
}

impl Default for Gaps {
    fn default() -> Self {
        Self { count: 0, largest: None, usual: Self::BEGIN.nanos() }
    }
}

impl Gaps {
    /// A gap is at least this factor longer than the usual interval.
    pub const FACTOR: u64 = 10;
    /// The usual interval before any interval was measured.
    pub const BEGIN: Duration = Duration::from_secs(1);
    /// Lower limit of the usual interval: shorter pauses come from the recorder's own scheduling.
    pub const LEAST: Duration = Duration::from_millis(10);

    #[inline]
    pub(super) fn interval(&mut self, last: Timestamp, time: Timestamp, place: Place) {
        let length = time.since(last).nanos();
        if length > self.usual {
            self.longer(Duration(length), Sighting { time, place });
        } else {
            self.usual = (self.usual - (self.usual >> 9)).max(Self::LEAST.nanos());
        }
    }

    #[cold]
    fn longer(&mut self, length: Duration, end: Sighting) {
        let usual = Duration(self.usual);
        if length > usual.times(Self::FACTOR) {
            self.count += 1;
            if self.largest.is_none_or(|largest| largest.length < length) {
                self.largest = Some(Gap { length, usual, end });
            }
        }
        self.usual = self.usual.saturating_add(self.usual >> 2);
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.count += other.count;
        let longer = |gap: &Gap| self.largest.is_none_or(|largest| largest.length < gap.length);
        self.largest = other.largest.filter(longer).or(self.largest);
    }
}
