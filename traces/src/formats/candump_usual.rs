//! A quick parser for the usual lines of a candump log.
//!
//! ```text
//! "(" 10 digits "." 6 or 9 digits ") " name " " (3 or 8 digits) "#" up to 16 digits [" R" | " T"] [CR] LF
//! ```
//!
//! The name occurred before, with the same padding. The grammar parses all other lines and all wrong ones; the quick
//! parser only gives the same result faster.

use crate::digits::{all_decimal, eight_decimal, hex_count, hex_prefix, three_hex};
use crate::lines::Passed;
use crate::{CanId, ChannelId, Direction, Frame, Place, Record, SkipSet, Timestamp};

/// The names that have occurred, each in the form between time and id.
#[derive(Default)]
pub(crate) struct Names(Vec<Name>);

struct Name {
    /// The padding, the name and the space after it, filled up with zeros.
    word: u64,
    /// The mask of the used bytes of the word.
    mask: u64,
    len: usize,
    channel: ChannelId,
}

impl Names {
    /// Maximum number of names. A log has one padded width at a time, so more names mean an unusual bus.
    const MOST: usize = 8;

    /// Remembers the form of a channel's name in a line, if it fits into a word; `frame` is the end of that line.
    pub(crate) fn learn(&mut self, line: &[u8], frame: &[u8], channel: ChannelId) {
        let behind_time = line.iter().position(|&byte| byte == b')').map_or(0, |at| at + 2);
        let text = line.get(behind_time..line.len() - frame.len()).unwrap_or_default();
        if text.len() > 8 || self.0.len() == Self::MOST || !text.ends_with(b" ") {
            return;
        }
        let mut bytes = [0; 8];
        bytes.iter_mut().zip(text).for_each(|(to, from)| *to = *from);
        let (word, mask) = (u64::from_le_bytes(bytes), u64::MAX >> (64 - 8 * text.len()));
        if !self.0.iter().any(|name| name.word == word) {
            self.0.push(Name { word, mask, len: text.len(), channel });
        }
    }

    #[inline]
    fn find(&self, text: &[u8; 8]) -> Option<&Name> {
        let word = u64::from_le_bytes(*text);
        self.0.iter().find(|name| word & name.mask == name.word)
    }
}

/// The frame of a usual line at the window's start, and the length of the line.
#[inline]
pub(crate) fn line(window: &[u8], names: &Names, place: Place) -> Option<(Record, usize)> {
    let (nanos, at) = time(window)?;
    let name = names.find(chunk(window, at)?)?;
    let (id, at) = identifier(window, at + name.len)?;
    frame(window, at, id, name.channel, Timestamp(nanos), place)
}

/// Like [`line`], but skips the line if its frame is in `skip`, and gives the direction. Values of a skipped frame are
/// not computed.
#[inline]
pub(crate) fn pass(window: &[u8], names: &Names, skip: &SkipSet, place: Place) -> Option<(Direction, Passed)> {
    let at = after_time(window)?;
    let name = names.find(chunk(window, at)?)?;
    let (id, at) = identifier(window, at + name.len)?;
    let skipped = skip.of(name.channel, id);
    if skipped.may_have() {
        let text = *chunk(window, at)?;
        let digits = hex_count(text);
        if skipped.has(|| hex_prefix(text).1, digits / 2) {
            let end = line_end(window, at + digits).filter(|_| digits.is_multiple_of(2));
            return end.map(|(direction, end)| (direction, Passed::Skipped(end)));
        }
    }
    let (nanos, _) = time(window)?;
    let (record, end) = frame(window, at, id, name.channel, Timestamp(nanos), place)?;
    Some((record.direction, Passed::Kept(record, end)))
}

/// The record of a line whose data begin at `at`, and the line's length.
#[inline(always)]
fn frame(
    window: &[u8],
    at: usize,
    id: CanId,
    channel: ChannelId,
    time: Timestamp,
    place: Place,
) -> Option<(Record, usize)> {
    let (digits, data) = hex_prefix(*chunk(window, at)?);
    if !digits.is_multiple_of(2) {
        return None;
    }
    let (direction, end) = line_end(window, at + digits)?;
    let frame = Frame::short(id, data, digits / 2);
    Some((Record::new(Timestamp::ZERO, channel, frame).seen(time, channel, direction, place), end))
}

/// The time of a usual line at the window's start.
pub(crate) fn time_of(window: &[u8]) -> Option<Timestamp> {
    time(window).map(|(nanos, _)| Timestamp(nanos))
}

