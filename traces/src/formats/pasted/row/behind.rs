//! What follows the frame of a line: its time and direction, and the remark.

use super::super::layout::{Behind, Core, DataForm};
use super::super::token::Kind;
use super::super::word::{Label, Word};
use super::{Found, Reading, Row};
use crate::{Direction, Record};

impl Reading<'_> {
    /// Reads what follows the frame.
    pub(super) fn finish(mut self, record: Record) -> Row {
        let values = match self.layout.behind {
            Behind::Nothing => 0,
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
            next,
            id,
            width_is_said,
            may_go_on,
            labelled,
            length_is_said,
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
