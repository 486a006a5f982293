//! What an interface description block says, and the clock of its packets.

use super::block::{self, IF_NAME, IF_TSOFFSET, IF_TSRESOL};
use crate::formats::socketcan::LinkType;
use crate::{ChannelId, Channels, Timestamp};
use nom::number::Endianness;
use nom::number::complete::{u16, u32};
use nom::{IResult, Parser};

/// The longest channel name that is kept, in bytes; interface names have at most 15.
const LONGEST_NAME: usize = 256;

/// An interface of the current section.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interface {
    /// As in the block; [`LinkType::from_number`] tells whether it is one of ours.
    pub(crate) link_number: u16,
    pub(crate) link: Option<LinkType>,
    pub(crate) snapshot: u32,
    pub(crate) channel: ChannelId,
    pub(crate) clock: Clock,
    /// How many lost frames were reported so far.
    pub(crate) dropped: u64,
}

/// How an interface counts time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Clock {
    unit: Unit,
    /// Seconds.
    offset: i64,
}

/// The unit of a time stamp.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Unit {
    /// That many nanoseconds.
    Nanoseconds(u64),
    /// That many of them are a nanosecond.
    PerNanosecond(u64),
    /// 2^-n seconds.
    BinaryFraction(u32),
}

impl Unit {
    /// From the value of `if_tsresol`: bit 7 tells powers of two from powers of ten.
    fn from_resolution(value: u8) -> Self {
        let exponent = u32::from(value & 0x7F);
        if value & 0x80 != 0 {
            Self::BinaryFraction(exponent)
        } else if exponent <= 9 {
            Self::Nanoseconds(10u64.pow(9 - exponent))
        } else {
            // 0 stands for units so small that 2^64 of them are no nanosecond.
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
    /// Nanoseconds; times before 1970 become 0.
    pub(crate) fn timestamp(self, time: u64) -> Timestamp {
        if let (Unit::Nanoseconds(unit), 0) = (self.unit, self.offset) {
            return Timestamp(time.saturating_mul(unit));
        }
        let nanos = match self.unit {
            Unit::Nanoseconds(unit) => u128::from(time) * u128::from(unit),
            Unit::PerNanosecond(units) => u128::from(time.checked_div(units).unwrap_or_default()),
            Unit::BinaryFraction(exponent) => (u128::from(time) * 1_000_000_000) >> exponent,
        };
        let nanos = nanos as i128 + i128::from(self.offset) * 1_000_000_000;
        Timestamp(u64::try_from(nanos.max(0)).unwrap_or(u64::MAX))
    }
}

/// The body of an interface description block, the `number`th of its section. The flag tells whether all
/// options could be read.
pub(crate) fn description<'a>(
    order: Endianness,
    number: usize,
    channels: &mut Channels,
    body: &'a [u8],
) -> IResult<&'a [u8], (Interface, bool)> {
    let (options, (link_number, _, snapshot)) = (u16(order), u16(order), u32(order)).parse(body)?;
    let (mut name, mut clock, mut readable) = (None, Clock::default(), true);
    let all = block::for_each_option(order, options, |code, value| match code {
        IF_NAME => name = Some(String::from_utf8_lossy(&value[..value.len().min(LONGEST_NAME)])),
        IF_TSRESOL => match value {
            [resolution, ..] => clock.unit = Unit::from_resolution(*resolution),
            [] => readable = false,
        },
        IF_TSOFFSET => match block::option_u64(order, value) {
            Some(seconds) => clock.offset = seconds as i64,
            None => readable = false,
        },
        _ => {}
    });
    let name = name.as_deref().map(|name| name.trim_end_matches('\0')).filter(|name| !name.is_empty());
    let channel = match name {
        Some(name) => channels.intern(name),
        None => channels.intern(&format!("can{number}")),
    };
    let link = LinkType::from_number(link_number);
    Ok((&[], (Interface { link_number, link, snapshot, channel, clock, dropped: 0 }, all && readable)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(resolution: u8, offset: i64) -> Clock {
        Clock { unit: Unit::from_resolution(resolution), offset }
    }

    #[test]
    fn resolutions() {
        assert_eq!(Clock::default().timestamp(1_700_000_000_123_456).nanos(), 1_700_000_000_123_456_000);
        assert_eq!(clock(9, 0).timestamp(123).nanos(), 123);
        assert_eq!(clock(0, 0).timestamp(3).nanos(), 3_000_000_000);
        assert_eq!(clock(12, 0).timestamp(123_456).nanos(), 123);
        assert_eq!(clock(0x80 | 10, 0).timestamp(1536).nanos(), 1_500_000_000);
        assert_eq!(clock(0x80 | 127, 0).timestamp(u64::MAX).nanos(), 0);
        assert_eq!(clock(127, 0).timestamp(u64::MAX).nanos(), 0);
        assert_eq!(clock(0, 0).timestamp(u64::MAX), Timestamp::MAX);
    }

    #[test]
    fn offsets_are_whole_seconds() {
        assert_eq!(clock(6, 1_700_000_000).timestamp(5).nanos(), 1_700_000_000_000_005_000);
        assert_eq!(clock(6, -10).timestamp(10_000_001).nanos(), 1_000);
        assert_eq!(clock(6, i64::MIN).timestamp(u64::MAX).nanos(), 0);
        assert_eq!(clock(6, i64::MAX).timestamp(u64::MAX), Timestamp::MAX);
    }
}
