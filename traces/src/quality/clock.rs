//! How fine and how steady the clock of a capture is.

use super::Sighting;
use crate::{Duration, Place, Timestamp};

/// Steps of the clock back in time.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ClockSteps {
    /// How many there were.
    pub count: u64,
    /// The largest one.
    pub largest: Duration,
    /// The first frame that is older than the one before it.
    pub first: Option<Sighting>,
}

impl ClockSteps {
    #[cold]
    pub(super) fn step(&mut self, last: Timestamp, time: Timestamp, place: Place) {
        self.count += 1;
        self.largest = self.largest.max(last.since(time));
        self.first.get_or_insert(Sighting { time, place });
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.largest = self.largest.max(other.largest);
        self.first = self.first.or(other.first);
    }
}

/// The largest power of ten that divides all times seen.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Resolution {
    /// The exponent, in nanoseconds: at most 9.
    digits: u8,
    /// The first time seen.
    first: Option<Timestamp>,
    /// Whether there was another time than the first one.
    moves: bool,
}

impl Default for Resolution {
    fn default() -> Self {
        Self { digits: 9, first: None, moves: false }
    }
}

impl Resolution {
    /// As coarse as this or coarser, times are worth a warning: CANopen's own times are in milliseconds.
    pub const COARSE: Duration = Duration::from_millis(1);

    /// The resolution, if at least two different times were seen.
    pub fn get(&self) -> Option<Duration> {
        self.moves.then(|| Duration(10_u64.pow(u32::from(self.digits))))
    }

    /// Whether the times are too coarse to tell how quickly nodes answer.
    pub fn is_coarse(&self) -> bool {
        self.get().is_some_and(|resolution| resolution >= Self::COARSE)
    }

    #[inline]
    pub(super) fn see(&mut self, time: Timestamp) {
        if !self.moves {
            let first = *self.first.get_or_insert(time);
            self.moves = first != time;
        }
        while !divides(self.digits, time.nanos()) {
            self.digits -= 1;
        }
    }

    pub(super) fn add(&mut self, other: Self) {
        self.digits = self.digits.min(other.digits);
        self.moves |= other.moves || (other.first.is_some() && self.first.is_some() && self.first != other.first);
        self.first = self.first.or(other.first);
    }
}

/// Whether that power of ten divides `nanos`. With divisors known in advance no division takes place.
#[inline]
fn divides(digits: u8, nanos: u64) -> bool {
    match digits {
        0 => true,
        1 => nanos.is_multiple_of(10),
        2 => nanos.is_multiple_of(100),
        3 => nanos.is_multiple_of(1_000),
        4 => nanos.is_multiple_of(10_000),
        5 => nanos.is_multiple_of(100_000),
        6 => nanos.is_multiple_of(1_000_000),
        7 => nanos.is_multiple_of(10_000_000),
        8 => nanos.is_multiple_of(100_000_000),
        _ => nanos.is_multiple_of(1_000_000_000),
    }
}
