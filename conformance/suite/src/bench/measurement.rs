//! Measurements of a case: numbers for comparing two releases of a firmware.

use canvass_traces::Duration;
use std::fmt;

/// A named number.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Measurement {
    /// The name of the measured quantity: `SDO response, 95 %`.
    pub name: String,
    /// The number, in `unit`.
    pub value: u64,
    /// The unit.
    pub unit: Unit,
}

/// The unit of a measurement.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unit {
    /// A time.
    Nanoseconds,
    /// A number of events.
    Count,
}

impl Unit {
    /// The name of the unit in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nanoseconds => "ns",
            Self::Count => "count",
        }
    }
}

/// `SDO response, 95 %: 1.2 ms`.
impl fmt::Display for Measurement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.unit {
            Unit::Nanoseconds => write!(f, "{}: {}", self.name, Duration::from_nanos(self.value)),
            Unit::Count => write!(f, "{}: {}", self.name, self.value),
        }
    }
}

/// The value at this percentile (nearest rank); `None` without values. Sorts the values.
pub fn percentile(values: &mut [Duration], percent: usize) -> Option<Duration> {
    values.sort_unstable();
    let rank = (values.len() * percent).div_ceil(100).max(1);
    values.get(rank - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_of_the_nearest_rank() {
        let mut values: Vec<Duration> = (1..=20).rev().map(Duration::from_millis).collect();
        let at = |values: &mut [Duration], percent| percentile(values, percent).map(|d| d.nanos() / 1_000_000);
        assert_eq!(at(&mut values, 50), Some(10));
        assert_eq!(at(&mut values, 95), Some(19));
        assert_eq!(at(&mut values, 100), Some(20));
        assert_eq!(percentile(&mut [], 50), None);
    }
}
