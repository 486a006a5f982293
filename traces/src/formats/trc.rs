//! PEAK TRC 1.0 to 2.1: what PCAN-View and PCAN-Explorer record.
//!
//! ```text
//! ;$FILEVERSION=2.1
//! ;$STARTTIME=44548.6028595139
//! ;$COLUMNS=N,O,T,B,I,d,R,L,D
//!       1     17535.400 DT 1  00000100 Tx -  8    00 00 00 00 00 00 00 00
//! ```
//!
//! A version is the order of its columns:
//!
//! | version | columns |
//! |---|---|
//! | 1.0, which has no `$FILEVERSION` | number, offset, id, DLC, data |
//! | 1.1 | number, offset, direction or kind, id, DLC, data |
//! | 1.2 | number, offset, bus, direction or kind, id, DLC, data |
//! | 1.3 | number, offset, bus, direction or kind, id, reserved, DLC, data |
//! | 2.0, 2.1 | as `$COLUMNS` says: N number, O offset, T kind, B bus, I id, d direction, R reserved, L DLC, l length, D data |
//!
//! What is easily got wrong:
//!
//! - `$STARTTIME` is in days since 1899-12-30 in the recorder's **local** time; 1.0 has it as text in a comment.
//! - Offsets are in milliseconds, with 0, 1 or 3 decimals.
//! - Four id digits are 11 bits, eight are 29; some tools leave out leading zeros of the eight.
//! - 1.x writes `RTR` in place of the data, and 1.0 `ERROR` before it. A row of 1.0 with id FFFFFFFF, or of kind `Warng`, is a bus status.
//! - Kinds of 2.x: DT data, RR remote, FD, FB (BRS), FE (ESI), BI (both), ER error frame; ST, EC and EV are status,
//!   error counters and events, whose other columns may be empty.
//! - L is the DLC, l the length. A classical DLC of 9 to 15 has eight bytes; anything else is malformed.
//!
//! Error frames tell no class as Linux does, and are read as a bus error without detail. A last line without line
//! end is read if all that its length promises is there.

use crate::formats::asc_row::BUS_ERROR;
use crate::formats::candump_log::intern;
use crate::grammar::{Expected, Parsed, billionths, decimal, hex_byte, hex_run, nibble, skip_blanks, word};
use crate::lines::{Line, LineFormat, TextReader, head_lines};
use crate::{
    CanId, ChannelId, Channels, Damage, DamageKind, Direction, Flags, Frame, ReadOptions, Reader, Record, Source,
    TimeBase, Timestamp,
};
use jiff::civil;

pub(crate) use crate::formats::trc_writer::create;

/// Days from 1899-12-30 to 1970-01-01.
pub(crate) const DAYS_TO_1970: u64 = 25_569;
/// Nanoseconds of a day.
pub(crate) const DAY: u64 = 86_400_000_000_000;

const SNIFF_LINES: usize = 100;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head_lines(head).take(SNIFF_LINES).any(|(line, _)| {
        line.starts_with(b";$FILEVERSION=") || line.starts_with(b";$STARTTIME=") || {
            let numbered = number_and_offset(line).is_ok_and(|(_, (_, bracket))| bracket);
            numbered && matches!(row(line, &Version::V1_0.columns()), Ok((_, Row::Frame { .. })))
        }
    })
}

fn number_and_offset(line: &[u8]) -> Parsed<'_, (u64, bool)> {
    let (rest, bracket) = message_number(skip_blanks(line))?;
    let (rest, offset) = millis(skip_blanks(rest))?;
    Ok((rest, (offset, bracket)))
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    let columns = Version::V1_0.columns();
    Box::new(TextReader::new(source, Trc { columns, start: None, start_in_text: None }))
}

struct Trc {
    columns: Vec<Column>,
    /// The start in local time.
    start: Option<u64>,
    /// The same from a comment, which is all that version 1.0 has.
    start_in_text: Option<u64>,
}

