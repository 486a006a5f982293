//! The expected values of the device's objects, as far as the device's own answers determine them.

use crate::Knowledge;
use canvass_analyzer::object;
use canvass_analyzer::{CobId, Multiplexer, NodeId};

/// The expected values of all objects after the writes so far, as far as they are certain.
#[derive(Clone, Debug)]
pub(super) struct ExpectedValues {
    values: Vec<Held>,
    /// Number of confirmed writes. A value that was read before the last write may have changed with it.
    writes: u32,
    /// Whether the value that is being read may change during the read.
    suspended: bool,
    /// A number that increases with each change of the expected behaviour of PDOs.
    version: u64,
    /// The object that was written last and its value, until [`ExpectedValues::take_change`].
    change: Option<(Multiplexer, u64)>,
    /// The object of the last aborted download.
    pub aborted: Option<usize>,
    sync: Option<u64>,
    emcy: Option<u64>,
    has_emcy_object: bool,
    time: Option<u64>,
    bus_changed: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Held {
    raw: Option<u64>,
    /// The value of [`ExpectedValues::writes`] when this value was learned.
    since: u32,
    /// Whether the value was restored by a reset.
    by_reset: bool,
}

/// The part of the dictionary that a reset restores.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Extent {
    /// The communication area, 1000h to 1FFFh.
    Communication,
    /// The whole dictionary.
    Node,
}

/// A message that the configuration of the device switches off.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Off {
    Sync,
    Time,
    Emcy,
}

impl Off {
    /// The rule that the message violates.
    pub const fn rule(self) -> &'static str {
        match self {
            Self::Sync => "SYNC although off",
            Self::Time => "TIME although off",
            Self::Emcy => "EMCY although off",
        }
    }

    /// The value of the COB-ID object that forbids the message.
    pub const fn reason(self) -> &'static str {
        match self {
            Self::Sync => "bit 30 of 1005h is 0, so that the device does not produce SYNC",
            Self::Time => "bit 30 of 1012h is 0, so that the device does not produce TIME",
            Self::Emcy => "bit 31 of 1014h is 1, so that EMCY does not exist",
        }
    }
}

impl ExpectedValues {
    pub fn new(knowledge: &Knowledge) -> Self {
        let mut expected_values = Self {
            values: vec![Held::default(); knowledge.entries().len()],
            writes: 0,
            suspended: false,
            version: 0,
            change: None,
            aborted: None,
            sync: None,
            emcy: None,
            has_emcy_object: knowledge.entry(Multiplexer::new(object::COB_ID_EMCY, 0)).is_some(),
            time: None,
            bus_changed: false,
        };
        expected_values.power_on(knowledge);
        expected_values
    }

    /// Sets all values to the power-on values.
    pub fn power_on(&mut self, knowledge: &Knowledge) {
        self.writes = 0;
        self.suspended = false;
        self.version += 1;
        self.change = None;
        self.aborted = None;
        self.bus_changed = false;
        for (held, known) in self.values.iter_mut().zip(knowledge.entries()) {
            *held = Held { raw: known.power_on.filter(|_| known.stable), since: 0, by_reset: false };
        }
        self.learn_identifiers(knowledge);
    }

    /// Restores the values that a reset of this extent restores.
    pub fn reset(&mut self, knowledge: &Knowledge, extent: Extent) {
        if self.writes == 0 {
            return;
        }
        self.writes += 1;
        self.version += 1;
        self.change = None;
        self.aborted = None;
        for (held, known) in self.values.iter_mut().zip(knowledge.entries()) {
            let communication = (0x1000..0x2000).contains(&known.at.index.0);
            let raw = match extent {
                // The event timer that a profile defines for a PDO may be the same value as the event timer of that
                // PDO.
                Extent::Communication if !communication && known.is_event_timer => None,
                Extent::Communication if !communication && knowledge.services.reset_communication_loads_all => None,
                // Values of these objects take effect only when they are stored before the reset.
                _ if knowledge.services.acts_when_stored.contains(&known.at) => None,
                // A reset sets parameters only, and a manufacturer's object need not be a parameter.
                _ if (0x2000..0x6000).contains(&known.at.index.0) && extent == Extent::Node => None,
                Extent::Communication if !communication => held.raw.filter(|_| held.since + 1 == self.writes),
                _ => known.power_on.filter(|_| known.stable && !known.persists),
            };
            *held = Held { raw, since: self.writes, by_reset: true };
        }
        self.learn_identifiers(knowledge);
    }

