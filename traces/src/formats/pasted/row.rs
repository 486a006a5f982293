//! Reads one pasted line by the meaning of its columns.

use super::layout::{Behind, Core, DataForm, Layout, Role};
use super::token::{Kind, Number, Token};
use super::word::{Label, Word};
use crate::grammar::{Expected, nibble, whole};
use crate::notation::frame;
use crate::{CanId, ChannelId, Direction, Flags, Frame, Record, Timestamp};

/// Why a line is no frame: the place, and what was expected there.
pub(super) type Miss = (usize, &'static str);

/// Maximum number of data bytes.
const MOST_BYTES: usize = 64;

/// The parts of a line, as indices of its tokens where they are not yet parsed.
pub(super) struct Row {
    pub(super) record: Record,
    /// The number with the time.
    pub(super) time: Option<usize>,
    pub(super) clock: Option<usize>,
    pub(super) date: Option<usize>,
    pub(super) channel: Option<usize>,
    /// The offset of the remark in the line.
    pub(super) remark: usize,
    /// The first token after the frame and its columns.
    pub(super) next: usize,
    /// The digits of the identifier, where it is a column.
    pub(super) id: Option<Number>,
    /// Whether a word says if the identifier has 11 or 29 bits.
    pub(super) width_is_said: bool,
    /// Whether the line may be the beginning of a longer one, if it has no line end.
    pub(super) may_go_on: bool,
    /// Whether a label or brackets show what the numbers mean.
    pub(super) labelled: bool,
    /// Whether a label or brackets show which number is the length.
    pub(super) length_is_said: bool,
}

/// Reads a line.
pub(super) fn read(line: &[u8], tokens: &[Token], layout: &Layout) -> Result<Row, Miss> {
    let mut reading = Reading { line, tokens, layout, at: 0, found: Found::default() };
    for role in &layout.before {
        let place = reading.next_value()?;
        reading.value(*role, place)?;
    }
    let record = match layout.core {
        Core::Apart => reading.apart()?,
        Core::Notation => reading.notation()?,
        Core::Slcan => reading.slcan()?,
    };
    Ok(reading.finish(record))
}

#[derive(Default)]
struct Found {
    id: Option<(Number, usize)>,
    len: Option<usize>,
    extended: Option<bool>,
    direction: Direction,
    remote: bool,
    fd: bool,
    time: Option<usize>,
    clock: Option<usize>,
    date: Option<usize>,
    channel: Option<usize>,
    label: Option<Label>,
    labelled: bool,
    length_is_said: bool,
}

struct Reading<'a> {
    line: &'a [u8],
    tokens: &'a [Token],
    layout: &'a Layout,
    at: usize,
    found: Found,
}

