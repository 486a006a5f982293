//! IXXAT MiniMon CSV: the trace export of MiniMon and canAnalyser.
//!
//! ```text
//! ASCII Trace IXXAT MiniMon V3  Version: 1.1.4.4533
//! Date: 28.01.2025
//! Start time: 10:47:15
//! Stop time: 10:48:02
//! Overruns: 0
//! Baudrate: 250 kbit/s
//! "Time";"Identifier (hex)";"Format";"Flags";"Data (hex)"
//! "10:47:15.23";"83";"Std";"";"00 11 22 "
//! ```
//!
//! - Separators are semicolons or, with English settings, commas; quotes may be absent. Dates are `28.01.2025`,
//!   `1/28/2025` or `2025-01-28`; times may have AM or PM. All are in local time.
//! - Ids have no leading zeros, so only `Std` and `Ext` distinguish 11 and 29 bits. The data ends with a blank.
//! - Times have two or three decimals. They are times of the day if the first time is not before the header's start
//!   time; otherwise they count from it. A time of the day that decreases by more than half a day is past midnight.
//! - `Baudrate` is the bit rate of the bus, in kbit/s or Mbit/s; any other text is ignored.
//! - `Overruns` is the number of frames that the recorder lost.
//! - A remote frame has `Rtr` in its flags, a frame that the recorder sent itself has `Self`.
//!
//! The data's closing quote shows that a last line without line end is whole.

use crate::formats::asc::LATEST;
use crate::grammar::{Expected, Parsed, billionths, decimal, hex_byte, hexadecimal, skip_blanks, tag};
use crate::lines::{Line, LineFormat, TextReader, head_lines};
use crate::{
    CanId, Channels, Damage, DamageKind, Direction, Frame, ReadOptions, Reader, Record, Source, TimeBase, Timestamp,
};
use jiff::civil;

const SECOND: u64 = 1_000_000_000;
const DAY: u64 = 86_400 * SECOND;

/// The name of the only channel.
const CHANNEL: &str = "1";
const SNIFF_LINES: usize = 20;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head_lines(head)
        .take(SNIFF_LINES)
        .any(|(line, _)| line.trim_ascii_start().starts_with(b"ASCII Trace IXXAT") || row(line).is_ok())
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(TextReader::new(source, MiniMon::default()))
}

#[derive(Default)]
struct MiniMon {
    /// Nanoseconds from 1970 to the date in the header.
    date: Option<u64>,
    /// The start time in the header, in nanoseconds of the day.
    start: Option<u64>,
    /// The offset that is added to the rows' times.
    zero: Option<u64>,
    /// Whether the times in rows are times of the day.
    of_day: bool,
    last: u64,
    /// Bit rate of the bus in bit/s.
    bit_rate: Option<u32>,
}

impl LineFormat for MiniMon {
    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        let text = line.bytes.trim_ascii();
        match text {
            [] => None,
            [b'"', b'0'..=b'9', ..] | [b'0'..=b'9', ..] => Some(self.row(line, channels)),
            _ => self.header(line, text).map(Err),
        }
    }

    fn time_base(&self) -> TimeBase {
        if self.date.is_some() { TimeBase::Local } else { TimeBase::Start }
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bit_rate
    }
}

impl MiniMon {
    fn header(&mut self, line: &Line<'_>, text: &[u8]) -> Option<Damage> {
        let unsupported = |what| Some(line.as_damage(DamageKind::Unsupported, what));
        if let Some(date) = text.strip_prefix(b"Date:") {
            self.date = parse_date(date);
            return if self.date.is_none() { unsupported("a date such as 28.01.2025") } else { None };
        }
        if let Some(time) = text.strip_prefix(b"Start time:") {
            self.start = start_time(time);
            return if self.start.is_none() { unsupported("a time such as 10:47:15") } else { None };
        }
        if let Some(count) = text.strip_prefix(b"Overruns:") {
            return match decimal("a number")(skip_blanks(count)) {
                Ok((_, 0)) => None,
                Ok((_, lost)) => Some(Damage::dropped(lost, line.place)),
                Err(_) => Some(line.malformed("a number of lost frames")),
            };
        }
        if let Some(rate) = text.strip_prefix(b"Baudrate:") {
            self.bit_rate = bit_rate(rate);
            return None;
        }
        let known = [&b"ASCII Trace"[..], b"Stop time:", b"\"Time\"", b"Time"];
        if known.iter().any(|known| text.starts_with(known)) {
            return None;
        }
        Some(line.damage(Expected::new(text, "a row such as \"10:47:15.23\";\"83\";\"Std\";\"\";\"00 11\"")))
    }

