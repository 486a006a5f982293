//! What captures hold and lack: `--quality json`.

use super::{Contract, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The quality of captures.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct QualityResult {
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    /// Each capture.
    pub sources: Vec<Source>,
    /// All captures together.
    pub total: Quality,
}

/// A capture.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Source {
    pub format: Word,
    pub name: String,
    /// What times count from: `utc`, `local`, `start` or `none`.
    pub time_base: Word,
    #[serde(flatten)]
    pub quality: Quality,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Quality {
    pub channels: Vec<Channel>,
    pub clock_steps_back: Steps,
    /// Damages by kind.
    pub damages: BTreeMap<Word, u64>,
    pub duration_ns: u64,
    pub first_t: Option<u64>,
    pub frames: u64,
    pub gaps: Gaps,
    /// Frames by kind.
    pub kinds: BTreeMap<Word, u64>,
    pub last_t: Option<u64>,
    pub resolution_ns: Option<u64>,
    /// What to be careful with.
    pub warnings: Vec<String>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Channel {
    pub frames: u64,
    pub name: String,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Steps {
    pub count: u64,
    pub first: Option<Place>,
    pub largest_ns: u64,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Gaps {
    pub count: u64,
    pub largest: Option<Gap>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Gap {
    pub end: Place,
    pub length_ns: u64,
    /// The longest that was usual.
    pub usual_ns: u64,
}

/// A place in a capture.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Place {
    /// Line or packet.
    pub number: u64,
    /// In bytes.
    pub offset: u64,
    pub t: u64,
}

impl Contract for QualityResult {
    const SCHEMA: &'static str = "canvass/quality/1";
    const COMMAND: &'static str = "canvass decode --quality json";
}
