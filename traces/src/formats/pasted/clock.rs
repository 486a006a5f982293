//! Times of pasted lines.

use crate::columns::Unit;
use crate::formats::candump_log::EPOCH_FROM;
use crate::grammar::{billionths, decimal};
use crate::{TimeBase, Timestamp};
use jiff::civil;

const SECOND: u64 = 1_000_000_000;
const DAY: u64 = 86_400 * SECOND;

/// A plain number in a column of times: its value in billionths, and its number of decimals.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Plain {
    pub(super) billionths: u128,
    pub(super) decimals: usize,
}

/// Parses `123`, `123.456` or `123,456`.
pub(super) fn plain(text: &[u8]) -> Option<Plain> {
    let (rest, whole) = decimal("a time")(text).ok()?;
    let (decimals, fraction) = match rest {
        [] => (0, 0),
        [b'.' | b',', digits @ ..] => match billionths(digits).ok()? {
            ([], fraction) => (digits.len(), fraction),
            _ => return None,
        },
        _ => return None,
    };
    Some(Plain { billionths: u128::from(whole) * u128::from(SECOND) + u128::from(fraction), decimals })
}

/// The units that fit the times of lines: a bus at 1 Mbit/s has at most one frame in 40 µs. A dialogue has more than
/// one frame a minute; chosen lines, such as those of one message, may have a day between them.
pub(super) fn units(times: &[Plain]) -> Vec<Unit> {
    const SHORTEST: u128 = 40_000;
    const MINUTE: u128 = 60 * SECOND as u128;
    const YEAR_1973: u128 = EPOCH_FROM as u128;
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return vec![Unit::Seconds] };
    let decimals = times.iter().map(|time| time.decimals).max().unwrap_or(0);
    if decimals >= 4 {
        return vec![Unit::Seconds];
    }
    // Numbers of this size are times since 1970, and have only one unit between 1973 and 2554.
    let nanos = |unit: Unit, value: u128| value.saturating_mul(u128::from(unit.nanos())) / u128::from(SECOND);
    let is_date = |unit: &Unit| (YEAR_1973..=u128::from(u64::MAX) / 4).contains(&nanos(*unit, first.billionths));
    if let Some(unit) = Unit::ALL.into_iter().find(is_date)
        && first.billionths >= 1_000_000_000 * u128::from(SECOND)
    {
        return vec![unit];
    }
    let likely = if decimals == 0 { &Unit::ALL[..3] } else { &Unit::ALL[..2] };
    let Some(gaps) = (times.len() as u128).checked_sub(1).filter(|gaps| *gaps > 0) else {
        return likely.iter().rev().take(1).copied().collect();
    };
    let span = last.billionths.saturating_sub(first.billionths);
    let longest = if decimals >= 2 { u128::from(DAY) } else { MINUTE };
    let fits = |unit: &&Unit| (SHORTEST..=longest).contains(&(nanos(**unit, span) / gaps));
    let fitting: Vec<_> = likely.iter().filter(fits).copied().collect();
    if fitting.is_empty() { vec![Unit::Seconds] } else { fitting }
}

/// Parses `hh:mm:ss`, with a fraction after a point, a comma or a colon, perhaps in two parts (`10:00:00.100.1`); gives
/// nanoseconds.
pub(super) fn time_of_day(text: &[u8]) -> Option<u64> {
    let mut parts = text.splitn(3, |byte| *byte == b':');
    let number = |part: Option<&[u8]>| match decimal("a number")(part?) {
        Ok(([], value)) => Some(value),
        _ => None,
    };
    let (hour, minute) = (number(parts.next())?, number(parts.next())?);
    let (rest, second) = decimal("seconds")(parts.next()?).ok()?;
    let fraction = match rest {
        [] => 0,
        [b'.' | b':' | b',', digits @ ..] => fraction(digits)?,
        _ => return None,
    };
    (hour < 24 * 366 && minute < 60 && second < 60).then_some((hour * 3600 + minute * 60 + second) * SECOND + fraction)
}

