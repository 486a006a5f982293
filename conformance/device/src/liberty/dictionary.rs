//! Liberties in the objects of a device and their defaults: the description and the device itself change together.

use super::edit::Edit;
use super::{Liberties, Liberty, timing};
use crate::models::{ApplicationSheet, Model, Sheet};
use canvass_analyzer::dictionary::{Access, DeviceDescription, Entry};
use canvass_analyzer::object;
use canvass_analyzer::{CobId, Multiplexer};
use std::borrow::Cow;

/// The first and the last member of a series.
type Span<T> = (T, T);

/// Objects that a device need not have, by the liberty that omits them.
const ABSENT: [(Liberty, &[Span<u16>]); 16] = [
    (Liberty::NoNames, &[(object::MANUFACTURER_DEVICE_NAME, object::MANUFACTURER_SOFTWARE_VERSION)]),
    (Liberty::NoEmcy, &[(object::COB_ID_EMCY, object::INHIBIT_TIME_EMCY)]),
    (Liberty::NoEmcyInhibitTime, &[(object::INHIBIT_TIME_EMCY, object::INHIBIT_TIME_EMCY)]),
    (Liberty::NoErrorHistory, &[(object::PREDEFINED_ERROR_FIELD, object::PREDEFINED_ERROR_FIELD)]),
    (Liberty::NoErrorBehaviour, &[(object::ERROR_BEHAVIOR, object::ERROR_BEHAVIOR)]),
    (Liberty::NoHeartbeatConsumer, &[(object::CONSUMER_HEARTBEAT_TIME, object::CONSUMER_HEARTBEAT_TIME)]),
    (Liberty::NoGuarding, &[(object::GUARD_TIME, object::LIFE_TIME_FACTOR)]),
    (Liberty::NoSyncCounter, &[(object::SYNCHRONOUS_COUNTER_OVERFLOW, object::SYNCHRONOUS_COUNTER_OVERFLOW)]),
    (Liberty::NoSyncWindow, &[(object::SYNCHRONOUS_WINDOW_LENGTH, object::SYNCHRONOUS_WINDOW_LENGTH)]),
    (
        Liberty::NoSyncProducer,
        &[
            (object::COMMUNICATION_CYCLE_PERIOD, object::COMMUNICATION_CYCLE_PERIOD),
            (object::SYNCHRONOUS_COUNTER_OVERFLOW, object::SYNCHRONOUS_COUNTER_OVERFLOW),
        ],
    ),
    (Liberty::NoTime, &[(object::COB_ID_TIME, object::HIGH_RESOLUTION_TIME_STAMP)]),
    (Liberty::NoStore, &[(object::STORE_PARAMETERS, object::RESTORE_DEFAULT_PARAMETERS)]),
    (Liberty::NoConfigurationDate, &[(object::VERIFY_CONFIGURATION, object::VERIFY_CONFIGURATION)]),
    (Liberty::NoFurtherSdo, &[(0x1201, 0x127F)]),
    (Liberty::NoEmcyConsumer, &[(object::EMERGENCY_CONSUMER, object::EMERGENCY_CONSUMER)]),
    (Liberty::OnePdo, &[(0x1401, 0x15FF), (0x1601, 0x17FF), (0x1801, 0x19FF), (0x1A01, 0x1BFF)]),
];

/// Sub-indexes that an object need not have, by the liberty that omits them.
const ABSENT_SUBS: [(Liberty, Span<u16>, Span<u8>); 6] = [
    (Liberty::VendorIdAlone, (object::IDENTITY, object::IDENTITY), (2, 255)),
    (Liberty::ShortErrorHistory, (object::PREDEFINED_ERROR_FIELD, object::PREDEFINED_ERROR_FIELD), (2, 255)),
    (Liberty::OneHeartbeatConsumer, (object::CONSUMER_HEARTBEAT_TIME, object::CONSUMER_HEARTBEAT_TIME), (2, 255)),
    (Liberty::NoInhibitTime, (0x1800, 0x19FF), (3, 3)),
    (Liberty::NoEventTimer, (0x1800, 0x19FF), (5, 5)),
    (Liberty::NoRpdoDeadline, (0x1400, 0x15FF), (5, 5)),
];

