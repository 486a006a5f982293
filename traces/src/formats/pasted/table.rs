//! Tables whose head names the columns, separated by commas, semicolons or tabs.

use super::clock::{date, day_and_time, order, plain, time_of_day, units};
use super::question::Question;
use super::row::Miss;
use crate::columns::{Columns, IdForm, Radix, Unit};
use crate::grammar::nibble;
use crate::lines::head_lines;
use crate::{CanId, ChannelId, Direction, ErrorClass, Flags, Frame, Record, Timestamp};

/// Number of lines in which the head is searched for, and of rows that decide.
const LINES: usize = 100;
const MOST_BYTES: usize = 64;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Field {
    Time(Option<Unit>),
    Date,
    Channel,
    Direction,
    /// The identifier, and its radix if the head names it.
    Id(Option<Radix>),
    Length,
    /// A length by a name that is no usual one for frames.
    Size,
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
    bytes_are_decimal: bool,
    /// Whether dates with slashes begin with the month.
    pub(super) month_first: bool,
    pub(super) unit: Unit,
}

/// A row, with the text of its time and channel.
pub(super) struct TableRow<'a> {
    pub(super) record: Record,
    pub(super) time: &'a [u8],
    pub(super) date: &'a [u8],
    pub(super) channel: &'a [u8],
    /// Whether the row may be the beginning of a longer one.
    pub(super) may_go_on: bool,
}

fn field(name: &[u8]) -> Field {
    let lower = name.to_ascii_lowercase();
    let bytes = trim(&lower);
    let (name, unit, radix) = split_unit(bytes);
    match name {
        b"id" | b"can id" | b"can-id" | b"can_id" | b"canid" | b"frame id" | b"frameid" | b"frame_id"
        | b"identifier" | b"message id" | b"msg id" | b"msgid" | b"arbitration id" | b"arbitration_id" | b"cob-id"
        | b"cobid" | b"arb id" | b"can_dataframe.id" => Field::Id(radix),
        b"size" => Field::Size,
        b"len"
        | b"dlc"
        | b"length"
        | b"data length"
        | b"data_length"
        | b"datalength"
        | b"dlen"
        | b"datalen"
        | b"can_dataframe.datalength" => Field::Length,
        b"data" | b"payload" | b"data bytes" | b"databytes" | b"data field" | b"can_dataframe.databytes" => Field::Data,
        b"time" | b"timestampepoch" | b"time stamp" | b"timestamp" | b"system time" | b"time offset" | b"abs time"
        | b"timestamps" => Field::Time(unit),
        b"date" => Field::Date,
        b"bus" | b"buschannel" | b"channel" | b"chn" | b"ch" | b"interface" | b"can_dataframe.buschannel" => {
            Field::Channel
        }
        b"dir" | b"direction" | b"rx/tx" | b"tx/rx" => Field::Direction,
        b"format" | b"type" | b"frame type" | b"frame format" | b"event type" | b"flags" | b"id type" => Field::Kind,
        b"extended" | b"ext" | b"ide" | b"is_extended" | b"is_extended_id" | b"extended id" | b"xtd"
        | b"can_dataframe.ide" => Field::Extended,
        b"remote" | b"rtr" | b"is_remote" | b"is_remote_frame" => Field::Remote,
        _ if is_byte_name(name) => Field::Byte,
        _ => Field::Other,
    }
}

