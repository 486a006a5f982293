//! Errors: the error register (1001h), the history (1003h) and the EMCY messages (1014h, 1015h).

use crate::{Fault, Faults};
use canvass_analyzer::wire::emcy::{Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Timestamp};
use std::collections::VecDeque;

/// Something that can be wrong with the device. Each is present or not; only changes are reported.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Condition {
    /// The temperature is outside the limits of 2120h.
    Temperature { now: u8, low: u8, high: u8 },
    /// The shaft is too fast (6505h bit 0).
    Overspeed,
    /// The master's guarding or a heartbeat is missing.
    Guarding,
    /// The position is wrong (6503h bit 0).
    Position,
}

impl Condition {
    const COUNT: usize = 4;

    const fn number(self) -> usize {
        match self {
            Self::Temperature { .. } => 0,
            Self::Overspeed => 1,
            Self::Guarding => 2,
            Self::Position => 3,
        }
    }

    const fn code(self) -> EmcyCode {
        match self {
            Self::Temperature { .. } | Self::Overspeed => EmcyCode(0x4200),
            Self::Guarding => EmcyCode::HEARTBEAT,
            Self::Position => EmcyCode::GENERIC,
        }
    }

    /// The bits of the error register. Bit 0 is always among them.
    const fn register(self) -> u8 {
        let profile = if matches!(self, Self::Position) { ErrorRegister::PROFILE.0 } else { 0 };
        ErrorRegister::GENERIC.0 | self.code().register_bits() | profile
    }

    /// Bytes 3 to 7.
    const fn manufacturer(self) -> [u8; 5] {
        match self {
            // Sensor error register, temperature, low and high threshold, sensor version.
            Self::Temperature { now, low, high } => [0x80, now, low, high, 0x2E],
            Self::Overspeed | Self::Guarding | Self::Position => [0; 5],
        }
    }
}

/// The state of errors.
#[derive(Clone, Debug)]
pub(super) struct Errors {
    present: [Option<Condition>; Condition::COUNT],
    /// 1003h, newest first.
    history: VecDeque<u32>,
    /// How many the history holds.
    capacity: usize,
    /// Not sent yet.
    queue: VecDeque<Emcy>,
    /// 1015h: no EMCY before then.
    inhibited_until: Timestamp,
    faults: Faults,
}

/// More EMCY messages than that don't wait; the oldest stay.
const LONGEST_QUEUE: usize = 16;

impl Errors {
    /// No error; the history holds `capacity` entries.
    pub fn new(capacity: usize, faults: Faults) -> Self {
        Self {
            faults,
            present: [None; Condition::COUNT],
            history: VecDeque::with_capacity(capacity),
            capacity,
            queue: VecDeque::with_capacity(LONGEST_QUEUE),
            inhibited_until: Timestamp::ZERO,
        }
    }

    /// 1001h.
    pub fn register(&self) -> u8 {
        let register = self.present.iter().flatten().fold(0, |register, condition| register | condition.register());
        match self.faults.has(Fault::ErrorRegisterGenericMissing) {
            true => register & !ErrorRegister::GENERIC.0,
            false => register,
        }
    }

    /// The entry of 1003h, of which sub-index 0 is the number of errors.
    ///
    /// # Errors
    /// "No data" for an entry that is still empty.
    pub fn history(&self, sub: u8) -> Result<u64, AbortCode> {
        match usize::from(sub).checked_sub(1) {
            None => Ok(self.history.len() as u64),
            Some(n) => self.history.get(n).map(|&entry| u64::from(entry)).ok_or(AbortCode::NO_DATA),
        }
    }

    /// 0 was written to 1003h:00.
    pub fn clear_history(&mut self) {
        if !self.faults.has(Fault::ErrorHistoryNotCleared) {
            self.history.clear();
        }
    }

    /// A condition is there or gone. Reports it only when that changes.
    pub fn set(&mut self, condition: Condition, present: bool) {
        let Some(slot) = self.present.get_mut(condition.number()) else { return };
        if slot.is_some() == present {
            return;
        }
        *slot = present.then_some(condition);
        let register = ErrorRegister(self.register());
        if present {
            self.remember(condition);
            let emcy = Emcy::new(condition.code(), register, condition.manufacturer());
            self.push(emcy);
            if self.faults.has(Fault::EmcyRepeated) {
                self.push(emcy);
            }
        } else if !self.faults.has(Fault::EmcyResetMissing) {
            self.push(Emcy::new(EmcyCode::NO_ERROR, register, [0; 5]));
        }
    }

    fn remember(&mut self, condition: Condition) {
        self.history.truncate(self.capacity.saturating_sub(1));
        let [low, high, ..] = condition.manufacturer();
        let information = u32::from(u16::from_le_bytes([low, high]));
        self.history.push_front(information << 16 | u32::from(condition.code().0));
    }

    fn push(&mut self, emcy: Emcy) {
        if self.queue.len() < LONGEST_QUEUE {
            self.queue.push_back(emcy);
        }
    }

    /// The next message to send, unless the inhibit time runs.
    pub fn poll(&mut self, now: Timestamp, inhibit: Duration) -> Option<Emcy> {
        if now < self.inhibited_until {
            return None;
        }
        let emcy = self.queue.pop_front()?;
        self.inhibited_until = now + inhibit;
        Some(emcy)
    }

    /// When [`Errors::poll`] has something again.
    pub fn timeout(&self) -> Timestamp {
        if self.queue.is_empty() { Timestamp::MAX } else { self.inhibited_until }
    }

    /// A reset: conditions are found anew, what was not sent is lost, the history stays until power-off.
    pub fn reset(&mut self) {
        self.present = [None; Condition::COUNT];
        self.queue.clear();
        self.inhibited_until = Timestamp::ZERO;
    }
}