/// The transmission types of event-driven PDOs.
const EVENT_DRIVEN: (u8, u8) = (254, 255);

impl Model {
    /// The model with the changes that these liberties make in its description and sheet.
    pub fn taking(&self, liberties: Liberties) -> Cow<'_, Self> {
        if liberties.is_empty() {
            return Cow::Borrowed(self);
        }
        let (mut description, mut sheet) = (self.description().clone(), self.sheet().clone());
        apply(&mut description, &mut sheet, liberties);
        Cow::Owned(self.with(description, sheet))
    }
}

/// Applies liberties to a description and its sheet.
pub(crate) fn apply(description: &mut DeviceDescription, sheet: &mut Sheet, liberties: Liberties) {
    let mut edit = Edit { description, sheet };
    services(&mut edit, liberties);
    objects(&mut edit, liberties);
    pdos(&mut edit, liberties);
    timing::apply(&mut edit.sheet.timing, liberties);
}

/// Changes the services that the firmware has.
fn services(edit: &mut Edit<'_>, liberties: Liberties) {
    let has = |liberty| liberties.has(liberty);
    let sheet = &mut *edit.sheet;
    let network = &mut sheet.network;
    network.sdo_block_transfer &= !has(Liberty::NoBlockTransfer);
    network.node_guarding &= !has(Liberty::NoGuarding);
    network.sync_producer &= !has(Liberty::NoSyncProducer);
    network.time_consumer &= !has(Liberty::NoTime);
    network.rtr &= !has(Liberty::NoRtr);
    if has(Liberty::NoTime) {
        network.time_period_ms = None;
    }
    if has(Liberty::NoLss) {
        network.lss = false;
        edit.description.device.lss_supported = false;
    }
    if has(Liberty::OwnEvents) {
        network.sent_on_change.clear();
    }
    if has(Liberty::NoSynchronousPdos) {
        network.transmission_types = vec![EVENT_DRIVEN];
        network.rpdo_transmission_types = vec![EVENT_DRIVEN];
    }
    sheet.quirks.strings_in_segments |= has(Liberty::StringsInSegments);
    if has(Liberty::GenericErrorBit) {
        sheet.quirks.error_register_bits = Some(1);
    }
    if has(Liberty::SignatureCodeValue) {
        sheet.storage.wrong_signature_abort = 0x0609_0030;
    }
    if has(Liberty::SignatureCodeGeneral) {
        sheet.storage.wrong_signature_abort = 0x0800_0000;
    }
}

/// Changes the objects that the device has.
fn objects(edit: &mut Edit<'_>, liberties: Liberties) {
    for (_, ranges) in ABSENT.iter().filter(|(liberty, _)| liberties.has(*liberty)) {
        edit.remove(ranges.iter().map(|&(first, last)| first..=last));
    }
    for (_, (first, last), (low, high)) in ABSENT_SUBS.into_iter().filter(|(liberty, ..)| liberties.has(*liberty)) {
        edit.remove_subs(first..=last, low..=high);
    }
    if liberties.has(Liberty::NamesEndInNul) {
        // A text in an EDS can't end in 00h, so only the text in the device gets this byte.
        (object::MANUFACTURER_DEVICE_NAME..=object::MANUFACTURER_SOFTWARE_VERSION)
            .for_each(|index| edit.end_in_nul(index));
    }
    if liberties.has(Liberty::NoApplicationObjects) {
        edit.remove([0x2000..=0xFFFF]);
        edit.sheet.application = ApplicationSheet::default();
        unmap_all(edit);
    }
    if liberties.has(Liberty::NoLongObjects) {
        remove_long(edit, |entry| entry.access.is_writable());
    }
    if liberties.has(Liberty::NoSegmentedTransfer) {
        remove_long(edit, |_| true);
    }
    // `StoresByItself` makes 1010h read-only, so `StoresBothWays` is checked first.
    match () {
        () if liberties.has(Liberty::StoresBothWays) => stores(edit, 0b11, true),
        () if liberties.has(Liberty::StoresByItself) => stores(edit, 0b10, false),
        () => {}
    }
    if liberties.has(Liberty::SelfStart) {
        edit.remove([object::NMT_STARTUP..=object::NMT_STARTUP]);
    }
    if liberties.has(Liberty::SelfStartByObject) {
        let start_up = edit.sheet.network.start_up;
        edit.set(object::NMT_STARTUP, 0, u64::from(start_up.value));
    }
    if liberties.has(Liberty::NoDummies) {
        edit.description.dummy_usage.values_mut().for_each(|usable| *usable = false);
        edit.unmap_where(|at| at.index.0 < 0x20);
    }
    if liberties.has(Liberty::EdsIdentityWithoutDefaults) {
        // The device still has the numbers: they move from the description to the sheet.
        edit.move_defaults(object::IDENTITY);
    }
}

