//! Dates in local time of an unknown zone.
//!
//! Such a date becomes nanoseconds since 1970 as if it were UTC, see [`crate::TimeBase::Local`].

use jiff::civil::{DateTime, date};

const EPOCH: DateTime = date(1970, 1, 1).at(0, 0, 0, 0);

/// Nanoseconds from 1970 to the date; `None` for a date before 1970 or after 2554.
pub(crate) fn nanos(date: DateTime) -> Option<u64> {
    u64::try_from(EPOCH.duration_until(date).as_nanos()).ok()
}

/// The date of a time in nanoseconds since 1970.
pub(crate) fn date_of(nanos: u64) -> DateTime {
    let seconds = i64::try_from(nanos / 1_000_000_000).unwrap_or(i64::MAX);
    let fraction = (nanos % 1_000_000_000) as i32;
    let date = EPOCH.checked_add(jiff::SignedDuration::new(seconds, fraction));
    debug_assert!(date.is_ok(), "2^64 ns are 584 years, well within the range of dates");
    date.unwrap_or(EPOCH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for nanos_since_1970 in [0, 1, 1_700_000_000_123_456_789, u64::MAX] {
            assert_eq!(nanos(date_of(nanos_since_1970)), Some(nanos_since_1970));
        }
        assert_eq!(date_of(1_700_000_000_000_000_000), date(2023, 11, 14).at(22, 13, 20, 0));
        assert_eq!(nanos(date(1969, 12, 31).at(23, 59, 59, 0)), None);
        assert_eq!(nanos(date(2600, 1, 1).at(0, 0, 0, 0)), None);
    }
}
