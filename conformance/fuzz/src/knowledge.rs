//! The knowledge of a device before the first sequence: its dictionary, services and power-on values.

use super::profile::{self, Profile};
use canvass_analyzer::dictionary::names::{self, Role};
use canvass_analyzer::dictionary::{Access, DataType, DeviceDescription, Entry, Manual, Value};
use canvass_analyzer::object::{self, Acting};
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lmt::{Lmt, Seven};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_device::models::Sheet;
use canvass_traces::Duration;
use std::collections::BTreeSet;

/// The knowledge of a device.
#[derive(Clone, Debug)]
pub struct Knowledge {
    /// The node-ID of the device.
    pub node: NodeId,
    /// The LSS address: 1018h:01 to 04. `None` if it is not known.
    pub address: Option<[u32; 4]>,
    /// The LMT address; `None` if the device has no LMT.
    pub lmt: Option<LmtAddress>,
    /// The supported services and their variants.
    pub services: Services,
    /// Waiting times for the device.
    pub patience: Patience,
    entries: Vec<Known>,
    /// The profiles that the device may have.
    profiles: Vec<&'static dyn Profile>,
    /// The indexes of the RPDO communication parameters.
    pub rpdos: Vec<u16>,
    /// CAN-IDs of frames that are sent unasked: by other nodes, by an SDO client of the device, by its application.
    pub bystanders: BTreeSet<u16>,
}

/// The address of an LMT slave.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LmtAddress {
    /// The manufacturer name, common to all devices of the model.
    pub manufacturer_name: Seven,
    /// The product name, common to all devices of the model.
    pub product_name: Seven,
    /// The serial number of this device. `None` if it is not known.
    pub serial_number: Option<Seven>,
}

/// The services of a device. `None` in a field: not described.
#[derive(Clone, Debug)]
pub struct Services {
    /// The device sends a boot-up message after initialisation.
    pub boot_up_message: bool,
    /// The device has an LSS slave.
    pub lss: Option<bool>,
    /// The LSS slave does not work in operational.
    pub lss_not_in_operational: bool,
    /// The LSS slave answers Fastscan.
    pub fastscan: Option<bool>,
    /// The LSS slave answers the inquiry services.
    pub lss_inquiry: Option<bool>,
    /// A node-ID configured by LSS takes effect by a restart when the slave leaves configuration state; otherwise it
    /// takes effect at the next reset.
    pub lss_restarts: Option<bool>,
    /// The device has an LMT slave, which uses the CAN-IDs of LSS.
    pub lmt: bool,
    /// The rows of table 0 that the LMT service "configure bit timing" accepts.
    pub lmt_bit_rates: Vec<u8>,
    /// Numbers from 1 of the TPDOs that are padded to eight bytes.
    pub padded_tpdos: Vec<u16>,
    /// The rows of table 0 that the LSS service "configure bit timing" accepts.
    pub lss_bit_rates: Option<Vec<u8>>,
    /// Reset communication sets the whole dictionary to its power-on values.
    pub reset_communication_loads_all: bool,
    /// Objects whose values take effect, and are checked, only when they are stored.
    pub acts_when_stored: Vec<Multiplexer>,
    /// The device answers node guarding.
    pub guarding: Option<bool>,
    /// The SDO server supports block transfers.
    pub block_transfer: Option<bool>,
    /// Objects that change the node-ID, the bit rate or stored values when they are written.
    pub bus_objects: Vec<Multiplexer>,
    /// The object that stores the values of [`Services::bus_objects`].
    pub bus_save_object: Option<Multiplexer>,
    /// Objects whose values persist at once, so that each write wears the memory out.
    pub persist_at_once: Vec<Multiplexer>,
}

/// How long the fuzzer waits for the device.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Maximum time of an answer that must come.
    pub answer: Duration,
    /// Time without an answer after which the device counts as silent.
    pub quiet: Duration,
    /// Maximum time from a reset to the boot-up message.
    pub boot: Duration,
    /// Tolerance of measured times. Device timers tick in milliseconds, and the measuring computer is sometimes late.
    pub jitter: Duration,
}

