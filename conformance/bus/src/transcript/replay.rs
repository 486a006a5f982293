//! The bus of a tester that repeats a run from its recording.

use super::{Clock, Transcript};
use crate::{Bus, BusError, Health};
use canvass_traces::{Direction, Duration, Frame, Record, Timestamp};
use std::cell::RefCell;
use std::collections::VecDeque;

/// The place at which tester and recording diverge.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{at}: {why}")]
pub struct Divergence {
    /// The place in the recording: `frame 12`.
    pub at: String,
    /// The expected and the recorded event.
    pub why: String,
}

/// A bus that answers from a recording. The tester must send the recorded frames, and receives the recorded frames at
/// their recorded times.
pub struct Replay {
    records: VecDeque<Record>,
    /// The frames that must be sent, oldest first.
    expected: VecDeque<Frame>,
    /// Number of sent frames whose echo was not delivered yet.
    under_way: usize,
    /// Number of delivered records.
    number: u64,
    waits: VecDeque<u64>,
    empty: u64,
    is_live: bool,
    bit_rate: Option<u32>,
    bit_rates: VecDeque<bool>,
    answers: RefCell<Answers>,
    divergence: Option<Divergence>,
}

/// Recorded answers, each repeated until the next change.
struct Answers {
    clock: Clock,
    readings: VecDeque<(u64, Timestamp)>,
    health: Health,
    changes: VecDeque<(u64, Health)>,
}

/// Counts one question. Returns the next recorded answer if the answer changed at this question; `None` if the previous
/// answer still holds.
fn next<T>(row: &mut VecDeque<(u64, T)>) -> Option<T> {
    match row.front_mut() {
        Some((0, _)) => row.pop_front().map(|(_, answer)| answer),
        Some((left, _)) => {
            *left -= 1;
            None
        }
        None => None,
    }
}

impl Replay {
    /// The bus of a recording.
    pub fn new(records: impl IntoIterator<Item = Record>, transcript: Transcript) -> Self {
        let records: VecDeque<Record> = records.into_iter().collect();
        let sent = records.iter().filter(|record| record.direction == Direction::Tx);
        let Transcript { is_live, bit_rate, begin, waits, clock, health, bit_rates, .. } = transcript;
        Self {
            expected: sent.map(|record| record.frame).collect(),
            under_way: 0,
            number: 0,
            waits: waits.into(),
            empty: 0,
            is_live,
            bit_rate,
            bit_rates: bit_rates.into(),
            answers: RefCell::new(Answers {
                clock: Clock(begin),
                readings: clock.into(),
                health: Health::default(),
                changes: health.into(),
            }),
            divergence: None,
            records,
        }
    }

    /// The first divergence of tester and recording, if there is one.
    pub fn divergence(&self) -> Option<Divergence> {
        let unsent = || self.expected.front().map(|frame| (frame, self.expected.len()));
        self.divergence.clone().or_else(|| {
            let (frame, count) = unsent()?;
            let why =
                format!("the number of frames in the recording that were not sent is {count}, the first is {frame}");
            Some(Divergence { at: "the end".to_owned(), why })
        })
    }

    fn diverge(&mut self, why: String) -> BusError {
        let at = format!("after frame {}", self.number);
        self.divergence.get_or_insert(Divergence { at, why }).clone().into()
    }

    /// Whether the next record is due.
    fn is_due(&mut self) -> bool {
        if self.records.is_empty() || self.waits.front().is_none_or(|wait| *wait > self.empty) {
            self.empty += 1;
            return false;
        }
        self.waits.pop_front();
        self.empty = 0;
        true
    }
}

impl Bus for Replay {
    fn now(&self) -> Timestamp {
        let answers = &mut *self.answers.borrow_mut();
        if let Some(now) = next(&mut answers.readings) {
            answers.clock.0 = now;
        }
        answers.clock.0
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        match self.expected.pop_front() {
            Some(expected) if expected == *frame => {
                self.under_way += 1;
                Ok(())
            }
            Some(expected) => Err(self.diverge(format!("expected {expected}, but {frame} is sent"))),
            // The recording may lack the echoes of a run's last frames.
            None => Ok(()),
        }
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        if let Some(divergence) = &self.divergence {
            return Err(divergence.clone().into());
        }
        let record = if self.is_due() { self.records.pop_front() } else { None };
        if let Some(record) = &record {
            self.number += 1;
            let is_own = record.direction == Direction::Tx;
            if is_own && self.under_way == 0 {
                return Err(self.diverge(format!("expected {} to be sent", record.frame)));
            }
            self.under_way -= usize::from(is_own);
            if !self.is_live && record.timestamp > deadline {
                return Err(self.diverge(format!("{} comes after the end of the wait", record.frame)));
            }
        }
        self.answers.get_mut().clock.advance(record.as_ref(), deadline);
        Ok(record)
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bit_rate
    }

    fn is_live(&self) -> bool {
        self.is_live
    }

    fn wait_for_client(&mut self, _: Duration) -> Result<(), BusError> {
        Ok(())
    }

    fn health(&self) -> Health {
        let answers = &mut *self.answers.borrow_mut();
        if let Some(health) = next(&mut answers.changes) {
            answers.health = health;
        }
        answers.health.clone()
    }

    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        match self.bit_rates.pop_front() {
            Some(true) => {
                self.bit_rate = Some(bit_rate);
                Ok(())
            }
            Some(false) => Err(BusError::FixedBitRate { bit_rate }),
            None => {
                Err(self
                    .diverge(format!("the bit rate is changed to {bit_rate} bit/s, which the recording does not have")))
            }
        }
    }
}
