//! The sheet of a device model, in the structure of its TOML file.

use super::annotations::{Bit, Choice, Mapped, Signal, Unused};
use super::emergency::Emergency;
use super::network::Network;
use super::profile::ApplicationSheet;
use super::quirks::Quirks;
use super::recognition::Recognition;
use super::rules::{Check, Link, Rule};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{Checked, Manual, Settings};
use canvass_analyzer::object::Acting;
use canvass_analyzer::wire::lmt::Seven;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::Duration;
use serde::de::IgnoredAny as ForPeople;
use serde::{Deserialize, Deserializer, de};

/// The facts about a device that an EDS cannot express. An unknown key is an error; the program skips the values of
/// keys that are only for people.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// The id of the model, which is its name on the command line.
    pub id: String,
    /// The description of the model in one line.
    pub summary: String,
    /// The services of the device and its access by the network.
    pub network: Network,
    /// The facts by which a node is recognised as this model, besides the defaults of the EDS.
    #[serde(default)]
    pub recognition: Recognition,
    /// The bit rates of the device, with their codes.
    #[serde(default, rename = "bit_rate")]
    pub bit_rates: Vec<BitRate>,
    /// The times of the device.
    #[serde(default)]
    pub timing: Timing,
    /// The non-volatile storage of the device.
    #[serde(default)]
    pub storage: Storage,
    /// The behaviour of the device's application, as its profile has read it.
    #[serde(default)]
    pub application: ApplicationSheet,
    /// Values of objects that have no default in the EDS.
    #[serde(default, rename = "value")]
    pub values: Vec<Value>,
    /// Objects whose values depend on each other.
    #[serde(default, rename = "link")]
    pub links: Vec<Link>,
    /// Values that objects refuse.
    #[serde(default, rename = "check")]
    pub checks: Vec<Check>,
    /// Objects of the manufacturer that act when they are written, and so are no settings.
    #[serde(default)]
    pub(super) acts: Vec<ActingRow>,
    /// Objects that repeat another object for comparison.
    #[serde(default)]
    pub(super) checked: Vec<CheckedRow>,
    /// The EMCY messages that the manual lists.
    #[serde(default, rename = "emergency")]
    pub emergencies: Vec<Emergency>,
    /// The LMT address; `None` if the device has no LMT slave.
    pub lmt: Option<LmtAddress>,
    /// Documented differences from the standards.
    #[serde(default)]
    pub quirks: Quirks,
    /// For people: the version of the schema of sheets.
    #[serde(default)]
    pub schema: ForPeople,
    /// For people: the file of the EDS.
    #[serde(default)]
    pub eds: ForPeople,
    /// For people: the profile, and the versions of the standards.
    #[serde(default)]
    pub profile: ForPeople,
    /// For people: the maker's products that the model represents.
    #[serde(default)]
    pub stands_for: ForPeople,
    /// For people: contradictions of the manual with itself or with the standard.
    #[serde(default, rename = "erratum")]
    pub errata: ForPeople,
    /// The manual: read together with the deviations.
    #[serde(default)]
    pub manual: ForPeople,
    /// Documented differences from the standard: read separately from the rest of the sheet.
    #[serde(default, rename = "deviation")]
    pub deviations: ForPeople,
    /// The units of objects.
    #[serde(default, rename = "signal")]
    pub(super) signals: Vec<Signal>,
    /// The names of values of objects.
    #[serde(default, rename = "choice")]
    pub(super) choices: Vec<Choice>,
    /// The names of bits of objects.
    #[serde(default, rename = "bit")]
    pub(super) bits: Vec<Bit>,
    /// Bits of objects that have no meaning in the device.
    #[serde(default)]
    pub(super) unused: Vec<Unused>,
    /// The objects that PDOs carry in another form than their data type tells.
    #[serde(default)]
    pub(super) mapped: Vec<Mapped>,
}

impl Sheet {
    /// The abort code of this device if a write to an object breaks a rule.
    pub fn abort(&self, rule: Rule, at: Multiplexer) -> AbortCode {
        self.check(rule, at).map_or(rule.standard_abort(), |check| check.abort)
    }

    /// The row `[[check]]` that applies a rule to an object.
    pub fn check(&self, rule: Rule, at: Multiplexer) -> Option<&Check> {
        self.checks.iter().find(|check| check.rule == rule && check.at.contains(at))
    }

    /// The facts that the analyzer uses.
    pub(super) fn manual_facts(&self) -> Manual {
        Manual {
            annotations: self.annotations(),
            settings: self.settings(),
            emergencies: self.emergencies.iter().map(Emergency::known).collect(),
            checked: self.checked.iter().map(CheckedRow::known).collect(),
            acting: self.acting(),
        }
    }

