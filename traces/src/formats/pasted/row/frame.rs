//! The frame of a line: its columns, or its one word.

use super::super::layout::{Behind, DataForm, Role};
use super::super::token::{Kind, Number, Token};
use super::super::word::Word;
use super::{MOST_BYTES, Miss, Reading};
use crate::grammar::{Expected, nibble, whole};
use crate::notation::frame;
use crate::{CanId, ChannelId, Direction, ErrorClass, Frame, Record, Timestamp};

impl Reading<'_> {
    /// The frame of a line with columns.
    pub(super) fn apart(&mut self) -> Result<Record, Miss> {
        let Some((number, id_at)) = self.found.id else { return Err((self.line.len(), "an identifier")) };
        if self.found.len != Some(0) || self.is_remote_next() {
            self.pass_words()?;
        }
        let begin = self.offset();
        let next = self.tokens.get(self.at).filter(|token| !token.aside).map(|token| token.kind);
        let is_number = matches!(next, Some(Kind::Number(_) | Kind::Digits));
        self.found.decide_letter(is_number && self.found.len != Some(0));
        let may_be_behind = self.found.len.is_some() && self.layout.behind != Behind::Nothing;
        if self.found.remote && is_number && !may_be_behind {
            return Err((begin, "a remote frame without data"));
        }
        let (data, count) = if self.found.remote { ([0; MOST_BYTES], 0) } else { self.data()? };
        let data = data.get(..count).unwrap_or_default();
        match self.found.len {
            Some(len) if !self.found.remote && len != count => {
                return Err((self.offset(), "as many bytes as the length says"));
            }
            Some(_) => {}
            None if count > 8 => return Err((begin, "at most 8 bytes without a length")),
            None if count == 0 && !self.found.remote && !self.is_frame_alone(&number, id_at) => {
                return Err((begin, "data bytes"));
            }
            None => {}
        }
        let id = self.identifier(&number).ok_or((id_at, "an identifier of 11 or 29 bits"))?;
        let record = if self.found.error {
            Frame::error(ErrorClass(id.raw()), data).map(at_zero)
        } else if self.found.remote {
            let len = self.found.len.unwrap_or(0);
            u8::try_from(len).ok().and_then(|len| Frame::remote(id, len)).map(at_zero)
        } else if self.found.fd || count > 8 {
            Record::fd(Timestamp::ZERO, ChannelId(0), id, self.found.flags, data)
        } else {
            Frame::new(id, data).map(at_zero)
        };
        record.ok_or((begin, "a length that frames have"))
    }

    fn is_remote_next(&self) -> bool {
        let next = self.tokens.get(self.at).map(|token| token.kind);
        matches!(next, Some(Kind::Word(Word::Remote | Word::ReceivedOrRemote)))
    }

    /// Whether an identifier without length and data is a frame, and not any number: a time, a direction or a channel
    /// is beside it, or it could not be a decimal number.
    fn is_frame_alone(&self, number: &Number, at: usize) -> bool {
        let is_seen = self.layout.has(Role::Time) || self.found.clock.is_some() || self.found.channel.is_some();
        let text = self.line.get(at..at + usize::from(number.digits)).unwrap_or_default();
        let is_padded = text.first() == Some(&b'0') && number.digits >= 3;
        let is_hex = !number.is_decimal && text.iter().any(u8::is_ascii_digit);
        self.ends_here()
            && (is_seen
                || self.found.direction != Direction::Unknown
                || self.found.labelled
                || is_padded
                || is_hex
                || number.is_hex)
    }

    fn ends_here(&self) -> bool {
        self.tokens.get(self.at).is_none_or(|token| token.aside)
    }

    /// The data bytes and their number.
    fn data(&mut self) -> Result<([u8; MOST_BYTES], usize), Miss> {
        let (mut data, mut count) = ([0; MOST_BYTES], 0);
        if self.layout.data == DataForm::Compact {
            return self.groups();
        }
        let limit = self.found.len.unwrap_or(MOST_BYTES).min(MOST_BYTES);
        while count < limit {
            let Some(byte) = self.next_byte() else { break };
            if self.found.len.is_none() && count < 7 && self.is_word_next() {
                return Err((self.offset(), "a mark such as // before a remark"));
            }
            if let Some(place) = data.get_mut(count) {
                *place = byte;
            }
            (count, self.at) = (count + 1, self.at + 1);
        }
        match self.next_byte() {
            Some(_) if self.is_counter_last() || self.found.len.is_some() && self.is_word_next() => Ok((data, count)),
            Some(_) => Err((self.offset(), "the end of the data")),
            None => Ok((data, count)),
        }
    }

    /// Data in words of several bytes: one word, or groups of the same length after a label or a length.
    fn groups(&mut self) -> Result<([u8; MOST_BYTES], usize), Miss> {
        let (mut data, mut count, mut digits) = ([0; MOST_BYTES], 0, None);
        let is_grouped = self.found.labelled || self.found.len.is_some();
        while (digits.is_none() || is_grouped) && self.found.len.is_none_or(|len| count < len) {
            let Some(token) = self.tokens.get(self.at).filter(|token| !token.aside) else { break };
            let place = data.get_mut(count..).unwrap_or_default();
            let Some(bytes) = compact(token, self.line, place) else {
                if digits.is_some() {
                    break;
                }
                return Err((token.start, "data bytes in hex"));
            };
            // The last group may be shorter. Bytes apart are no groups.
            if digits.is_some_and(|digits| bytes > digits || digits == 1) {
                return Err((token.start, "groups of bytes of one length"));
            }
            (digits, count, self.at) = (digits.or(Some(bytes)), count + bytes, self.at + 1);
        }
        let next = self.tokens.get(self.at).filter(|token| !token.aside);
        let is_bytes = next.is_some_and(|token| compact(token, self.line, &mut [0; MOST_BYTES]).is_some());
        if is_bytes && !self.is_counter_last() && !self.is_word_next() {
            return Err((self.offset(), "the end of the data"));
        }
        Ok((data, count))
    }

    /// Whether the line ends in its number, as the meaning of the columns says.
    pub(super) fn is_counter_last(&self) -> bool {
        let last = self.tokens.get(self.at).and_then(Token::number);
        self.layout.behind == Behind::Counter
            && self.at + 1 == self.tokens.len()
            && last.is_some_and(|number| number.is_decimal)
    }

    /// Whether the next token has letters that could be digits, and a word follows: `be careful`.
    fn is_word_next(&self) -> bool {
        let Some([token, next]) = self.tokens.get(self.at..self.at + 2) else { return false };
        let is_word = |token: &Token| token.text(self.line).iter().all(u8::is_ascii_lowercase);
        let is_letters = token.number().is_some_and(|number| number.may_be_word());
        is_letters && is_word(token) && is_word(next) && matches!(next.kind, Kind::Word(Word::Unknown | Word::Usual))
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
fn compact(token: &Token, line: &[u8], data: &mut [u8]) -> Option<usize> {
    let text = match token.kind {
        Kind::Digits => token.text(line),
        Kind::Number(number) if !number.extended && !number.bracketed => token.text(line),
        _ => return None,
    };
    let digits = text.strip_prefix(b"0x").unwrap_or(text);
    if !digits.len().is_multiple_of(2) || digits.len() > 2 * data.len() {
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
