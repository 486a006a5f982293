//! The sheet of a device model, as its TOML file lays it out.

use super::annotations::{Bit, Choice, Signal};
use super::emergency::Emergency;
use super::network::Network;
use super::profile::ApplicationSheet;
use super::quirks::Quirks;
use super::recognition::Recognition;
use super::rules::{Check, Link, Rule};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{Manual, Settings};
use canvass_analyzer::object::Acting;
use canvass_analyzer::wire::lmt::Seven;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::Duration;
use serde::de::IgnoredAny as ForPeople;
use serde::{Deserialize, Deserializer, de};

/// What an EDS cannot say about a device. A key that is not here is an error; what only people read is not looked at.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// The name on the command line.
    pub id: String,
    /// One line.
    pub summary: String,
    /// Node-ID, bit rate, services.
    pub network: Network,
    /// What tells the model, where the defaults of the EDS do not.
    #[serde(default)]
    pub recognition: Recognition,
    /// Bit rates by their codes.
    #[serde(default, rename = "bit_rate")]
    pub bit_rates: Vec<BitRate>,
    /// How long things take.
    #[serde(default)]
    pub timing: Timing,
    /// What is stored, and how.
    #[serde(default)]
    pub storage: Storage,
    /// The behaviour of the device's application, as read by its profile.
    #[serde(default)]
    pub application: ApplicationSheet,
    /// Values that the EDS leaves open.
    #[serde(default, rename = "value")]
    pub values: Vec<Value>,
    /// Objects that hang together.
    #[serde(default, rename = "link")]
    pub links: Vec<Link>,
    /// Values that are refused.
    #[serde(default, rename = "check")]
    pub checks: Vec<Check>,
    /// Objects of the manufacturer that act when they are written: no settings.
    #[serde(default)]
    pub(super) acts: Vec<ActingRow>,
    /// The EMCY messages of its manual.
    #[serde(default, rename = "emergency")]
    pub emergencies: Vec<Emergency>,
    /// The LMT address, where there is an LMT slave.
    pub lmt: Option<LmtAddress>,
    /// What it does otherwise than the standards.
    #[serde(default)]
    pub quirks: Quirks,
    /// For people: the version of this schema.
    #[serde(default)]
    pub schema: ForPeople,
    /// For people: the file of the EDS.
    #[serde(default)]
    pub eds: ForPeople,
    /// For people: the profile and the versions of the standards.
    #[serde(default)]
    pub profile: ForPeople,
    /// For people: for which products of the maker the model stands.
    #[serde(default)]
    pub stands_for: ForPeople,
    /// For people: where the manual contradicts itself or the standard.
    #[serde(default, rename = "erratum")]
    pub errata: ForPeople,
    /// Which manual it is: read with the deviations.
    #[serde(default)]
    pub manual: ForPeople,
    /// Differences from the standard: read beside the rest.
    #[serde(default, rename = "deviation")]
    pub deviations: ForPeople,
    /// Units.
    #[serde(default, rename = "signal")]
    pub(super) signals: Vec<Signal>,
    /// Names of values.
    #[serde(default, rename = "choice")]
    pub(super) choices: Vec<Choice>,
    /// Names of bits.
    #[serde(default, rename = "bit")]
    pub(super) bits: Vec<Bit>,
}

impl Sheet {
    /// The abort code of this device for a breach of a rule at that object.
    pub fn abort(&self, rule: Rule, at: Multiplexer) -> AbortCode {
        self.check(rule, at).map_or(rule.standard_abort(), |check| check.abort)
    }

    /// The row that gives that object that rule.
    pub fn check(&self, rule: Rule, at: Multiplexer) -> Option<&Check> {
        self.checks.iter().find(|check| check.rule == rule && check.at.contains(at))
    }

    /// What the analyzer takes of it.
    pub(super) fn manual_facts(&self) -> Manual {
        Manual {
            annotations: self.annotations(),
            settings: self.settings(),
            emergencies: self.emergencies.iter().map(Emergency::known).collect(),
            acting: self.acting(),
        }
    }

    /// Which objects of the manufacturer act when they are written.
    pub fn acting(&self) -> Vec<(Multiplexer, Acting)> {
        let stores = self.storage.bus_save_object.map(|at| (at, Acting::Stores));
        self.acts.iter().map(|row| (row.at, row.does.into())).chain(stores).collect()
    }