    /// The objects of the manufacturer that act when they are written.
    pub fn acting(&self) -> Vec<(Multiplexer, Acting)> {
        let stores = self.storage.bus_save_object.map(|at| (at, Acting::Stores));
        self.acts.iter().map(|row| (row.at, row.does.into())).chain(stores).collect()
    }

    /// The objects that set node-ID and bit rate, and further settings that the analyzer needs.
    fn settings(&self) -> Settings {
        let rate = |rate: &BitRate| Some((u32::from(rate.object_code?), rate.kbit.saturating_mul(1_000)));
        let shortest = |rate: &BitRate| Some((rate.kbit.saturating_mul(1_000), rate.minimum_pdo_cycle_ms?));
        Settings {
            node_id: self.network.node_id_object,
            bit_rate: self.network.bit_rate_object,
            bit_rates: self.bit_rates.iter().filter_map(rate).collect(),
            shortest_cycles: self.bit_rates.iter().filter_map(shortest).collect(),
            layer_management: self.network.lmt,
            padded_tpdos: self.network.padded_tpdos.clone(),
        }
    }
}

/// The three parts of an LMT address (CiA DS-205).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LmtAddress {
    /// The manufacturer name: up to seven characters.
    #[serde(deserialize_with = "lmt_name")]
    pub manufacturer_name: Seven,
    /// The product name: up to seven characters.
    #[serde(deserialize_with = "lmt_name")]
    pub product_name: Seven,
    /// The serial number: fourteen decimal digits.
    #[serde(deserialize_with = "lmt_serial_number")]
    pub serial_number: Seven,
}

/// A bit rate with its codes.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BitRate {
    /// The bit rate in kbit/s.
    pub kbit: u32,
    /// The code of the bit rate in the device's own object.
    pub object_code: Option<u8>,
    /// The code of the bit rate in LSS; `None`: not selectable by LSS.
    pub lss_code: Option<u8>,
    /// The shortest event timer of TPDOs at this bit rate.
    pub minimum_pdo_cycle_ms: Option<u32>,
    /// For people: whether PDOs may be sent on change at this bit rate.
    #[serde(default)]
    pub sends_on_change: ForPeople,
}

/// The times of a device.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Timing {
    /// The time from power-on or reset to the boot-up message.
    pub boot_ms: u64,
    /// The shortest time from an SDO request to its response.
    pub sdo_response_us: u64,
    /// The largest random addition to the response time.
    pub sdo_response_jitter_us: u64,
    /// The time that writing the non-volatile memory takes.
    pub store_ms: u64,
    /// The time after which the SDO server ends a transfer whose client is silent.
    pub sdo_timeout_ms: u64,
    /// For people: the values of this table that the manual does not give.
    pub assumed: ForPeople,
    /// For people: the interval between measurements of the temperature.
    pub temperature_update_s: ForPeople,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            boot_ms: 250,
            sdo_response_us: 1_000,
            sdo_response_jitter_us: 100,
            store_ms: 14,
            sdo_timeout_ms: 1_000,
            assumed: ForPeople,
            temperature_update_s: ForPeople,
        }
    }
}

impl Timing {
    /// The time from power-on or reset to the boot-up message.
    pub const fn boot(&self) -> Duration {
        Duration::from_millis(self.boot_ms)
    }

    /// The shortest time from an SDO request to its response.
    pub const fn sdo_response(&self) -> Duration {
        Duration::from_micros(self.sdo_response_us)
    }

    /// The time that writing the non-volatile memory takes.
    pub const fn store(&self) -> Duration {
        Duration::from_millis(self.store_ms)
    }

    /// The time after which the SDO server ends a transfer whose client is silent.
    pub(crate) const fn sdo_timeout(&self) -> Duration {
        Duration::from_millis(self.sdo_timeout_ms)
    }
}

/// The non-volatile storage of a device: its commands and objects.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Storage {
    /// The signature that stores the parameters when it is written to 1010h.
    pub save_signature: u32,
    /// The signature that restores the defaults when it is written to 1011h.
    pub load_signature: u32,
    /// The abort code for any other signature.
    pub wrong_signature_abort: u32,
    /// The object that stores `bus_objects` when the save signature is written to it.
    #[serde(deserialize_with = "address_option")]
    pub bus_save_object: Option<Multiplexer>,
    /// Node-ID, bit rate and related objects. 1010h stores them only if there is no `bus_save_object`.
    #[serde(deserialize_with = "addresses")]
    pub bus_objects: Vec<Multiplexer>,
    /// Objects that are stored as soon as they are written.
    #[serde(deserialize_with = "addresses")]
    pub persist_at_once: Vec<Multiplexer>,
    /// For people: the values of this table that the manual does not give.
    pub assumed: ForPeople,
    /// For people: the object that restores the defaults.
    pub load_object: ForPeople,
    /// For people: the object that stores the parameters.
    pub save_object: ForPeople,
    /// For people: when the device loads the stored values.
    pub stored_values_load: ForPeople,
}

