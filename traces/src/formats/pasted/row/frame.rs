//! The frame of a line: its columns, or its one word.

use super::super::layout::DataForm;
use super::super::token::{Kind, Number, Token};
use super::super::word::Word;
use super::{MOST_BYTES, Miss, Reading};
use crate::grammar::{Expected, nibble, whole};
use crate::notation::frame;
use crate::{CanId, ChannelId, Flags, Frame, Record, Timestamp};

impl Reading<'_> {
    /// The frame of a line with columns.
    pub(super) fn apart(&mut self) -> Result<Record, Miss> {
        let Some((number, id_at)) = self.found.id else { return Err((self.line.len(), "an identifier")) };
        if self.found.len != Some(0) || self.is_remote_next() {
            self.pass_words()?;
        }
        let begin = self.offset();
        let (data, count) = if self.found.remote { ([0; MOST_BYTES], 0) } else { self.data()? };
        let data = data.get(..count).unwrap_or_default();
        match self.found.len {
            Some(len) if !self.found.remote && len != count => {
                return Err((self.offset(), "as many bytes as the length says"));
            }
            Some(_) => {}
            None if count > 8 => return Err((begin, "at most 8 bytes without a length")),
            None if count == 0 && !self.found.remote && !self.ends_here() => return Err((begin, "data bytes")),
            None => {}
        }
        let id = self.identifier(&number).ok_or((id_at, "an identifier of 11 or 29 bits"))?;
        let record = if self.found.remote {
            let len = self.found.len.unwrap_or(0);
            u8::try_from(len).ok().and_then(|len| Frame::remote(id, len)).map(at_zero)
        } else if self.found.fd || count > 8 {
            Record::fd(Timestamp::ZERO, ChannelId(0), id, Flags::NONE, data)
        } else {
            Frame::new(id, data).map(at_zero)
        };
        record.ok_or((begin, "a length that frames have"))
    }

    fn is_remote_next(&self) -> bool {
        let next = self.tokens.get(self.at).map(|token| token.kind);
        matches!(next, Some(Kind::Word(Word::Remote | Word::ReceivedOrRemote)))
    }

    fn ends_here(&self) -> bool {
        self.tokens.get(self.at).is_none_or(|token| token.aside)
    }

    /// The data bytes and their number.
    fn data(&mut self) -> Result<([u8; MOST_BYTES], usize), Miss> {
        let (mut data, mut count) = ([0; MOST_BYTES], 0);
        if self.layout.data == DataForm::Compact {
            if let Some(token) = self.tokens.get(self.at).filter(|token| !token.aside && self.found.len != Some(0)) {
                count = compact(token, self.line, &mut data).ok_or((token.start, "data bytes in hex"))?;
                self.at += 1;
            }
            return Ok((data, count));
        }
        let limit = self.found.len.unwrap_or(MOST_BYTES).min(MOST_BYTES);
        while count < limit {
            let Some(byte) = self.next_byte() else { break };
            if let Some(place) = data.get_mut(count) {
                *place = byte;
            }
            (count, self.at) = (count + 1, self.at + 1);
        }
        match self.next_byte() {
            Some(_) => Err((self.offset(), "the end of the data")),
            None => Ok((data, count)),
        }
    }

    /// The next token as a data byte.
    fn next_byte(&self) -> Option<u8> {
        let token = self.tokens.get(self.at).filter(|token| !token.aside)?;
        let number = token.number().filter(|number| !number.bracketed && !number.extended)?;
        let byte = match self.layout.data {
            DataForm::Decimal => number.decimal()?,
            DataForm::Padded if number.digits != 2 && !number.is_hex => return None,
            _ if number.digits > 2 => return None,
            _ => number.hex,
        };
        u8::try_from(byte).ok()
    }

    fn identifier(&self, number: &Number) -> Option<CanId> {
        let value = if self.layout.id_is_decimal { number.decimal()? } else { number.hex };
        let is_wide = value > CanId::MAX_STANDARD
            || !self.layout.id_is_decimal && number.digits == 8 && !self.layout.wide_is_standard;
        if number.extended || self.found.extended.unwrap_or(is_wide) {
            CanId::extended(value)
        } else {
            CanId::standard(value)
        }
    }

    pub(super) fn notation(&mut self) -> Result<Record, Miss> {
        let text = self.whole_word(Kind::Notation)?;
        let from = self.offset();
        let text = self.line.get(text.0..text.1).unwrap_or_default();
        whole(frame(text), "the end of the frame").map_err(|Expected { what, .. }| (from, what))
    }

    pub(super) fn slcan(&mut self) -> Result<Record, Miss> {
        let from = self.offset();
        let text = self.whole_word(Kind::Slcan)?;
        let text = self.line.get(text.0..text.1).unwrap_or_default();
        slcan(text).ok_or((from, "a frame in SLCAN's notation"))
    }

    /// The next token, which must be a whole frame.
    fn whole_word(&mut self, kind: Kind) -> Result<(usize, usize), Miss> {
        self.pass_words()?;
        match self.tokens.get(self.at) {
            Some(token) if token.kind == kind && !token.aside => {
                self.at += 1;
                Ok((token.start, token.end))
            }
            _ => Err((self.offset(), "a frame such as 605#4000100000000000")),
        }
    }
}

fn at_zero(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId(0), frame)
}

/// Writes the bytes of a word of digits into `data`; returns their number.
fn compact(token: &Token, line: &[u8], data: &mut [u8; MOST_BYTES]) -> Option<usize> {
    let text = match token.kind {
        Kind::Digits => token.text(line),
        Kind::Number(number) if !number.extended && !number.bracketed => token.text(line),
        _ => return None,
    };
    let digits = text.strip_prefix(b"0x").unwrap_or(text);
    if !digits.len().is_multiple_of(2) || digits.len() > 2 * MOST_BYTES {
        return None;
    }
    for (place, pair) in data.iter_mut().zip(digits.chunks(2)) {
        let [high, low] = pair else { return None };
        *place = nibble(*high)? << 4 | nibble(*low)?;
    }
    Some(digits.len() / 2)
}

/// Parses a frame in SLCAN's notation: `t`, `T`, `r` or `R`, the identifier, the length and the data.
fn slcan(text: &[u8]) -> Option<Record> {
    let (kind, digits) = text.split_first()?;
    let (extended, remote) = (matches!(kind, b'T' | b'R'), matches!(kind, b'r' | b'R'));
    let (id, rest) = digits.split_at_checked(if extended { 8 } else { 3 })?;
    let id = id.iter().try_fold(0, |id, digit| Some(id << 4 | u32::from(nibble(*digit)?)))?;
    let id = if extended { CanId::extended(id) } else { CanId::standard(id) }?;
    let (len, bytes) = rest.split_first()?;
    let len = nibble(*len)?;
    if remote {
        return Frame::remote(id, len).map(at_zero);
    }
    let mut data = [0; 8];
    let data = data.get_mut(..usize::from(len))?;
    for (place, pair) in data.iter_mut().zip(bytes.chunks(2)) {
        let [high, low] = pair else { return None };
        *place = nibble(*high)? << 4 | nibble(*low)?;
    }
    Frame::new(id, data).map(at_zero)
}