impl Patience {
    /// The patience for a device with these measured times of answers and of its last start. The time of silence
    /// depends on the fastest nine of ten answers: a single late answer is usually due to the host.
    pub fn measured(self, mut answers: Vec<Duration>, restart: Duration) -> Self {
        answers.sort_unstable();
        let slowest = answers.last().copied().unwrap_or_default();
        let usual = answers.get(answers.len() * 9 / 10).copied().unwrap_or(slowest);
        Self {
            answer: self.answer.max(slowest.times(3)),
            quiet: usual.times(2) + self.jitter.min(LEAST_QUIET),
            boot: LEAST_BOOT.max(restart.times(3)),
            jitter: self.jitter,
        }
    }
}

/// Maximum time added to twice the usual time of an answer.
const LEAST_QUIET: Duration = Duration::from_millis(1);
/// Minimum time for booting, even of a device that boots at once.
const LEAST_BOOT: Duration = Duration::from_secs(1);

impl Default for Patience {
    /// The patience for a slow device on a live bus.
    fn default() -> Self {
        Self {
            answer: Duration::from_millis(1_000),
            quiet: Duration::from_millis(20),
            boot: Duration::from_millis(5_000),
            jitter: Duration::from_millis(50),
        }
    }
}

/// An object of the dictionary.
#[derive(Clone, Debug)]
pub struct Known {
    /// The address of the object.
    pub at: Multiplexer,
    /// The data type of the object.
    pub data_type: DataType,
    /// The length of values in bytes, if it is fixed.
    pub size: Option<usize>,
    /// The object can be read.
    pub readable: bool,
    /// The object can be written.
    pub writable: bool,
    /// The value never changes.
    pub constant: bool,
    /// Lowest and highest value.
    pub limits: (Option<i128>, Option<i128>),
    /// A written value stays until the object is written again.
    pub stable: bool,
    /// A written value survives a reset.
    pub persists: bool,
    /// The action that writing the object triggers. The fuzzer writes no value of such an object back.
    pub acting: Option<Acting>,
    /// The object is the event timer that a device profile defines for a TPDO.
    pub is_event_timer: bool,
    /// The object can be mapped into a TPDO.
    pub tpdo_mappable: bool,
    /// Typical length in bytes of a value of variable length.
    pub usual_length: usize,
    /// The value after power-on, for types of up to eight bytes.
    pub power_on: Option<u64>,
    /// Whether the power-on value was read from the device, where it may have been stored, and not taken from the
    /// description.
    pub was_read: bool,
}

impl Knowledge {
    /// The knowledge from the description and the device sheet.
    pub fn new(node: NodeId, description: Option<&DeviceDescription>, sheet: Option<&Sheet>) -> Self {
        let entries: Vec<Known> = description
            .map(|description| {
                description.dictionary.entries().filter_map(|(at, entry)| Known::new(at, entry, node)).collect()
            })
            .unwrap_or_default();
        let mut knowledge = Self {
            node,
            address: None,
            lmt: sheet.and_then(|sheet| sheet.lmt).map(|address| LmtAddress {
                manufacturer_name: address.manufacturer_name,
                product_name: address.product_name,
                serial_number: None,
            }),
            services: Services::new(description, sheet),
            patience: Patience::default(),
            rpdos: entries
                .iter()
                .filter(|known| known.at.sub.0 == 1 && object::is_rpdo_communication(known.at.index.0))
                .map(|known| known.at.index.0)
                .collect(),
            bystanders: BTreeSet::new(),
            profiles: profile::possible(description.and_then(DeviceDescription::device_profile)),
            entries,
        };
        let stores_by_itself = description.is_some_and(stores_by_itself);
        let manual = Manual { acting: sheet.map(Sheet::acting).unwrap_or_default(), ..Manual::default() };
        for known in &mut knowledge.entries {
            known.acting = manual.acting(known.at, description);
            known.persists = stores_by_itself || knowledge.services.persist_at_once.contains(&known.at);
            // LSS, switches or the last start determine node-ID and bit rate.
            known.stable &= !knowledge.services.bus_objects.contains(&known.at);
        }
        if let Some(sheet) = sheet {
            for value in &sheet.values {
                let raw = value.value.as_integer().map(|number| number as u64);
                if let (Some(found), Some(raw)) = (knowledge.position(value.at), raw) {
                    knowledge.entries[found].power_on = Some(raw);
                }
            }
        }
        knowledge
    }