    fn row(&mut self, line: &Line<'_>, channels: &mut Channels) -> Result<Record, Damage> {
        let (rest, row) = row(line.bytes).map_err(|error| line.damage(error.into()))?;
        if !line.ended && !row.closed {
            return Err(line.cut("the end of this line, as the frame may go on,"));
        }
        if !skip_blanks(rest).is_empty() {
            return Err(line.damage(Expected::new(rest, "the end of the line")));
        }
        let time = self.time(row.time).ok_or_else(|| line.malformed(LATEST))?;
        let mut record = Record::new(time, channels.intern(CHANNEL), row.frame);
        record.direction = row.direction;
        record.place = line.place;
        Ok(record)
    }

    fn time(&mut self, time: u64) -> Option<Timestamp> {
        let zero = *self.zero.get_or_insert_with(|| {
            self.of_day = self.start.is_none_or(|start| time >= start);
            self.date.map_or(0, |date| date.saturating_add(if self.of_day { 0 } else { self.start.unwrap_or(0) }))
        });
        if self.of_day && time + DAY / 2 < self.last {
            self.zero = Some(zero.saturating_add(DAY));
        }
        self.last = time;
        Timestamp(time).after(self.zero.unwrap_or(zero))
    }
}

/// Parses a bit rate such as `250 kbit/s` into bit/s. The decimal point may be a comma.
fn bit_rate(text: &[u8]) -> Option<u32> {
    const FASTEST: f64 = 1e6;
    let text = std::str::from_utf8(text).ok()?.trim().replace(',', ".");
    let unit = text.find(|c: char| c != '.' && !c.is_ascii_digit())?;
    let (number, unit) = text.split_at_checked(unit)?;
    let factor = match unit.trim().to_ascii_lowercase().as_str() {
        "bit/s" | "bps" | "baud" | "bd" => 1.0,
        "kbit/s" | "kbps" | "kbaud" | "kbd" => 1e3,
        "mbit/s" | "mbps" | "mbaud" | "mbd" => 1e6,
        _ => return None,
    };
    let rate = number.parse::<f64>().ok()? * factor;
    (1.0..=FASTEST).contains(&rate).then_some(rate as u32)
}

struct MinimonRow {
    time: u64,
    frame: Frame,
    direction: Direction,
    /// Whether the data's quotes are closed.
    closed: bool,
}

fn row(input: &[u8]) -> Parsed<'_, MinimonRow> {
    let (rest, (time_text, _)) = field(skip_blanks(input))?;
    let (after, time) = time_of_day(time_text)?;
    end_of_field(after)?;
    let (rest, (id_text, _)) = field(separator(rest)?.0)?;
    let (after, raw) = hexadecimal("an id in hex")(id_text)?;
    end_of_field(after)?;
    let (rest, (format, _)) = field(separator(rest)?.0)?;
    let id = match format {
        _ if format.eq_ignore_ascii_case(b"Std") => CanId::standard(raw),
        _ if format.eq_ignore_ascii_case(b"Ext") => CanId::extended(raw),
        _ => return Expected::fail(format, "Std or Ext"),
    };
    let Some(id) = id else { return Expected::fail(id_text, "an id of at most 7FF (Std) or 1FFFFFFF (Ext)") };
    let (rest, (flags, _)) = field(separator(rest)?.0)?;
    let (rest, (data, closed)) = field(separator(rest)?.0)?;
    let has = |flag: &[u8]| flags.windows(flag.len()).any(|w| w.eq_ignore_ascii_case(flag));
    let direction = if has(b"self") { Direction::Tx } else { Direction::Unknown };
    let frame = if has(b"rtr") || has(b"rem") { remote(id, data) } else { data_frame(id, data)? };
    match frame {
        Some(frame) => Ok((rest, MinimonRow { time, frame, direction, closed })),
        None => Expected::fail(data, "at most 8 bytes"),
    }
}

