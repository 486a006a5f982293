//! What the fuzzer knows of a device before it begins: its dictionary, its services, its values after power-on.

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

/// A device as the fuzzer knows it.
#[derive(Clone, Debug)]
pub struct Knowledge {
    /// Its node-ID.
    pub node: NodeId,
    /// LSS address: 1018h:01 to 04; `None` where it could not be found out.
    pub address: Option<[u32; 4]>,
    /// LMT address, of a device with LMT.
    pub lmt: Option<LmtAddress>,
    /// What it can do.
    pub services: Services,
    /// How long to wait.
    pub patience: Patience,
    entries: Vec<Known>,
    /// The profiles that it may have.
    profiles: Vec<&'static dyn Profile>,
    /// The indexes of the communication parameters of its RPDOs.
    pub rpdos: Vec<u16>,
    /// CAN-IDs of frames that come by themselves: of other nodes, of an SDO client of the device, of its application.
    pub bystanders: BTreeSet<u16>,
}

/// The address of an LMT slave.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LmtAddress {
    /// Of all devices of the model.
    pub manufacturer_name: Seven,
    /// Of all devices of the model.
    pub product_name: Seven,
    /// Of this device; `None`: not known.
    pub serial_number: Option<Seven>,
}

/// What a device can do; `None` where nobody has said.
#[derive(Clone, Debug)]
pub struct Services {
    /// It sends a boot-up message after initialisation.
    pub boot_up_message: bool,
    /// It has an LSS slave.
    pub lss: Option<bool>,
    /// LSS does not work in operational.
    pub lss_not_in_operational: bool,
    /// It answers Fastscan.
    pub fastscan: Option<bool>,
    /// It answers the inquiry services of LSS.
    pub lss_inquiry: Option<bool>,
    /// A node-ID that LSS configured acts when the slave leaves configuration, by a restart; else at the next reset.
    pub lss_restarts: Option<bool>,
    /// It has an LMT slave, whose frames have the CAN-IDs of LSS.
    pub lmt: bool,
    /// The rows of table 0 that configure bit timing of LMT accepts.
    pub lmt_bit_rates: Vec<u8>,
    /// TPDOs that are filled up to eight bytes, by their number from 1.
    pub padded_tpdos: Vec<u16>,
    /// The rows of table 0 that configure bit timing accepts.
    pub lss_bit_rates: Option<Vec<u8>>,
    /// Reset communication brings the values of the whole dictionary back.
    pub reset_communication_loads_all: bool,
    /// Objects whose values act, and are checked, only when they are stored.
    pub acts_when_stored: Vec<Multiplexer>,
    /// It answers node guarding.
    pub guarding: Option<bool>,
    /// It knows SDO block transfers.
    pub block_transfer: Option<bool>,
    /// Objects whose writing changes node-ID, bit rate or what is stored.
    pub bus_objects: Vec<Multiplexer>,
    /// The object that stores them.
    pub bus_save_object: Option<Multiplexer>,
    /// Values act and persist at once: writing them wears the memory out.
    pub persist_at_once: Vec<Multiplexer>,
}

/// How long the fuzzer waits for the device.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// For an answer that must come.
    pub answer: Duration,
    /// Where nothing may come.
    pub quiet: Duration,
    /// From a reset to the boot-up message.
    pub boot: Duration,
    /// By how much times may be off that are measured here: timers tick in milliseconds, and the computer that
    /// measures them is late sometimes.
    pub jitter: Duration,
}

