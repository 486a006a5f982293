//! Transmit PDOs: communication parameters (1800h..), mapping (1A00h..), and when they are sent.

use super::objects::Objects;
use super::parameters::Parameters;
use crate::models::Network;
use crate::{Fault, Faults};
use canvass_analyzer::wire::pdo::{MappingEntry, TransmissionType, insert};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_traces::{CanId, Duration, Frame, Timestamp};

/// How often the device looks whether a mapped value has changed.
const SAMPLING: Duration = Duration::from_millis(1);
/// A PDO has at most so many entries, of one bit each.
const MOST_ENTRIES: u64 = 64;

/// One TPDO.
#[derive(Clone, Debug)]
pub(super) struct Tpdo {
    /// 0 for 1800h and 1A00h.
    number: u16,
    cob_id: CobId,
    transmission: TransmissionType,
    inhibit: Duration,
    event_timer: Duration,
    mapping: Vec<MappingEntry>,
    running: bool,
    event_due: Timestamp,
    sample_due: Timestamp,
    inhibited_until: Timestamp,
    /// An event came while the inhibit time ran.
    waiting: bool,
    /// SYNCs since the last transmission.
    syncs: u8,
    last: Option<Frame>,
    /// What type 252 took at the last SYNC.
    sampled: Option<Frame>,
    /// What a faulty firmware sends the next time.
    late: Option<Frame>,
    /// Whether the frame is filled up to 8 bytes.
    padded: bool,
}

impl Tpdo {
    /// The TPDOs of the dictionary.
    pub fn all(parameters: &Parameters) -> Vec<Self> {
        let is_first = |entry: &&super::parameters::Parameter| entry.at.sub.0 == 0;
        let communication = parameters.entries().iter().filter(is_first);
        communication
            .filter_map(|entry| entry.at.index.0.checked_sub(0x1800))
            .filter(|&n| n < 0x200)
            .map(Self::new)
            .collect()
    }

    fn new(number: u16) -> Self {
        Self {
            number,
            cob_id: CobId(CobId::INVALID),
            transmission: TransmissionType(255),
            inhibit: Duration::ZERO,
            event_timer: Duration::ZERO,
            mapping: Vec::with_capacity(8),
            running: false,
            event_due: Timestamp::MAX,
            sample_due: Timestamp::MAX,
            inhibited_until: Timestamp::ZERO,
            waiting: false,
            syncs: 0,
            last: None,
            sampled: None,
            late: None,
            padded: false,
        }
    }

    /// Takes the parameters over, and begins anew with them.
    pub fn configure(&mut self, now: Timestamp, objects: &Objects) {
        let number = |sub| objects.parameters.number_or_zero(0x1800 + self.number, sub);
        self.cob_id = CobId(number(1) as u32);
        self.transmission = TransmissionType(number(2) as u8);
        self.inhibit = Duration::from_micros(100 * number(3));
        let factor = if objects.faults.has(Fault::EventTimerDoubled) { 2 } else { 1 };
        self.event_timer = Duration::from_millis(number(5)).times(factor);
        let padded = &objects.model.sheet().network.padded_tpdos;
        self.padded = padded.iter().any(|&number| u16::from(number) == self.number + 1);
        self.mapping.clear();
        self.mapping.extend(mapping(&objects.parameters, self.number));
        if self.running {
            self.arm(now, objects);
        }
    }

    /// Whether frames with that CAN-ID are this PDO.
    pub fn uses(&self, can_id: u16) -> bool {
        self.cob_id.is_valid() && self.cob_id.can_id() == u32::from(can_id)
    }

    /// The device became operational: event-driven PDOs are sent at once (CiA 406).
    pub fn start(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        self.running = true;
        self.syncs = 0;
        self.last = None;
        self.sampled = None;
        self.late = None;
        self.waiting = false;
        self.inhibited_until = Timestamp::ZERO;
        self.arm(now, objects);
        let sent_at_once = self.is_event_driven() && !objects.faults.has(Fault::TpdoNotSentOnStart);
        if sent_at_once { self.transmit(now, objects) } else { None }
    }

    /// The device is not operational any more.
    pub fn stop(&mut self) {
        self.running = false;
        self.waiting = false;
        self.event_due = Timestamp::MAX;
        self.sample_due = Timestamp::MAX;
    }

    fn arm(&mut self, now: Timestamp, objects: &Objects) {
        let active = self.is_active() && self.is_event_driven();
        let timed = active && self.event_timer > Duration::ZERO;
        self.event_due = if timed { now + self.event_timer } else { Timestamp::MAX };
        let sampled = active && self.is_sent_on_change() && objects.is_moving();
        self.sample_due = if sampled { now + SAMPLING } else { Timestamp::MAX };
    }

