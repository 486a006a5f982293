//! Tables whose head names the columns, separated by commas, semicolons or tabs.

use super::clock::{date, plain, time_of_day, units};
use super::question::Question;
use super::row::Miss;
use crate::columns::Unit;
use crate::grammar::nibble;
use crate::lines::head_lines;
use crate::{CanId, ChannelId, Direction, Flags, Frame, Record, Timestamp};

/// Number of lines in which the head is searched for, and of rows that decide.
const LINES: usize = 100;
const MOST_BYTES: usize = 64;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Field {
    Time(Option<Unit>),
    Channel,
    Direction,
    Id,
    Length,
    /// The number of bits of the identifier, or the kind of the frame, in words.
    Kind,
    /// Whether the identifier has 29 bits.
    Extended,
    Remote,
    Data,
    /// One byte of the data.
    Byte,
    Other,
}

/// A table.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Table {
    separator: u8,
    fields: Vec<Field>,
    /// The line with the names.
    head: Vec<u8>,
    id_is_decimal: bool,
    pub(super) unit: Unit,
}

/// A row, with the text of its time and channel.
pub(super) struct TableRow<'a> {
    pub(super) record: Record,
    pub(super) time: &'a [u8],
    pub(super) channel: &'a [u8],
    /// Whether the row may be the beginning of a longer one.
    pub(super) may_go_on: bool,
}

fn field(name: &[u8]) -> Field {
    let lower = name.to_ascii_lowercase();
    let bytes = trim(&lower);
    let (name, unit) = split_unit(bytes);
    match name {
        b"id" | b"id (hex)" | b"can id" | b"can-id" | b"can_id" | b"canid" | b"frame id" | b"frameid" | b"frame_id"
        | b"identifier" | b"message id" | b"msg id" | b"msgid" | b"arbitration id" | b"arbitration_id" | b"cob-id"
        | b"cobid" => Field::Id,
        b"len" | b"dlc" | b"length" | b"data length" | b"data_length" | b"datalength" | b"dlen" | b"size"
        | b"datalen" => Field::Length,
        b"data" | b"data (hex)" | b"payload" | b"data bytes" | b"databytes" | b"data field" => Field::Data,
        b"time" | b"timestampepoch" | b"time stamp" | b"timestamp" | b"system time" | b"time offset" | b"abs time"
        | b"date" => Field::Time(unit),
        b"bus" | b"buschannel" | b"channel" | b"chn" | b"ch" | b"interface" => Field::Channel,
        b"dir" | b"direction" | b"rx/tx" | b"tx/rx" => Field::Direction,
        b"format" | b"type" | b"frame type" | b"frame format" | b"event type" | b"flags" | b"id type" => Field::Kind,
        b"extended" | b"ext" | b"ide" | b"is_extended" | b"is_extended_id" | b"extended id" => Field::Extended,
        b"remote" | b"rtr" | b"is_remote" | b"is_remote_frame" => Field::Remote,
        _ if is_byte_name(name) => Field::Byte,
        _ => Field::Other,
    }
}

/// The name without a unit in brackets, and the unit.
fn split_unit(name: &[u8]) -> (&[u8], Option<Unit>) {
    let Some(open) = name.iter().position(|byte| b"[(".contains(byte)) else { return (name, None) };
    let (before, inside) = name.split_at_checked(open).unwrap_or((name, &[]));
    if before.is_empty() {
        return (name, None);
    }
    let symbol = inside.get(1..inside.len().saturating_sub(1)).unwrap_or_default();
    (before.trim_ascii_end(), Unit::by_symbol(symbol.trim_ascii()))
}

/// `d1`, `b0`, `byte 3`, `data0`.
fn is_byte_name(name: &[u8]) -> bool {
    let digits = name.iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
    let stem = name.get(..name.len() - digits).unwrap_or_default().trim_ascii_end();
    (1..=2).contains(&digits) && matches!(stem, b"d" | b"b" | b"byte" | b"data" | b"db")
}

fn trim(field: &[u8]) -> &[u8] {
    let is_around = |byte: &u8| b" \t\"'=".contains(byte);
    let start = field.iter().take_while(|byte| is_around(byte)).count();
    let end = field.len() - field.iter().rev().take_while(|byte| is_around(byte)).count();
    field.get(start..end).unwrap_or_default()
}

/// The table at the beginning of a text; `None` if no head names the columns, or the rows are no frames.
pub(super) fn infer(head: &[u8], given: Option<Unit>) -> Result<Option<Table>, Question> {
    let mut lines = head_lines(head).map(|(line, _)| line).take(LINES);
    let Some(mut table) = lines.find_map(Table::by_head) else { return Ok(None) };
    let rows: Vec<_> = lines.filter(|line| !line.trim_ascii().is_empty()).collect();
    let count = |table: &Table| rows.iter().filter(|row| table.row(row).is_ok()).count();
    let decimal = Table { id_is_decimal: true, ..table.clone() };
    if count(&decimal) > count(&table) {
        table = decimal;
    }
    let read = count(&table);
    if read == 0 || 2 * read < rows.len() {
        return Ok(None);
    }
    table.find_unit(&rows, given)?;
    Ok(Some(table))
}

