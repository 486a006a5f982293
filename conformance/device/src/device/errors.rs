//! The errors of a device, as the error register (1001h), the history (1003h) and the EMCY messages show them.

use super::condition::Condition;
use crate::models::Quirks;
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::wire::emcy::{Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Timestamp};
use std::collections::VecDeque;

/// The errors of a device.
#[derive(Clone, Debug)]
pub(super) struct Errors {
    present: Vec<Condition>,
    /// The entries of 1003h, newest first.
    history: VecDeque<u32>,
    /// Maximum number of entries of the history.
    capacity: usize,
    /// EMCY messages that wait to be sent.
    queue: VecDeque<Emcy>,
    /// The time before which 1015h forbids the next EMCY.
    inhibited_until: Timestamp,
    /// Bits of the error register that a faulty firmware forgets to clear.
    stuck: u8,
    quirks: Quirks,
    firmware: Firmware,
}

/// Maximum number of waiting EMCY messages; further messages are lost.
const LONGEST_QUEUE: usize = 16;

/// Number of errors that the device counts if 1003h shows fewer.
const MOST_COUNTED: usize = 16;

impl Errors {
    /// The state without errors; `capacity` is the number of entries of 1003h.
    pub fn new(capacity: usize, quirks: &Quirks, firmware: &Firmware) -> Self {
        // If errors can only be cleared one by one, the device counts more of them than 1003h shows.
        let capacity = if quirks.error_register_read_clears { MOST_COUNTED } else { capacity };
        Self {
            quirks: quirks.clone(),
            stuck: 0,
            firmware: *firmware,
            present: Vec::new(),
            history: VecDeque::with_capacity(capacity),
            capacity,
            queue: VecDeque::with_capacity(LONGEST_QUEUE),
            inhibited_until: Timestamp::ZERO,
        }
    }

    /// The value of 1001h.
    pub fn register(&self) -> u8 {
        let register =
            self.present.iter().fold(self.stuck, |register, condition| register | condition.register(&self.quirks));
        let register = register | u8::from(self.firmware.has(Fault::ErrorRegisterNeverClear));
        match self.firmware.has(Fault::ErrorRegisterGenericMissing) {
            true => register & !ErrorRegister::GENERIC.0,
            false => register,
        }
    }

    /// The value of an entry of 1003h; sub-index 0 is the number of errors.
    ///
    /// # Errors
    /// "No data" for an entry that is still empty.
    pub fn history(&self, sub: u8) -> Result<u64, AbortCode> {
        let Some(n) = usize::from(sub).checked_sub(1) else { return Ok(self.history.len() as u64) };
        let position = match self.firmware.has(Fault::ErrorHistoryReversed) {
            true => self.history.len().checked_sub(n + 1),
            false if self.firmware.has(Fault::ErrorHistoryMovesTwo) => Some(n.min(1)),
            false => Some(n),
        };
        match position.and_then(|position| self.history.get(position)) {
            Some(&entry) => Ok(u64::from(entry)),
            None if self.quirks.empty_error_history_reads_zero => Ok(0),
            None if self.firmware.has(Fault::ErrorHistoryEmptyReadsZero) => Ok(0),
            None if self.firmware.takes(Liberty::HistoryCodeGeneral) => Err(AbortCode::GENERAL),
            None => Err(AbortCode::NO_DATA),
        }
    }

    /// Handles a write of 0 to 1003h:00.
    pub(crate) fn clear_history(&mut self) {
        if self.firmware.has(Fault::ErrorHistoryNotCleared) {
            return;
        }
        let was_empty = self.history.is_empty();
        self.history.clear();
        let acknowledges = self.quirks.error_register_read_clears || self.firmware.has(Fault::HistoryClearsRegister);
        if acknowledges && !was_empty {
            self.acknowledge();
        }
    }

    /// Handles the reading of 1001h by SDO.
    pub(crate) fn register_was_read(&mut self) {
        if self.firmware.has(Fault::ErrorRegisterReadClears) {
            self.present.clear();
        }
        if self.firmware.has(Fault::EmcyResetUnasked) {
            self.push(Emcy::new(EmcyCode::NO_ERROR, ErrorRegister(self.register()), [0; 5]));
        }
        if self.quirks.error_register_read_clears && self.history.pop_front().is_some() && self.history.is_empty() {
            self.acknowledge();
        }
    }

    /// Clears the error register, and reports that no error is left.
    fn acknowledge(&mut self) {
        self.present.clear();
        self.push(Emcy::new(EmcyCode::NO_ERROR, ErrorRegister(0), [0; 5]));
    }

    /// Whether a condition is present.
    pub(crate) fn is_present(&self, condition: Condition) -> bool {
        self.present.iter().any(|present| present.key() == condition.key())
    }

