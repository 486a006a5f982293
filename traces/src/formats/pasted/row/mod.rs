//! Reads one pasted line by the meaning of its columns.

mod behind;
mod frame;

use super::layout::{Core, Layout, Role};
use super::token::{Kind, Number, Token};
use super::word::{Label, Word};
use crate::{CanId, Direction, Record};

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
}