impl Table {
    fn by_head(line: &[u8]) -> Option<Self> {
        let by = |separator: u8| {
            let fields: Vec<Field> = line.split(|byte| *byte == separator).map(field).collect();
            let has = |wanted: &[Field]| fields.iter().any(|field| wanted.contains(field));
            let about_frames = [Field::Length, Field::Extended, Field::Direction, Field::Kind, Field::Channel];
            let is_head = has(&[Field::Id]) && has(&[Field::Data, Field::Byte]) && has(&about_frames);
            is_head.then(|| Self {
                separator,
                fields,
                head: line.to_owned(),
                id_is_decimal: false,
                unit: Unit::Seconds,
            })
        };
        [b'\t', b',', b';'].into_iter().find_map(by)
    }

    /// Whether the line is the one with the names.
    pub(super) fn is_head(&self, line: &[u8]) -> bool {
        line == self.head
    }

    fn find_unit(&mut self, rows: &[&[u8]], given: Option<Unit>) -> Result<(), Question> {
        let in_head = self.fields.iter().find_map(|field| if let Field::Time(unit) = field { *unit } else { None });
        // SavvyCAN's GVRET files count microseconds.
        let is_gvret = self.fields.contains(&Field::Byte) && self.fields.contains(&Field::Extended);
        if let Some(unit) = given.or(in_head).or(is_gvret.then_some(Unit::Micros)) {
            self.unit = unit;
            return Ok(());
        }
        let times: Vec<_> =
            rows.iter().filter_map(|row| self.row(row).ok()).filter_map(|row| plain(row.time)).collect();
        match units(&times)[..] {
            [first, second, ..] => {
                let columns = [first, second].map(|unit| format!("time[{}],id,len,data", unit.symbol()));
                let [one, other] = [first, second].map(|unit| format!("times in {}", unit.symbol()));
                Err(Question::new(one, other, columns))
            }
            [unit] => {
                self.unit = unit;
                Ok(())
            }
            [] => Ok(()),
        }
    }

    /// Whether a line that is no row looks like one: it has enough fields, and half of them have digits.
    pub(super) fn is_like_row(&self, line: &[u8]) -> bool {
        let texts = || line.split(|byte| *byte == self.separator).filter(|text| !text.trim_ascii().is_empty());
        let with_digits = texts().filter(|text| text.iter().any(u8::is_ascii_digit)).count();
        // The longer half of a row that a damaged byte splits has nearly half of the separators.
        2 * line.iter().filter(|byte| **byte == self.separator).count() + 2 >= self.fields.len()
            && 2 * with_digits >= texts().count()
    }

    /// Reads a row.
    pub(super) fn row<'a>(&self, line: &'a [u8]) -> Result<TableRow<'a>, Miss> {
        let mut row = Fields::default();
        let mut at = 0;
        let mut fields = self.fields.iter().copied();
        for text in line.split(|byte| *byte == self.separator) {
            // Fields after the last named one are further bytes of the data.
            let last = if self.fields.last() == Some(&Field::Data) { Field::Byte } else { Field::Other };
            row.take(fields.next().unwrap_or(last), trim(text), self.id_is_decimal).map_err(|what| (at, what))?;
            at += text.len() + 1;
        }
        let record = row.record().map_err(|what| (0, what))?.with_direction(row.direction);
        let may_go_on = row.ends_in_digit || row.len.is_none() && record.frame.len() < 8;
        Ok(TableRow { record, time: row.time, channel: row.channel, may_go_on })
    }
}

struct Fields<'a> {
    time: &'a [u8],
    channel: &'a [u8],
    direction: Direction,
    id: Option<(u32, usize)>,
    extended: Option<bool>,
    remote: bool,
    len: Option<usize>,
    data: [u8; MOST_BYTES],
    count: usize,
    /// Whether the last byte has one digit.
    ends_in_digit: bool,
}

impl Default for Fields<'_> {
    fn default() -> Self {
        Self {
            time: &[],
            channel: &[],
            direction: Direction::Unknown,
            id: None,
            extended: None,
            remote: false,
            len: None,
            data: [0; MOST_BYTES],
            count: 0,
            ends_in_digit: false,
        }
    }
}

