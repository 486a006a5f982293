//! Stands between a tester and a bus, and writes the transcript.

use super::{Clock, Transcript};
use crate::{Bus, BusError, Health};
use canvass_traces::{Direction, Duration, Frame, Record, Timestamp};
use std::cell::RefCell;
use std::collections::VecDeque;

/// A bus whose use is transcribed.
pub struct Transcriber<'a> {
    bus: &'a mut dyn Bus,
    /// Gets each frame that the tester receives.
    observe: &'a mut dyn FnMut(&Record),
    written: RefCell<Written>,
    /// Sent frames that have not been on the bus yet.
    sent: VecDeque<Frame>,
}

struct Written {
    transcript: Transcript,
    clock: Clock,
    /// Number of questions since the last written answer.
    asked_time: u64,
    asked_health: u64,
    health: Health,
    empty: u64,
}

impl Written {
    fn trouble(&mut self, what: impl FnOnce() -> String) {
        self.transcript.trouble.get_or_insert_with(what);
    }
}

impl<'a> Transcriber<'a> {
    /// Begins a transcript.
    pub fn new(bus: &'a mut dyn Bus, observe: &'a mut dyn FnMut(&Record)) -> Self {
        let begin = bus.now();
        let transcript =
            Transcript { is_live: bus.is_live(), bit_rate: bus.bit_rate(), begin, ..Transcript::default() };
        let (clock, health) = (Clock(begin), Health::default());
        let written = Written { transcript, clock, asked_time: 0, asked_health: 0, health, empty: 0 };
        Self { bus, observe, written: RefCell::new(written), sent: VecDeque::new() }
    }

    /// Ends the transcript.
    pub fn finish(self) -> Transcript {
        self.written.into_inner().transcript
    }

    fn is_next(&mut self, record: &Record) {
        if record.direction == Direction::Tx && self.sent.pop_front() != Some(record.frame) {
            let frame = record.frame;
            self.written.get_mut().trouble(|| format!("{frame} was on the bus in another order than sent"));
        }
    }
}

impl Bus for Transcriber<'_> {
    fn now(&self) -> Timestamp {
        let now = self.bus.now();
        let written = &mut *self.written.borrow_mut();
        if now == written.clock.0 {
            written.asked_time += 1;
        } else {
            written.transcript.clock.push((std::mem::take(&mut written.asked_time), now));
            written.clock.0 = now;
        }
        now
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let sent = self.bus.send(frame);
        match &sent {
            Ok(()) => self.sent.push_back(*frame),
            Err(error) => self.written.get_mut().trouble(|| error.to_string()),
        }
        sent
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        let received = self.bus.receive(deadline);
        let written = self.written.get_mut();
        match &received {
            Ok(Some(record)) => {
                written.transcript.waits.push(std::mem::take(&mut written.empty));
                written.clock.advance(Some(record), deadline);
                (self.observe)(record);
                self.is_next(record);
            }
            Ok(None) => {
                written.empty += 1;
                written.clock.advance(None, deadline);
            }
            Err(error) => written.trouble(|| error.to_string()),
        }
        received
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bus.bit_rate()
    }

    fn is_live(&self) -> bool {
        self.bus.is_live()
    }

    fn wait_for_client(&mut self, patience: Duration) -> Result<(), BusError> {
        self.bus.wait_for_client(patience)
    }

    fn health(&self) -> Health {
        let health = self.bus.health();
        let written = &mut *self.written.borrow_mut();
        if health == written.health {
            written.asked_health += 1;
        } else {
            written.transcript.health.push((std::mem::take(&mut written.asked_health), health.clone()));
            written.health = health.clone();
        }
        health
    }

    fn is_interrupted(&self) -> bool {
        self.bus.is_interrupted()
    }

    fn wait_until_back(&mut self) -> Result<(), BusError> {
        self.bus.wait_until_back()
    }

    fn limit_backlog(&mut self, frames: usize) {
        self.bus.limit_backlog(frames);
    }

    fn only(&mut self, cob_ids: &[(u16, u16)]) -> Result<(), BusError> {
        self.bus.only(cob_ids)
    }

    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        let set = self.bus.set_bit_rate(bit_rate);
        let written = self.written.get_mut();
        match &set {
            Ok(()) => written.transcript.bit_rates.push(true),
            Err(BusError::FixedBitRate { .. }) => written.transcript.bit_rates.push(false),
            Err(error) => written.trouble(|| error.to_string()),
        }
        set
    }
}