/// Parses a remote frame. The data column may hold its length.
fn remote(id: CanId, text: &[u8]) -> Option<Frame> {
    let digit = text.iter().find(|b| b.is_ascii_digit()).map_or(0, |b| b - b'0');
    Frame::remote(id, digit)
}

fn data_frame(id: CanId, text: &[u8]) -> Result<Option<Frame>, nom::Err<Expected<'_>>> {
    let mut data = Vec::new();
    let mut rest = skip_blanks(text);
    while !rest.is_empty() && data.len() <= 8 {
        let (after, byte) = hex_byte(rest)?;
        if !matches!(after, [] | [b' ', ..]) {
            return Expected::fail(after, "a space after the byte").map(|(_, none)| none);
        }
        data.push(byte);
        rest = skip_blanks(after);
    }
    Ok(Frame::new(id, &data))
}

/// Parses a field; gives the text without quotes, and whether the quotes are closed.
fn field(input: &[u8]) -> Parsed<'_, (&[u8], bool)> {
    if let [b'"', inside @ ..] = input {
        let end = inside.iter().position(|&b| b == b'"');
        return match end.and_then(|end| inside.split_at_checked(end)) {
            Some((text, rest)) => Ok((rest.get(1..).unwrap_or_default(), (text, true))),
            None => Expected::fail(&input[input.len()..], "a closing quote"),
        };
    }
    let end = input.iter().position(|b| b";,\t".contains(b)).unwrap_or(input.len());
    let (text, rest) = input.split_at_checked(end).unwrap_or((input, &[]));
    Ok((rest, (text, false)))
}

fn separator(input: &[u8]) -> Parsed<'_, ()> {
    match input {
        [b';' | b',' | b'\t', rest @ ..] => Ok((rest, ())),
        _ => Expected::fail(input, "a semicolon or comma"),
    }
}

fn end_of_field(rest: &[u8]) -> Result<(), nom::Err<Expected<'_>>> {
    if rest.is_empty() { Ok(()) } else { Err(nom::Err::Error(Expected::new(rest, "the end of the field"))) }
}

/// Parses `hh:mm:ss.cc`; the value is in nanoseconds.
fn time_of_day(input: &[u8]) -> Parsed<'_, u64> {
    let (rest, hour) = decimal("hours")(input)?;
    let (rest, ()) = tag(b":", "':'")(rest)?;
    let (rest, minute) = decimal("minutes")(rest)?;
    let (rest, ()) = tag(b":", "':'")(rest)?;
    let (rest, second) = decimal("seconds")(rest)?;
    let (rest, fraction) = match rest {
        [b'.', digits @ ..] => billionths(digits)?,
        _ => (rest, 0),
    };
    // A recording of more than a day may continue beyond 24 hours.
    if hour >= 24 * 366 || minute >= 60 || second >= 60 {
        return Expected::fail(input, "a time such as 10:47:15.23");
    }
    Ok((rest, (hour * 3600 + minute * 60 + second) * SECOND + u64::from(fraction)))
}

/// Parses a time of the day with or without AM or PM.
fn start_time(text: &[u8]) -> Option<u64> {
    let (rest, time) = time_of_day(text.trim_ascii()).ok()?;
    let half_day = 12 * 3600 * SECOND;
    match rest.trim_ascii() {
        [] if time < DAY => Some(time),
        half if half.eq_ignore_ascii_case(b"am") => Some(time % half_day),
        half if half.eq_ignore_ascii_case(b"pm") => Some(time % half_day + half_day),
        _ => None,
    }
}

/// Parses a date in the order that its separator and the sizes of its numbers suggest; gives nanoseconds since 1970.
fn parse_date(text: &[u8]) -> Option<u64> {
    let text = std::str::from_utf8(text).ok()?.trim();
    let mut parts = text.splitn(3, ['.', '/', '-', ':']).map(|part| part.trim().parse::<i16>().ok());
    let (a, b, c) = (parts.next()??, parts.next()??, parts.next()??);
    let (year, month, day) = match () {
        () if a > 31 => (a, b, c),
        () if text.contains('/') && a <= 12 => (c, a, b),
        () => (c, b, a),
    };
    let date = civil::Date::new(year, i8::try_from(month).ok()?, i8::try_from(day).ok()?).ok()?;
    crate::local_time::nanos(date.at(0, 0, 0, 0))
}