    /// Whether the dictionary is known.
    pub fn is_described(&self) -> bool {
        !self.entries.is_empty()
    }

    /// The profiles that the device may have: its own, or all if its profile is not known.
    pub fn profiles(&self) -> &[&'static dyn Profile] {
        &self.profiles
    }

    /// All objects, by rising address.
    pub fn entries(&self) -> &[Known] {
        &self.entries
    }

    /// The position of an object in [`Knowledge::entries`].
    pub fn position(&self, at: Multiplexer) -> Option<usize> {
        self.entries.binary_search_by_key(&at, |known| known.at).ok()
    }

    /// The object at that address.
    pub fn entry(&self, at: Multiplexer) -> Option<&Known> {
        self.position(at).and_then(|found| self.entries.get(found))
    }

    /// Whether writing the object moves the zero point of a position or an angle. A device without a description may
    /// have any profile.
    pub fn moves_zero_point(&self, at: Multiplexer) -> bool {
        let acting = match self.is_described() {
            true => self.entry(at).and_then(|known| known.acting),
            false => names::acting(at, None),
        };
        acting == Some(Acting::MovesZeroPoint)
    }

    /// Whether writing the object stores or restores parameters: 1010h, 1011h, or the object that stores node-ID and
    /// bit rate. The device may be silent for some time after it.
    pub(crate) fn stores(&self, at: Multiplexer) -> bool {
        matches!(at.index.0, object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS)
            || self.services.bus_save_object == Some(at)
    }

    /// Whether the dictionary contains the index.
    pub fn has_index(&self, at: Multiplexer) -> bool {
        let first = self.entries.partition_point(|known| known.at.index < at.index);
        self.entries.get(first).is_some_and(|known| known.at.index == at.index)
    }

    /// Sets the power-on value of an object as read from the device.
    pub fn learn(&mut self, at: Multiplexer, raw: u64) {
        if let Some(found) = self.position(at) {
            (self.entries[found].power_on, self.entries[found].was_read) = (Some(raw), true);
        }
    }
}

impl Services {
    fn new(description: Option<&DeviceDescription>, sheet: Option<&Sheet>) -> Self {
        let network = sheet.map(|sheet| &sheet.network);
        let storage = sheet.map(|sheet| &sheet.storage);
        let mut bus_objects: Vec<Multiplexer> = network
            .into_iter()
            .flat_map(|network| [network.node_id_object, network.bit_rate_object])
            .flatten()
            .collect();
        bus_objects.extend(storage.into_iter().flat_map(|storage| storage.bus_save_object));
        bus_objects.extend(storage.into_iter().flat_map(|storage| storage.bus_objects.iter().copied()));
        Self {
            boot_up_message: network.is_none_or(|network| network.boot_up_message),
            lss: network.map(|network| network.lss).or(description.map(|description| description.device.lss_supported)),
            lss_not_in_operational: network.is_some_and(|network| {
                !network.lss_states.is_empty() && !network.lss_states.iter().any(|state| state == "operational")
            }),
            fastscan: None,
            lss_inquiry: None,
            lss_restarts: network.map(|network| network.lss_restarts),
            lmt: network.is_some_and(|network| network.lmt),
            lmt_bit_rates: (0..=u8::MAX)
                .filter(|&row| {
                    let has =
                        |rate| sheet.is_some_and(|sheet| sheet.bit_rates.iter().any(|own| own.kbit * 1_000 == rate));
                    Lmt::bit_rate(row).is_some_and(has)
                })
                .collect(),
            padded_tpdos: network
                .map(|network| network.padded_tpdos.iter().map(|&number| u16::from(number)).collect())
                .unwrap_or_default(),
            lss_bit_rates: sheet
                .map(|sheet| sheet.bit_rates.iter().filter_map(|rate| rate.lss_code).collect::<Vec<u8>>())
                .filter(|rates| !rates.is_empty()),
            reset_communication_loads_all: sheet.is_some_and(|sheet| sheet.quirks.reset_communication_loads_all),
            acts_when_stored: sheet.map(|sheet| sheet.quirks.acts_when_stored.clone()).unwrap_or_default(),
            guarding: network.map(|network| network.node_guarding),
            block_transfer: network.map(|network| network.sdo_block_transfer),
            bus_objects,
            bus_save_object: storage.and_then(|storage| storage.bus_save_object),
            persist_at_once: storage.map(|storage| storage.persist_at_once.clone()).unwrap_or_default(),
        }
    }
}

