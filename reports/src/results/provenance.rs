//! The member `provenance` of all results: what a reader needs to know to believe one, and to repeat it.

use super::{Device, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Where a result comes from.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Provenance {
    /// `null` where files were read.
    pub bus: Option<Bus>,
    /// As RFC 3339 writes it; `null` of a simulated run to which no date was given.
    pub date: Option<String>,
    pub devices: Vec<NamedDevice>,
    pub files: Vec<File>,
    /// `null` where only a simulated bus was needed.
    pub host: Option<Host>,
    /// What `--note` added, by its key.
    pub notes: BTreeMap<String, String>,
    /// All options that have to do with the result.
    pub options: Vec<Choice>,
    /// The seed of everything that was left to chance.
    pub seed: Option<u64>,
    /// The version of canvass.
    pub version: Word,
    /// The name of the time zone.
    pub zone: Option<String>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Bus {
    /// What connects this computer to the bus.
    pub adapter: String,
    /// As the user addressed it.
    pub address: String,
    /// In bit/s.
    pub bit_rate: Option<u32>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct NamedDevice {
    /// `node 63`; of a comparison `old device` and `new device`.
    pub device: String,
    #[serde(flatten)]
    pub identity: Device,
}

/// A file that the result depends on, or that belongs to it.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct File {
    /// Its length; `null` of what can't be read twice.
    pub bytes: Option<u64>,
    pub path: String,
    /// `description`, `waivers`, `recording`, `capture`.
    pub role: Word,
    /// In hexadecimal; `null` of what can't be read twice.
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
    /// Who chose the value: `default`, `command-line`, `environment`, `settings`.
    pub by: Word,
    /// The value where none is given.
    pub default: Vec<String>,
    /// The name of the option on the command line, without the leading hyphens.
    pub name: String,
    pub value: Vec<String>,
}