impl Patience {
    /// For a device whose answers, and whose last start, took so long. Silence lasts by what nine of ten answers took: a
    /// single late one is the host's, and is noticed where it matters.
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

/// What is added to twice the usual time of an answer.
const LEAST_QUIET: Duration = Duration::from_millis(1);
/// A device that boots at once is given that time all the same.
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
    /// Its address.
    pub at: Multiplexer,
    /// Its type.
    pub data_type: DataType,
    /// The length of values in bytes, where it is fixed.
    pub size: Option<usize>,
    /// It can be read.
    pub readable: bool,
    /// It can be written.
    pub writable: bool,
    /// It never changes.
    pub constant: bool,
    /// Lowest and highest value.
    pub limits: (Option<i128>, Option<i128>),
    /// What was written is what is read, until somebody writes it again.
    pub stable: bool,
    /// It keeps what was written over a reset.
    pub persists: bool,
    /// What it does when it is written: no value of it is put back.
    pub acting: Option<Acting>,
    /// It is the timer that a device profile has for a TPDO.
    pub is_event_timer: bool,
    /// It can be mapped into a TPDO.
    pub tpdo_mappable: bool,
    /// How many bytes a value of variable length usually has.
    pub usual_length: usize,
    /// The value after power-on, for types of up to eight bytes.
    pub power_on: Option<u64>,
    /// That value was read from the device, where it may have been stored; else it is that of the description.
    pub was_read: bool,
}

impl Knowledge {
    /// What description and sheet say.
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
            // Node-ID and bit rate are what LSS, switches or the last start made them.
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

    /// Whether the dictionary is known at all.
    pub fn is_described(&self) -> bool {
        !self.entries.is_empty()
    }

    /// The profiles that it may have: its own, or all where nobody knows it.
    pub fn profiles(&self) -> &[&'static dyn Profile] {
        &self.profiles
    }

    /// All objects, by rising address.
    pub fn entries(&self) -> &[Known] {
        &self.entries
    }

    /// The number of that object in [`Knowledge::entries`].
    pub fn position(&self, at: Multiplexer) -> Option<usize> {
        self.entries.binary_search_by_key(&at, |known| known.at).ok()
    }

    /// The object at that address.
    pub fn entry(&self, at: Multiplexer) -> Option<&Known> {
        self.position(at).and_then(|found| self.entries.get(found))
    }

    /// Whether writing that object moves the zero point of a position or an angle. A device that nobody has described may have any
    /// profile.
    pub fn moves_zero_point(&self, at: Multiplexer) -> bool {
        let acting = match self.is_described() {
            true => self.entry(at).and_then(|known| known.acting),
            false => names::acting(at, None),
        };
        acting == Some(Acting::MovesZeroPoint)
    }

    /// Whether there is an object with that index.
    pub fn has_index(&self, at: Multiplexer) -> bool {
        let first = self.entries.partition_point(|known| known.at.index < at.index);
        self.entries.get(first).is_some_and(|known| known.at.index == at.index)
    }

    /// Takes over what was read from the device after power-on.
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

/// Objects whose reading differs from what was written, by their purpose.
fn has_a_life_of_its_own(at: Multiplexer) -> bool {
    matches!(at.index.0, object::ERROR_REGISTER | object::MANUFACTURER_STATUS_REGISTER | object::PREDEFINED_ERROR_FIELD | object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS | object::HIGH_RESOLUTION_TIME_STAMP | object::VERIFY_CONFIGURATION | 0x1023..=0x1026 | 0x1F50..=0x1F57)
}

/// Bit 1 of 1010h:01: what is written is stored without a command (CiA 301, 7.5.2.13).
fn stores_by_itself(description: &DeviceDescription) -> bool {
    let entry = description.dictionary.entry(Multiplexer::new(object::STORE_PARAMETERS, 1));
    let default = entry.ok().and_then(|entry| entry.default.as_ref()?.fixed()?.to_raw());
    default.is_some_and(|capability| capability & 1 << 1 != 0)
}

/// Entries that CiA 301 reserves in the communication parameters of PDOs: reading and writing them is refused with abort
/// 0609 0011h, whatever the description says (7.5.2.35 and 7.5.2.37).
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

    /// Whether a number lies within the limits.
    pub fn in_limits(&self, raw: u64) -> bool {
        let Some(value) = Value::from_raw(self.data_type, raw).and_then(|value| value.as_number()) else { return true };
        self.limits.0.is_none_or(|low| value >= low) && self.limits.1.is_none_or(|high| value <= high)
    }
}
