//! The rows of PEAK TRC.

use crate::formats::asc_row::BUS_ERROR;
use crate::grammar::{Expected, Parsed, billionths, decimal, hex_byte, hex_run, nibble, skip_blanks, word};
use crate::{CanId, ChannelId, Direction, Flags, Frame, Record, Timestamp};

/// A column; version 2.x names it by a letter.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Column {
    Number,
    Offset,
    /// The kind of row in 2.x: two letters.
    Kind,
    Bus,
    Id,
    Direction,
    /// The direction or kind in 1.x: `Rx`, `Tx`, or a word for a row without frame.
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

/// A row: its content and, if its version numbers rows, its message number.
pub(crate) struct TrcRow<'a> {
    pub(crate) number: Option<u64>,
    pub(crate) content: Content<'a>,
}

/// The content of a row: a frame, an event, or an unsupported kind.
pub(crate) enum Content<'a> {
    Frame {
        offset: u64,
        bus: &'a [u8],
        record: Record,
        /// Whether the file may have been cut inside the row, if the row is the last one.
        in_doubt: bool,
    },
    /// A status, error counters or another event.
    Event,
    Unsupported,
}

/// The columns of a row parsed so far.
struct Fields<'a> {
    number: Option<u64>,
    offset: u64,
    kind: Kind,
    bus: &'a [u8],
    id: Option<CanId>,
    direction: Direction,
    /// The DLC or the length, and the column that it came from.
    length: Option<(u64, Column)>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A data frame of version 1, or a remote frame, if the data column says so.
    Classical,
    Data,
    Remote,
    Fd(Flags),
    Error,
}

pub(crate) fn row<'a>(line: &'a [u8], columns: &[Column]) -> Parsed<'a, TrcRow<'a>> {
    let mut fields = Fields {
        number: None,
        offset: 0,
        kind: Kind::Classical,
        // The channel of a file without a column for channels.
        bus: b"1",
        id: None,
        direction: Direction::Unknown,
        length: None,
    };
    let (rest, content) = content(line, columns, &mut fields)?;
    Ok((rest, TrcRow { number: fields.number, content }))
}

fn content<'a>(line: &'a [u8], all: &[Column], fields: &mut Fields<'a>) -> Parsed<'a, Content<'a>> {
    let mut rest = line;
    let mut columns = all.iter();
    while let Some(column) = columns.next() {
        if *column == Column::Data {
            break;
        }
        rest = skip_blanks(rest);
        match column {
            Column::Number => {
                let (behind, (number, _)) = message_number(rest)?;
                (rest, fields.number) = (behind, Some(number));
            }
            Column::Offset => (rest, fields.offset) = millis(rest)?,
            Column::Bus => (rest, fields.bus) = word("a bus")(rest)?,
            Column::Reserved => rest = word("the reserved column")(rest)?.0,
            Column::Kind => {
                let (behind, value) = word("a kind of row")(rest)?;
                rest = behind;
                match kind(value) {
                    Some(Kind::Error) => return status(b"ER", rest, columns.as_slice(), fields),
                    Some(kind) => fields.kind = kind,
                    None => return status(value, rest, columns.as_slice(), fields),
                }
            }
            Column::Direction | Column::DirectionOrKind => {
                let (behind, value) = word("Rx or Tx")(rest)?;
                match (direction(value), value) {
                    (Some(direction), _) => (rest, fields.direction) = (behind, direction),
                    (None, b"Error") if *column == Column::DirectionOrKind => return Ok((behind, error_frame(fields))),
                    (None, b"Warng") if *column == Column::DirectionOrKind => return Ok((behind, Content::Event)),
                    (None, _) if *column == Column::DirectionOrKind => return Ok((behind, Content::Unsupported)),
                    _ => return Expected::fail(rest, "Rx or Tx"),
                }
            }
            Column::Id if rest.starts_with(STATUS_ID) && is_status(rest, all) => return Ok((rest, Content::Event)),
            Column::Id => {
                let (behind, id) = identifier(rest)?;
                (rest, fields.id) = (behind, Some(id));
            }
            Column::Dlc | Column::Length => {
                let (behind, length) = decimal("a length")(rest)?;
                (rest, fields.length) = (behind, Some((length, *column)));
            }
            Column::Data => {}
        }
    }
    data(rest, fields)
}

/// The id that distinguishes a bus status of version 1.0 from a frame.
const STATUS_ID: &[u8] = b"FFFFFFFF";

fn is_status(rest: &[u8], columns: &[Column]) -> bool {
    let has_kind = columns.iter().any(|column| matches!(column, Column::Kind | Column::DirectionOrKind));
    !has_kind && word("an id")(rest).is_ok_and(|(_, id)| id == STATUS_ID)
}

