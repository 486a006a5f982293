//! Errors: the error register (1001h), the history (1003h) and the EMCY messages (1014h, 1015h).

use super::context::Context;
use super::nmt;
use super::parameters::Parameters;
use super::routes::{Route, Routes};
use super::service::{Event, Service};
use crate::Firmware;
use crate::models::Quirks;
use canvass_analyzer::CobId;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Frame, Timestamp};
use std::collections::VecDeque;

/// Something that can be wrong with the device. Each is present or not; only changes are reported.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Condition {
    /// The temperature is outside the limits of 2120h.
    Temperature { now: u8, low: u8, high: u8 },
    /// The shaft is too fast (6505h bit 0).
    Overspeed,
    /// The master's guarding is missing.
    Guarding,
    /// The position is wrong (6503h bit 0).
    Position,
    /// The heartbeat of that node is missing.
    Heartbeat { node: u8 },
    /// RPDO of that number, from 1: shorter than its mapping.
    RpdoTooShort { rpdo: u16 },
    /// RPDO of that number, from 1: longer than its mapping.
    RpdoTooLong { rpdo: u16 },
    /// RPDO of that number, from 1: not within its deadline.
    RpdoLate { rpdo: u16 },
    /// SYNC does not have the length that 1019h asks for.
    SyncLength,
    /// A parameter that was to be stored is out of its limits (6503h bit 13).
    Parameter,
    /// Something of the hardware, by its EMCY code, as the model's sheet describes it.
    Hardware { code: EmcyCode, register: u8, bytes: [u8; 5] },
}

impl Condition {
    /// Conditions with equal keys are the same one, with other details.
    const fn key(self) -> (u8, u16) {
        match self {
            Self::Temperature { .. } => (0, 0),
            Self::Overspeed => (1, 0),
            Self::Guarding => (2, 0),
            Self::Heartbeat { node } => (3, node as u16),
            Self::RpdoTooShort { rpdo } => (4, rpdo),
            Self::RpdoTooLong { rpdo } => (5, rpdo),
            Self::RpdoLate { rpdo } => (6, rpdo),
            Self::SyncLength => (7, 0),
            Self::Parameter => (8, 0),
            Self::Position => (9, 0),
            Self::Hardware { code, .. } => (10, code.0),
        }
    }

    fn code(self, quirks: &Quirks) -> EmcyCode {
        match self {
            Self::Temperature { .. } | Self::Overspeed => EmcyCode(0x4200),
            Self::Guarding => quirks.life_guarding_code(),
            Self::Heartbeat { .. } => EmcyCode::HEARTBEAT,
            Self::Parameter | Self::Position => EmcyCode::GENERIC,
            Self::RpdoTooShort { .. } => EmcyCode::PDO_LENGTH,
            Self::RpdoTooLong { .. } => EmcyCode::PDO_LENGTH_EXCEEDED,
            Self::RpdoLate { .. } => EmcyCode::RPDO_TIMEOUT,
            Self::SyncLength => EmcyCode::SYNC_LENGTH,
            Self::Hardware { code, .. } => code,
        }
    }

    /// The bit of 6503h.
    const fn alarm(self) -> u64 {
        match self {
            Self::Parameter => 1 << 13,
            _ => 0,
        }
    }

    /// The bits of the error register. Bit 0 is always among them, as far as the device has it.
    fn register(self, quirks: &Quirks) -> u8 {
        if let Self::Hardware { register: documented @ 1.., .. } = self {
            return documented;
        }
        let is_alarm = matches!(self, Self::Parameter | Self::Position);
        let profile = if is_alarm { ErrorRegister::PROFILE.0 } else { 0 };
        // Whatever its code is, a lost master is an error of communication.
        let communication = if matches!(self, Self::Guarding) { ErrorRegister::COMMUNICATION.0 } else { 0 };
        let bits = ErrorRegister::GENERIC.0 | self.code(quirks).register_bits() | communication | profile;
        match quirks.error_register_bits {
            None => bits,
            Some(own) if bits & own == 0 => own,
            Some(own) => bits & own,
        }
    }