#[inline]
fn chunk<const N: usize>(window: &[u8], at: usize) -> Option<&[u8; N]> {
    window.get(at..)?.first_chunk()
}

/// The time in nanoseconds, and the offset of the text after its parenthesis and one space.
#[inline(always)]
fn time(window: &[u8]) -> Option<(u64, usize)> {
    let head: &[u8; 24] = window.first_chunk()?;
    let [b'(', s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, b'.', fraction @ ..] = *head else { return None };
    let seconds = u64::from(eight_decimal([s0, s1, s2, s3, s4, s5, s6, s7])?) * 100 + two_decimal(s8, s9)?;
    let [f0, f1, f2, f3, f4, f5, f6, f7, f8, after, space, _] = fraction;
    let (fraction, at) = if f6 == b')' && f7 == b' ' {
        (u64::from(eight_decimal([f0, f1, f2, f3, f4, f5, b'0', b'0'])?) * 10, 20)
    } else if after == b')' && space == b' ' {
        (u64::from(eight_decimal([f0, f1, f2, f3, f4, f5, f6, f7])?) * 10 + two_decimal(b'0', f8)?, 23)
    } else {
        return None;
    };
    // Seconds of ten digits are below 2^64 nanoseconds.
    Some((seconds * 1_000_000_000 + fraction, at))
}

/// The offset of the text after the time; agrees with [`time`].
#[inline]
fn after_time(window: &[u8]) -> Option<usize> {
    let head: &[u8; 24] = window.first_chunk()?;
    let [b'(', s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, b'.', fraction @ ..] = *head else { return None };
    let [f0, f1, f2, f3, f4, f5, f6, f7, f8, after, space, _] = fraction;
    if !(all_decimal([s0, s1, s2, s3, s4, s5, s6, s7]) && s8.is_ascii_digit() && s9.is_ascii_digit()) {
        return None;
    }
    if f6 == b')' && f7 == b' ' {
        return all_decimal([f0, f1, f2, f3, f4, f5, b'0', b'0']).then_some(20);
    }
    let nine = all_decimal([f0, f1, f2, f3, f4, f5, f6, f7]) && f8.is_ascii_digit();
    (nine && after == b')' && space == b' ').then_some(23)
}

#[inline]
fn two_decimal(tens: u8, ones: u8) -> Option<u64> {
    let (tens, ones) = (tens.wrapping_sub(b'0'), ones.wrapping_sub(b'0'));
    (tens < 10 && ones < 10).then(|| u64::from(10 * tens + ones))
}

/// An identifier of 3 or 8 digits without the error bit, and the offset of the text after its `#`.
#[inline(always)]
fn identifier(window: &[u8], at: usize) -> Option<(CanId, usize)> {
    let text: &[u8; 9] = chunk(window, at)?;
    let [i0, i1, i2, i3, i4, i5, i6, i7, i8] = *text;
    if i3 == b'#' {
        return Some((CanId::standard(three_hex([i0, i1, i2])?)?, at + 4));
    }
    let (8, [a, b, c, d, ..]) = hex_prefix([i0, i1, i2, i3, i4, i5, i6, i7, 0, 0, 0, 0, 0, 0, 0, 0]) else {
        return None;
    };
    let id = CanId::extended(u32::from_be_bytes([a, b, c, d]))?;
    (i8 == b'#').then_some((id, at + 9))
}

