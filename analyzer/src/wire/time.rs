//! TIME: the time of day for all nodes (CAN-ID 100h unless 1012h says otherwise).
//!
//! ```text
//! bytes 0..3: milliseconds after midnight, 28 bits, little-endian; upper 4 bits reserved
//! bytes 4..5: days since 1984-01-01, little-endian
//! ```

use super::{Field, Fields, Layout, Malformed, Wire, named};
use nom::{
    IResult, Parser,
    number::complete::{le_u16, le_u32},
};
use std::fmt;

/// The default CAN-ID.
pub const CAN_ID: u16 = 0x100;

/// A value of the type TIME_OF_DAY, also TIME_DIFFERENCE.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct TimeOfDay {
    /// The first four bytes unchanged; the upper four bits are reserved.
    pub raw_milliseconds: u32,
    /// Days since 1984-01-01.
    pub days: u16,
}

impl TimeOfDay {
    /// Milliseconds in a day.
    pub const DAY: u32 = 86_400_000;

    /// Milliseconds after midnight, 28 bits; a day has [`TimeOfDay::DAY`].
    pub const fn milliseconds(self) -> u32 {
        self.raw_milliseconds & 0x0FFF_FFFF
    }

    /// The reserved bits; 0 if the sender follows the standard.
    pub const fn reserved(self) -> u8 {
        (self.raw_milliseconds >> 28) as u8
    }

    /// Year, month and day of the Gregorian calendar.
    pub const fn date(self) -> (u32, u32, u32) {
        // Days are counted from a 1 March, so that a leap day ends its year; 1983-03-01 is 306 days before
        // 1984-01-01. Four-year cycles suffice: 1984 + 65535 days ends in 2163, and the only exception, 2100, is
        // handled below.
        let mut since_march_1983 = self.days as u32 + 306;
        let days_to_end_of_february_2100 = 42_734;
        if since_march_1983 >= days_to_end_of_february_2100 {
            since_march_1983 += 1;
        }
        let cycle = since_march_1983 / 1461;
        let in_cycle = since_march_1983 % 1461;
        let leap_first = if in_cycle >= 366 { (in_cycle - 366) / 365 + 1 } else { 0 };
        let day_of_year = if leap_first == 0 { in_cycle } else { (in_cycle - 366) % 365 };
        let shifted_month = (5 * day_of_year + 2) / 153;
        let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
        let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
        let year = 1983 + 4 * cycle + leap_first + if month <= 2 { 1 } else { 0 };
        (year, month, day)
    }
}

impl Wire for TimeOfDay {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let milliseconds = named("milliseconds after midnight, 4 bytes", le_u32);
        let days = named("days since 1984-01-01, 2 bytes", le_u16);
        (milliseconds, days).map(|(raw_milliseconds, days)| Self { raw_milliseconds, days }).parse(input)
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        buffer[..4].copy_from_slice(&self.raw_milliseconds.to_le_bytes());
        buffer[4..6].copy_from_slice(&self.days.to_le_bytes());
        6
    }
}

static TIME: Layout = Layout {
    name: "TIME",
    fields: &[
        Field::new("milliseconds after midnight", 0, 0, 28),
        Field::new("upper four bits", 3, 4, 4),
        Field::new("days since 1984-01-01", 4, 0, 16),
    ],
};

impl Fields for TimeOfDay {
    const LAYOUTS: &'static [&'static Layout] = &[&TIME];

    fn layout(&self) -> &'static Layout {
        &TIME
    }
}

/// Writes `2024-02-29 13:45:10.250`.
impl fmt::Display for TimeOfDay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (year, month, day) = self.date();
        let ms = self.milliseconds();
        let (hour, minute, second) = (ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60);
        write!(f, "{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}.{:03}", ms % 1000)?;
        if ms >= Self::DAY {
            f.write_str(" (beyond midnight)")?;
        }
        if self.reserved() != 0 {
            write!(f, " (reserved bits {:X}h)", self.reserved())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::{both_ways, stable};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn days_and_milliseconds() {
        both_ways(&[0x02, 0, 0, 0, 0x01, 0], TimeOfDay { raw_milliseconds: 2, days: 1 });
        assert_eq!(TimeOfDay { raw_milliseconds: 0, days: 0 }.to_string(), "1984-01-01 00:00:00.000");
        assert_eq!(TimeOfDay { raw_milliseconds: 86_399_999, days: 59 }.to_string(), "1984-02-29 23:59:59.999");
        assert_eq!(
            TimeOfDay { raw_milliseconds: 0xF000_0000, days: 60 }.to_string(),
            "1984-03-01 00:00:00.000 (reserved bits Fh)"
        );
        let midnight = TimeOfDay { raw_milliseconds: 86_400_000, days: 0 };
        assert_eq!(midnight.to_string(), "1984-01-01 24:00:00.000 (beyond midnight)");
        assert_eq!(TimeOfDay::read(&[0; 5]), Err(Malformed { offset: 4, expected: "days since 1984-01-01, 2 bytes" }));
    }

    /// The expected dates come from walking the calendar, independently of the formula.
    #[test]
    fn every_date_that_sixteen_bits_can_say() {
        let leap = |year: u32| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
        let (mut year, mut month, mut day) = (1984, 1, 1);
        for days in 0..=u16::MAX {
            assert_eq!(TimeOfDay { raw_milliseconds: 0, days }.date(), (year, month, day), "day {days}");
            let length = match month {
                2 if leap(year) => 29,
                2 => 28,
                4 | 6 | 9 | 11 => 30,
                _ => 31,
            };
            day += 1;
            if day > length {
                (month, day) = (month + 1, 1);
            }
            if month > 12 {
                (year, month) = (year + 1, 1);
            }
        }
    }

    proptest! {
        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<TimeOfDay>(&bytes);
        }
    }
}
