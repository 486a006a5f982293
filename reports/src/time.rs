//! The shown time of a frame.

use crate::push::{push_decimal, push_fraction, push_six_digits, push_text};
use canvass_traces::{Duration, Timestamp};

/// The style of a frame's shown time.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum TimeStyle {
    /// Seconds as in the capture.
    #[default]
    Absolute,
    /// Seconds since the first frame.
    Relative,
    /// Seconds since the frame before.
    Delta,
    /// Date and time in UTC with nanoseconds, in the notation of RFC 3339.
    Utc,
    /// Date and time in the zone of this computer with its offset from UTC and nanoseconds, in the notation of RFC
    /// 3339.
    Local,
}

/// Formats the times of frames one after the other.
#[derive(Clone)]
pub struct Clock {
    style: TimeStyle,
    /// Always nine decimals, for programs.
    full: bool,
    first: Option<Timestamp>,
    previous: Option<Timestamp>,
    /// A second and its text, as most frames are in the same second as the previous frame.
    second: (u64, Vec<u8>),
    /// The text after a date.
    zone: Vec<u8>,
}

const NANOS: u64 = 1_000_000_000;

/// A time in milliseconds with three decimals, which is enough for comparisons by people.
pub fn milliseconds(time: Duration) -> String {
    let micros = time.nanos() / 1_000;
    format!("{}.{:03}", micros / 1_000, micros % 1_000)
}

impl Clock {
    /// A clock for people: six decimals, or nine if the time has them.
    pub const fn new(style: TimeStyle) -> Self {
        Self { style, full: false, first: None, previous: None, second: (u64::MAX, Vec::new()), zone: Vec::new() }
    }

    /// A clock for programs: always nine decimals.
    pub const fn full(style: TimeStyle) -> Self {
        let mut clock = Self::new(style);
        clock.full = true;
        clock
    }

    /// The style of the times.
    pub const fn style(&self) -> TimeStyle {
        self.style
    }

    /// The width of most times in columns: seconds since 1970 with six decimals, or a date.
    pub const fn width(&self) -> usize {
        match self.style {
            TimeStyle::Absolute => 17,
            TimeStyle::Relative | TimeStyle::Delta => 12,
            TimeStyle::Utc => 30,
            TimeStyle::Local => 35,
        }
    }

    /// Appends a time.
    pub fn push(&mut self, now: Timestamp, out: &mut Vec<u8>) {
        let first = *self.first.get_or_insert(now);
        let previous = self.previous.replace(now).unwrap_or(now);
        let from = match self.style {
            TimeStyle::Absolute => Timestamp::ZERO,
            TimeStyle::Relative => first,
            TimeStyle::Delta => previous,
            TimeStyle::Utc | TimeStyle::Local => return self.push_date(now, out),
        };
        if now < from {
            out.push(b'-');
        }
        let nanos = now.nanos().abs_diff(from.nanos());
        self.push_seconds(nanos / NANOS, out);
        match nanos % 1000 {
            0 if !self.full => push_six_digits(out, (nanos % NANOS / 1000) as u32),
            _ => push_fraction(out, nanos % NANOS, 9),
        }
    }

    /// Appends the whole seconds and the point after them.
    fn push_seconds(&mut self, second: u64, out: &mut Vec<u8>) {
        let (known, digits) = &mut self.second;
        if *known != second || digits.is_empty() {
            *known = second;
            digits.clear();
            push_decimal(digits, second);
            digits.push(b'.');
        }
        out.extend_from_slice(digits);
    }

    fn push_date(&mut self, now: Timestamp, out: &mut Vec<u8>) {
        let second = now.nanos() / NANOS;
        let (known, date) = &mut self.second;
        if *known != second {
            *known = second;
            date.clear();
            self.zone.clear();
            // 64 bits of nanoseconds reach to the year 2554, so every second has a date.
            if let Ok(time) = jiff::Timestamp::from_second(second.cast_signed()) {
                let zone = match self.style {
                    TimeStyle::Local => local_zone(time),
                    _ => jiff::tz::TimeZone::UTC,
                };
                let time = time.to_zoned(zone);
                push_text(date, time.strftime("%Y-%m-%dT%H:%M:%S"));
                match self.style {
                    TimeStyle::Local => push_text(&mut self.zone, time.strftime("%:z")),
                    _ => self.zone.push(b'Z'),
                }
            }
        }
        out.extend_from_slice(date);
        out.push(b'.');
        push_fraction(out, now.nanos() % NANOS, 9);
        out.extend_from_slice(&self.zone);
    }
}

/// The zone of this computer.
#[cfg(not(target_family = "wasm"))]
fn local_zone(_: jiff::Timestamp) -> jiff::tz::TimeZone {
    jiff::tz::TimeZone::system()
}

/// The offset of the browser's zone at this time, as a zone.
#[cfg(target_family = "wasm")]
fn local_zone(time: jiff::Timestamp) -> jiff::tz::TimeZone {
    let date = js_sys::Date::new(&(time.as_millisecond() as f64).into());
    // JavaScript counts the minutes from local time to UTC.
    let seconds = -60 * date.get_timezone_offset() as i32;
    jiff::tz::Offset::from_seconds(seconds).map_or(jiff::tz::TimeZone::UTC, |offset| offset.to_time_zone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(mut clock: Clock, times: &[u64]) -> Vec<String> {
        let mut pushed = |&nanos: &u64| {
            let mut out = Vec::new();
            clock.push(Timestamp(nanos), &mut out);
            String::from_utf8(out).unwrap()
        };
        times.iter().map(&mut pushed).collect()
    }

    #[test]
    fn styles() {
        let times = [1_500_000_000, 1_500_001_000, 1_400_000_001];
        assert_eq!(shown(Clock::new(TimeStyle::Absolute), &times), ["1.500000", "1.500001", "1.400000001"]);
        assert_eq!(shown(Clock::full(TimeStyle::Relative), &times), ["0.000000000", "0.000001000", "-0.099999999"]);
        assert_eq!(shown(Clock::new(TimeStyle::Delta), &times), ["0.000000", "0.000001", "-0.100000999"]);
    }

    #[test]
    fn dates() {
        let times = [0, 1_738_061_235_500_000_001, 1_738_061_235_600_000_000, u64::MAX];
        let expected = [
            "1970-01-01T00:00:00.000000000Z",
            "2025-01-28T10:47:15.500000001Z",
            "2025-01-28T10:47:15.600000000Z",
            "2554-07-21T23:34:33.709551615Z",
        ];
        assert_eq!(shown(Clock::new(TimeStyle::Utc), &times), expected);
    }
}
