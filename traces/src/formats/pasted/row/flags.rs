//! The flags of a frame, and error frames without identifier.

use super::super::layout::{Core, Role};
use super::super::token::{Kind, Number, Token};
use super::super::word::{Label, Word};
use super::{Found, Reading, Row};
use crate::formats::asc_row::BUS_ERROR;
use crate::{ChannelId, Direction, Flags, Frame, Record, Timestamp};

impl Reading<'_> {
    /// A flag of letters that could be digits: `E` of an error frame, `F` and `FD` of CAN FD, `d` of data.
    pub(super) fn letter_flag(&mut self, number: &Number, text: &[u8]) {
        self.found.fd |= number.digits == 2 && matches!(number.hex, 0xFB | 0xFD | 0xFE);
        // python-can writes its flags after `S` or `X`. Elsewhere `E` may mean an identifier of 29 bits.
        if self.found.id.is_some() && self.found.extended.is_some() {
            self.found.error |= text == b"E";
            self.found.fd |= text == b"F";
        }
        self.found.flags = if number.hex == 0xFB { self.found.flags.with(Flags::BRS) } else { self.found.flags };
    }

    /// The value after a word such as `EXT`, if another word or label follows the value: `EXT 0 DLC 8`.
    pub(super) fn said_flag(&mut self, word: Word) -> Option<()> {
        let label = match word {
            Word::Extended => Label::Extended,
            Word::Remote => Label::Remote,
            _ => return None,
        };
        let [name, value, next] = self.tokens.get(self.at..self.at + 3)? else { return None };
        let is_named = name.end - name.start > 2 && matches!(next.kind, Kind::Word(_) | Kind::Label(_));
        let is_number = value.number().is_some_and(|number| number.digits == 1 && number.hex <= 1);
        if is_named && is_number { self.labelled_flag(label) } else { None }
    }

    /// The value after a label such as `IDE:`.
    pub(super) fn labelled_flag(&mut self, label: Label) -> Option<()> {
        if !matches!(label, Label::Extended | Label::Remote) {
            return None;
        }
        let is_set = flag(self.tokens.get(self.at + 1)?, self.line)?;
        match label {
            Label::Extended => self.found.extended = Some(is_set),
            _ => self.found.remote |= is_set,
        }
        Some(())
    }

    /// Whether the line ends after the mark of a remote frame, so that it has no length.
    pub(super) fn is_remote_at_end(&mut self) -> bool {
        let is_remote = self.at == self.tokens.len() && (self.found.remote || self.found.received_or_remote);
        self.found.remote |= is_remote;
        is_remote
    }

    /// The error frame of a line that has the word `ErrorFrame` in the place of the identifier, and nothing but a time and
    /// a direction after it.
    pub(super) fn error_frame(mut self, role: Role) -> Option<Row> {
        let is_error = |token: &Token| token.kind == Kind::Word(Word::ErrorFrame);
        if role != Role::Id || self.layout.core != Core::Apart || !self.tokens.get(self.at).is_some_and(is_error) {
            return None;
        }
        self.at += 1;
        let frame = Frame::error(BUS_ERROR, &[])?;
        let len = self.tokens.len();
        let row = self.finish(Record::new(Timestamp::ZERO, ChannelId(0), frame));
        (row.next == len).then_some(row)
    }
}

/// The value of a flag.
fn flag(token: &Token, line: &[u8]) -> Option<bool> {
    let is = |words: [&[u8]; 4]| words.iter().any(|word| token.text(line).eq_ignore_ascii_case(word));
    match token.kind {
        Kind::Number(number) if number.digits == 1 && number.hex <= 1 => Some(number.hex == 1),
        Kind::Word(_) if is([b"true", b"yes", b"ext", b"extended"]) => Some(true),
        Kind::Word(_) if is([b"false", b"no", b"std", b"standard"]) => Some(false),
        _ => None,
    }
}

impl Found {
    /// Decides what a letter meant that is a direction or the mark of a remote frame: remote frames have no data.
    pub(super) fn decide_letter(&mut self, has_data: bool) {
        if self.received_or_remote {
            match has_data || self.len == Some(0) {
                true => self.direction = Direction::Rx,
                false => self.remote = true,
            }
        }
    }
}
