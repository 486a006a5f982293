//! The sheet of a device model, as its TOML file lays it out.

use super::annotations::{Bit, Choice, Signal};
use super::emergency::Emergency;
use super::quirks::Quirks;
use super::recognition::Recognition;
use super::rules::{Check, Link, Rule};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::Settings;
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
    /// The measurement.
    pub encoder: Option<Encoder>,
    /// Values that the EDS leaves open.
    #[serde(default, rename = "value")]
    pub values: Vec<Value>,
    /// Objects that hang together.
    #[serde(default, rename = "link")]
    pub links: Vec<Link>,
    /// Values that are refused.
    #[serde(default, rename = "check")]
    pub checks: Vec<Check>,
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

    /// How node-ID and bit rate are set.
    pub(super) fn settings(&self) -> Settings {
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

/// How the device is reached and which services it has.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// As delivered; `None` if it has to be set by LSS first.
    pub default_node_id: Option<u8>,
    /// As delivered.
    pub default_bit_rate_kbit: u32,
    /// The object that holds the node-ID to use.
    #[serde(default, deserialize_with = "address_option")]
    pub node_id_object: Option<Multiplexer>,
    /// The object that holds the code of the bit rate to use.
    #[serde(default, deserialize_with = "address_option")]
    pub bit_rate_object: Option<Multiplexer>,
    /// Whether there is an LMT slave, the forerunner of LSS.
    #[serde(default)]
    pub lmt: bool,
    /// What takes a new node-ID over.
    #[serde(default = "power_on_and_reset_node")]
    pub takes_effect: Vec<Trigger>,
    /// Whether there is an LSS slave.
    #[serde(default)]
    pub lss: bool,
    /// The NMT states in which LSS works; empty: in all.
    #[serde(default)]
    pub lss_states: Vec<String>,
    /// Whether entries of 1016h act only once they are stored: at the next boot-up, or when written again.
    #[serde(default)]
    pub heartbeat_consumer_needs_store: bool,
    /// Whether node guarding is answered.
    #[serde(default)]
    pub node_guarding: bool,
    /// Whether a boot-up message is sent.
    #[serde(default = "yes")]
    pub boot_up_message: bool,
    /// Whether TPDOs can be asked for by remote frames.
    #[serde(default)]
    pub rtr: bool,
    /// The transmission types of TPDOs, as ranges.
    #[serde(default = "all_transmission_types")]
    pub transmission_types: Vec<(u8, u8)>,
    /// The transmission types with which a TPDO is sent when a mapped value changes.
    #[serde(default = "event_of_manufacturer")]
    pub sent_on_change: Vec<u8>,
    /// The transmission types of RPDOs, as ranges.
    #[serde(default = "all_rpdo_transmission_types")]
    pub rpdo_transmission_types: Vec<(u8, u8)>,
    /// Whether the SDO server knows block transfers.
    #[serde(default)]
    pub sdo_block_transfer: bool,
    /// The abort code for a value of another length than its object's; `None`: one for too long, one for too short.
    pub sdo_length_abort: Option<u32>,
    /// The TPDOs, from 1, whose frames are filled up with zeros to 8 bytes.
    #[serde(default)]
    pub padded_tpdos: Vec<u8>,
    /// Whether SYNC can be produced (1005h bit 30).
    #[serde(default)]
    pub sync_producer: bool,
    /// The shortest time of 1006h, in microseconds.
    #[serde(default = "shortest_sync_period")]
    pub sync_period_least_us: u32,
    /// Whether TIME can be consumed (1012h bit 31): 1013h follows it.
    #[serde(default)]
    pub time_consumer: bool,
    /// How often TIME is sent where 1012h bit 30 is set; `None`: it can't be produced.
    pub time_period_ms: Option<u64>,
    /// The object, a TIME_OF_DAY, that shows the device's clock.
    #[serde(default, deserialize_with = "address_option")]
    pub clock_object: Option<Multiplexer>,
    /// The object, of 64 bits, that shows the last EMCY received from a node of 1028h.
    #[serde(default, deserialize_with = "address_option")]
    pub received_emcy_object: Option<Multiplexer>,
    /// When 1F80h makes the device operational by itself.
    #[serde(default)]
    pub start_up: StartUp,
    /// What LSS "store configuration" answers: 0 success, 1 not supported, 2 no access to the storage medium.
    #[serde(default)]
    pub lss_store_error: u8,
    /// Whether a new node-ID makes the device restart as soon as LSS is back in waiting; else it waits for reset
    /// communication (CiA 305).
    #[serde(default = "yes")]
    pub lss_restarts: bool,
    /// For people: which of these values the manual does not say.
    #[serde(default)]
    pub assumed: ForPeople,
    /// For people: how many nodes 1016h watches.
    #[serde(default)]
    pub heartbeat_consumers: ForPeople,
    /// For people: whether there is a heartbeat.
    #[serde(default)]
    pub heartbeat_producer: ForPeople,
    /// For people: how many there are.
    #[serde(default)]
    pub rpdos: ForPeople,
    /// For people: how many there are.
    #[serde(default)]
    pub tpdos: ForPeople,
}

