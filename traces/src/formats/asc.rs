//! Vector ASC: the text format of CANoe and CANalyzer.
//!
//! ```text
//! date Sat Sep 30 15:06:13.191 2017
//! base hex  timestamps absolute
//! internal events logged
//! // a comment; other tools begin it with a semicolon
//! Begin Triggerblock Sat Sep 30 15:06:13.191 2017
//!    0.000000 Start of measurement
//!    3.098426 1  18EBFF00x       Rx   d 8 01 A0 0F A6 60 3B D1 40  Length = 273910 BitCount = 141 ID = 418119424x
//!    3.100000 CANFD   1 Rx        7d  BrakeData   1 0 9 12 01 .. 0c   104812  132   323000 a800f6c9 ..
//!    3.200000 1  ErrorFrame
//! End TriggerBlock
//! ```
//!
//! Pitfalls:
//!
//! - The date is in the recorder's local time, in English or German, with 24 hours or AM and PM. The date of the first
//!   trigger block counts, because times count from there. Without a date, times count from the start.
//! - Times have 4, 5, 6 or 9 decimals. **A relative time is the difference to the event before, of any kind**, so rows
//!   without frames move the clock, too.
//! - **The DLC is one hex digit**, even with `base dec`, which applies to ids and data only.
//! - Rows of kind `CANFD`: the symbolic name may be absent, the DLC is hex and the length decimal. **Such a row may
//!   carry a classical frame**: then bit 1000h of the flags (FDF) is clear; bit 10h marks a remote frame. Other tools
//!   write flags of 0 for CAN FD frames: a length that only CAN FD has, BRS or ESI then show that the frame is CAN FD.
//! - `TxRq` is the request to send, not a frame on the bus; the `Tx` row follows when the frame was sent. `TxRq` is
//!   ignored like other known events (`Statistic:`, `J1939TP`, `Status:`). A row of any other kind is reported as
//!   unsupported: it may be a frame whose first word is damaged.
//! - `ErrorFrame` gives no class that is the same in all versions; it is read as a bus error without detail.
//!
//! A last line without line end is read if it has all bytes that its DLC promises, and its last number can't continue;
//! a `CANFD` row must go on after its flags.

use crate::formats::asc_row::{self, AscRow, Radix};
use crate::grammar::{Expected, decimal, seconds, skip_blanks, word};
use crate::lines::{Line, LineFormat, TextReader, head_lines};
use crate::{
    Channels, Damage, DamageKind, ReadOptions, Reader, Record, Source, TimeBase, Timestamp,
    formats::candump_log::intern,
};
use jiff::civil;

pub(crate) use crate::formats::asc_writer::create;

const SNIFF_LINES: usize = 20;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head_lines(head).take(SNIFF_LINES).any(|(line, _)| match header(line) {
        Some(Header::Date(Some(_)) | Header::Base(..) | Header::Block(_)) => true,
        Some(_) => false,
        None => seconds(skip_blanks(line)).is_ok_and(|(rest, _)| is_frame(rest)),
    })
}

/// Whether the text is a row of a capture without header.
fn is_frame(rest: &[u8]) -> bool {
    matches!(asc_row::row(rest, Radix::Hexadecimal), Ok((_, AscRow::Frame { .. } | AscRow::Request)))
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(TextReader::new(source, Asc::default()))
}

#[derive(Default)]
struct Asc {
    radix: Radix,
    relative: bool,
    /// The start of the recording, in local time.
    start: Option<u64>,
    block_seen: bool,
    /// The time of the last event since the start.
    now: Timestamp,
}

/// The expected text for a time that a record can't hold.
pub(crate) const LATEST: &str = "a time before the year 2554";

impl LineFormat for Asc {
    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        match header(line.bytes) {
            Some(header) => self.header(line, header).map(Err),
            None => self.event(line, channels).transpose(),
        }
    }

    fn time_base(&self) -> TimeBase {
        if self.start.is_some() { TimeBase::Local } else { TimeBase::Start }
    }
}

impl Asc {
    fn header(&mut self, line: &Line<'_>, header: Header) -> Option<Damage> {
        let date = match header {
            Header::Nothing => return None,
            Header::Base(radix, relative) => {
                (self.radix, self.relative) = (radix, relative);
                return None;
            }
            Header::Date(date) => date,
            Header::Block(_) if std::mem::replace(&mut self.block_seen, true) => return None,
            Header::Block(None) => return None,
            Header::Block(date) => date,
        };
        match date {
            Some(_) => {
                self.start = date;
                None
            }
            None => Some(line.as_damage(DamageKind::Unsupported, "a date such as Sat Sep 30 15:06:13.191 2017")),
        }
    }

    /// Parses a row: an event with its time.
    fn event(&mut self, line: &Line<'_>, channels: &mut Channels) -> Result<Option<Record>, Damage> {
        let damage = |error| line.damage(Expected::from(error));
        let (rest, time) = seconds(skip_blanks(line.bytes)).map_err(damage)?;
        if !matches!(rest.first(), Some(b' ' | b'\t')) {
            return Err(line.damage(Expected::new(rest, "a space after the time")));
        }
        let before = if self.relative { self.now } else { Timestamp::ZERO };
        self.now = before.after(time).ok_or_else(|| line.malformed(LATEST))?;
        match asc_row::row(rest, self.radix).map_err(damage)?.1 {
            AscRow::Unknown if !line.ended => Err(line.cut("the end of this row")),
            AscRow::Unknown => Err(line.as_damage(DamageKind::Unsupported, "a CAN or CAN FD frame, or a known event")),
            AscRow::Event if !line.ended && may_become_a_frame(skip_blanks(rest)) => {
                Err(line.cut("the end of this row"))
            }
            AscRow::Event | AscRow::Request => Ok(None),
            AscRow::Frame { in_doubt: true, .. } if !line.ended => {
                Err(line.cut("the end of this line, as the frame may go on,"))
            }
            AscRow::Frame { channel, mut record, .. } => {
                record.channel = intern(channel, channels).map_err(|missing| line.damage(missing))?;
                let time = self.now.after(self.start.unwrap_or(0));
                record.timestamp = time.ok_or_else(|| line.malformed(LATEST))?;
                record.place = line.place;
                Ok(Some(record))
            }
        }
    }
}