/// The direction after the data, and the offset of the next line.
#[inline]
fn line_end(window: &[u8], at: usize) -> Option<(Direction, usize)> {
    match window.get(at..)? {
        [b'\n', ..] => Some((Direction::Unknown, at + 1)),
        [b'\r', b'\n', ..] => Some((Direction::Unknown, at + 2)),
        [b' ', letter @ (b'R' | b'T'), rest @ ..] => {
            let direction = if *letter == b'R' { Direction::Rx } else { Direction::Tx };
            match rest {
                [b'\n', ..] => Some((direction, at + 3)),
                [b'\r', b'\n', ..] => Some((direction, at + 4)),
                _ => None,
            }
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Format, ReadOptions, Source};
    use proptest::prelude::*;

    const FIRST: &str = "(1700000000.000000)   can0 123#\n(1700000000.000000) vcan10 123#\n";

    fn names() -> Names {
        let mut names = Names::default();
        for (n, line) in FIRST.lines().enumerate() {
            names.learn(line.as_bytes(), b"123#", ChannelId(n as u16));
        }
        names.learn(b"(1700000000.000000) can0 123#", b"123#", ChannelId(0));
        names
    }

    /// The records that the grammar reads from a line. The space before the line makes it unusual.
    fn by_grammar(line: &str) -> Vec<Option<Record>> {
        let source = Source::from_bytes(format!("{FIRST} {line}"));
        let reader = Format::Candump.open(source, &ReadOptions::default());
        reader.skip(2).map(|item| item.ok().map(|record| record.at(0, 0))).collect()
    }

    /// A usual line, in which one byte may be changed.
    fn nearly_usual() -> impl Strategy<Value = Vec<u8>> {
        let usual = "\\([0-9]{10}\\.([0-9]{6}|[0-9]{9})\\) (  can0|can0|vcan10) [0-7][0-9A-Fa-f]{2}#([0-9A-Fa-f]{2}){0,8}( R| T)?\r?\n";
        let other = proptest::option::of((any::<proptest::sample::Index>(), any::<u8>()));
        (usual, other).prop_map(|(line, other)| {
            let mut line = line.into_bytes();
            if let Some((at, byte)) = other {
                *at.get_mut(&mut line) = byte;
            }
            line
        })
    }

    proptest! {
        #[test]
        fn a_line_is_passed_over_exactly_where_it_is_read(line in nearly_usual(), only_a_byte in any::<bool>()) {
            let text = [&line[..], b"(1700000000.123456) can0 181#00\n"].concat();
            let read = super::line(&text, &names(), Place::default());
            let first = read.as_ref().and_then(|(record, _)| record.data().first().copied()).unwrap_or_default();
            let mut skip = SkipSet::default();
            for (channel, id) in [0, 1].into_iter().flat_map(|channel| (0..0x800).map(move |id| (ChannelId(channel), id))) {
                match (only_a_byte, id % 3) {
                    (_, 0) => {}
                    (true, _) => skip.byte(channel, id, first),
                    (false, _) => skip.all(channel, id),
                }
            }
            let passed = pass(&text, &names(), &skip, Place::default());
            let expected = read.clone().map(|(record, len)| match skip.skips(&record) {
                true => (record.direction, Passed::Skipped(len)),
                false => (record.direction, Passed::Kept(record, len)),
            });
            let time = passed.as_ref().and_then(|_| time_of(&text));
            prop_assert_eq!(passed, expected);
            prop_assert_eq!(time, read.map(|(record, _)| record.timestamp));
        }
    }

    fn at_a_glance(line: &str) -> Option<(Record, usize)> {
        super::line(line.as_bytes(), &names(), Place::default())
    }

    #[test]
    fn usual_lines_are_seen() {
        for line in [
            "(1700000000.123456) can0 181#0011223344556677\n",
            "(1700000000.123456789)   can0 181#\n",
            "(1700000000.123456) vcan10 12345678#aAbB R\n",
            "(1700000000.123456) can0 7FF#01 T\r\n",
        ] {
            let rest = format!("{line}(1700000000.123456) can0 181#00\n");
            let (record, len) = at_a_glance(&rest).unwrap();
            assert_eq!((by_grammar(line), len), (vec![Some(record)], line.len()), "{line}");
        }
    }

    proptest! {
        #[test]
        fn what_is_seen_at_a_glance_is_what_the_grammar_says(
            seconds in "[0-9]{10}",
            fraction in "[0-9]{6}|[0-9]{9}|[0-9]{5,10}",
            name in "can0|  can0| can0|vcan10|can1|can0 ",
            id in "[0-7][0-9A-Fa-f]{2}|[01][0-9A-F]{7}|[0-9A-F]{2,9}",
            data in "([0-9A-Fa-f]{2}){0,8}|[0-9A-F._R#]{0,20}",
            end in "\n| R\n| T\n|\r\n| R\r\n| \n| 0\n| R T\n|_9\n",
            change in prop::option::of((any::<prop::sample::Index>(), "[ -~\t\r\n]")),
        ) {
            let mut line = format!("({seconds}.{fraction}) {name} {id}#{data}{end}");
            if let Some((at, to)) = change {
                let at = at.index(line.len());
                line.replace_range(at..=at, &to);
            }
            let lines = format!("{line}{:64}", "");
            if let Some((record, len)) = at_a_glance(&lines) {
                prop_assert_eq!(by_grammar(&line[..len]), vec![Some(record)]);
            }
        }
    }
}
