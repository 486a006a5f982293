//! Non-volatile memory: the groups of 1010h and 1011h, storing and loading.

use super::parameters::{Content, Parameters};
use crate::models::{Model, Storage};
use crate::{Fault, Firmware};
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::Timestamp;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A set of groups of parameters.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Groups(u8);

impl Groups {
    /// No group.
    pub const NONE: Self = Self(0);
    /// 1000h to 1FFFh.
    pub const COMMUNICATION: Self = Self(1);
    /// 6000h to 9FFFh.
    pub(crate) const APPLICATION: Self = Self(2);
    /// 2000h to 5FFFh, without bit rate and node-ID.
    pub const MANUFACTURER: Self = Self(4);
    /// Bit rate, node-ID and further parameters that only a separate command stores.
    pub const BUS: Self = Self(8);
    /// All groups.
    pub const ALL: Self = Self(15);
    /// The groups that 1010h:01 and 1011h:01 concern.
    pub const PARAMETERS: Self = Self(7);

    const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The groups of this set that are not in `other`.
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether an object is in one of the groups.
    pub fn has(self, at: Multiplexer, storage: &Storage) -> bool {
        self.contains(Self::of(at, storage))
    }

    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The group of an object.
    fn of(at: Multiplexer, storage: &Storage) -> Self {
        match at.index.0 {
            _ if storage.bus_objects.contains(&at) => Self::BUS,
            ..0x2000 => Self::COMMUNICATION,
            0x2000..0x6000 => Self::MANUFACTURER,
            _ => Self::APPLICATION,
        }
    }

    /// The groups that a sub-index of 1010h or 1011h concerns.
    const fn of_sub_index(sub: u8) -> Self {
        match sub {
            1 => Self::PARAMETERS,
            2 => Self::COMMUNICATION,
            3 => Self::APPLICATION,
            _ => Self::MANUFACTURER,
        }
    }
}

/// The command that a write to 1010h, to 1011h or to the object that stores the bus parameters gives.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum StoreCommand {
    Save(Groups),
    /// Load the defaults at the next reset.
    Restore(Groups),
}

impl StoreCommand {
    /// The command that a write to this object gives; `None` if the write is no command.
    pub fn of(at: Multiplexer, storage: &Storage) -> Option<Self> {
        match (at.index.0, at.sub.0) {
            _ if Some(at) == storage.bus_save_object => Some(Self::Save(Groups::BUS)),
            // If no separate object stores the bus parameters, 1010h:01 ("all") stores them too.
            (object::STORE_PARAMETERS, 1) if storage.bus_save_object.is_none() => Some(Self::Save(Groups::ALL)),
            (object::STORE_PARAMETERS, sub @ 1..) => Some(Self::Save(Groups::of_sub_index(sub))),
            (object::RESTORE_DEFAULT_PARAMETERS, sub @ 1..) => Some(Self::Restore(Groups::of_sub_index(sub))),
            _ => None,
        }
    }

    /// Whether the command stores parameters.
    pub(crate) const fn is_save(self) -> bool {
        matches!(self, Self::Save(_))
    }

    /// Checks the signature written to 1010h or 1011h.
    ///
    /// # Errors
    /// The abort code of this model for a wrong signature.
    pub fn check(self, value: u64, storage: &Storage) -> Result<(), AbortCode> {
        let signature = match self {
            Self::Save(_) => storage.save_signature,
            Self::Restore(_) => storage.load_signature,
        };
        if value == u64::from(signature) { Ok(()) } else { Err(AbortCode(storage.wrong_signature_abort)) }
    }
}

/// The stored node-ID and bit rate of a device that has no objects for them.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct StoredNetwork {
    /// The node-ID: 1 to 127, or 255 for none.
    pub node_id: Option<u8>,
    /// The bit rate: the index in table 0 of CiA 305.
    pub bit_timing: Option<u8>,
}