    /// How node-ID and bit rate are set.
    fn settings(&self) -> Settings {
        let rate = |rate: &BitRate| Some((u32::from(rate.object_code?), rate.kbit.saturating_mul(1_000)));
        Settings {
            node_id: self.network.node_id_object,
            bit_rate: self.network.bit_rate_object,
            bit_rates: self.bit_rates.iter().filter_map(rate).collect(),
            layer_management: self.network.lmt,
            padded_tpdos: self.network.padded_tpdos.clone(),
        }
    }
}

/// The three parts of an LMT address (CiA DS-205).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LmtAddress {
    /// Up to seven characters.
    #[serde(deserialize_with = "lmt_name")]
    pub manufacturer_name: Seven,
    /// Up to seven characters.
    #[serde(deserialize_with = "lmt_name")]
    pub product_name: Seven,
    /// Fourteen decimal digits.
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
    /// For people: how slow PDOs have to be at that bit rate.
    #[serde(default)]
    pub minimum_pdo_cycle_ms: ForPeople,
    /// For people: whether PDOs may be sent on change at that bit rate.
    #[serde(default)]
    pub sends_on_change: ForPeople,
}

/// How long things take.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Timing {
    /// From power-on or reset to the boot-up message.
    pub boot_ms: u64,
    /// From an SDO request to its response.
    pub sdo_response_us: u64,
    /// By how much responses come later than that, at most, by chance.
    pub sdo_response_jitter_us: u64,
    /// Writing the non-volatile memory.
    pub store_ms: u64,
    /// How long the SDO server waits for the next request of a transfer.
    pub sdo_timeout_ms: u64,
    /// For people: which of these values the manual does not say.
    pub assumed: ForPeople,
    /// For people: how often the temperature is measured.
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
    /// From power-on or reset to the boot-up message.
    pub const fn boot(&self) -> Duration {
        Duration::from_millis(self.boot_ms)
    }

    /// From an SDO request to its response.
    pub const fn sdo_response(&self) -> Duration {
        Duration::from_micros(self.sdo_response_us)
    }

    /// Writing the non-volatile memory.
    pub const fn store(&self) -> Duration {
        Duration::from_millis(self.store_ms)
    }

    /// How long the SDO server waits for the next request of a transfer.
    pub const fn sdo_timeout(&self) -> Duration {
        Duration::from_millis(self.sdo_timeout_ms)
    }
}

/// What is stored, and how.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Storage {
    /// The signature that stores the parameters when it is written to 1010h.
    pub save_signature: u32,
    /// The signature that restores the defaults when it is written to 1011h.
    pub load_signature: u32,
    /// The abort code for any other signature.
    pub wrong_signature_abort: u32,
    /// The object that stores `bus_objects` when the save signature is written.
    #[serde(deserialize_with = "address_option")]
    pub bus_save_object: Option<Multiplexer>,
    /// Node-ID, bit rate and what belongs to them. 1010h stores them only where there is no `bus_save_object`.
    #[serde(deserialize_with = "addresses")]
    pub bus_objects: Vec<Multiplexer>,
    /// Objects that are stored as soon as they are written.
    #[serde(deserialize_with = "addresses")]
    pub persist_at_once: Vec<Multiplexer>,
    /// For people: which of these values the manual does not say.
    pub assumed: ForPeople,
    /// For people: the object that restores.
    pub load_object: ForPeople,
    /// For people: the object that stores.
    pub save_object: ForPeople,
    /// For people: when stored values are loaded.
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

/// An object that acts when it is written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ActingRow {
    #[serde(deserialize_with = "address")]
    at: Multiplexer,
    does: Does,
}

/// What it does.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Does {
    /// Carries out a command.
    Command,
    /// Moves the zero point of a position or an angle.
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

/// The value of an object where the EDS has no default.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Value {
    /// The object.
    #[serde(deserialize_with = "address")]
    pub at: Multiplexer,
    /// A number.
    pub value: toml::Value,
    /// For people: what it is.
    #[serde(default)]
    pub note: ForPeople,
}

impl Value {
    /// A number or a text.
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