    fn learn_identifiers(&mut self, knowledge: &Knowledge) {
        self.sync = self.number(knowledge, object::COB_ID_SYNC, 0);
        self.emcy = self.number(knowledge, object::COB_ID_EMCY, 0);
        self.time = self.number(knowledge, object::COB_ID_TIME, 0);
    }

    /// A number that changes with each change of the expected behaviour of PDOs.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// The expected value of an object, if it is known.
    pub fn number(&self, knowledge: &Knowledge, index: u16, sub: u8) -> Option<u64> {
        let found = knowledge.position(Multiplexer::new(index, sub))?;
        self.values.get(found)?.raw
    }

    /// The value that a read has to return now, because nothing was written since the value was learned.
    pub fn certain(&self, entry: usize) -> Option<u64> {
        let held = self.values.get(entry).filter(|held| held.since == self.writes && !self.suspended);
        held.and_then(|held| held.raw)
    }

    /// Number of writes.
    pub fn writes(&self) -> u32 {
        self.writes
    }

    /// Ignores the value of the read under way.
    pub(crate) fn suspend(&mut self) {
        self.suspended = true;
    }

    /// Accepts values that are read from now on.
    pub(crate) fn resume(&mut self) {
        self.suspended = false;
    }

    /// Whether the value of the object was restored by a reset.
    pub(crate) fn is_by_reset(&self, entry: usize) -> bool {
        self.values.get(entry).is_some_and(|held| held.by_reset)
    }

    /// Records a confirmed download.
    pub fn written(&mut self, knowledge: &Knowledge, entry: usize, raw: Option<u64>) {
        let Some(known) = knowledge.entries().get(entry) else { return };
        self.writes += 1;
        self.version += 1;
        self.aborted = None;
        if let Some(held) = self.values.get_mut(entry) {
            *held = Held { raw: raw.filter(|_| known.stable), since: self.writes, by_reset: false };
        }
        if !(0x1000..0x2000).contains(&known.at.index.0) {
            self.forget_linked(knowledge);
        }
        self.bus_changed |= knowledge.services.bus_objects.contains(&known.at);
        self.change = raw.map(|raw| (known.at, raw));
        match (known.at.index.0, known.at.sub.0) {
            (object::COB_ID_SYNC, 0) => self.sync = raw,
            (object::COB_ID_TIME, 0) => self.time = raw,
            (object::COB_ID_EMCY, 0) => self.emcy = raw,
            _ => {}
        }
    }

    /// Forgets event timers: objects of the profile and the manufacturer can be linked to them, such as 6200h to
    /// 1800h:05.
    fn forget_linked(&mut self, knowledge: &Knowledge) {
        let first =
            knowledge.entries().partition_point(|known| known.at.index.0 < object::TPDO_COMMUNICATION_PARAMETER);
        let last = knowledge.entries().partition_point(|known| known.at.index.0 < object::TPDO_MAPPING_PARAMETER);
        for (held, known) in self.values[first..last].iter_mut().zip(&knowledge.entries()[first..last]) {
            if known.at.sub.0 == 5 {
                held.raw = None;
            }
        }
    }

    /// Records a value that was read.
    pub fn read(&mut self, knowledge: &Knowledge, entry: usize, raw: u64) {
        if !self.suspended
            && knowledge.entries().get(entry).is_some_and(|known| known.stable)
            && let Some(held) = self.values.get_mut(entry)
        {
            self.version += u64::from(held.raw != Some(raw));
            *held = Held { raw: Some(raw), since: self.writes, by_reset: false };
        }
    }

    /// Records that an object holds `raw` after a start instead of its power-on value.
    pub fn holds(&mut self, knowledge: &Knowledge, at: Multiplexer, raw: u64) {
        if let Some(entry) = knowledge.position(at) {
            self.read(knowledge, entry, raw);
            self.learn_identifiers(knowledge);
        }
    }

    /// Records that a PDO may have written objects.
    pub(crate) fn forget_outputs(&mut self) {
        self.writes += 1;
    }

    /// Records that an unknown value was written, maybe even to an unknown object. All values are forgotten.
    pub fn forget(&mut self, at: Option<Multiplexer>) {
        // Values of these objects have effects that can't be seen on the bus.
        let hidden = at.is_none_or(|at| {
            matches!(at.index.0, object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS | object::ERROR_BEHAVIOR)
        });
        self.change = hidden.then(|| (at.unwrap_or(Multiplexer::new(object::ERROR_BEHAVIOR, 1)), u64::MAX));
        self.writes += 1;
        self.version += 1;
        self.bus_changed = true;
        self.values.iter_mut().for_each(|held| held.raw = None);
        (self.sync, self.emcy, self.time) = (None, None, None);
    }

