//! The rows of PEAK TRC.

use crate::formats::asc_row::BUS_ERROR;
use crate::grammar::{Expected, Parsed, billionths, decimal, hex_byte, hex_run, nibble, skip_blanks, word};
use crate::{CanId, ChannelId, Direction, Flags, Frame, Record, Timestamp};

/// A column, which 2.x names by a letter.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Column {
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

/// The columns by their letters.
pub(crate) fn columns(letters: &[u8]) -> Option<Vec<Column>> {
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

/// What a row tells.
pub(crate) enum Row<'a> {
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

pub(crate) fn row<'a>(line: &'a [u8], columns: &[Column]) -> Parsed<'a, Row<'a>> {
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
pub(crate) fn message_number(input: &[u8]) -> Parsed<'_, bool> {
    let (rest, _) = decimal("a message number")(input)?;
    match rest {
        [b')', rest @ ..] => Ok((rest, true)),
        _ => Ok((rest, false)),
    }
}

/// Milliseconds, with or without decimals, in nanoseconds.
pub(crate) fn millis(input: &[u8]) -> Parsed<'_, u64> {
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