/// The non-volatile memory.
#[derive(Clone, Debug)]
pub(super) struct Store {
    storage: Arc<Storage>,
    /// Stored values that differ from the default, by the position of the parameter in the object dictionary.
    image: Arc<Vec<Option<Content>>>,
    /// The value that the application stores in addition to the parameters.
    retained: Option<i64>,
    /// Values stored by LSS that no object holds.
    network: StoredNetwork,
    /// Groups whose defaults are loaded until power-off, although stored values exist.
    restored: Groups,
    /// Whether restored defaults are lost at power-off unless 1010h stores them.
    restore_needs_store: bool,
    /// The write in progress, with its end. A reset before the end leaves the memory unchanged.
    pending: Option<(Timestamp, StoreCommand)>,
}

impl Store {
    /// An empty memory: the device is as delivered.
    pub fn new(model: &Model, parameters: &Parameters) -> Self {
        let storage = Arc::new(model.sheet().storage.clone());
        Self {
            storage,
            image: Arc::new(vec![None; parameters.entries().len()]),
            retained: None,
            network: StoredNetwork::default(),
            restored: Groups::NONE,
            restore_needs_store: model.sheet().quirks.restore_needs_store,
            pending: None,
        }
    }

    /// Begins a write that ends at `done`.
    pub fn begin(&mut self, done: Timestamp, command: StoreCommand, firmware: &Firmware) {
        let command = match command {
            StoreCommand::Save(_) if firmware.has(Fault::StoreWithoutEffect) => return,
            StoreCommand::Restore(_) if firmware.has(Fault::RestoreWithoutEffect) => return,
            StoreCommand::Restore(_) if firmware.has(Fault::RestoreGroupIgnored) => {
                StoreCommand::Restore(Groups::PARAMETERS)
            }
            StoreCommand::Save(Groups::BUS) => command,
            StoreCommand::Save(_) if firmware.has(Fault::StoreGroupIgnored) => StoreCommand::Save(Groups::PARAMETERS),
            StoreCommand::Save(groups) if firmware.has(Fault::StoreLosesGroup) => {
                StoreCommand::Save(Groups(groups.0 & !Groups::APPLICATION.0))
            }
            command => command,
        };
        self.pending = Some((done, command));
    }

    /// Handles a reset while a faulty firmware writes: the first half of the memory has new values, the second half has
    /// old values.
    pub(crate) fn tear(&mut self, parameters: &Parameters, node: NodeId) {
        if let Some((_, StoreCommand::Save(groups))) = self.pending {
            let half = self.image.len() / 2;
            let old: Vec<_> = self.image.iter().skip(half).cloned().collect();
            self.save(groups, parameters, None, node);
            let image = Arc::make_mut(&mut self.image);
            image.truncate(half);
            image.extend(old);
        }
    }

    /// The time at which the write in progress ends.
    pub fn timeout(&self) -> Timestamp {
        self.pending.map_or(Timestamp::MAX, |(done, _)| done)
    }

    /// Ends the write in progress if its time has come.
    pub fn finish(&mut self, now: Timestamp, parameters: &Parameters, retained: Option<i64>, node: NodeId) {
        if let Some((done, command)) = self.pending
            && now >= done
        {
            self.pending = None;
            match command {
                StoreCommand::Save(groups) => self.save(groups, parameters, retained, node),
                StoreCommand::Restore(groups) if self.restore_needs_store => self.restored = self.restored.with(groups),
                StoreCommand::Restore(groups) => self.forget(groups, parameters),
            }
        }
    }

    fn save(&mut self, groups: Groups, parameters: &Parameters, retained: Option<i64>, node: NodeId) {
        for (slot, entry) in Arc::make_mut(&mut self.image).iter_mut().zip(parameters.entries()) {
            if entry.writable && groups.has(entry.at, &self.storage) {
                // A default COB-ID is not stored, so that it still follows the node-ID.
                *slot = (*entry.content != entry.default_content(node)).then(|| entry.content.clone());
            }
        }
        if groups.contains(Groups::APPLICATION) {
            self.retained = retained;
        }
        self.restored = self.restored.without(groups);
    }

    fn forget(&mut self, groups: Groups, parameters: &Parameters) {
        for (slot, entry) in Arc::make_mut(&mut self.image).iter_mut().zip(parameters.entries()) {
            if groups.has(entry.at, &self.storage) {
                *slot = None;
            }
        }
        if groups.contains(Groups::APPLICATION) {
            self.retained = None;
        }
    }