    /// Takes the object that was written last and its value.
    pub fn take_change(&mut self) -> Option<(Multiplexer, u64)> {
        self.change.take()
    }

    /// Whether node-ID, bit rate or stored values were changed, or may have been changed. The values after the next
    /// reset are then unknown.
    pub(crate) fn bus_changed(&self) -> bool {
        self.bus_changed
    }

    /// Whether parameters were stored or restored. The models don't follow values after that, and the device may be
    /// silent while it stores.
    pub fn has_stored(&self, knowledge: &Knowledge) -> bool {
        self.change.is_some_and(|(at, _)| knowledge.stores(at))
    }

    /// Whether the identifier belongs to SYNC: 080h if 1005h is not known.
    pub(crate) fn is_sync(&self, can_id: u16) -> bool {
        u64::from(can_id) == self.sync.unwrap_or(0x80) & 0x7FF
    }

    /// Whether the device is the producer of SYNC (bit 30 of 1005h).
    pub(crate) fn produces_sync(&self) -> bool {
        self.sync.is_some_and(|raw| raw >> 30 & 1 != 0)
    }

    /// The message with this identifier that the device must not send, because its configuration switches it off.
    pub(crate) fn is_off(&self, can_id: u16) -> Option<Off> {
        let has_id = |raw: u64| raw & 0x7FF == u64::from(can_id);
        let consumed = |raw: Option<u64>| raw.is_some_and(|raw| has_id(raw) && raw & u64::from(CobId::NO_RTR) == 0);
        let invalid = |raw: Option<u64>| raw.is_some_and(|raw| has_id(raw) && !CobId(raw as u32).is_valid());
        match self {
            _ if consumed(self.sync) => Some(Off::Sync),
            _ if consumed(self.time) => Some(Off::Time),
            _ if invalid(self.emcy) => Some(Off::Emcy),
            _ => None,
        }
    }

    /// Whether the identifier belongs to the device's EMCY.
    pub(crate) fn is_emcy(&self, can_id: u16, node: NodeId) -> bool {
        let predefined = 0x80 + u64::from(node.raw());
        match self.emcy {
            Some(raw) => CobId(raw as u32).is_valid() && raw & 0x7FF == u64::from(can_id),
            None => !self.has_emcy_object && u64::from(can_id) == predefined || u64::from(can_id) == predefined,
        }
    }

    /// Whether the device may delay or omit the EMCY of an error. There are several reasons: the device has no EMCY;
    /// EMCY is off, has an inhibit time or is not known; or the device monitors other nodes, whose loss it need not
    /// report (CiA 301, 7.2.8.2.2).
    pub(crate) fn errs_silently(&self, knowledge: &Knowledge) -> bool {
        if !self.has_emcy_object || self.watches(knowledge) {
            return true;
        }
        let is_set = |index| knowledge.entry(Multiplexer::new(index, 0)).is_some_and(|known| known.stable);
        let valid = self.emcy.is_some_and(|raw| CobId(raw as u32).is_valid());
        is_set(object::COB_ID_EMCY) && !valid
            || is_set(object::INHIBIT_TIME_EMCY) && self.number(knowledge, object::INHIBIT_TIME_EMCY, 0) != Some(0)
    }

    /// Whether the device may be monitoring other nodes (1016h) or its master (100Ch, 100Dh).
    fn watches(&self, knowledge: &Knowledge) -> bool {
        let first = knowledge
            .entries()
            .partition_point(|known| known.at < Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1));
        let consumers =
            knowledge.entries()[first..].iter().take_while(|known| known.at.index.0 == object::CONSUMER_HEARTBEAT_TIME);
        let heartbeats = self.values[first..].iter().zip(consumers).any(|(held, _)| held.raw.is_none_or(has_time));
        let is_guarded = [object::GUARD_TIME, object::LIFE_TIME_FACTOR].into_iter().all(|index| {
            let exists = knowledge.entry(Multiplexer::new(index, 0)).is_some();
            exists && self.number(knowledge, index, 0) != Some(0)
        });
        heartbeats || is_guarded
    }

    /// Whether the device produces SYNC or TIME with the identifier.
    pub(crate) fn is_produced(&self, can_id: u16) -> bool {
        let produces = |raw: Option<u64>| {
            raw.is_some_and(|raw| raw & u64::from(CobId::NO_RTR) != 0 && raw & 0x7FF == u64::from(can_id))
        };
        produces(self.sync) || produces(self.time)
    }
}

/// Whether an entry of 1016h has a time other than 0, so that it is in use.
const fn has_time(entry: u64) -> bool {
    entry & 0xFFFF != 0
}