/// Whether a row that the end of the file cuts may be a frame: it has a channel, or the beginning of a kind of frame.
fn may_become_a_frame(text: &[u8]) -> bool {
    let kind = text.first().is_some_and(|first| first.is_ascii_alphabetic()) && b"CANFD".starts_with(text);
    kind || text.first().is_some_and(u8::is_ascii_digit)
}

/// A line other than a row.
#[derive(Clone, Copy)]
enum Header {
    Nothing,
    /// A date; `None` if it can't be read.
    Date(Option<u64>),
    /// The base of ids and data, and whether times are relative.
    Base(Radix, bool),
    Block(Option<u64>),
}

fn header(line: &[u8]) -> Option<Header> {
    let text = skip_blanks(line);
    let (rest, first) = word("a word")(text).unwrap_or((&[], &[]));
    let second = word("a word")(skip_blanks(rest)).map_or(&b""[..], |(_, second)| second);
    let is = |word: &[u8], name: &str| word.eq_ignore_ascii_case(name.as_bytes());
    match first {
        [] | [b'/', b'/', ..] => Some(Header::Nothing),
        [b';', ..] if !begins_with_time(text.get(1..).unwrap_or_default()) => Some(Header::Nothing),
        _ if is(first, "date") => Some(Header::Date(date(rest))),
        _ if is(first, "base") => {
            let radix = if is(second, "dec") { Radix::Decimal } else { Radix::Hexadecimal };
            let relative = rest.windows(8).any(|w| w.eq_ignore_ascii_case(b"relative"));
            (is(second, "dec") || is(second, "hex")).then_some(Header::Base(radix, relative))
        }
        _ if is(first, "begin") && is(second, "triggerblock") => {
            let (behind, _) = word("a word")(skip_blanks(rest)).unwrap_or_default();
            Some(Header::Block(date(behind)))
        }
        _ if is(first, "end") && is(second, "triggerblock") => Some(Header::Nothing),
        _ if is(first, "internal") || is(first, "no") && is(second, "internal") => Some(Header::Nothing),
        _ if is(first, "previous") => Some(Header::Nothing),
        _ => None,
    }
}

/// Whether the text after the first byte of a line begins with a time, or with the rest of a time. Then the first byte
/// is damaged and does not begin a comment.
fn begins_with_time(behind: &[u8]) -> bool {
    [skip_blanks(behind), &[b"0", behind].concat()].into_iter().any(|text| seconds(text).is_ok())
}

/// Parses a date such as `Sat Sep 30 15:06:13.191 2017`, with or without AM or PM; gives nanoseconds since 1970 as if
/// it were UTC.
fn date(text: &[u8]) -> Option<u64> {
    let mut words = text.split(|&b| b == b' ' || b == b'\t').filter(|word| !word.is_empty());
    let (_weekday, month, day, time) = (words.next()?, words.next()?, words.next()?, words.next()?);
    let (mut year, mut half) = (words.next()?, None);
    if year.eq_ignore_ascii_case(b"am") || year.eq_ignore_ascii_case(b"pm") {
        half = Some(year.eq_ignore_ascii_case(b"pm"));
        year = words.next()?;
    }
    let number = |text: &[u8]| std::str::from_utf8(text).ok()?.parse::<i16>().ok();
    let narrow = |text: &[u8]| i8::try_from(number(text)?).ok();
    let mut parts = time.splitn(3, |&b| b == b':');
    let (hour, minute, second) = (narrow(parts.next()?)?, narrow(parts.next()?)?, parts.next()?);
    let hour = match half {
        Some(pm) if (1..=12).contains(&hour) => hour % 12 + if pm { 12 } else { 0 },
        Some(_) => return None,
        None => hour,
    };
    let (rest, second_number) = decimal("seconds")(second).ok()?;
    let fraction = match rest {
        [] => 0,
        // Some versions write the milliseconds without leading zeros, which is indistinguishable from a decimal
        // fraction.
        [b'.', digits @ ..] => crate::grammar::billionths(digits).ok()?.1,
        _ => return None,
    };
    let date = civil::Date::new(number(year)?, month_number(month)?, narrow(day)?).ok()?;
    let second = i8::try_from(second_number).ok()?;
    let time = civil::Time::new(hour, minute, second, i32::try_from(fraction).ok()?).ok()?;
    crate::local_time::nanos(date.to_datetime(time))
}

/// The number of a month by the first three letters of its English or German name; an umlaut may be in Latin-1 or
/// UTF-8.
fn month_number(name: &[u8]) -> Option<i8> {
    let head: Vec<u8> = name.iter().take(3).map(u8::to_ascii_lowercase).collect();
    let number = match head.as_slice() {
        b"jan" => 1,
        b"feb" => 2,
        b"mar" | b"mrz" | b"m\xE4r" | b"m\xC3\xA4" => 3,
        b"apr" => 4,
        b"may" | b"mai" => 5,
        b"jun" => 6,
        b"jul" => 7,
        b"aug" => 8,
        b"sep" => 9,
        b"oct" | b"okt" => 10,
        b"nov" => 11,
        b"dec" | b"dez" => 12,
        _ => return None,
    };
    Some(number)
}