/// Parses the digits after the decimal sign: `100`, or milliseconds and what follows them: `100.1`.
fn fraction(digits: &[u8]) -> Option<u64> {
    match billionths(digits).ok()? {
        ([], fraction) => Some(u64::from(fraction)),
        ([b'.', rest @ ..], millis) if digits.len() - rest.len() == 4 => match billionths(rest).ok()? {
            ([], fraction) => Some(u64::from(millis) + u64::from(fraction) / 1000),
            _ => None,
        },
        _ => None,
    }
}

/// Parses the time of CL1000 loggers, day of the month, hour, minute, second and milliseconds: `30T104423567`.
pub(super) fn day_and_time(text: &[u8]) -> Option<u64> {
    let [d1, d2, b'T', clock @ ..] = text else { return None };
    let pair = |pair: &[u8]| match pair {
        [a @ b'0'..=b'9', b @ b'0'..=b'9'] => Some(u64::from(a - b'0') * 10 + u64::from(b - b'0')),
        _ => None,
    };
    let day = pair(&[*d1, *d2])?;
    let (hour, minute, second) = (pair(clock.get(..2)?)?, pair(clock.get(2..4)?)?, pair(clock.get(4..6)?)?);
    let fraction = fraction(clock.get(6..)?)?;
    let is_time = (1..=31).contains(&day) && hour < 24 && minute < 60 && second < 60;
    is_time.then_some(((day * 24 + hour) * 3600 + minute * 60 + second) * SECOND + fraction)
}

/// The order of day and month in a date with slashes, if its numbers show it: whether the month comes first.
pub(super) fn order(text: &[u8]) -> Option<bool> {
    let mut parts = text.split(|byte| *byte == b'/').map(|part| decimal("a number")(part).ok().map(|(_, value)| value));
    match (parts.next()??, parts.next()??) {
        (first, _) if first > 12 => Some(false),
        (_, second) if second > 12 => Some(true),
        _ => None,
    }
}

/// A moment in the calendar.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Date {
    /// Nanoseconds since 1970.
    pub(super) nanos: u64,
    /// Whether `Z` says that it is in UTC.
    pub(super) is_utc: bool,
}

/// Parses a date, perhaps with a time of the day after `T`.
pub(super) fn date(text: &[u8], month_first: bool) -> Option<Date> {
    let end = text.iter().position(|byte| *byte == b'T').unwrap_or(text.len());
    let (day, time) = text.split_at_checked(end)?;
    let mut parts = day.splitn(3, |byte| b"-./".contains(byte)).map(|part| match decimal("a number")(part) {
        Ok(([], value)) => i16::try_from(value).ok(),
        _ => None,
    });
    let (a, b, c) = (parts.next()??, parts.next()??, parts.next()??);
    let (year, month, day) = match () {
        () if a > 31 => (a, b, c),
        () if text.contains(&b'/') && month_first => (c, a, b),
        () => (c, b, a),
    };
    let date = civil::Date::new(year, i8::try_from(month).ok()?, i8::try_from(day).ok()?).ok()?;
    let midnight = crate::local_time::nanos(date.at(0, 0, 0, 0))?;
    let is_utc = time.ends_with(b"Z");
    let time = match time.trim_ascii_end() {
        [] => 0,
        [b'T', clock @ ..] => time_of_day(clock.strip_suffix(b"Z").unwrap_or(clock))?,
        _ => return None,
    };
    Some(Date { nanos: midnight.checked_add(time)?, is_utc })
}

/// The times so far.
#[derive(Default)]
pub(super) struct Clock {
    base: Option<TimeBase>,
    now: u64,
    /// Nanoseconds of the days that have passed, where lines have only a time of the day.
    days: u64,
    last_of_day: u64,
}

impl Clock {
    pub(super) fn base(&self) -> TimeBase {
        self.base.unwrap_or(TimeBase::None)
    }

