//! `--from` and `--to`: a part of a capture.

use anyhow::{Context, Result, bail};
use canvass_traces::{Duration, Timestamp};
use std::str::FromStr;

/// A point in time as typed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TimePoint {
    /// A time as the capture counts it: seconds, or a date and time.
    Absolute(Timestamp),
    /// A time since the first frame.
    SinceStart(Duration),
}

/// The part of a capture between two points, both included.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct TimeRange {
    /// Leave out frames before this time: seconds as in the capture, +SECONDS since its first frame, or
    /// 2025-01-28T10:47:15Z
    #[arg(long, value_name = "TIME")]
    from: Option<TimePoint>,
    /// Leave out frames after this time
    #[arg(long, value_name = "TIME")]
    to: Option<TimePoint>,
    #[arg(skip)]
    start: Option<Timestamp>,
}

impl TimeRange {
    /// The part between two points; `None` leaves that side open.
    pub fn new(from: Option<TimePoint>, to: Option<TimePoint>) -> Self {
        Self { from, to, start: None }
    }

    /// Whether a frame of this time is in the part. The first call sets the start of the capture.
    pub fn contains(&mut self, time: Timestamp) -> bool {
        let start = *self.start.get_or_insert(time);
        self.from.is_none_or(|from| from.after(start) <= time) && self.to.is_none_or(|to| time <= to.after(start))
    }
}

impl TimePoint {
    fn after(self, start: Timestamp) -> Timestamp {
        match self {
            Self::Absolute(time) => time,
            Self::SinceStart(span) => start + span,
        }
    }
}

impl FromStr for TimePoint {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        if let Some(seconds) = text.strip_prefix('+') {
            return Ok(Self::SinceStart(Duration(nanos(seconds)?)));
        }
        if text.contains(['T', ':']) {
            let time: jiff::Timestamp = text.parse().context("expected a time such as 2025-01-28T10:47:15.5Z")?;
            let nanos = u64::try_from(time.as_nanosecond()).context("expected a time after 1970 and before 2554")?;
            return Ok(Self::Absolute(Timestamp(nanos)));
        }
        nanos(text).map(|nanos| Self::Absolute(Timestamp(nanos)))
    }
}

/// Parses seconds with up to nine decimals, without rounding.
fn nanos(text: &str) -> Result<u64> {
    let expected = "expected seconds such as 12.5 (+12.5 counts from the first frame)";
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    if fraction.len() > 9 || !fraction.bytes().all(|byte| byte.is_ascii_digit()) {
        bail!("{expected}, with at most nine decimals");
    }
    let whole: u64 = whole.parse().context(expected)?;
    let fraction: u64 = format!("{fraction:0<9}").parse().context(expected)?;
    whole
        .checked_mul(1_000_000_000)
        .and_then(|nanos| nanos.checked_add(fraction))
        .context("expected a time before 2554")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_as_typed() {
        let parsed = |text: &str| text.parse::<TimePoint>().unwrap();
        assert_eq!(parsed("12.5"), TimePoint::Absolute(Timestamp(12_500_000_000)));
        assert_eq!(parsed("+0.000000001"), TimePoint::SinceStart(Duration(1)));
        assert_eq!(parsed("1970-01-01T00:00:01Z"), TimePoint::Absolute(Timestamp(1_000_000_000)));
        for wrong in ["", "x", "1.2.3", "-1", "1.0000000001", "2025-01-28T10", "99999999999999"] {
            assert!(wrong.parse::<TimePoint>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn both_ends_are_in_the_part() {
        let mut range = TimeRange { from: Some("+1".parse().unwrap()), to: Some("+2".parse().unwrap()), start: None };
        let at = |seconds: u64| Timestamp(seconds * 1_000_000_000);
        let kept: Vec<bool> = (10..=14).map(|seconds| range.contains(at(seconds))).collect();
        assert_eq!(kept, [false, true, true, false, false]);
    }
}
