//! Reads one pasted line by the meaning of its columns.

mod behind;
mod flags;
mod frame;

use super::layout::{Behind, Core, Layout, Role};
use super::token::{Kind, Number, Token};
use super::word::{Label, Word};
use crate::{CanId, Direction, Flags, Record};

pub(super) use behind::clock_at;

/// Why a line is no frame: the place, and what was expected there.
pub(super) type Miss = (usize, &'static str);

/// Maximum number of data bytes.
const MOST_BYTES: usize = 64;

/// The parts of a line, as indices of its tokens where they are not yet parsed.
pub(super) struct Row {
    pub(super) record: Record,
    /// The number with the time.
    pub(super) time: Option<usize>,
    /// The number with the microseconds of a time in seconds.
    pub(super) micros: Option<usize>,
    /// Whether a label without meaning is before the identifier.
    pub(super) other_label: bool,
    pub(super) clock: Option<usize>,
    pub(super) date: Option<usize>,
    pub(super) channel: Option<usize>,
    /// The offset of the remark in the line.
    pub(super) remark: usize,
    /// The first token after the data.
    pub(super) end: usize,
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
        match reading.next_value() {
            Ok(place) => reading.value(*role, place)?,
            Err(_) if *role == Role::Length && reading.is_remote_at_end() => {}
            Err(miss) => return reading.error_frame(*role).ok_or(miss),
        }
    }
    let record = match layout.core {
        Core::Apart => reading.apart()?,
        Core::Notation => reading.notation()?,
        Core::Slcan => reading.slcan()?,
    };
    if reading.found.strange_id && !(layout.has(Role::Length) && reading.at == tokens.len()) {
        return Err((reading.found.id.map_or(0, |(_, at)| at), "an identifier with as many digits as the others"));
    }
    if reading.found.other_label && !layout.has_labels {
        return Err((0, "no label that other lines don't have"));
    }
    if layout.behind == Behind::Counter && !reading.is_counter_last() {
        return Err((reading.offset(), "the number of the line at its end"));
    }
    Ok(reading.finish(record))
}

/// Another frame in the line of a frame.
pub(super) struct Second {
    /// The offset of the frame in the line.
    pub(super) at: usize,
    pub(super) record: Record,
    /// Whether it follows the first frame without a mark between them.
    pub(super) is_next: bool,
}

/// The frame after the one that ends before the token `next`.
pub(super) fn second(line: &[u8], tokens: &[Token], layout: &Layout, next: usize) -> Option<Second> {
    let rest = tokens.get(next..)?;
    let has_frame = match layout.core {
        Core::Apart => layout.has(Role::Length) && rest.iter().filter(|token| token.is_value()).count() >= 3,
        Core::Notation => rest.iter().any(|token| token.kind == Kind::Notation),
        Core::Slcan => rest.iter().any(|token| token.kind == Kind::Slcan),
    };
    if !has_frame {
        return None;
    }
    let is_aside = rest.first().is_some_and(|token| token.aside);
    let rest: Vec<Token> = rest.iter().map(|token| Token { aside: false, ..*token }).collect();
    // A mark may be before it.
    (0..rest.len().min(3)).find_map(|from| {
        let (tokens, first) = (rest.get(from..)?, rest.get(from)?);
        let Row { record, .. } = read(line, tokens, layout).ok()?;
        let is_next = from == 0 && !is_aside;
        (layout.core != Core::Apart || record.frame.len() >= 2).then_some(Second { at: first.start, record, is_next })
    })
}

#[derive(Default)]
struct Found {
    id: Option<(Number, usize)>,
    len: Option<usize>,
    extended: Option<bool>,
    direction: Direction,
    remote: bool,
    /// A letter that is a direction or the mark of a remote frame.
    received_or_remote: bool,
    error: bool,
    fd: bool,
    flags: Flags,
    /// The identifier has a number of digits that no other has.
    strange_id: bool,
    time: Option<usize>,
    micros: Option<usize>,
    clock: Option<usize>,
    date: Option<usize>,
    channel: Option<usize>,
    label: Option<Label>,
    /// A label without meaning was before the identifier.
    other_label: bool,
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
                Some(token @ Token { kind: Kind::Number(number), .. }) => {
                    self.letter_flag(number, token.text(self.line));
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
                Kind::Word(word) if self.said_flag(word).is_some() => self.at += 1,
                Kind::Word(word) => self.word(word, *token)?,
                Kind::Label(label) if self.labelled_flag(label).is_some() => self.at += 1,
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
            Word::Direction(_) if self.layout.arrow_is_mark && token.text(self.line) == b"->" => {}
            Word::Direction(direction) => found.direction = direction,
            Word::ReceivedOrRemote if found.id.is_none() => found.direction = Direction::Rx,
            Word::ReceivedOrRemote if found.direction == Direction::Unknown => found.received_or_remote = true,
            Word::ReceivedOrRemote | Word::Remote => found.remote = true,
            Word::Extended => found.extended = Some(true),
            Word::Standard => found.extended = Some(false),
            Word::Bits(direction, extended) => (found.direction, found.extended) = (direction, Some(extended)),
            Word::Fd => found.fd = true,
            Word::Brs => (found.fd, found.flags) = (true, found.flags.with(Flags::BRS)),
            Word::Esi => (found.fd, found.flags) = (true, found.flags.with(Flags::ESI)),
            Word::ErrorFrame if found.id.is_some() => found.error = true,
            Word::ErrorFrame | Word::Error => return Err((token.start, "a frame with an identifier")),
            Word::Channel => found.channel = found.channel.or(Some(self.at)),
            Word::Name | Word::Usual => {}
            Word::Unknown if self.layout.words.knows(token.text(self.line)) => {}
            Word::Unknown => return Err((token.start, "no word that other lines don't have")),
        }
        Ok(())
    }

    fn value(&mut self, role: Role, place: usize) -> Result<(), Miss> {
        let Some(token) = self.tokens.get(place) else { return Err((self.line.len(), "a number")) };
        let label = self.found.label.take();
        self.found.other_label |= label == Some(Label::Other);
        let is_id = matches!(label, Some(Label::Id | Label::ExtendedId));
        match role {
            _ if is_id && role != Role::Id => return Err((token.start, "no other identifier")),
            Role::Skip => {}
            Role::Time if self.found.id.is_some() && token.kind != Kind::Fraction => {
                return Err((token.start, "a time with a decimal sign"));
            }
            Role::Time => self.found.time = Some(place),
            Role::Micros => self.found.micros = Some(place),
            Role::Channel => self.found.channel = Some(place),
            Role::Id => {
                let Some(number) = token.number().filter(|number| self.may_be_id(number, is_id)) else {
                    return Err((token.start, "an identifier"));
                };
                self.found.extended = self.found.extended.or((label == Some(Label::ExtendedId)).then_some(true));
                self.found.id = Some((number, token.start));
                self.found.labelled |= is_id;
                self.found.strange_id =
                    !(is_id || number.is_hex || number.extended) && self.layout.is_strange(number.digits);
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