impl Default for Storage {
    fn default() -> Self {
        Self {
            save_signature: u32::from_le_bytes(*b"save"),
            load_signature: u32::from_le_bytes(*b"load"),
            wrong_signature_abort: 0x0800_0020,
            bus_save_object: None,
            bus_objects: Vec::new(),
            persist_at_once: Vec::new(),
            assumed: ForPeople,
            load_object: ForPeople,
            save_object: ForPeople,
            stored_values_load: ForPeople,
        }
    }
}

/// An object with its inverse and its checksum.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CheckedRow {
    #[serde(deserialize_with = "address")]
    at: Multiplexer,
    /// The object whose value has all bits of `at` inverted.
    #[serde(default, deserialize_with = "address_option")]
    inverse: Option<Multiplexer>,
    /// The object with the CRC-CCITT over the four bytes.
    #[serde(default, deserialize_with = "address_option")]
    crc: Option<Multiplexer>,
    #[serde(default)]
    crc_start: u16,
}

impl CheckedRow {
    const fn known(&self) -> Checked {
        Checked { value: self.at, inverse: self.inverse, crc: self.crc, crc_start: self.crc_start }
    }
}

/// An object that acts when it is written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ActingRow {
    #[serde(deserialize_with = "address")]
    at: Multiplexer,
    does: Does,
}

/// The effect of writing an object.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Does {
    /// The object carries out a command.
    Command,
    /// The object moves the zero point of a position or an angle.
    ZeroPoint,
}

impl From<Does> for Acting {
    fn from(does: Does) -> Self {
        match does {
            Does::Command => Self::Commands,
            Does::ZeroPoint => Self::MovesZeroPoint,
        }
    }
}

/// The value of an object that has no default in the EDS.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Value {
    /// The object.
    #[serde(deserialize_with = "address")]
    pub at: Multiplexer,
    /// The value: a number or a text.
    pub value: toml::Value,
    /// For people: the meaning of the value.
    #[serde(default)]
    pub note: ForPeople,
}

impl Value {
    /// The value of an object: a number or a text.
    pub(crate) fn new(at: Multiplexer, value: impl Into<toml::Value>) -> Self {
        Self { at, value: value.into(), note: ForPeople }
    }
}

fn lmt_name<'de, D: Deserializer<'de>>(from: D) -> Result<Seven, D::Error> {
    let name = String::deserialize(from)?;
    Seven::name(&name).ok_or_else(|| de::Error::custom(format!("expected up to 7 characters, found \"{name}\"")))
}

fn lmt_serial_number<'de, D: Deserializer<'de>>(from: D) -> Result<Seven, D::Error> {
    let text = String::deserialize(from)?;
    let digit = |at: usize| text.as_bytes().get(at).filter(|byte| byte.is_ascii_digit()).map(|byte| byte - b'0');
    let pair = |n: usize| Some(digit(2 * n)? << 4 | digit(2 * n + 1)?);
    let bytes: Option<Vec<u8>> = (0..7).map(pair).collect();
    bytes
        .filter(|_| text.len() == 14)
        .and_then(|bytes| bytes.try_into().ok())
        .map(Seven)
        .ok_or_else(|| de::Error::custom(format!("expected 14 decimal digits, found \"{text}\"")))
}

pub(super) fn parse_address<E: de::Error>(text: &str) -> Result<Multiplexer, E> {
    let parsed = text.split_once(':').and_then(|(index, sub)| {
        Some(Multiplexer::new(u16::from_str_radix(index, 16).ok()?, u8::from_str_radix(sub, 16).ok()?))
    });
    parsed.ok_or_else(|| E::custom(format!("expected \"index:sub\" in hexadecimal, found \"{text}\"")))
}

pub(super) fn address<'de, D: Deserializer<'de>>(from: D) -> Result<Multiplexer, D::Error> {
    parse_address(&String::deserialize(from)?)
}

pub(super) fn address_option<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Multiplexer>, D::Error> {
    address(from).map(Some)
}

pub(super) fn addresses<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Multiplexer>, D::Error> {
    Vec::<String>::deserialize(from)?.iter().map(|text| parse_address(text)).collect()
}