    /// Sets or clears a condition. Only a change is reported; returns whether there was one.
    pub fn set(&mut self, condition: Condition, present: bool) -> bool {
        let position = self.present.iter().position(|other| other.key() == condition.key());
        match (position, present) {
            (None, true) => self.present.push(condition),
            (Some(position), false) => {
                self.present.remove(position);
                if self.firmware.has(Fault::ErrorsClearedTogether) {
                    self.present.clear();
                }
            }
            _ => return false,
        }
        if !present && self.firmware.has(Fault::ErrorRegisterStuck) {
            self.stuck |= condition.register(&self.quirks);
        }
        let register = ErrorRegister(if self.firmware.has(Fault::EmcyRegisterZero) { 0 } else { self.register() });
        if present {
            self.remember(condition);
            let emcy = Emcy::new(self.code(condition), register, condition.manufacturer());
            self.push(emcy);
            if self.firmware.has(Fault::EmcyRepeated) {
                self.push(emcy);
            }
        } else if self.firmware.has(Fault::EmcyResetRegisterWrong) {
            let old = ErrorRegister(register.0 | condition.register(&self.quirks));
            self.push(Emcy::new(EmcyCode::NO_ERROR, old, [0; 5]));
        } else if !self.firmware.has(Fault::EmcyResetMissing) {
            self.push(Emcy::new(EmcyCode::NO_ERROR, register, [0; 5]));
        }
        true
    }

    /// The EMCY code of a condition.
    fn code(&self, condition: Condition) -> EmcyCode {
        match condition {
            _ if self.firmware.takes(Liberty::GenericErrorCodes) => EmcyCode::GENERIC,
            Condition::RpdoTooLong { .. } if self.firmware.has(Fault::LongRpdoCalledLate) => EmcyCode::RPDO_TIMEOUT,
            _ => condition.code(&self.quirks),
        }
    }

    fn remember(&mut self, condition: Condition) {
        let kept = if self.firmware.has(Fault::ErrorHistoryOverflows) { 254 } else { self.capacity };
        self.history.truncate(kept.saturating_sub(1));
        let [low, high, ..] = condition.manufacturer();
        let information = u32::from(u16::from_le_bytes([low, high]));
        self.history.push_front(information << 16 | u32::from(self.code(condition).0));
    }

    fn push(&mut self, emcy: Emcy) {
        if self.queue.len() < LONGEST_QUEUE && !self.firmware.takes(Liberty::NoEmcy) {
            self.queue.push_back(emcy);
        }
    }

    /// The next message to send, unless the inhibit time is running.
    pub fn poll(&mut self, now: Timestamp, inhibit: Duration) -> Option<Emcy> {
        if now < self.inhibited_until {
            if self.firmware.has(Fault::EmcyLostWhenInhibited) {
                self.queue.clear();
            }
            return None;
        }
        let emcy = self.queue.pop_front()?;
        if !self.firmware.has(Fault::EmcyInhibitTimeIgnored) {
            self.inhibited_until = now + inhibit;
        }
        Some(emcy)
    }

    /// Time at which [`Errors::poll`] returns the next message.
    pub fn timeout(&self) -> Timestamp {
        match self.queue.is_empty() {
            true => Timestamp::MAX,
            // A firmware that loses inhibited messages must do so at once.
            false if self.firmware.has(Fault::EmcyLostWhenInhibited) => Timestamp::ZERO,
            false => self.inhibited_until,
        }
    }

    /// Begins an inhibit time, for a device that begins it with a write to 1015h.
    pub(crate) fn inhibit_until(&mut self, end: Timestamp) {
        self.inhibited_until = end;
    }

    /// Handles entering the state stopped.
    pub(crate) fn on_stopped(&mut self) {
        if self.firmware.has(Fault::EmcyLostWhenStopped) {
            self.queue.clear();
            self.clear_history();
        }
    }

    /// Handles leaving the state stopped: messages that were queued meanwhile may be sent now.
    pub(crate) fn after_stopped(&mut self) {
        if self.firmware.takes(Liberty::StoppedEmcyDropped) {
            self.queue.clear();
        }
        if self.firmware.takes(Liberty::StoppedEmcyNewest) {
            self.queue.drain(..self.queue.len().saturating_sub(1));
        }
    }

    /// Handles a reset: conditions are detected anew, and waiting messages are lost. The history stays until power-off,
    /// unless the device clears it at a reset too.
    pub fn reset(&mut self) {
        self.present.clear();
        if !self.firmware.has(Fault::EmcySurvivesReset) {
            self.queue.clear();
        }
        self.inhibited_until = Timestamp::ZERO;
        if self.quirks.error_register_read_clears || self.quirks.life_guarding_until_reset {
            self.clear_history();
        }
    }

    /// Handles power-off and on: all errors and messages are gone.
    pub fn power_on(&mut self) {
        self.history.clear();
        self.reset();
    }
}
