//! What follows the frame of a line: its time and direction, and the remark.

use super::super::layout::{Behind, Core, DataForm};
use super::super::token::{Kind, Token};
use super::super::word::{Label, Word};
use super::{Found, Reading, Row};
use crate::{Direction, Record};

impl Reading<'_> {
    /// Reads what follows the frame.
    pub(super) fn finish(mut self, record: Record) -> Row {
        let end = self.at;
        let values = match self.layout.behind {
            Behind::Nothing | Behind::Clock => 0,
            Behind::Time | Behind::Counter => 1,
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
        if self.layout.behind == Behind::Clock {
            self.clock_behind();
        }
        self.direction_behind();
        if let Some(label) = self.channel_label() {
            self.found.channel = Some(label + 1);
            self.at = label + 2;
        }
        let remark = self.at.checked_sub(1).and_then(|last| self.tokens.get(last)).map_or(0, |token| token.end);
        let may_go_on = self.may_go_on(&record, remark);
        let Found { time, clock, date, channel, labelled, length_is_said, .. } = self.found;
        let Found { direction, id, extended, micros, other_label, .. } = self.found;
        let (id, next) = (id.map(|(number, _)| number), self.at);
        let width_is_said = extended.is_some() || id.is_some_and(|id| id.extended);
        let record = record.with_direction(direction);
        Row {
            record,
            time,
            micros,
            other_label,
            clock,
            date,
            channel,
            remark,
            end,
            next,
            id,
            width_is_said,
            may_go_on,
            labelled,
            length_is_said,
        }
    }

    /// A date and a time of the day after the frame.
    fn clock_behind(&mut self) {
        let Some(begin) = clock_at(self.tokens, self.at) else { return };
        self.at = begin;
        while let Some(token) = self.tokens.get(self.at) {
            match token.kind {
                Kind::Date => self.found.date = Some(self.at),
                Kind::Clock => self.found.clock = Some(self.at),
                _ => return,
            }
            self.at += 1;
        }
    }

    /// The label of a channel after the frame, perhaps after the data as characters in quotes.
    fn channel_label(&self) -> Option<usize> {
        let behind = self.at.checked_sub(1).and_then(|last| self.tokens.get(last)).map_or(0, |token| token.end);
        let is_quoted = self.line.get(behind..)?.trim_ascii_start().starts_with(b"'");
        let is_label = |at: &usize| self.tokens.get(*at).is_some_and(|t| t.kind == Kind::Label(Label::Channel));
        let last = if is_quoted { self.tokens.len() } else { self.at + 1 };
        let label = (self.at..last).rev().find(is_label)?;
        (label + 1 < self.tokens.len()).then_some(label)
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
            // `R` may be the beginning of `Rx`.
            Core::Apart if frame.is_remote() => self.found.len.is_none() || self.found.received_or_remote,
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

/// The place of a date or a time of the day that follows a frame, perhaps after a number of a timer.
pub(in super::super) fn clock_at(tokens: &[Token], at: usize) -> Option<usize> {
    let is_timer = tokens.get(at).is_some_and(|token| token.kind == Kind::Digits);
    let begin = at + usize::from(is_timer);
    tokens.get(begin).is_some_and(|token| matches!(token.kind, Kind::Date | Kind::Clock)).then_some(begin)
}