/// Which bits of 1F80h start the device.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartUp {
    /// The bits that count.
    pub mask: u32,
    /// Their values where the device starts by itself.
    pub value: u32,
}

impl Default for StartUp {
    /// CiA 302-2: bit 2 is 0.
    fn default() -> Self {
        Self { mask: 4, value: 0 }
    }
}

/// What makes a device take over what is configured.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trigger {
    /// Off and on again.
    PowerOn,
    /// NMT reset node.
    ResetNode,
    /// NMT reset communication.
    ResetCommunication,
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
    /// In kbit/s.
    pub kbit: u32,
    /// In the device's own object.
    pub object_code: Option<u8>,
    /// In LSS; `None`: not selectable.
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
    /// Writing it to 1010h stores.
    pub save_signature: u32,
    /// Writing it to 1011h restores the defaults.
    pub load_signature: u32,
    /// The abort code for any other value.
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

/// The measurement.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Encoder {
    /// What is measured.
    pub kind: EncoderKind,
    /// The resolution of one revolution, in bits.
    pub single_turn_bits: u8,
    /// The revolutions that can be told apart.
    pub revolutions: u32,
    /// Neither 6001h nor 6002h is smaller, but for the 0 of 6002h, which stands for 2^32.
    pub units_per_revolution_least: u32,
    /// Above it, 6505h bit 0 warns.
    pub speed_warning_rpm: Option<u32>,
    /// Whether the position goes on over the end of the physical range.
    pub universal_scaling: UniversalScaling,
    /// The bit of 6000h that makes the speed units per second instead of revolutions per minute.
    pub speed_format_bit: u8,
    /// The bits of 6000h that have a meaning in CiA 406 or in the manual; a write of others is refused.
    pub operating_bits: u16,
    /// Of a draw-wire encoder: the sum of its two channels, in 0.1 mm.
    pub full_scale_tenth_mm: u32,
    /// Of a draw-wire encoder: how far one turn of its drum moves the wire, in 0.1 mm.
    pub tenth_mm_per_revolution: u32,
    /// Of an inclinometer: how the housing hangs, in hundredths of a degree, clockwise.
    pub tilt_hundredths: i32,
    /// For people: which of these values the manual does not say.
    pub assumed: ForPeople,
    /// For people: over which times the speed is measured.
    pub integration_times_ms: ForPeople,
    /// For people: the finest resolution of the family.
    pub single_turn_bits_most: ForPeople,
    /// For people: what the speed is measured in.
    pub speed_unit: ForPeople,
    /// For people: the step of a linear scale.
    pub step_nm: ForPeople,
    /// For people: whether revolutions are counted.
    pub turns: ForPeople,
    /// For people: what 0 in 6002h means.
    pub zero_range_means_2_pow_32: ForPeople,
}

impl Default for Encoder {
    /// As CiA 406 V3.2 has it.
    fn default() -> Self {
        Self {
            kind: EncoderKind::Rotary,
            single_turn_bits: 0,
            revolutions: 1,
            units_per_revolution_least: 1,
            speed_warning_rpm: None,
            universal_scaling: UniversalScaling::ByBit12,
            speed_format_bit: 13,
            operating_bits: 0xF00F,
            full_scale_tenth_mm: 0,
            tenth_mm_per_revolution: 1,
            tilt_hundredths: 0,
            assumed: ForPeople,
            integration_times_ms: ForPeople,
            single_turn_bits_most: ForPeople,
            speed_unit: ForPeople,
            step_nm: ForPeople,
            turns: ForPeople,
            zero_range_means_2_pow_32: ForPeople,
        }
    }
}

/// What an encoder measures.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EncoderKind {
    /// The angle of a shaft, and its revolutions.
    Rotary,
    /// A place on a straight scale; its period counts as a revolution.
    Linear,
    /// The length of a wire, by two redundant channels, and the tilt of the housing.
    DrawWire,
}

/// When the universal scaling function works: any scaling, without a jump where the physical range ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UniversalScaling {
    /// As bit 12 of 6000h says.
    #[serde(rename = "by-bit-12")]
    ByBit12,
    /// Wherever scaling is on.
    Always,
    /// Not at all.
    Never,
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

const fn yes() -> bool {
    true
}

fn all_transmission_types() -> Vec<(u8, u8)> {
    vec![(0, 240), (252, 255)]
}

fn event_of_manufacturer() -> Vec<u8> {
    vec![254]
}

/// CiA 301: 241 to 253 are reserved for RPDOs.
fn all_rpdo_transmission_types() -> Vec<(u8, u8)> {
    vec![(0, 240), (254, 255)]
}

const fn shortest_sync_period() -> u32 {
    1_000
}

fn power_on_and_reset_node() -> Vec<Trigger> {
    vec![Trigger::PowerOn, Trigger::ResetNode]
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
