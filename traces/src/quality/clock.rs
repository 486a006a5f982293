//! Resolution and steps of a capture's clock.

use super::Sighting;
use crate::{Duration, Place, Timestamp};

/// Backward steps of the clock.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ClockSteps {
    /// Number of steps.
    pub count: u64,
    /// The largest step.
    pub largest: Duration,
    /// The first frame that is older than the frame before it.
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
    /// The exponent of the power of ten, in nanoseconds: at most 9.
    digits: u8,
    /// The first time.
    first: Option<Timestamp>,
    /// Whether another time than the first has occurred.
    moves: bool,
}

impl Default for Resolution {
    fn default() -> Self {
        Self { digits: 9, first: None, moves: false }
    }
}

impl Resolution {
    /// The resolution from which times get a warning as too coarse: CANopen's own times are in milliseconds.
    pub const COARSE: Duration = Duration::from_millis(1);

    /// The resolution, if at least two different times were seen.
    pub fn get(&self) -> Option<Duration> {
        self.moves.then(|| Duration(10_u64.pow(u32::from(self.digits))))
    }

    /// Whether the times are too coarse for measuring response times.
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

/// For each number of digits n: the inverse of 5^n modulo 2^64, and the largest quotient of a 64-bit number by 10^n.
const DIVISORS: [(u64, u64); 10] = {
    let mut divisors = [(1, u64::MAX); 10];
    let mut digits = 1;
    while digits < 10 {
        // 0xCCCC_CCCC_CCCC_CCCD times 5 is 1 modulo 2^64.
        let (inverse, most) = divisors[digits - 1];
        divisors[digits] = (0xCCCC_CCCC_CCCC_CCCD_u64.wrapping_mul(inverse), most / 10);
        digits += 1;
    }
    divisors
};

/// Whether 10^`digits` divides `nanos`, computed without a division: multiplying a multiple of 5^n by the inverse of
/// 5^n gives a small number, and rotating by n makes a number that is no multiple of 2^n large.
#[inline]
fn divides(digits: u8, nanos: u64) -> bool {
    let (inverse, most) = DIVISORS[usize::from(digits)];
    nanos.wrapping_mul(inverse).rotate_right(u32::from(digits)) <= most
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn divides_as_a_division_does(nanos: u64, digits in 0_u8..10) {
            let power = 10_u64.pow(u32::from(digits));
            prop_assert_eq!(divides(digits, nanos), nanos % power == 0);
            prop_assert!(divides(digits, nanos / power * power));
        }
    }
}