    fn is_active(&self) -> bool {
        self.running && self.cob_id.is_valid() && !self.mapping.is_empty()
    }

    fn is_event_driven(&self) -> bool {
        self.transmission >= TransmissionType::EVENT_MANUFACTURER
    }

    /// The encoder's own event is a change of value; of type 255 it is the timer alone.
    fn is_sent_on_change(&self) -> bool {
        self.transmission == TransmissionType::EVENT_MANUFACTURER
    }

    /// When [`Tpdo::poll`] wants to be called.
    pub fn timeout(&self) -> Timestamp {
        let waiting = if self.waiting { self.inhibited_until } else { Timestamp::MAX };
        self.event_due.min(self.sample_due).min(waiting)
    }

    /// A time has come.
    pub fn poll(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        let mut frame = None;
        if now >= self.event_due {
            let planned = self.event_due + self.event_timer;
            frame = self.transmit(now, objects);
            self.event_due = planned;
        }
        if now >= self.sample_due {
            self.sample_due = now + SAMPLING;
            frame = frame.or_else(|| self.on_change(now, objects));
        }
        if self.waiting && now >= self.inhibited_until {
            frame = frame.or_else(|| self.transmit(now, objects));
        }
        frame
    }

    /// A mapped value may have changed.
    pub fn on_change(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        let watched = self.is_active() && self.is_sent_on_change();
        if !watched || self.last == Some(self.frame(now, objects)) {
            return None;
        }
        self.transmit(now, objects)
    }

    /// A SYNC came.
    pub fn on_sync(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        if !self.is_active() {
            return None;
        }
        match self.transmission {
            TransmissionType::SYNCHRONOUS_ACYCLIC => {
                let changed = self.last != Some(self.frame(now, objects));
                if changed { self.transmit(now, objects) } else { None }
            }
            TransmissionType::RTR_SYNCHRONOUS => {
                self.sampled = Some(self.frame(now, objects));
                None
            }
            transmission => {
                let cycle = transmission.cycle()?;
                self.syncs = self.syncs.saturating_add(1);
                if self.syncs < cycle && !objects.faults.has(Fault::SyncCycleIgnored) {
                    return None;
                }
                self.syncs = 0;
                self.transmit(now, objects)
            }
        }
    }

    /// A remote frame asks for the PDO.
    pub fn on_remote(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        if !self.is_active() || !self.cob_id.allows_rtr() {
            return None;
        }
        match self.transmission {
            TransmissionType::RTR_SYNCHRONOUS => self.sampled,
            _ => Some(self.frame(now, objects)),
        }
    }

    /// Sends the PDO, or keeps it waiting for the end of the inhibit time.
    fn transmit(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        self.waiting = false;
        if !self.is_active() {
            return None;
        }
        if now < self.inhibited_until {
            self.waiting = true;
            return None;
        }
        if self.is_event_driven() && !objects.faults.has(Fault::InhibitTimeIgnored) {
            self.inhibited_until = now + self.inhibit;
        }
        if self.event_due < Timestamp::MAX {
            self.event_due = now + self.event_timer;
        }
        let frame = self.frame(now, objects);
        self.last = Some(frame);
        if objects.faults.has(Fault::TpdoPositionLate) {
            return self.late.replace(frame).or(Some(frame));
        }
        Some(frame)
    }

    /// The PDO with the values of now.
    fn frame(&self, now: Timestamp, objects: &Objects) -> Frame {
        let mut payload = [0; 8];
        let mut offset = 0;
        for (n, entry) in self.mapping.iter().enumerate() {
            let again = self.mapping.iter().take(n).any(|before| before.object() == entry.object());
            let value = objects.number(now, entry.object(), again).unwrap_or(0);
            // The mapping was checked: everything fits.
            insert(&mut payload, offset, entry.bits(), value);
            offset += usize::from(entry.bits());
        }
        let id = CanId::standard_masked(self.cob_id.can_id());
        let len = if self.padded { 8 } else { offset.div_ceil(8).min(8) };
        Frame::new(id, payload.get(..len).unwrap_or(&[])).unwrap_or(Frame::full(id, payload))
    }
}

/// The entries of a mapping as far as it is in use.
fn mapping(parameters: &Parameters, number: u16) -> impl Iterator<Item = MappingEntry> + use<'_> {
    let count = parameters.number_or_zero(0x1A00 + number, 0).min(MOST_ENTRIES) as u8;
    (1..=count).filter_map(move |sub| parameters.number(0x1A00 + number, sub)).map(|raw| MappingEntry(raw as u32))
}

