//! What the objects of the device hold, as far as its own answers tell.

use crate::Knowledge;
use canvass_analyzer::object;
use canvass_analyzer::{CobId, Multiplexer, NodeId};

/// The values that all objects should hold after what was written, as far as that is certain.
#[derive(Clone, Debug)]
pub(super) struct ExpectedValues {
    values: Vec<Held>,
    /// How many writes were confirmed: what was read before another write may have changed with it.
    writes: u32,
    /// The value that is being read may have changed while it was read.
    suspended: bool,
    /// Counts every change of what PDOs should do.
    version: u64,
    /// The object that was written last, until it is taken.
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
    /// [`ExpectedValues::writes`] when it was learned.
    since: u32,
    /// A reset brought it back.
    by_reset: bool,
}

/// What a reset brings back.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Extent {
    /// 1000h to 1FFFh.
    Communication,
    /// Everything.
    Node,
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

    /// The device was switched on: all values are those of power-on.
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

    /// A reset brought values back.
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
                // The timer that a profile has for a PDO may be the event timer of that PDO.
                Extent::Communication if !communication && known.is_event_timer => None,
                Extent::Communication if !communication && knowledge.services.reset_communication_loads_all => None,
                // What has not been stored before a reset never acts.
                _ if knowledge.services.acts_when_stored.contains(&known.at) => None,
                // A manufacturer's variables need not be parameters, which a reset sets.
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

    /// Another number whenever a PDO should do something else.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// The value of an object, if it is known.
    pub fn number(&self, knowledge: &Knowledge, index: u16, sub: u8) -> Option<u64> {
        let found = knowledge.position(Multiplexer::new(index, sub))?;
        self.values.get(found)?.raw
    }

    /// The value that must be read now: nothing else was written since it was learned.
    pub fn certain(&self, entry: usize) -> Option<u64> {
        let held = self.values.get(entry).filter(|held| held.since == self.writes && !self.suspended);
        held.and_then(|held| held.raw)
    }

    /// How many writes there were.
    pub fn writes(&self) -> u32 {
        self.writes
    }

    /// What is being read now says nothing.
    pub fn suspend(&mut self) {
        self.suspended = true;
    }

    /// What is read from now on says something.
    pub fn resume(&mut self) {
        self.suspended = false;
    }

    /// Whether a reset brought the value of that object back.
    pub fn is_by_reset(&self, entry: usize) -> bool {
        self.values.get(entry).is_some_and(|held| held.by_reset)
    }

    /// A download was confirmed.
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

    /// Objects of the profile and the manufacturer can be linked to event timers: 6200h is 1800h:05.
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

    /// A value was read.
    pub fn read(&mut self, knowledge: &Knowledge, entry: usize, raw: u64) {
        if !self.suspended
            && knowledge.entries().get(entry).is_some_and(|known| known.stable)
            && let Some(held) = self.values.get_mut(entry)
        {
            self.version += u64::from(held.raw != Some(raw));
            *held = Held { raw: Some(raw), since: self.writes, by_reset: false };
        }
    }

    /// An object has another value after a start than that of power-on.
    pub fn holds(&mut self, knowledge: &Knowledge, at: Multiplexer, raw: u64) {
        if let Some(entry) = knowledge.position(at) {
            self.read(knowledge, entry, raw);
            self.learn_identifiers(knowledge);
        }
    }

    /// Objects may have been written by a PDO.
    pub fn forget_outputs(&mut self) {
        self.writes += 1;
    }

    /// Something was written, but nobody knows what, and maybe not even which object.
    pub fn forget(&mut self, at: Option<Multiplexer>) {
        // What a device does on an error, and what it stores, it shows to nobody.
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

    /// What was written last, once.
    pub fn take_change(&mut self) -> Option<(Multiplexer, u64)> {
        self.change.take()
    }

    /// Whether node-ID, bit rate or stored values were changed, or may have been: what a reset brings is then not known.
    pub fn bus_changed(&self) -> bool {
        self.bus_changed
    }

    /// Whether parameters were stored or restored: what is read from then on is not modelled.
    pub fn has_stored(&self) -> bool {
        self.change
            .is_some_and(|(at, _)| matches!(at.index.0, object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS))
    }

    /// Whether that is the identifier of SYNC; 080h where 1005h is not known.
    pub fn is_sync(&self, can_id: u16) -> bool {
        u64::from(can_id) == self.sync.unwrap_or(0x80) & 0x7FF
    }

    /// Whether the device is the producer of SYNC (bit 30 of 1005h).
    pub fn produces_sync(&self) -> bool {
        self.sync.is_some_and(|raw| raw >> 30 & 1 != 0)
    }

    /// Whether that is the identifier of the device's EMCY.
    pub fn is_emcy(&self, can_id: u16, node: NodeId) -> bool {
        let predefined = 0x80 + u64::from(node.raw());
        match self.emcy {
            Some(raw) => CobId(raw as u32).is_valid() && raw & 0x7FF == u64::from(can_id),
            None => !self.has_emcy_object && u64::from(can_id) == predefined || u64::from(can_id) == predefined,
        }
    }

    /// Whether an error may not be reported at once: there is no EMCY, it is off or has an inhibit time, or nobody knows;
    /// or the device watches other nodes, whose loss it need not report (CiA 301, 7.2.8.2.2).
    pub fn errs_silently(&self, knowledge: &Knowledge) -> bool {
        if !self.has_emcy_object || self.watches(knowledge) {
            return true;
        }
        let is_set = |index| knowledge.entry(Multiplexer::new(index, 0)).is_some_and(|known| known.stable);
        let valid = self.emcy.is_some_and(|raw| CobId(raw as u32).is_valid());
        is_set(object::COB_ID_EMCY) && !valid
            || is_set(object::INHIBIT_TIME_EMCY) && self.number(knowledge, object::INHIBIT_TIME_EMCY, 0) != Some(0)
    }

    /// Whether the device may be watching other nodes (1016h), or its master (100Ch, 100Dh).
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

    /// Whether the device produces SYNC or TIME on that identifier.
    pub fn is_produced(&self, can_id: u16) -> bool {
        let produces = |raw: Option<u64>| {
            raw.is_some_and(|raw| raw & u64::from(CobId::NO_RTR) != 0 && raw & 0x7FF == u64::from(can_id))
        };
        produces(self.sync) || produces(self.time)
    }
}

/// Whether an entry of 1016h has a time, so that it is in use.
const fn has_time(entry: u64) -> bool {
    entry & 0xFFFF != 0
}