fn direction(word: &[u8]) -> Option<Direction> {
    match word {
        b"Rx" => Some(Direction::Rx),
        b"Tx" => Some(Direction::Tx),
        _ => None,
    }
}

fn kind(word: &[u8]) -> Option<Kind> {
    Some(match word {
        b"DT" => Kind::Data,
        b"RR" => Kind::Remote,
        b"FD" => Kind::Fd(Flags::NONE),
        b"FB" => Kind::Fd(Flags::BRS),
        b"FE" => Kind::Fd(Flags::ESI),
        b"BI" => Kind::Fd(Flags::BRS.with(Flags::ESI)),
        b"ER" => Kind::Error,
        _ => return None,
    })
}

/// Parses a row of 2.x other than a data or remote frame: an error frame, a status, error counters or an event. None of
/// these has an id; a row with an id is a frame with a damaged kind.
fn status<'a>(kind: &[u8], input: &'a [u8], columns: &[Column], fields: &mut Fields<'a>) -> Parsed<'a, Content<'a>> {
    if !matches!(kind, b"ER" | b"ST" | b"EC" | b"EV") {
        return Ok((input, Content::Unsupported));
    }
    let mut rest = skip_blanks(input);
    if columns.first() == Some(&Column::Bus) {
        let (behind, bus) = word("a bus")(rest)?;
        (rest, fields.bus) = (skip_blanks(behind), bus);
    }
    let (behind, first) = word("a direction")(rest)?;
    let (after, second) = word("a direction")(skip_blanks(behind)).unwrap_or((&[], &[]));
    let (rest, way) = if first == b"-" { (after, second) } else { (behind, first) };
    match direction(way) {
        Some(direction) => fields.direction = direction,
        // The text of an event is arbitrary.
        None if kind == b"EV" && direction(second).is_none() => return Ok((rest, Content::Event)),
        None => return Expected::fail(first, "no id, as the row is of a kind that has none"),
    }
    Ok((rest, if kind == b"ER" { error_frame(fields) } else { Content::Event }))
}

fn frame_row<'a>(fields: &Fields<'a>, record: Record, in_doubt: bool) -> Content<'a> {
    let record = record.with_direction(fields.direction);
    Content::Frame { offset: fields.offset, bus: fields.bus, record, in_doubt }
}

fn error_frame<'a>(fields: &Fields<'a>) -> Content<'a> {
    Frame::error(BUS_ERROR, &[]).map_or(Content::Event, |frame| frame_row(fields, at_zero(frame), false))
}

fn at_zero(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId(0), frame)
}

/// Parses the last column, and makes the frame.
fn data<'a>(input: &'a [u8], fields: &Fields<'a>) -> Parsed<'a, Content<'a>> {
    let at = skip_blanks(input);
    let (Some(id), Some((length, column))) = (fields.id, fields.length) else {
        return Expected::fail(at, "an id and a length");
    };
    let dlc = if column == Column::Dlc && length <= 15 { length as u8 } else { 0 };
    if fields.kind == Kind::Classical && at.starts_with(b"ERROR") {
        return Ok((at, error_frame(fields)));
    }
    let is_remote = fields.kind == Kind::Remote || fields.kind == Kind::Classical && at.starts_with(b"RTR");
    if is_remote {
        let frame = Frame::remote(id, length.min(8) as u8).map(|frame| frame.with_raw_dlc(dlc));
        let most = if column == Column::Dlc { 15 } else { 8 };
        // `RTR` ends the row. Without `RTR`, a cut length may have had a second digit, if the longer number is allowed.
        let in_doubt = fields.kind == Kind::Remote && input.is_empty() && 10 * length <= most && length > 0;
        return match frame {
            Some(frame) if length <= most => Ok((at, frame_row(fields, at_zero(frame), in_doubt))),
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
        // Without bytes, a cut length of 0 may have been followed by `RTR` or a second digit.
        Some(record) => Ok((rest, frame_row(fields, record, bytes.is_empty()))),
        None => Expected::fail(at, "a length that this kind of frame has"),
    }
}

/// Parses all bytes up to the end of the line.
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

/// Parses `12)` or `12`; returns also whether there is a bracket.
pub(crate) fn message_number(input: &[u8]) -> Parsed<'_, (u64, bool)> {
    let (rest, number) = decimal("a message number")(input)?;
    match rest {
        [b')', rest @ ..] => Ok((rest, (number, true))),
        _ => Ok((rest, (number, false))),
    }
}

/// Parses milliseconds, with or without decimals; the value is in nanoseconds.
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