enum Version {
    V1_0,
    V1_1,
    V1_2,
    V1_3,
    V2_0,
    V2_1,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Column {
    Number,
    Offset,
    /// Two letters of 2.x.
    Kind,
    Bus,
    Id,
    Direction,
    /// 1.x: `Rx`, `Tx`, or that it is no frame.
    DirectionOrKind,
    Reserved,
    Dlc,
    Length,
    Data,
}

impl Version {
    fn columns(&self) -> Vec<Column> {
        use Column::{Bus, Data, Dlc, Id, Number, Offset, Reserved};
        let direction = Column::DirectionOrKind;
        match self {
            Self::V1_0 => vec![Number, Offset, Id, Dlc, Data],
            Self::V1_1 => vec![Number, Offset, direction, Id, Dlc, Data],
            Self::V1_2 => vec![Number, Offset, Bus, direction, Id, Dlc, Data],
            Self::V1_3 => vec![Number, Offset, Bus, direction, Id, Reserved, Dlc, Data],
            Self::V2_0 => columns(b"N,O,T,I,d,l,D").unwrap_or_default(),
            Self::V2_1 => columns(b"N,O,T,B,I,d,R,L,D").unwrap_or_default(),
        }
    }
}

/// The columns by their letters.
fn columns(letters: &[u8]) -> Option<Vec<Column>> {
    let column = |letter: &[u8]| match letter.trim_ascii() {
        b"N" => Some(Column::Number),
        b"O" => Some(Column::Offset),
        b"T" => Some(Column::Kind),
        b"B" => Some(Column::Bus),
        b"I" => Some(Column::Id),
        b"d" => Some(Column::Direction),
        b"R" => Some(Column::Reserved),
        b"L" => Some(Column::Dlc),
        b"l" => Some(Column::Length),
        b"D" => Some(Column::Data),
        _ => None,
    };
    letters.split(|&b| b == b',').map(column).collect()
}

impl LineFormat for Trc {
    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        match skip_blanks(line.bytes) {
            [] => None,
            [b';', comment @ ..] => self.comment(line, comment).map(Err),
            _ => self.row(line, channels).transpose(),
        }
    }

    fn time_base(&self) -> TimeBase {
        if self.start().is_some() { TimeBase::Local } else { TimeBase::Start }
    }
}

impl Trc {
    fn start(&self) -> Option<u64> {
        self.start.or(self.start_in_text)
    }

    fn comment(&mut self, line: &Line<'_>, comment: &[u8]) -> Option<Damage> {
        let unsupported = |expected| Some(line.as_damage(DamageKind::Unsupported, expected));
        if let Some(version) = comment.strip_prefix(b"$FILEVERSION=") {
            let version = match version.trim_ascii() {
                b"1.0" => Version::V1_0,
                b"1.1" => Version::V1_1,
                b"1.2" => Version::V1_2,
                b"1.3" => Version::V1_3,
                b"2.0" => Version::V2_0,
                b"2.1" => Version::V2_1,
                _ => return unsupported("a version of 1.0 to 2.1"),
            };
            self.columns = version.columns();
        } else if let Some(days) = comment.strip_prefix(b"$STARTTIME=") {
            self.start = start_time(days.trim_ascii());
            if self.start.is_none() {
                return unsupported("days since 1899-12-30, such as 44548.6028595139");
            }
        } else if let Some(letters) = comment.strip_prefix(b"$COLUMNS=") {
            match columns(letters) {
                Some(columns) => self.columns = columns,
                None => return unsupported("columns out of N, O, T, B, I, d, R, L, l, D"),
            }
        } else if let Some(text) = skip_blanks(comment).strip_prefix(b"Start time:") {
            self.start_in_text = start_in_text(text.trim_ascii());
        }
        None
    }

    fn row(&mut self, line: &Line<'_>, channels: &mut Channels) -> Result<Option<Record>, Damage> {
        match row(line.bytes, &self.columns).map_err(|error| line.damage(error.into()))?.1 {
            Row::Event => Ok(None),
            Row::Unsupported => Err(line.as_damage(DamageKind::Unsupported, "a kind of row of TRC 1.0 to 2.1")),
            Row::Frame { in_doubt: true, .. } if !line.ended => {
                Err(line.cut("the end of this line, as the frame may go on,"))
            }
            Row::Frame { offset, bus, mut record, .. } => {
                record.channel = intern(bus, channels).map_err(|missing| line.damage(missing))?;
                record.timestamp = Timestamp(self.start().unwrap_or(0).saturating_add(offset));
                record.place = line.place;
                Ok(Some(record))
            }
        }
    }
}

/// Days since 1899-12-30 in nanoseconds since 1970.
fn start_time(days: &[u8]) -> Option<u64> {
    let (rest, whole) = decimal("days")(days).ok()?;
    let fraction = match rest {
        [] => 0,
        [b'.', digits @ ..] if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit) => {
            // Up to 18 digits are far more than the nanoseconds of a day.
            let digits = digits.get(..18).unwrap_or(digits);
            let scale = 10_u128.pow(digits.len() as u32);
            let value = digits.iter().fold(0, |value, digit| 10 * value + u128::from(digit - b'0'));
            u64::try_from((value * u128::from(DAY) + scale / 2) / scale).ok()?
        }
        _ => return None,
    };
    whole.checked_sub(DAYS_TO_1970)?.checked_mul(DAY)?.checked_add(fraction)
}

