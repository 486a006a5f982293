//! Receive PDOs: when their values act, their length, and their deadline (CiA 301, 7.2.2.4).

use super::objects::Objects;
use super::parameters::Parameters;
use super::pdo::{self, Direction};
use crate::Firmware;
use canvass_analyzer::wire::pdo::{MappingEntry, TransmissionType, extract};
use canvass_analyzer::{CobId, Multiplexer};
use canvass_traces::{Duration, Timestamp};

/// One RPDO.
#[derive(Clone, Debug)]
pub(super) struct Rpdo {
    /// 0 for 1400h and 1600h.
    number: u16,
    cob_id: CobId,
    transmission: TransmissionType,
    mapping: Vec<MappingEntry>,
    /// What the mapping takes, in bytes.
    len: usize,
    /// Zero: the PDO is not awaited.
    deadline: Duration,
    /// [`Timestamp::MAX`] until the first PDO.
    due: Timestamp,
    /// Received, and not yet acting: it waits for SYNC.
    held: Option<Payload>,
    firmware: Firmware,
}

/// The data of a PDO, filled up with zeros.
pub(super) type Payload = [u8; 8];

/// What a received PDO means.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Received {
    /// The values act now.
    Act(Payload),
    /// The values act at the next SYNC.
    Hold,
    /// Shorter than its mapping: not processed.
    TooShort,
}

impl Rpdo {
    /// The RPDOs of the dictionary.
    pub fn all(parameters: &Parameters, firmware: &Firmware) -> Vec<Self> {
        let new = |number| Self {
            number,
            cob_id: CobId(CobId::INVALID),
            transmission: TransmissionType(255),
            mapping: Vec::with_capacity(8),
            len: 0,
            deadline: Duration::ZERO,
            due: Timestamp::MAX,
            held: None,
            firmware: *firmware,
        };
        pdo::numbers(Direction::Receive, parameters).map(new).collect()
    }

    /// 1 for 1400h and 1600h.
    pub const fn ordinal(&self) -> u16 {
        self.number + 1
    }

    /// Takes the parameters over.
    pub fn configure(&mut self, objects: &Objects) {
        let number = |sub| objects.parameters.number_or_zero(0x1400 + self.number, sub);
        self.cob_id = CobId(number(1) as u32);
        self.transmission = TransmissionType(number(2) as u8);
        self.deadline = Duration::from_millis(number(5));
        self.mapping.clear();
        self.mapping.extend(pdo::mapping(Direction::Receive, &objects.parameters, self.number));
        self.len = self.mapping.iter().map(|entry| usize::from(entry.bits())).sum::<usize>().div_ceil(8).min(8);
        if self.deadline == Duration::ZERO || !self.cob_id.is_valid() {
            self.due = Timestamp::MAX;
        }
    }

    /// Its CAN-ID, if it is received.
    pub fn can_id(&self) -> Option<u16> {
        let received = self.cob_id.is_valid() || self.firmware.receives_invalid_rpdo();
        (received && !self.mapping.is_empty()).then_some(self.cob_id.can_id() as u16)
    }

    /// The device is not operational any more: what was held is forgotten.
    pub fn stop(&mut self) {
        self.held = None;
        self.due = Timestamp::MAX;
    }

    /// How many bytes are mapped.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// A PDO came.
    pub fn on_frame(&mut self, now: Timestamp, data: &[u8]) -> Received {
        if data.len() < self.len && self.firmware.checks_rpdo_length() {
            return Received::TooShort;
        }
        if self.deadline > Duration::ZERO && self.firmware.heeds_rpdo_deadline() {
            self.due = now + self.deadline;
        }
        let mut payload = [0; 8];
        payload.iter_mut().zip(data).for_each(|(to, from)| *to = *from);
        if self.is_synchronous() && self.firmware.holds_synchronous_rpdo() {
            self.held = Some(payload);
            return Received::Hold;
        }
        Received::Act(payload)
    }

    /// Whether its values wait for SYNC.
    pub fn is_synchronous(&self) -> bool {
        self.transmission.0 <= 240
    }

    /// A SYNC came: what was held acts now.
    pub fn on_sync(&mut self) -> Option<Payload> {
        self.held.take()
    }

    /// The window of synchronous PDOs is over.
    pub fn forget(&mut self) {
        self.held = None;
    }

    /// When the PDO is missed.
    pub const fn timeout(&self) -> Timestamp {
        self.due
    }

    /// Whether the PDO is missed now; says so once, until the next one.
    pub fn is_late(&mut self, now: Timestamp) -> bool {
        let late = now >= self.due;
        if late {
            self.due = Timestamp::MAX;
        }
        late
    }

    /// The values of the mapped objects; dummies are left out.
    pub fn values(&self, payload: Payload) -> Vec<(Multiplexer, u64)> {
        let mut offset = 0;
        let mut values = Vec::with_capacity(self.mapping.len());
        for entry in &self.mapping {
            if let Some(value) = extract(&payload, offset, entry.bits())
                && !entry.is_dummy()
            {
                values.push((entry.object(), value));
            }
            offset += usize::from(entry.bits());
        }
        values
    }
}