/// Sets the storing capability that 1010h shows, and whether 1010h can be written.
fn stores(edit: &mut Edit<'_>, capability: u64, on_command: bool) {
    for sub in 1..=4 {
        edit.set(object::STORE_PARAMETERS, sub, capability);
        if !on_command {
            edit.entry(object::STORE_PARAMETERS, sub, |entry| entry.access = Access::Ro);
        }
    }
}

/// Removes each object that has an entry of more than four bytes for which `is_meant` holds.
fn remove_long(edit: &mut Edit<'_>, is_meant: impl Fn(&Entry) -> bool) {
    let is_long = |entry: &Entry| is_meant(entry) && entry.data_type.bytes().is_none_or(|bytes| bytes > 4);
    let entries = edit.description.dictionary.entries();
    let long: Vec<u16> = entries.filter(|(_, entry)| is_long(entry)).map(|(at, _)| at.index.0).collect();
    edit.unmap_where(|at| long.contains(&at.index.0));
    edit.remove(long.into_iter().map(|index| index..=index));
}

/// Changes the PDOs as delivered.
fn pdos(edit: &mut Edit<'_>, liberties: Liberties) {
    let has = |liberty| liberties.has(liberty);
    let (rpdos, tpdos) =
        (edit.pdos(object::RPDO_COMMUNICATION_PARAMETER), edit.pdos(object::TPDO_COMMUNICATION_PARAMETER));
    if has(Liberty::PdosInvalid) {
        rpdos.iter().chain(&tpdos).for_each(|&index| edit.set_cob_id_bits(index, CobId::INVALID));
    }
    if has(Liberty::NoRtr) {
        tpdos.iter().for_each(|&index| edit.set_cob_id_bits(index, CobId::NO_RTR));
        tpdos.iter().for_each(|&index| event_driven(edit, index, |kind| matches!(kind, 252 | 253)));
    }
    if has(Liberty::NoSynchronousPdos) {
        rpdos.iter().chain(&tpdos).for_each(|&index| event_driven(edit, index, |kind| kind < 254));
    }
    if has(Liberty::LongInhibitTime) {
        // The inhibit time is in units of 100 us, the event timer in ms.
        edit.set(object::TPDO_COMMUNICATION_PARAMETER, 3, 2_000);
        edit.set(object::TPDO_COMMUNICATION_PARAMETER, 5, 100);
    }
    if has(Liberty::ValidAndEmpty) {
        edit.unmap(object::TPDO_MAPPING_PARAMETER);
    }
    if has(Liberty::MappingInBytes) {
        edit.description.device.granularity = 8;
    }
    if has(Liberty::MappingFixed) {
        edit.description.device.granularity = 0;
        edit.entries(|at, entry| {
            if object::is_pdo_mapping(at.index.0) {
                entry.access = Access::Const;
            }
        });
    }
}

/// Makes a PDO event-driven if the device does not support its delivered transmission type.
fn event_driven(edit: &mut Edit<'_>, index: u16, is_missing: impl Fn(u64) -> bool) {
    let entry = edit.description.dictionary.entry(Multiplexer::new(index, 2));
    let default = entry.ok().and_then(|entry| entry.default.as_ref()?.fixed()?.to_raw());
    if default.is_some_and(is_missing) {
        edit.set(index, 2, 255);
    }
}

fn unmap_all(edit: &mut Edit<'_>) {
    for first in [object::RPDO_COMMUNICATION_PARAMETER, object::TPDO_COMMUNICATION_PARAMETER] {
        for index in edit.pdos(first) {
            edit.set_cob_id_bits(index, CobId::INVALID);
            edit.unmap(index + 0x200);
        }
    }
}