/// `18.12.2021 14:28:07.062`, perhaps with more digits behind another point.
fn start_in_text(text: &[u8]) -> Option<u64> {
    let text = std::str::from_utf8(text).ok()?;
    let (date, time) = text.split_once(' ')?;
    let mut date = date.splitn(3, '.');
    let (day, month, year) = (date.next()?.parse().ok()?, date.next()?.parse().ok()?, date.next()?.parse().ok()?);
    let mut time = time.trim().splitn(3, ':');
    let (hour, minute, second) = (time.next()?.parse().ok()?, time.next()?.parse().ok()?, time.next()?);
    let mut second = second.split('.');
    let whole = second.next()?.parse().ok()?;
    let fraction = second.next().map_or(Ok((&[][..], 0)), |digits| billionths(digits.as_bytes())).ok()?.1;
    let time = civil::Time::new(hour, minute, whole, i32::try_from(fraction).ok()?).ok()?;
    crate::local_time::nanos(civil::Date::new(year, month, day).ok()?.to_datetime(time))
}

/// What a row tells.
enum Row<'a> {
    Frame {
        offset: u64,
        bus: &'a [u8],
        record: Record,
        /// The row may go on if the file was cut behind it.
        in_doubt: bool,
    },
    /// Status, error counters and the like.
    Event,
    Unsupported,
}

/// What the columns of a row have told so far.
struct Fields<'a> {
    offset: u64,
    kind: Kind,
    bus: &'a [u8],
    id: Option<CanId>,
    direction: Direction,
    /// DLC, or length, and which.
    length: Option<(u64, Column)>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Data or, as the data column tells, remote: version 1.
    Classical,
    Data,
    Remote,
    Fd(Flags),
    Error,
}

fn row<'a>(line: &'a [u8], columns: &[Column]) -> Parsed<'a, Row<'a>> {
    // The channel of files that have none.
    let mut fields =
        Fields { offset: 0, kind: Kind::Classical, bus: b"1", id: None, direction: Direction::Unknown, length: None };
    let mut rest = line;
    for column in columns {
        rest = skip_blanks(rest);
        let at = rest;
        match column {
            Column::Number => rest = message_number(rest)?.0,
            Column::Offset => (rest, fields.offset) = millis(rest)?,
            Column::Bus => (rest, fields.bus) = word("a bus")(rest)?,
            Column::Reserved => rest = word("the reserved column")(rest)?.0,
            Column::Kind | Column::DirectionOrKind | Column::Direction => {
                let (behind, value) = word("a direction or kind")(rest)?;
                rest = behind;
                match value {
                    b"Rx" => fields.direction = Direction::Rx,
                    b"Tx" => fields.direction = Direction::Tx,
                    _ => match (kind(value), column) {
                        (Some(kind), _) => fields.kind = kind,
                        (None, Column::Kind) => return Ok((rest, status(value))),
                        (None, Column::DirectionOrKind) => return Ok((rest, Row::Event)),
                        _ => return Expected::fail(at, "Rx or Tx"),
                    },
                }
                if fields.kind == Kind::Error && *column != Column::Kind {
                    return Ok((rest, error_frame(&fields)));
                }
            }
            Column::Id if fields.kind == Kind::Error => rest = word("an id")(rest)?.0,
            Column::Id if rest.starts_with(b"FFFFFFFF") => return Ok((rest, Row::Event)),
            Column::Id => {
                let (behind, id) = identifier(rest)?;
                (rest, fields.id) = (behind, Some(id));
            }
            Column::Dlc | Column::Length if fields.kind == Kind::Error => return Ok((rest, error_frame(&fields))),
            Column::Dlc | Column::Length => {
                let (behind, length) = decimal("a length")(rest)?;
                (rest, fields.length) = (behind, Some((length, *column)));
            }
            Column::Data => break,
        }
    }
    data(rest, &fields)
}

fn kind(word: &[u8]) -> Option<Kind> {
    Some(match word {
        b"DT" => Kind::Data,
        b"RR" => Kind::Remote,
        b"FD" => Kind::Fd(Flags::NONE),
        b"FB" => Kind::Fd(Flags::BRS),
        b"FE" => Kind::Fd(Flags::ESI),
        b"BI" => Kind::Fd(Flags::BRS.with(Flags::ESI)),
        b"ER" | b"Error" => Kind::Error,
        _ => return None,
    })
}

fn status(kind: &[u8]) -> Row<'_> {
    if matches!(kind, b"ST" | b"EC" | b"EV") { Row::Event } else { Row::Unsupported }
}

fn frame_row<'a>(fields: &Fields<'a>, record: Record, in_doubt: bool) -> Row<'a> {
    let record = record.with_direction(fields.direction);
    Row::Frame { offset: fields.offset, bus: fields.bus, record, in_doubt }
}