/// The name without a detail in brackets, and the unit or radix that the detail names.
fn split_unit(name: &[u8]) -> (&[u8], Option<Unit>, Option<Radix>) {
    let Some(open) = name.iter().position(|byte| b"[(".contains(byte)) else { return (name, None, None) };
    let (before, inside) = name.split_at_checked(open).unwrap_or((name, &[]));
    if before.is_empty() {
        return (name, None, None);
    }
    let symbol = inside.get(1..inside.len().saturating_sub(1)).unwrap_or_default().trim_ascii();
    let radix = match symbol {
        b"hex" => Some(Radix::Hexadecimal),
        b"dec" => Some(Radix::Decimal),
        _ => None,
    };
    (before.trim_ascii_end(), Unit::by_symbol(if symbol == b"sec" { b"s" } else { symbol }), radix)
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
pub(super) fn infer(head: &[u8], columns: Option<&Columns>) -> Result<Option<Table>, Question> {
    let mut lines = head_lines(head).map(|(line, _)| line).take(LINES);
    let Some(mut table) = lines.find_map(Table::by_head) else { return Ok(None) };
    let rows: Vec<_> = lines.filter(|line| !line.trim_ascii().is_empty()).collect();
    if !rows.iter().any(|row| table.has_time(row)) {
        table.forget_times();
    }
    let bytes = table.infer_bytes(&rows, columns);
    let id = table.infer_id(&rows, columns);
    let read = table.count(&rows);
    if read == 0 || 2 * read < rows.len() || table.is_of_something_else(&rows) {
        return Ok(None);
    }
    (bytes?, id?);
    table.find_unit(&rows, columns.and_then(Columns::unit))?;
    table.find_order(&rows, columns.and_then(Columns::month_first))?;
    Ok(Some(table))
}

/// The question with two readings that differ in one column.
fn question(first: &str, second: &str, columns: [&str; 2]) -> Question {
    Question::new(first, second, columns.map(str::to_owned))
}

impl Table {
    fn by_head(line: &[u8]) -> Option<Self> {
        let by = |separator: u8| {
            let fields: Vec<Field> = line.split(|byte| *byte == separator).map(field).collect();
            let has = |wanted: &[Field]| fields.iter().any(|field| wanted.contains(field));
            let about_frames =
                [Field::Length, Field::Size, Field::Extended, Field::Direction, Field::Kind, Field::Channel];
            let has_id = fields.iter().any(|field| matches!(field, Field::Id(_)));
            let is_head = has_id && has(&[Field::Data, Field::Byte]) && has(&about_frames);
            is_head.then(|| Self {
                separator,
                fields,
                head: line.to_owned(),
                id_is_decimal: false,
                bytes_are_decimal: false,
                month_first: true,
                unit: Unit::Seconds,
            })
        };
        [b'\t', b',', b';'].into_iter().find_map(by)
    }

    /// Number of rows that are frames.
    fn count(&self, rows: &[&[u8]]) -> usize {
        rows.iter().filter(|row| self.row(row).is_ok()).count()
    }

    /// The filled fields of one kind.
    fn texts<'a>(&self, rows: &[&'a [u8]], wanted: fn(Field) -> bool) -> Vec<&'a [u8]> {
        let fields = |row: &&'a [u8]| split(row, self.separator).zip(&self.fields).collect::<Vec<_>>();
        let texts = rows.iter().flat_map(fields).filter(|(_, field)| wanted(**field)).map(|(text, _)| trim(text));
        texts.filter(|text| !text.is_empty()).collect()
    }

    fn has_time(&self, row: &[u8]) -> bool {
        let times = self.texts(&[row], |field| matches!(field, Field::Time(_) | Field::Date));
        times.into_iter().any(is_time)
    }

    /// Times in no known form are no columns.
    fn forget_times(&mut self) {
        for field in &mut self.fields {
            if matches!(field, Field::Time(_) | Field::Date) {
                *field = Field::Other;
            }
        }
    }

    /// The meaning of the columns in words.
    pub(super) fn describe(&self) -> String {
        let has = |wanted: fn(&Field) -> bool| self.fields.iter().any(wanted);
        let mut parts = vec!["a table with named columns".to_owned()];
        if has(|field| matches!(field, Field::Time(_))) {
            parts.push(format!("times in {}", self.unit.symbol()));
        } else if !has(|field| *field == Field::Date) {
            parts.push("no times".to_owned());
        }
        parts.extend(self.id_is_decimal.then(|| "id in decimal".to_owned()));
        parts.extend(self.bytes_are_decimal.then(|| "bytes in decimal".to_owned()));
        parts.join(", ")
    }

    /// Whether nothing but the numbers of bytes says that the rows are frames: sizes and data are columns of other tables
    /// too, whose numbers are decimal.
    fn is_of_something_else(&self, rows: &[&[u8]]) -> bool {
        let is_about_frames = |field: &Field| {
            matches!(field, Field::Length | Field::Extended | Field::Direction | Field::Kind | Field::Channel)
        };
        let is_hex = |text: &&[u8]| text.iter().any(|byte| byte.is_ascii_hexdigit() && !byte.is_ascii_digit());
        let has_hex = self.texts(rows, |field| matches!(field, Field::Data | Field::Byte)).iter().any(is_hex);
        !has_hex && !self.fields.iter().any(is_about_frames)
    }

    /// Finds out whether the bytes are decimal.
    fn infer_bytes(&mut self, rows: &[&[u8]], columns: Option<&Columns>) -> Result<(), Question> {
        let texts = self.texts(rows, |field| matches!(field, Field::Data | Field::Byte));
        let is_between = |byte: &u8| matches!(byte, b' ' | b'-' | b'.' | b'[' | b']');
        let words = || texts.iter().flat_map(|text| text.split(is_between)).filter(|word| !word.is_empty());
        let is_number = |word: &[u8]| word.len() <= 3 && word.iter().all(u8::is_ascii_digit);
        if let Some(radix) = columns.and_then(Columns::data) {
            self.bytes_are_decimal = radix == Radix::Decimal;
            return Ok(());
        }
        if !words().all(is_number) {
            return Ok(());
        }
        let (longest, shortest) = (words().map(<[u8]>::len).max(), words().map(<[u8]>::len).min());
        let is_filled = |word: &[u8]| word.len() == 2 && word.starts_with(b"0");
        match (longest, shortest) {
            (Some(3), _) => self.bytes_are_decimal = true,
            (_, Some(1)) if !words().any(is_filled) => {
                return Err(question("bytes in hex", "bytes in decimal", ["id,data[hex]", "id,data[dec]"]));
            }
            _ => {}
        }
        Ok(())
    }

    /// Finds out whether the identifiers are decimal.
    fn infer_id(&mut self, rows: &[&[u8]], columns: Option<&Columns>) -> Result<(), Question> {
        let in_head = self.fields.iter().find_map(|field| if let Field::Id(radix) = field { *radix } else { None });
        let given = match columns.map(Columns::id) {
            Some(IdForm::Decimal) => Some(Radix::Decimal),
            Some(IdForm::Hexadecimal | IdForm::Bits11 | IdForm::Bits29) => Some(Radix::Hexadecimal),
            Some(IdForm::Usual) | None => None,
        };
        if let Some(radix) = given.or(in_head) {
            self.id_is_decimal = radix == Radix::Decimal;
            return Ok(());
        }
        let ids = self.texts(rows, |field| matches!(field, Field::Id(_)));
        let decimal = Self { id_is_decimal: true, ..self.clone() };
        let (hex, other) = (self.count(rows), decimal.count(rows));
        // As hexadecimal numbers these would have more than 11 bits, and fewer digits than 29 bits have.
        let is_long = |id: &&[u8]| id.len() == 4 && **id >= *b"0800".as_slice();
        let is_decimal = |id: &&[u8]| id.iter().all(u8::is_ascii_digit) && id.len() <= 4;
        let are_long = ids.iter().any(is_long) && ids.iter().all(is_decimal);
        match () {
            () if other > hex => self.id_is_decimal = true,
            () if other == hex && hex > 0 && are_long && decimal.are_standard(rows) => {
                return Err(question("identifiers in hex", "identifiers in decimal", ["id[hex],data", "id[dec],data"]));
            }
            () => {}
        }
        Ok(())
    }

    fn are_standard(&self, rows: &[&[u8]]) -> bool {
        let id = |row: &&[u8]| self.row(row).ok().map(|row| row.record.frame.id().raw());
        rows.iter().filter_map(id).all(|id| id <= CanId::MAX_STANDARD)
    }

    /// Finds the order of day and month in dates with slashes.
    fn find_order(&mut self, rows: &[&[u8]], given: Option<bool>) -> Result<(), Question> {
        let dates = self.texts(rows, |field| matches!(field, Field::Date | Field::Time(_)));
        let has_slashes = |date: &&&[u8]| date.iter().position(|byte| *byte == b'/').is_some_and(|digits| digits <= 2);
        let mut dates = dates.iter().filter(has_slashes).peekable();
        if dates.peek().is_none() {
            return Ok(());
        }
        self.month_first = given.or_else(|| dates.find_map(|date| order(date))).ok_or_else(|| {
            let columns = ["date[mdy],id,data", "date[dmy],id,data"];
            question("dates that begin with the month", "dates that begin with the day", columns)
        })?;
        Ok(())
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
        for text in split(line, self.separator) {
            // Fields after the last named one are further bytes of the data.
            let last = if self.fields.last() == Some(&Field::Data) { Field::Byte } else { Field::Other };
            row.take(fields.next().unwrap_or(last), trim(text), self).map_err(|what| (at, what))?;
            at += text.len() + 1;
        }
        row.bytes_are_fields = self.fields.contains(&Field::Byte);
        if let (true, Some(at)) = (row.time.is_empty() && row.date.is_empty(), row.no_time) {
            return Err((line.len().min(offset(line, at)), "a time"));
        }
        let record = row.record().map_err(|what| (0, what))?.with_direction(row.direction);
        let may_go_on = row.ends_in_digit || row.len.is_none() && record.frame.len() < 8;
        Ok(TableRow { record, time: row.time, date: row.date, channel: row.channel, may_go_on })
    }
}