impl Reading<'_> {
    /// The offset of the next token in the line.
    fn offset(&self) -> usize {
        self.tokens.get(self.at).map_or(self.line.len(), |token| token.start)
    }

    /// Passes what stands beside the columns; returns the place of the next number.
    fn next_value(&mut self) -> Result<usize, Miss> {
        loop {
            self.pass_words()?;
            let place = self.at;
            match self.tokens.get(place) {
                Some(token) if token.is_value() && !token.aside => {
                    self.at += 1;
                    return Ok(place);
                }
                // Letters that could be digits: a flag, such as `d` for data.
                Some(Token { kind: Kind::Number(number), .. }) => {
                    self.found.fd |= number.digits == 2 && matches!(number.hex, 0xFB | 0xFD | 0xFE);
                    self.at += 1;
                }
                _ => return Err((self.offset(), "another column of the frame")),
            }
        }
    }

    /// Passes words, labels, marks, dates and times of the day.
    fn pass_words(&mut self) -> Result<(), Miss> {
        while let Some(token) = self.tokens.get(self.at) {
            match token.kind {
                Kind::Word(word) => self.word(word, *token)?,
                Kind::Label(label) => self.found.label = Some(label),
                Kind::Clock => self.found.clock = Some(self.at),
                Kind::Date => self.found.date = Some(self.at),
                Kind::Mark => {}
                _ => return Ok(()),
            }
            self.at += 1;
        }
        Ok(())
    }

    fn word(&mut self, word: Word, token: Token) -> Result<(), Miss> {
        let found = &mut self.found;
        match word {
            Word::Direction(direction) => found.direction = direction,
            Word::ReceivedOrRemote if found.direction == Direction::Unknown => found.direction = Direction::Rx,
            Word::ReceivedOrRemote | Word::Remote => found.remote = true,
            Word::Extended => found.extended = Some(true),
            Word::Standard => found.extended = Some(false),
            Word::Bits(direction, extended) => (found.direction, found.extended) = (direction, Some(extended)),
            Word::Fd => found.fd = true,
            Word::Error => return Err((token.start, "a frame with an identifier, not an error frame")),
            Word::Channel => found.channel = found.channel.or(Some(self.at)),
            Word::Usual => {}
            Word::Unknown if self.layout.words.knows(token.text(self.line)) => {}
            Word::Unknown => return Err((token.start, "no word that other lines don't have")),
        }
        Ok(())
    }

    fn value(&mut self, role: Role, place: usize) -> Result<(), Miss> {
        let Some(token) = self.tokens.get(place) else { return Err((self.line.len(), "a number")) };
        let label = self.found.label.take();
        let is_id = matches!(label, Some(Label::Id | Label::ExtendedId));
        match role {
            _ if is_id && role != Role::Id => return Err((token.start, "no other identifier")),
            Role::Skip => {}
            Role::Time => self.found.time = Some(place),
            Role::Channel => self.found.channel = Some(place),
            Role::Id => {
                let Some(number) = token.number().filter(|number| self.may_be_id(number, is_id)) else {
                    return Err((token.start, "an identifier"));
                };
                self.found.extended = self.found.extended.or((label == Some(Label::ExtendedId)).then_some(true));
                self.found.id = Some((number, token.start));
                self.found.labelled |= is_id;
            }
            Role::Length => {
                let len =
                    token.number().and_then(|number| if number.is_hex { Some(number.hex) } else { number.decimal() });
                let Some(len) = len.map(|len| len as usize).filter(|len| *len <= MOST_BYTES) else {
                    return Err((token.start, "a length of at most 64"));
                };
                self.found.len = Some(len);
                let is_said = label == Some(Label::Length) || token.number().is_some_and(|n| n.bracketed);
                self.found.labelled |= is_said;
                self.found.length_is_said |= is_said;
            }
        }
        Ok(())
    }

    fn may_be_id(&self, number: &Number, labelled: bool) -> bool {
        if number.bracketed {
            return false;
        }
        if self.layout.id_is_decimal {
            return number.decimal().is_some_and(|id| {
                id <= CanId::MAX_EXTENDED && (id == 0 || id.ilog10() + 1 == u32::from(number.digits))
            });
        }
        match number.digits {
            _ if number.hex > CanId::MAX_EXTENDED => false,
            8 => true,
            _ if number.is_hex || number.extended || labelled => true,
            1..=4 => number.hex <= CanId::MAX_STANDARD,
            _ => false,
        }
    }

    /// The frame of a line with columns.
    fn apart(&mut self) -> Result<Record, Miss> {
        let Some((number, id_at)) = self.found.id else { return Err((self.line.len(), "an identifier")) };
        if self.found.len != Some(0) || self.is_remote_next() {
            self.pass_words()?;
        }
        let begin = self.offset();
        let (data, count) = if self.found.remote { ([0; MOST_BYTES], 0) } else { self.data()? };
        let data = data.get(..count).unwrap_or_default();
        match self.found.len {
            Some(len) if !self.found.remote && len != count => {
                return Err((begin, "as many bytes as the length says"));
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

    fn notation(&mut self) -> Result<Record, Miss> {
        let text = self.whole_word(Kind::Notation)?;
        let from = self.offset();
        let text = self.line.get(text.0..text.1).unwrap_or_default();
        whole(frame(text), "the end of the frame").map_err(|Expected { what, .. }| (from, what))
    }

    fn slcan(&mut self) -> Result<Record, Miss> {
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

    /// Reads what follows the frame.
    fn finish(mut self, record: Record) -> Row {
        let values = match self.layout.behind {
            Behind::Nothing => 0,
            Behind::Time => 1,
            Behind::CycleAndCount => 2,
        };
        for _ in 0..values {
            if let Some(token) = self.tokens.get(self.at).filter(|token| token.is_value()) {
                if self.layout.behind == Behind::Time && token.kind == Kind::Fraction {
                    self.found.time = Some(self.at);
                }
                self.at += 1;
            }
        }
        self.direction_behind();
        if let Some([label, value]) = self.tokens.get(self.at..self.at + 2)
            && label.kind == Kind::Label(Label::Channel)
        {
            self.found.channel = Some(self.at + 1);
            self.at += 2;
            debug_assert!(value.start >= label.end, "tokens are in the order of the line");
        }
        let remark = self.at.checked_sub(1).and_then(|last| self.tokens.get(last)).map_or(0, |token| token.end);
        let may_go_on = self.may_go_on(&record, remark);
        let Found { time, clock, date, channel, labelled, length_is_said, .. } = self.found;
        let Found { direction, id, extended, .. } = self.found;
        let (id, next) = (id.map(|(number, _)| number), self.at);
        let width_is_said = extended.is_some() || id.is_some_and(|id| id.extended);
        let record = record.with_direction(direction);
        Row { record, time, clock, date, channel, remark, next, id, width_is_said, may_go_on, labelled, length_is_said }
    }

    /// Whether more digits, a direction or words that make a frame a remote one may follow.
    fn may_go_on(&self, record: &Record, remark: usize) -> bool {
        if self.layout.behind != Behind::Nothing && self.found.direction == Direction::Unknown {
            return true;
        }
        let (frame, layout) = (&record.frame, self.layout);
        let is_open = match layout.core {
            Core::Notation => frame.is_remote() || frame.len() < 8,
            Core::Slcan => false,
            Core::Apart if frame.is_remote() => false,
            Core::Apart => {
                let has_length = self.found.len.is_some_and(|len| len > 0);
                !has_length && frame.len() < 8 || matches!(layout.data, DataForm::Unpadded | DataForm::Decimal)
            }
        };
        is_open && self.line.get(remark..).unwrap_or_default().trim_ascii().is_empty()
    }

    /// A direction after the frame, unless it is an arrow, which begins a remark.
    fn direction_behind(&mut self) {
        let Some(token) = self.tokens.get(self.at).filter(|token| !token.aside) else { return };
        if self.found.direction != Direction::Unknown || !token.text(self.line).iter().all(u8::is_ascii_alphabetic) {
            return;
        }
        let direction = match token.kind {
            Kind::Word(Word::Direction(direction)) => direction,
            Kind::Word(Word::ReceivedOrRemote) => Direction::Rx,
            _ => return,
        };
        (self.found.direction, self.at) = (direction, self.at + 1);
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
