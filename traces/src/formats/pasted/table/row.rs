//! The fields of one row.

use super::super::clock::{date, day_and_time, plain, time_of_day};
use super::Table;
use super::head::Field;
use crate::grammar::nibble;
use crate::{CanId, ChannelId, Direction, ErrorClass, Flags, Frame, Record, Timestamp};

const MOST_BYTES: usize = 64;

/// The fields of a row, parsed as far as they are needed.
pub(super) struct Fields<'a> {
    pub(super) time: &'a [u8],
    pub(super) date: &'a [u8],
    /// A filled field for the time that is none.
    pub(super) no_time: Option<&'a [u8]>,
    error: bool,
    /// Whether each byte is a column, so that a row may have bytes beyond its length.
    pub(super) bytes_are_fields: bool,
    pub(super) channel: &'a [u8],
    pub(super) direction: Direction,
    id: Option<(u32, usize)>,
    extended: Option<bool>,
    remote: bool,
    pub(super) len: Option<usize>,
    data: [u8; MOST_BYTES],
    count: usize,
    /// Whether the last byte has one digit.
    pub(super) ends_in_digit: bool,
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
    /// Takes the text of the next field.
    pub(super) fn take(&mut self, field: Field, text: &'a [u8], table: &Table) -> Result<(), &'static str> {
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

    /// Recognises remote frames, error frames and the length of the identifier by a text such as `Standard`, `Ext`,
    /// `CAN Frame` or `Remote`.
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

    /// The frame of the row.
    pub(super) fn record(&self) -> Result<Record, &'static str> {
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

/// Whether a text is a time, a date, or both.
pub(super) fn is_time(text: &[u8]) -> bool {
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