/// The fields of a row. A separator in quotes separates nothing.
fn split(line: &[u8], separator: u8) -> impl Iterator<Item = &[u8]> {
    let mut is_quoted = false;
    line.split(move |byte| {
        is_quoted ^= *byte == b'"';
        *byte == separator && !is_quoted
    })
}

/// The offset of a field in its line.
fn offset(line: &[u8], field: &[u8]) -> usize {
    (field.as_ptr() as usize).saturating_sub(line.as_ptr() as usize)
}

struct Fields<'a> {
    time: &'a [u8],
    date: &'a [u8],
    /// A filled field for the time that is none.
    no_time: Option<&'a [u8]>,
    error: bool,
    /// Whether each byte is a column, so that a row may have bytes beyond its length.
    bytes_are_fields: bool,
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
            date: &[],
            no_time: None,
            error: false,
            bytes_are_fields: false,
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
    fn take(&mut self, field: Field, text: &'a [u8], table: &Table) -> Result<(), &'static str> {
        match field {
            Field::Time(_) if self.time.is_empty() && is_time(text) => self.time = text,
            Field::Date if is_time(text) => self.date = text,
            Field::Time(_) | Field::Date if !text.is_empty() => self.no_time = self.no_time.or(Some(text)),
            Field::Channel => self.channel = text,
            Field::Direction => self.direction = direction(text),
            Field::Id(_) => self.id = Some(identifier(text, table.id_is_decimal).ok_or("an identifier")?),
            Field::Length | Field::Size => self.len = Some(length(text).ok_or("a length of at most 64")?),
            Field::Extended => self.extended = flag(text).or(self.extended),
            Field::Remote => self.remote |= flag(text) == Some(true),
            Field::Kind => self.kind(text),
            Field::Data | Field::Byte if table.bytes_are_decimal => self.decimal_bytes(text)?,
            Field::Data | Field::Byte => self.bytes(text)?,
            Field::Time(_) | Field::Date | Field::Other => {}
        }
        Ok(())
    }

    /// A text such as `Standard`, `Ext`, `CAN Frame`, `Remote`.
    fn kind(&mut self, text: &[u8]) {
        let lower = text.to_ascii_lowercase();
        let has = |word: &[u8]| lower.windows(word.len()).any(|window| window == word);
        self.remote |= has(b"remote") || has(b"rtr");
        self.error |= has(b"error");
        match () {
            () if has(b"ext") => self.extended = Some(true),
            () if has(b"std") || has(b"standard") => self.extended = Some(false),
            () => {}
        }
    }

    fn decimal_bytes(&mut self, text: &[u8]) -> Result<(), &'static str> {
        let is_between = |byte: &u8| matches!(byte, b' ' | b'-' | b'.' | b'[' | b']');
        for word in text.split(is_between).filter(|word| !word.is_empty()) {
            let number = std::str::from_utf8(word).ok().and_then(|word| word.parse::<u8>().ok());
            self.ends_in_digit = word.len() < 3;
            self.push(number)?;
        }
        Ok(())
    }

    /// Bytes apart or together; a letter and a bar may stand before them.
    fn bytes(&mut self, text: &[u8]) -> Result<(), &'static str> {
        let text = text.strip_prefix(b"x|").unwrap_or(text);
        for word in text.split(|byte| matches!(byte, b' ' | b'-' | b'.' | b'[' | b']')).filter(|word| !word.is_empty())
        {
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
        let byte = byte.ok_or("a byte")?;
        *self.data.get_mut(self.count).ok_or("at most 64 bytes")? = byte;
        self.count += 1;
        Ok(())
    }

    fn record(&self) -> Result<Record, &'static str> {
        let (value, digits) = self.id.ok_or("an identifier")?;
        let extended = self.extended.unwrap_or(value > CanId::MAX_STANDARD || digits == 8);
        let id = if extended { CanId::extended(value) } else { CanId::standard(value) };
        let id = id.ok_or("an identifier of 11 or 29 bits")?;
        if self.error {
            let data = self.data.get(..self.count).unwrap_or_default();
            return Frame::error(ErrorClass(id.raw()), data).map(at_zero).ok_or("at most 8 bytes of an error frame");
        }
        if self.remote {
            let frame = u8::try_from(self.len.unwrap_or(0)).ok().and_then(|len| Frame::remote(id, len));
            return frame.map(at_zero).ok_or("a remote frame's length of 0 to 8");
        }
        // A row may have all eight columns of bytes filled with zeros, whatever the length.
        let is_filling = |len: &usize| {
            let mut behind = self.data.get(*len..self.count).unwrap_or_default().iter();
            self.bytes_are_fields && *len < self.count && behind.all(|byte| *byte == 0)
        };
        let data = self.data.get(..self.len.filter(is_filling).unwrap_or(self.count)).unwrap_or_default();
        match self.len {
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
    let is_date = || {
        let day = text.split(|byte| *byte == b' ').next().unwrap_or_default();
        date(day, true).or_else(|| date(day, false)).is_some()
    };
    plain(text).is_some() || time_of_day(text).is_some() || day_and_time(text).is_some() || is_date()
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
        b"true" | b"t" | b"1" | b"yes" | b"x" | b"ext" | b"extended" => Some(true),
        b"false" | b"f" | b"0" | b"no" | b"" | b"std" | b"standard" => Some(false),
        _ => None,
    }
}
