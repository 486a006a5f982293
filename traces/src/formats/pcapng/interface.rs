//! An interface description block, and the clock of its packets.

use super::block;
use crate::formats::socketcan::LinkType;
use crate::{ChannelId, Channels, Timestamp};
use pcap_file::Endianness;

/// Codes of the options that this module reads.
const IF_NAME: u16 = 2;
const IF_TSRESOL: u16 = 9;
const IF_TSOFFSET: u16 = 14;

/// Maximum length of a channel name in bytes; names of Linux interfaces have at most 15.
const LONGEST_NAME: usize = 256;

/// An interface of the current section.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interface {
    /// The link type as in the block; [`LinkType::from_number`] tells whether it carries CAN.
    pub(crate) link_number: u16,
    pub(crate) link: Option<LinkType>,
    pub(crate) channel: ChannelId,
    pub(crate) clock: Clock,
    /// Number of lost frames reported so far.
    pub(crate) dropped: u64,
}

/// The clock of an interface.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Clock {
    unit: Unit,
    /// Offset that is added to all times, in seconds.
    offset: i64,
}

/// The unit of a time stamp.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Unit {
    /// The unit is this number of nanoseconds.
    Nanoseconds(u64),
    /// This number of units make one nanosecond.
    PerNanosecond(u64),
    /// The unit is 2^-n seconds.
    BinaryFraction(u32),
}

impl Unit {
    /// Parses the value of `if_tsresol`: bit 7 distinguishes powers of two from powers of ten.
    fn from_resolution(value: u8) -> Self {
        let exponent = u32::from(value & 0x7F);
        if value & 0x80 != 0 {
            Self::BinaryFraction(exponent)
        } else if exponent <= 9 {
            Self::Nanoseconds(10u64.pow(9 - exponent))
        } else {
            // 0 stands for a unit so small that 2^64 of them are less than a nanosecond.
            Self::PerNanosecond(10u64.checked_pow(exponent - 9).unwrap_or_default())
        }
    }
}

impl Default for Clock {
    fn default() -> Self {
        Self { unit: Unit::from_resolution(6), offset: 0 }
    }
}

impl Clock {
    /// The time in nanoseconds since 1970; `None` for a time before 1970 or after 2554.
    #[inline]
    pub(crate) fn timestamp(self, time: u64) -> Option<Timestamp> {
        if let (Unit::Nanoseconds(unit), 0) = (self.unit, self.offset) {
            return time.checked_mul(unit).map(Timestamp);
        }
        let nanos = match self.unit {
            Unit::Nanoseconds(unit) => u128::from(time) * u128::from(unit),
            Unit::PerNanosecond(units) => u128::from(time.checked_div(units).unwrap_or_default()),
            Unit::BinaryFraction(exponent) => (u128::from(time) * 1_000_000_000) >> exponent,
        };
        let nanos = nanos as i128 + i128::from(self.offset) * 1_000_000_000;
        u64::try_from(nanos).ok().map(Timestamp)
    }
}

/// The `number`th interface of its section, with this link type and these options. The flag tells whether all options
/// are readable.
pub(crate) fn described(
    order: Endianness,
    link_number: u16,
    options: &[u8],
    number: usize,
    channels: &mut Channels,
) -> (Interface, bool) {
    let (mut name, mut clock, mut readable) = (None, Clock::default(), true);
    let all = block::for_each_option(order, options, |code, value| match code {
        IF_NAME => name = Some(String::from_utf8_lossy(&value[..value.len().min(LONGEST_NAME)])),
        IF_TSRESOL => match value {
            [resolution, ..] => clock.unit = Unit::from_resolution(*resolution),
            [] => readable = false,
        },
        IF_TSOFFSET => match value.try_into() {
            Ok(seconds) => clock.offset = signed(order, seconds),
            Err(_) => readable = false,
        },
        _ => {}
    });
    let name = name.as_deref().map(|name| name.trim_end_matches('\0')).filter(|name| !name.is_empty());
    let channel = match name {
        Some(name) => channels.intern(name),
        None => channels.intern(&format!("can{number}")),
    };
    let link = LinkType::from_number(link_number);
    (Interface { link_number, link, channel, clock, dropped: 0 }, all && readable)
}

fn signed(order: Endianness, bytes: [u8; 8]) -> i64 {
    match order {
        Endianness::Big => i64::from_be_bytes(bytes),
        Endianness::Little => i64::from_le_bytes(bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(resolution: u8, offset: i64) -> Clock {
        Clock { unit: Unit::from_resolution(resolution), offset }
    }

    fn nanos(clock: Clock, time: u64) -> Option<u64> {
        clock.timestamp(time).map(Timestamp::nanos)
    }

    #[test]
    fn resolutions() {
        assert_eq!(nanos(Clock::default(), 1_700_000_000_123_456), Some(1_700_000_000_123_456_000));
        assert_eq!(nanos(clock(9, 0), 123), Some(123));
        assert_eq!(nanos(clock(0, 0), 3), Some(3_000_000_000));
        assert_eq!(nanos(clock(12, 0), 123_456), Some(123));
        assert_eq!(nanos(clock(0x80 | 10, 0), 1536), Some(1_500_000_000));
        assert_eq!(nanos(clock(0x80 | 127, 0), u64::MAX), Some(0));
        assert_eq!(nanos(clock(127, 0), u64::MAX), Some(0));
    }

    #[test]
    fn offsets_are_whole_seconds() {
        assert_eq!(nanos(clock(6, 1_700_000_000), 5), Some(1_700_000_000_000_005_000));
        assert_eq!(nanos(clock(6, -10), 10_000_001), Some(1_000));
    }

    #[test]
    fn times_that_no_record_can_hold_are_none() {
        assert_eq!(nanos(Clock::default(), u64::MAX), None);
        assert_eq!(nanos(clock(0, 0), u64::MAX), None);
        assert_eq!(nanos(clock(6, -10), 9_999_999), None);
        assert_eq!(nanos(clock(6, i64::MIN), u64::MAX), None);
        assert_eq!(nanos(clock(6, i64::MAX), u64::MAX), None);
        assert_eq!(nanos(clock(9, 0), u64::MAX), Some(u64::MAX));
    }
}