impl<'a> Fields<'a> {
    fn take(&mut self, field: Field, text: &'a [u8], id_is_decimal: bool) -> Result<(), &'static str> {
        match field {
            Field::Time(_) if self.time.is_empty() && is_time(text) => self.time = text,
            Field::Channel => self.channel = text,
            Field::Direction => self.direction = direction(text),
            Field::Id => self.id = Some(identifier(text, id_is_decimal).ok_or("an identifier")?),
            Field::Length => self.len = Some(length(text).ok_or("a length of at most 64")?),
            Field::Extended => self.extended = flag(text).or(self.extended),
            Field::Remote => self.remote |= flag(text) == Some(true),
            Field::Kind => self.kind(text),
            Field::Data | Field::Byte => self.bytes(text)?,
            Field::Time(_) | Field::Other => {}
        }
        Ok(())
    }

    /// A text such as `Standard`, `Ext`, `CAN Frame`, `Remote`.
    fn kind(&mut self, text: &[u8]) {
        let lower = text.to_ascii_lowercase();
        let has = |word: &[u8]| lower.windows(word.len()).any(|window| window == word);
        self.remote |= has(b"remote") || has(b"rtr");
        match () {
            () if has(b"ext") => self.extended = Some(true),
            () if has(b"std") || has(b"standard") => self.extended = Some(false),
            () => {}
        }
    }

    /// Bytes apart or together; a letter and a bar may stand before them.
    fn bytes(&mut self, text: &[u8]) -> Result<(), &'static str> {
        let text = text.strip_prefix(b"x|").unwrap_or(text);
        for word in text.split(|byte| matches!(byte, b' ' | b'-' | b'.')).filter(|word| !word.is_empty()) {
            let digits = word.strip_prefix(b"0x").unwrap_or(word);
            let digits = digits.strip_suffix(b"h").unwrap_or(digits);
            self.ends_in_digit = digits.len() == 1;
            if let [digit] = digits {
                self.push(nibble(*digit))?;
                continue;
            }
            for pair in digits.chunks(2) {
                let [high, low] = pair else { return Err("bytes of two hex digits") };
                self.push(nibble(*high).zip(nibble(*low)).map(|(high, low)| high << 4 | low))?;
            }
        }
        Ok(())
    }

    fn push(&mut self, byte: Option<u8>) -> Result<(), &'static str> {
        let byte = byte.ok_or("bytes of two hex digits")?;
        *self.data.get_mut(self.count).ok_or("at most 64 bytes")? = byte;
        self.count += 1;
        Ok(())
    }

    fn record(&self) -> Result<Record, &'static str> {
        let (value, digits) = self.id.ok_or("an identifier")?;
        let extended = self.extended.unwrap_or(value > CanId::MAX_STANDARD || digits == 8);
        let id = if extended { CanId::extended(value) } else { CanId::standard(value) };
        let id = id.ok_or("an identifier of 11 or 29 bits")?;
        if self.remote {
            let frame = u8::try_from(self.len.unwrap_or(0)).ok().and_then(|len| Frame::remote(id, len));
            return frame.map(at_zero).ok_or("a remote frame's length of 0 to 8");
        }
        let data = self.data.get(..self.count).unwrap_or_default();
        match self.len {
            // A row may have all eight bytes of a table, whatever the length.
            Some(len) if len != data.len() => Err("as many bytes as the length says"),
            None if data.is_empty() => Err("data bytes"),
            _ if data.len() > 8 => {
                Record::fd(Timestamp::ZERO, ChannelId(0), id, Flags::NONE, data).ok_or("a length that CAN FD has")
            }
            _ => Frame::new(id, data).map(at_zero).ok_or("at most 8 bytes"),
        }
    }
}

fn at_zero(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId(0), frame)
}

fn is_time(text: &[u8]) -> bool {
    plain(text).is_some() || time_of_day(text).is_some() || date(text).is_some() || text.contains(&b':')
}

fn direction(text: &[u8]) -> Direction {
    match text.first().map(u8::to_ascii_lowercase) {
        Some(b'r') => Direction::Rx,
        Some(b't' | b's') => Direction::Tx,
        _ => Direction::Unknown,
    }
}

/// The identifier and its number of digits.
fn identifier(text: &[u8], is_decimal: bool) -> Option<(u32, usize)> {
    let hex = text.strip_prefix(b"0x").or_else(|| text.strip_prefix(b"0X"));
    let digits = hex.unwrap_or(text);
    let digits = digits.strip_suffix(b"h").unwrap_or(digits);
    if digits.is_empty() || digits.len() > 9 {
        return None;
    }
    let radix = if is_decimal && hex.is_none() { 10 } else { 16 };
    let digit = |digit: &u8| nibble(*digit).map(u32::from).filter(|digit| *digit < radix);
    let value = digits.iter().try_fold(0_u32, |value, next| value.checked_mul(radix)?.checked_add(digit(next)?))?;
    (value <= CanId::MAX_EXTENDED).then_some((value, if radix == 10 { 0 } else { digits.len() }))
}

fn length(text: &[u8]) -> Option<usize> {
    let (digits, radix) = match text.strip_prefix(b"0x") {
        Some(digits) => (digits, 16),
        None => (text, 10),
    };
    let len = usize::from_str_radix(std::str::from_utf8(digits).ok()?, radix).ok()?;
    (len <= MOST_BYTES).then_some(len)
}

fn flag(text: &[u8]) -> Option<bool> {
    match text.to_ascii_lowercase().as_slice() {
        b"true" | b"1" | b"yes" | b"x" | b"ext" | b"extended" => Some(true),
        b"false" | b"0" | b"no" | b"" | b"std" | b"standard" => Some(false),
        _ => None,
    }
}