    /// The sub-index of 1029h that says what the device does about it.
    pub const fn behaviour(self) -> Option<u8> {
        match self {
            Self::Guarding | Self::Heartbeat { .. } => Some(1),
            Self::Temperature { .. } | Self::Overspeed => Some(2),
            // Temperature and sensors are of the profile, communication is communication, the rest the manufacturer's.
            Self::Hardware { code, .. } => Some(match code.0 {
                0x4000..0x5000 | 0x5050..0x5060 | 0xFF00 => 2,
                0x8000..0x9000 => 1,
                _ => 3,
            }),
            _ => None,
        }
    }

    /// Bytes 3 to 7.
    const fn manufacturer(self) -> [u8; 5] {
        match self {
            Self::Hardware { bytes, .. } => bytes,
            // Sensor error register, temperature, low and high threshold, sensor version.
            Self::Temperature { now, low, high } => [0x80, now, low, high, 0x2E],
            Self::RpdoTooShort { rpdo } | Self::RpdoTooLong { rpdo } | Self::RpdoLate { rpdo } => {
                let [low, high] = rpdo.to_le_bytes();
                [low, high, 0, 0, 0]
            }
            Self::Overspeed
            | Self::Guarding
            | Self::Heartbeat { .. }
            | Self::SyncLength
            | Self::Parameter
            | Self::Position => [0; 5],
        }
    }
}

/// The state of errors.
#[derive(Clone, Debug)]
pub(super) struct Errors {
    present: Vec<Condition>,
    /// 1003h, newest first.
    history: VecDeque<u32>,
    /// How many the history holds.
    capacity: usize,
    /// Not sent yet.
    queue: VecDeque<Emcy>,
    /// 1015h: no EMCY before then.
    inhibited_until: Timestamp,
    /// Bits that a firmware forgets to clear.
    stuck: u8,
    quirks: Quirks,
    firmware: Firmware,
}

/// More EMCY messages than that don't wait; the oldest stay.
const LONGEST_QUEUE: usize = 16;

/// As many errors are counted where 1003h shows fewer.
const MOST_COUNTED: usize = 16;