fn error_frame<'a>(fields: &Fields<'a>) -> Row<'a> {
    Frame::error(BUS_ERROR, &[]).map_or(Row::Event, |frame| frame_row(fields, at_zero(frame), false))
}

fn at_zero(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId(0), frame)
}

/// What stands in the last column, and so the frame.
fn data<'a>(input: &'a [u8], fields: &Fields<'a>) -> Parsed<'a, Row<'a>> {
    let at = skip_blanks(input);
    let (Some(id), Some((length, column))) = (fields.id, fields.length) else {
        return if fields.kind == Kind::Error {
            Ok((at, error_frame(fields)))
        } else {
            Expected::fail(at, "an id and a length")
        };
    };
    let dlc = if column == Column::Dlc && length <= 15 { length as u8 } else { 0 };
    if fields.kind == Kind::Classical && at.starts_with(b"ERROR") {
        return Ok((at, error_frame(fields)));
    }
    let is_remote = fields.kind == Kind::Remote || fields.kind == Kind::Classical && at.starts_with(b"RTR");
    if is_remote {
        let frame = Frame::remote(id, length.min(8) as u8).map(|frame| frame.with_raw_dlc(dlc));
        let known = length <= if column == Column::Dlc { 15 } else { 8 };
        return match frame {
            Some(frame) if known => Ok((at, frame_row(fields, at_zero(frame), at.is_empty()))),
            _ => Expected::fail(at, "a remote frame's DLC of at most 15"),
        };
    }
    let (rest, bytes) = bytes(at)?;
    let is_fd = matches!(fields.kind, Kind::Fd(_));
    let expected = match column {
        Column::Dlc if is_fd => Frame::FD_LENGTHS.get(usize::from(dlc)).map_or(0, |&l| u64::from(l)),
        Column::Dlc => length.min(8),
        _ => length,
    };
    if length > 64 || (column == Column::Dlc && length > 15) || expected != bytes.len() as u64 {
        let missing = (bytes.len() as u64) < expected;
        return Expected::fail(if missing { rest } else { at }, "as many bytes as the length column tells");
    }
    let record = match fields.kind {
        Kind::Fd(flags) => Record::fd(Timestamp::ZERO, ChannelId(0), id, flags, &bytes),
        _ => Frame::new(id, &bytes).map(|frame| at_zero(frame.with_raw_dlc(dlc))),
    };
    match record {
        // Without bytes a length of 0 may become RTR, or a number of two digits.
        Some(record) => Ok((rest, frame_row(fields, record, bytes.is_empty()))),
        None => Expected::fail(at, "a length that this kind of frame has"),
    }
}

/// All bytes up to the end of the line.
fn bytes(input: &[u8]) -> Parsed<'_, Vec<u8>> {
    let mut data = Vec::new();
    let mut rest = skip_blanks(input);
    while !rest.is_empty() {
        let (behind, byte) = hex_byte(rest)?;
        if behind.first().is_some_and(|&b| nibble(b).is_some()) {
            return Expected::fail(behind, "a space after the byte");
        }
        data.push(byte);
        rest = skip_blanks(behind);
    }
    Ok((rest, data))
}

/// `12)` or `12`, and whether there is a bracket.
fn message_number(input: &[u8]) -> Parsed<'_, bool> {
    let (rest, _) = decimal("a message number")(input)?;
    match rest {
        [b')', rest @ ..] => Ok((rest, true)),
        _ => Ok((rest, false)),
    }
}

/// Milliseconds, with or without decimals, in nanoseconds.
fn millis(input: &[u8]) -> Parsed<'_, u64> {
    let (rest, whole) = decimal("an offset in milliseconds")(input)?;
    let (rest, fraction) = match rest {
        [b'.', digits @ ..] => billionths(digits)?,
        _ => (rest, 0),
    };
    let nanos = whole.checked_mul(1_000_000).and_then(|nanos| nanos.checked_add(u64::from(fraction / 1_000)));
    nanos.map_or_else(|| Expected::fail(input, "an offset of at most 584 years"), |nanos| Ok((rest, nanos)))
}

fn identifier(input: &[u8]) -> Parsed<'_, CanId> {
    let (rest, digits, raw) = hex_run(input);
    let id = if digits <= 4 { CanId::standard(raw) } else { CanId::extended(raw) };
    match id {
        Some(id) if digits > 0 && matches!(rest, [] | [b' ' | b'\t', ..]) => Ok((rest, id)),
        _ => Expected::fail(input, "an id of four hex digits, at most 07FF, or eight, at most 1FFFFFFF"),
    }
}