    /// Stores the application's own value at once.
    pub(crate) fn save_retained(&mut self, retained: i64) {
        self.retained = Some(retained);
    }

    /// The stored value of the application; `None` if none is stored.
    pub(crate) fn retained(&self) -> Option<i64> {
        self.retained
    }

    /// Handles power-off and on: stored values are loaded again in place of restored defaults.
    pub const fn power_on(&mut self) {
        self.restored = Groups::NONE;
    }

    /// Erases the stored value of one object at once.
    pub(crate) fn forget_number(&mut self, at: Multiplexer, parameters: &Parameters) {
        let position = parameters.entries().position(|entry| entry.at == at);
        if let Some(slot) = position.and_then(|position| Arc::make_mut(&mut self.image).get_mut(position)) {
            *slot = None;
        }
    }

    /// Values stored by LSS that no object holds.
    pub const fn network(&self) -> StoredNetwork {
        self.network
    }

    /// Stores values of LSS that no object holds.
    pub(crate) const fn save_network(&mut self, network: StoredNetwork) {
        self.network = network;
    }

    /// Stores one number at once, regardless of groups: LSS stores node-ID and bit rate in this way.
    pub(crate) fn save_number(&mut self, at: Multiplexer, number: u64, parameters: &Parameters) {
        let position = parameters.entries().position(|entry| entry.at == at);
        if let Some(slot) = position.and_then(|position| Arc::make_mut(&mut self.image).get_mut(position)) {
            *slot = Some(Content::Number(number));
        }
    }

    /// Whether anything was ever stored.
    pub(crate) fn holds_something(&self) -> bool {
        self.image.iter().any(Option::is_some)
    }

    /// Stores one parameter as soon as it is written.
    pub(crate) fn save_at_once(&mut self, at: Multiplexer, parameters: &Parameters, node: NodeId) {
        let found = parameters.entries().enumerate().find(|(_, entry)| entry.at == at);
        let Some((position, entry)) = found.filter(|(_, entry)| entry.writable) else { return };
        if Groups::PARAMETERS.contains(Groups::of(at, &self.storage))
            && let Some(slot) = Arc::make_mut(&mut self.image).get_mut(position)
        {
            *slot = (*entry.content != entry.default_content(node)).then(|| entry.content.clone());
        }
    }

    /// The stored number of the object at an address.
    pub fn number(&self, at: Multiplexer, parameters: &Parameters) -> Option<u64> {
        let position = parameters.entries().position(|entry| entry.at == at)?;
        match self.image.get(position)?.as_ref()? {
            Content::Number(number) => Some(*number),
            Content::Bytes(_) => None,
        }
    }

    /// The stored values by address, and the stored value of the application.
    pub(super) fn contents<'a>(
        &'a self,
        parameters: &'a Parameters,
    ) -> (impl Iterator<Item = (Multiplexer, &'a Content)>, Option<i64>) {
        let stored = self.image.iter().zip(parameters.entries());
        (stored.filter_map(|(slot, entry)| Some((entry.at, slot.as_ref()?))), self.retained)
    }

    /// Replaces the whole memory by these values. Values of absent addresses are dropped.
    pub(super) fn replace(
        &mut self,
        contents: &BTreeMap<Multiplexer, Content>,
        retained: Option<i64>,
        network: StoredNetwork,
        parameters: &Parameters,
    ) {
        for (slot, entry) in Arc::make_mut(&mut self.image).iter_mut().zip(parameters.entries()) {
            *slot = contents.get(&entry.at).cloned();
        }
        (self.retained, self.network, self.pending) = (retained, network, None);
    }

    /// Handles a reset: loads the stored values of the groups, or their defaults.
    pub fn load(&mut self, groups: Groups, parameters: &mut Parameters, node: NodeId) {
        self.pending = None;
        for (slot, (entry, content)) in self.image.iter().zip(parameters.entries_mut()) {
            let group = Groups::of(entry.at, &self.storage);
            if groups.contains(group) {
                let slot = if self.restored.contains(group) { &None } else { slot };
                *content = slot.clone().unwrap_or_else(|| entry.default_content(node));
            }
        }
    }
}