impl Errors {
    /// No error; the history holds `capacity` entries.
    pub fn new(capacity: usize, quirks: &Quirks, firmware: &Firmware) -> Self {
        // Errors that can only be cleared one by one are counted beyond those that are shown.
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

    /// 1001h.
    pub fn register(&self) -> u8 {
        let register =
            self.present.iter().fold(self.stuck, |register, condition| register | condition.register(&self.quirks));
        match !self.firmware.sets_generic_bit() {
            true => register & !ErrorRegister::GENERIC.0,
            false => register,
        }
    }

    /// The entry of 1003h, of which sub-index 0 is the number of errors.
    ///
    /// # Errors
    /// "No data" for an entry that is still empty.
    pub fn history(&self, sub: u8) -> Result<u64, AbortCode> {
        let Some(n) = usize::from(sub).checked_sub(1) else { return Ok(self.history.len() as u64) };
        let position = match self.firmware.reverses_history() {
            true => self.history.len().checked_sub(n + 1),
            false => Some(n),
        };
        match position.and_then(|position| self.history.get(position)) {
            Some(&entry) => Ok(u64::from(entry)),
            None if self.quirks.empty_error_history_reads_zero => Ok(0),
            None if self.firmware.reads_empty_history_as_zero() => Ok(0),
            None => Err(self.firmware.empty_history_code()),
        }
    }

    /// 0 was written to 1003h:00.
    pub fn clear_history(&mut self) {
        if !self.firmware.clears_history() {
            return;
        }
        let was_empty = self.history.is_empty();
        self.history.clear();
        if self.quirks.error_register_read_clears && !was_empty {
            self.acknowledge();
        }
    }

    /// 1001h was read by SDO.
    pub fn register_was_read(&mut self) {
        if self.quirks.error_register_read_clears && self.history.pop_front().is_some() && self.history.is_empty() {
            self.acknowledge();
        }
    }

    /// The last error of the history is gone: so is what the register shows.
    fn acknowledge(&mut self) {
        self.present.clear();
        self.push(Emcy::new(EmcyCode::NO_ERROR, ErrorRegister(0), [0; 5]));
    }

    /// 6503h.
    pub fn alarms(&self) -> u64 {
        self.present.iter().fold(0, |alarms, condition| alarms | condition.alarm())
    }

    /// A condition is there or gone. Reports it only when that changes, and says whether it does.
    pub fn set(&mut self, condition: Condition, present: bool) -> bool {
        let position = self.present.iter().position(|other| other.key() == condition.key());
        match (position, present) {
            (None, true) => self.present.push(condition),
            (Some(position), false) => {
                self.present.remove(position);
            }
            _ => return false,
        }
        if !present && self.firmware.keeps_register_bits() {
            self.stuck |= condition.register(&self.quirks);
        }
        let register = ErrorRegister(if !self.firmware.shows_register_in_emcy() { 0 } else { self.register() });
        if present {
            self.remember(condition);
            let emcy = Emcy::new(self.code(condition), register, condition.manufacturer());
            self.push(emcy);
            if self.firmware.repeats_emcy() {
                self.push(emcy);
            }
        } else if self.firmware.sends_error_reset() {
            self.push(Emcy::new(EmcyCode::NO_ERROR, register, [0; 5]));
        }
        true
    }

    /// The code that is signalled.
    fn code(&self, condition: Condition) -> EmcyCode {
        if self.firmware.has_generic_codes_only() { EmcyCode::GENERIC } else { condition.code(&self.quirks) }
    }

    fn remember(&mut self, condition: Condition) {
        let kept = if self.firmware.overflows_history() { 254 } else { self.capacity };
        self.history.truncate(kept.saturating_sub(1));
        let [low, high, ..] = condition.manufacturer();
        let information = u32::from(u16::from_le_bytes([low, high]));
        self.history.push_front(information << 16 | u32::from(self.code(condition).0));
    }

    fn push(&mut self, emcy: Emcy) {
        if self.queue.len() < LONGEST_QUEUE && self.firmware.signals_errors() {
            self.queue.push_back(emcy);
        }
    }

    /// The next message to send, unless the inhibit time runs.
    pub fn poll(&mut self, now: Timestamp, inhibit: Duration) -> Option<Emcy> {
        if now < self.inhibited_until {
            if !self.firmware.keeps_emcy_when_inhibited() {
                self.queue.clear();
            }
            return None;
        }
        let emcy = self.queue.pop_front()?;
        if self.firmware.heeds_emcy_inhibit_time() {
            self.inhibited_until = now + inhibit;
        }
        Some(emcy)
    }

    /// When [`Errors::poll`] has something again.
    pub fn timeout(&self) -> Timestamp {
        match self.queue.is_empty() {
            true => Timestamp::MAX,
            // What is lost is lost at once.
            false if !self.firmware.keeps_emcy_when_inhibited() => Timestamp::ZERO,
            false => self.inhibited_until,
        }
    }

    /// The device is in stopped.
    pub fn on_stopped(&mut self) {
        if !self.firmware.keeps_emcy_when_stopped() {
            self.queue.clear();
            self.clear_history();
        }
    }

    /// The device has left stopped: what came meanwhile may be signalled now.
    fn after_stopped(&mut self) {
        if self.firmware.drops_emcy_of_stopped() {
            self.queue.clear();
        }
        if self.firmware.signals_newest_after_stopped() {
            self.queue.drain(..self.queue.len().saturating_sub(1));
        }
    }

    /// A reset: conditions are found anew, what was not sent is lost, the history stays until power-off, unless a reset
    /// clears it too.
    pub fn reset(&mut self) {
        self.present.clear();
        self.queue.clear();
        self.inhibited_until = Timestamp::ZERO;
        if self.quirks.error_register_read_clears {
            self.clear_history();
        }
    }

    /// Off and on again: nothing is remembered, and nothing said.
    pub fn power_on(&mut self) {
        self.history.clear();
        self.reset();
    }
}

/// Sends what is to be said of errors, and hears what others say of theirs.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmcyService;

impl EmcyService {
    /// The next EMCY, if there is one and it may be sent.
    fn next(now: Timestamp, context: &mut Context) -> Option<Frame> {
        if now < Self.timeout(context) {
            return None;
        }
        let inhibit = Duration::from_micros(100 * context.objects.parameters.number_or_zero(0x1015, 0));
        // One that 1014h silences is gone, the next one may follow at once.
        loop {
            let emcy = context.objects.errors.poll(now, inhibit)?;
            let cob_id = Self::cob_id(context)?;
            if cob_id.is_valid() || context.firmware().sends_emcy_when_invalid() {
                return Some(emcy.to_frame(cob_id.can_id() as u16));
            }
        }
    }