/// Whether an object, by its purpose, returns another value than the value written to it.
fn has_a_life_of_its_own(at: Multiplexer) -> bool {
    matches!(at.index.0, object::ERROR_REGISTER | object::MANUFACTURER_STATUS_REGISTER | object::PREDEFINED_ERROR_FIELD | object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS | object::HIGH_RESOLUTION_TIME_STAMP | object::VERIFY_CONFIGURATION | 0x1023..=0x1026 | 0x1F50..=0x1F57)
}

/// Whether the device stores written values without a command: bit 1 of 1010h:01 (CiA 301, 7.5.2.13).
fn stores_by_itself(description: &DeviceDescription) -> bool {
    let entry = description.dictionary.entry(Multiplexer::new(object::STORE_PARAMETERS, 1));
    let default = entry.ok().and_then(|entry| entry.default.as_ref()?.fixed()?.to_raw());
    default.is_some_and(|capability| capability & 1 << 1 != 0)
}

/// Entries that CiA 301 reserves in the communication parameters of PDOs: reading and writing them is refused with
/// abort 0609 0011h, whatever the description says (7.5.2.35 and 7.5.2.37).
const fn is_reserved(at: Multiplexer) -> bool {
    matches!((at.index.0, at.sub.0), (0x1400..=0x15FF, 4 | 6) | (0x1800..=0x19FF, 4))
}

impl Known {
    fn new(at: Multiplexer, entry: &Entry, node: NodeId) -> Option<Self> {
        entry.data_type.class()?;
        if is_reserved(at) {
            return None;
        }
        let limit = |setting: &Option<canvass_analyzer::dictionary::Setting>| {
            setting.as_ref().map(|setting| setting.resolve(entry.data_type, node)).as_ref().and_then(Value::as_number)
        };
        let constant = entry.access == Access::Const;
        Some(Self {
            at,
            data_type: entry.data_type,
            size: entry.data_type.bytes(),
            readable: entry.access.is_readable(),
            writable: entry.access.is_writable(),
            constant,
            limits: (limit(&entry.low_limit), limit(&entry.high_limit)),
            stable: entry.access.is_readable()
                && (constant || entry.access.is_writable())
                && !has_a_life_of_its_own(at),
            persists: false,
            acting: None,
            is_event_timer: at.sub.0 == 0 && names::has_role(at.index, Role::EventTimer),
            tpdo_mappable: entry.pdo_mappable && entry.access.allows_tpdo(),
            usual_length: match entry.start_value(node) {
                Some(value) => value.encode(entry.data_type).map_or(0, |bytes| bytes.len()),
                None => 0,
            },
            power_on: entry
                .start_value(node)
                .as_ref()
                .and_then(Value::to_raw)
                .filter(|_| entry.data_type.bytes().is_some()),
            was_read: false,
        })
    }

    /// Whether a value lies within the limits.
    pub(crate) fn in_limits(&self, raw: u64) -> bool {
        let Some(value) = Value::from_raw(self.data_type, raw).and_then(|value| value.as_number()) else { return true };
        self.limits.0.is_none_or(|low| value >= low) && self.limits.1.is_none_or(|high| value <= high)
    }
}