    /// The time of a line with a date, a time of the day, or both.
    pub(super) fn calendar(&mut self, date: Option<Date>, of_day: Option<u64>) -> Option<Timestamp> {
        let (base, nanos) = match (date, of_day) {
            (Some(Date { nanos, is_utc }), of_day) => {
                let base = if is_utc { TimeBase::Utc } else { TimeBase::Local };
                (base, nanos.checked_add(of_day.unwrap_or(0))?)
            }
            (None, Some(of_day)) => {
                if of_day + DAY / 2 < self.last_of_day {
                    self.days = self.days.saturating_add(DAY);
                }
                self.last_of_day = of_day;
                (TimeBase::Start, self.days.checked_add(of_day)?)
            }
            (None, None) => (TimeBase::None, self.now),
        };
        self.base.get_or_insert(base);
        self.now = nanos;
        Some(Timestamp(nanos))
    }

    /// The time of a line with a plain number.
    pub(super) fn plain(&mut self, time: Plain, unit: Unit, differences: bool) -> Option<Timestamp> {
        let nanos = u64::try_from(time.billionths * u128::from(unit.nanos()) / u128::from(SECOND)).ok()?;
        let nanos = if differences { self.now.checked_add(nanos)? } else { nanos };
        let base = if nanos >= EPOCH_FROM && !differences { TimeBase::Utc } else { TimeBase::Start };
        self.base.get_or_insert(base);
        self.now = nanos;
        Some(Timestamp(nanos))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fitting(times: &[&str]) -> Vec<Unit> {
        units(&times.iter().map(|time| plain(time.as_bytes()).unwrap()).collect::<Vec<_>>())
    }

    #[test]
    fn the_unit_that_a_bus_allows() {
        assert_eq!(fitting(&["12.345", "12.346", "12.347"]), [Unit::Seconds], "1 µs is too short for a frame");
        assert_eq!(fitting(&["100.1", "101.0", "500.0"]), [Unit::Millis], "more than a minute between frames");
        assert_eq!(fitting(&["0.100100", "400.101000"]), [Unit::Seconds], "six decimals");
        assert_eq!(fitting(&["1.0", "2.0", "3.0"]), [Unit::Seconds, Unit::Millis]);
        assert_eq!(fitting(&["1000", "2000", "3000"]), [Unit::Millis, Unit::Micros]);
        assert_eq!(fitting(&["1700000000", "1700000001"]), [Unit::Seconds]);
        assert_eq!(fitting(&["1700000000000", "1700000000001"]), [Unit::Millis]);
        assert_eq!(fitting(&["1700000000000000", "1700000000000100"]), [Unit::Micros]);
    }

    #[test]
    fn dates() {
        let day = 1_682_899_200 * SECOND;
        for text in ["2023-05-01", "01.05.2023", "5/1/2023", "2023-05-01T00:00:00Z", "2023/05/01"] {
            assert_eq!(date(text.as_bytes(), true).map(|date| date.nanos), Some(day), "{text}");
        }
        let nanos = |text: &[u8]| date(text, true).map(|date| date.nanos);
        assert_eq!(nanos(b"2023-05-01T00:00:01.5"), Some(day + SECOND * 3 / 2));
        assert_eq!(nanos(b"2023-13-01"), None);
        assert_eq!(date(b"1/5/2023", false).map(|date| date.nanos), Some(day));
    }

    #[test]
    fn fractions_in_two_parts() {
        assert_eq!(time_of_day(b"00:00:01.100.1"), Some(1_100_100_000));
        assert_eq!(time_of_day(b"00:00:01,100"), Some(1_100_000_000));
        assert_eq!(time_of_day(b"00:00:01.10.1"), None);
        assert_eq!(day_and_time(b"01T000001500"), Some(DAY + SECOND * 3 / 2));
        assert_eq!(day_and_time(b"01T250001500"), None);
    }

    #[test]
    fn a_time_of_the_day_passes_midnight() {
        let mut clock = Clock::default();
        let mut at = |text: &[u8]| clock.calendar(None, time_of_day(text)).unwrap().nanos() / SECOND;
        assert_eq!((at(b"23:59:59:5000"), at(b"00:00:01.0")), (86_399, 86_401));
    }
}