    fn due(context: &Context) -> Timestamp {
        if context.serves(nmt::Service::Emcy) { context.objects.errors.timeout() } else { Timestamp::MAX }
    }

    fn cob_id(context: &Context) -> Option<CobId> {
        let usual = CobId(u32::from(emcy::CAN_ID_BASE) + u32::from(context.node?.raw()));
        Some(context.objects.parameters.number(0x1014, 0).map_or(usual, |raw| CobId(raw as u32)))
    }
}

impl Service for EmcyService {
    /// The EMCY of a node of 1028h.
    fn handle(&mut self, _: Timestamp, _: Route, frame: &Frame, context: &mut Context) {
        if frame.len() == 8 && context.phase.is_running() {
            context.objects.received_emcy = u64::from_le_bytes(frame.bytes());
        }
    }

    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Initialise => context.objects.errors.reset(),
            Event::Entered { before: nmt::Phase::Stopped } => context.objects.errors.after_stopped(),
            Event::Written(at, value) if at.index.0 == 0x1015 && context.firmware().inhibits_from_write() => {
                context.objects.errors.inhibited_until = now + Duration::from_micros(100 * value);
            }
            Event::Written(at, _) if at.index.0 == 0x1003 => context.objects.errors.clear_history(),
            Event::Written(at, _) if matches!(at.index.0, 0x1014 | 0x1028) => context.routes_changed = true,
            _ => {}
        }
    }

    fn timeout(&self, context: &Context) -> Timestamp {
        Self::due(context)
    }

    fn transmit(&mut self, now: Timestamp, context: &mut Context) {
        while let Some(frame) = Self::next(now, context) {
            context.send(frame);
        }
    }

    fn find_routes(&self, context: &Context, routes: &mut Routes) {
        let parameters = &context.objects.parameters;
        for cob_id in (1..=127).map_while(|sub| parameters.number(0x1028, sub)).map(|raw| CobId(raw as u32)) {
            if cob_id.is_valid() && cob_id.can_id() != 0 {
                routes.set(cob_id.can_id() as u16, Route::PeerEmcy);
            }
        }
    }
}

/// The conditions of a write to 1014h: 11 bits, not restricted, and another CAN-ID only while bit 31 is set.
///
/// # Errors
/// "Invalid value" otherwise.
pub(super) fn check_cob_id(value: u64, parameters: &Parameters, firmware: &Firmware) -> Result<(), AbortCode> {
    let (old, new) = (CobId(parameters.number_or_zero(0x1014, 0) as u32), CobId(value as u32));
    if firmware.refuses_cob_id_rewrite() && old.is_valid() && new.is_valid() {
        return Err(firmware.cob_id_code(AbortCode::INVALID_VALUE));
    }
    check_peer_cob_id(value, old, firmware, firmware.checks_emcy_ids_while_valid())
}

/// The same for the COB-IDs of 1028h and of the further SDO channels.
///
/// # Errors
/// "Invalid value" otherwise.
pub(super) fn check_peer_cob_id(
    value: u64,
    old: CobId,
    firmware: &Firmware,
    stays_while_valid: bool,
) -> Result<(), AbortCode> {
    let new = CobId(value as u32);
    let reserved = new.0 & (0x1FFF_F800 | CobId::NO_RTR) != 0 || new.is_extended();
    let restricted = new.is_valid() && new.is_restricted() && firmware.checks_restricted_can_ids();
    if reserved || restricted {
        return Err(AbortCode::INVALID_VALUE);
    }
    let moved = old.is_valid() && new.is_valid() && new.can_id() != old.can_id() && stays_while_valid;
    if moved { Err(firmware.cob_id_code(AbortCode::INVALID_VALUE)) } else { Ok(()) }
}
