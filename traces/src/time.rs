//! Points in time, in integer nanoseconds.

use std::fmt;
use std::ops::{Add, AddAssign, Sub};

/// Nanoseconds since 1970-01-01 00:00:00 UTC, or since the start of a capture whose format has no date (see
/// [`crate::TimeBase`]). On the simulated bus: since the bus was switched on.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug)]
pub struct Timestamp(pub u64);

/// A span of time in nanoseconds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug)]
pub struct Duration(pub u64);

impl Timestamp {
    /// The zero of the time scale.
    pub const ZERO: Self = Self(0);
    /// A time later than any other: a wait until then has no end.
    pub const MAX: Self = Self(u64::MAX);

    /// Nanoseconds since the zero of the time scale.
    pub const fn nanos(self) -> u64 {
        self.0
    }

    /// The time `nanos` nanoseconds later; `None` if it is after the largest time, in the year 2554.
    pub(crate) const fn after(self, nanos: u64) -> Option<Self> {
        match self.0.checked_add(nanos) {
            Some(nanos) => Some(Self(nanos)),
            None => None,
        }
    }

    /// The time since `earlier`, or zero if the clock stepped back.
    ///
    /// ```
    /// use canvass_traces::{Duration, Timestamp};
    ///
    /// let (earlier, later) = (Timestamp(1_000_000), Timestamp(3_500_000));
    /// assert_eq!(later.since(earlier), Duration::from_micros(2_500));
    /// assert_eq!(earlier.since(later), Duration::ZERO);
    /// ```
    pub const fn since(self, earlier: Self) -> Duration {
        Duration(self.0.saturating_sub(earlier.0))
    }
}

impl Duration {
    /// A span of length zero.
    pub const ZERO: Self = Self(0);

    /// `n` nanoseconds.
    pub const fn from_nanos(n: u64) -> Self {
        Self(n)
    }

    /// `n` microseconds.
    pub const fn from_micros(n: u64) -> Self {
        Self(n.saturating_mul(1_000))
    }

    /// `n` milliseconds.
    pub const fn from_millis(n: u64) -> Self {
        Self(n.saturating_mul(1_000_000))
    }

    /// `n` seconds.
    pub const fn from_secs(n: u64) -> Self {
        Self(n.saturating_mul(1_000_000_000))
    }

    /// The span in nanoseconds.
    pub const fn nanos(self) -> u64 {
        self.0
    }

    /// The span in milliseconds, with its fraction.
    pub fn as_millis(self) -> f64 {
        self.0 as f64 / 1e6
    }

    /// The span multiplied by `n`, limited to [`u64::MAX`] nanoseconds.
    pub const fn times(self, n: u64) -> Self {
        Self(self.0.saturating_mul(n))
    }
}

impl Add<Duration> for Timestamp {
    type Output = Self;
    fn add(self, span: Duration) -> Self {
        Self(self.0.saturating_add(span.0))
    }
}

impl AddAssign<Duration> for Timestamp {
    fn add_assign(&mut self, span: Duration) {
        *self = *self + span;
    }
}

impl Sub for Timestamp {
    type Output = Duration;
    fn sub(self, earlier: Self) -> Duration {
        self.since(earlier)
    }
}

impl Add for Duration {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

/// Seconds with nine digits, as `SECONDS.NANOSECONDS`.
impl fmt::Display for Timestamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:09}", self.0 / 1_000_000_000, self.0 % 1_000_000_000)
    }
}

/// The span in the unit that keeps the number readable: `350 ns`, `12.5 µs`, `14 ms`, `3.2 s`.
impl fmt::Display for Duration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, name) = match self.0 {
            0..1_000 => (1, "ns"),
            1_000..1_000_000 => (1_000, "µs"),
            1_000_000..1_000_000_000 => (1_000_000, "ms"),
            _ => (1_000_000_000, "s"),
        };
        let (whole, thousandths) = (self.0 / unit, (self.0 % unit) * 1_000 / unit);
        if thousandths == 0 {
            write!(f, "{whole} {name}")
        } else {
            let digits = format!("{thousandths:03}");
            write!(f, "{whole}.{} {name}", digits.trim_end_matches('0'))
        }
    }
}

impl From<Duration> for std::time::Duration {
    fn from(span: Duration) -> Self {
        Self::from_nanos(span.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_read_well() {
        let shown = |nanos| Duration(nanos).to_string();
        assert_eq!(shown(0), "0 ns");
        assert_eq!(shown(12_500), "12.5 µs");
        assert_eq!(shown(14_000_000), "14 ms");
        assert_eq!(shown(3_200_000_000), "3.2 s");
        assert_eq!(shown(1_001_000_000), "1.001 s");
    }

    #[test]
    fn a_clock_that_steps_back_gives_no_negative_span() {
        assert_eq!(Timestamp(5) - Timestamp(9), Duration::ZERO);
    }
}