/// The conditions of a write to 1800h and the following.
///
/// # Errors
/// The abort code for a value that is not possible now.
pub(super) fn check_communication(
    at: Multiplexer,
    value: u64,
    parameters: &Parameters,
    network: &Network,
    faults: Faults,
) -> Result<(), AbortCode> {
    let cob_id = CobId(parameters.number_or_zero(at.index.0, 1) as u32);
    let fits = match at.sub.0 {
        1 => check_cob_id(cob_id, CobId(value as u32), network.rtr, faults),
        2 => {
            let by_rtr = matches!(value, 252 | 253);
            let known =
                network.transmission_types.iter().any(|&(low, high)| (low.into()..=high.into()).contains(&value));
            (known || faults.has(Fault::ReservedTransmissionTypeAccepted)) && (cob_id.allows_rtr() || !by_rtr)
        }
        3 => !cob_id.is_valid() || value == parameters.number_or_zero(at.index.0, 3),
        _ => true,
    };
    let has_mapping = mapping(parameters, at.index.0 - 0x1800).next().is_some();
    let switches_on = at.sub.0 == 1 && CobId(value as u32).is_valid();
    if fits && (has_mapping || !switches_on) { Ok(()) } else { Err(AbortCode::INVALID_VALUE) }
}

/// Whether the COB-ID of a TPDO can change so: the CAN-ID only while the PDO is not valid (CiA 301, 7.5.2.37).
fn check_cob_id(old: CobId, new: CobId, rtr: bool, faults: Faults) -> bool {
    let reserved = new.0 & 0x1FFF_F800 != 0;
    let moved = old.is_valid() && new.can_id() != old.can_id() && !faults.has(Fault::CobIdChangeWhileValid);
    let restricted = new.is_restricted() && !faults.has(Fault::RestrictedCanIdAccepted);
    let impossible = new.is_valid() && (moved || restricted || (new.allows_rtr() && !rtr));
    !reserved && !new.is_extended() && !impossible
}

/// The conditions of a write to 1A00h and the following: only while the PDO is not valid, entries only while
/// sub-index 0 is 0.
///
/// # Errors
/// The abort code for a mapping that is not possible, or not now.
pub(super) fn check_mapping(
    at: Multiplexer,
    value: u64,
    parameters: &Parameters,
    faults: Faults,
) -> Result<(), AbortCode> {
    let number = at.index.0 - 0x1A00;
    let valid = CobId(parameters.number_or_zero(0x1800 + number, 1) as u32).is_valid();
    let in_use = at.sub.0 != 0 && parameters.number_or_zero(at.index.0, 0) != 0;
    if (valid || in_use) && !faults.has(Fault::MappingChangeWhileValid) {
        return Err(AbortCode::UNSUPPORTED_ACCESS);
    }
    if at.sub.0 != 0 {
        return if value == 0 { Ok(()) } else { check_entry(MappingEntry(value as u32), parameters, faults) };
    }
    let most = u8::try_from(value).map_err(|_| AbortCode::PDO_LENGTH)?;
    parameters.number(at.index.0, most).ok_or(AbortCode::PDO_LENGTH)?;
    let mut bits = 0;
    for sub in 1..=most {
        let entry = MappingEntry(parameters.number_or_zero(at.index.0, sub) as u32);
        check_entry(entry, parameters, faults)?;
        bits += u32::from(entry.bits());
    }
    if bits <= 64 || faults.has(Fault::MappingTooLongAccepted) { Ok(()) } else { Err(AbortCode::PDO_LENGTH) }
}

/// Whether an object can be mapped, with that length.
fn check_entry(entry: MappingEntry, parameters: &Parameters, faults: Faults) -> Result<(), AbortCode> {
    if entry.is_dummy() {
        return Err(AbortCode::NOT_MAPPABLE);
    }
    let object = parameters.entry(entry.object()).map_err(|_| AbortCode::NO_OBJECT)?;
    // What is mapped as delivered can be mapped again, a part of an object too.
    let mappings = parameters.entries().iter().filter(|it| matches!(it.at.index.0, 0x1A00..0x1C00) && it.at.sub.0 > 0);
    if mappings.into_iter().any(|it| it.is_delivered_as(entry.0.into())) {
        return Ok(());
    }
    let mappable = object.tpdo_mappable || faults.has(Fault::UnmappableObjectMapped);
    let bits = object.data_type.bits().unwrap_or(0);
    if mappable && bits == u32::from(entry.bits()) { Ok(()) } else { Err(AbortCode::NOT_MAPPABLE) }
}
