//! The member `provenance` of all results: the facts that a reader needs to trust a result and to repeat the run.

use super::{Device, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The provenance of a result.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Provenance {
    /// The bus that was used; `null` if canvass read files.
    pub bus: Option<Bus>,
    /// The date in the notation of RFC 3339; `null` for a simulated run without a given date.
    pub date: Option<String>,
    pub devices: Vec<NamedDevice>,
    pub files: Vec<File>,
    /// The computer on which canvass ran; `null` if only a simulated bus was used.
    pub host: Option<Host>,
    /// The notes that `--note` added, by their keys.
    pub notes: BTreeMap<String, String>,
    /// All options that affect the result.
    pub options: Vec<Choice>,
    /// The seed of all random choices.
    pub seed: Option<u64>,
    /// The version of canvass.
    pub version: Word,
    /// The name of the time zone.
    pub zone: Option<String>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Bus {
    /// The adapter that connects this computer to the bus.
    pub adapter: String,
    /// The address of the bus, as the user gave it.
    pub address: String,
    /// The bit rate in bit/s.
    pub bit_rate: Option<u32>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct NamedDevice {
    /// The name of the device: `node 63`, or in a comparison `old device` and `new device`.
    pub device: String,
    #[serde(flatten)]
    pub identity: Device,
}

/// A file that the result depends on, or that belongs to it.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct File {
    /// The length in bytes; `null` if the file can be read only once.
    pub bytes: Option<u64>,
    pub path: String,
    /// The role of the file: `description`, `waivers`, `recording` or `capture`.
    pub role: Word,
    /// The SHA-256 in hexadecimal; `null` if the file can be read only once.
    pub sha256: Option<String>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Host {
    pub name: String,
    /// The operating system.
    pub system: String,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Choice {
    /// The source of the value: `default`, `command-line`, `environment` or `settings`.
    pub by: Word,
    /// The default value.
    pub default: Vec<String>,
    /// The name of the option on the command line, without the leading hyphens.
    pub name: String,
    pub value: Vec<String>,
}
