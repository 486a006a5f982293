//! The quality of captures: the output of `--quality json`.

use super::{Contract, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The quality of captures.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct QualityResult {
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    /// The captures, each with its quality.
    pub sources: Vec<Source>,
    /// The quality of all captures together.
    pub total: Quality,
}

/// A capture.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Source {
    pub format: Word,
    pub name: String,
    /// The origin of the times: `utc`, `local`, `start` or `none`.
    pub time_base: Word,
    #[serde(flatten)]
    pub quality: Quality,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Quality {
    pub channels: Vec<Channel>,
    pub clock_steps_back: Steps,
    /// Number of damages by kind.
    pub damages: BTreeMap<Word, u64>,
    pub duration_ns: u64,
    pub first_t: Option<u64>,
    pub frames: u64,
    pub gaps: Gaps,
    /// Number of frames by kind.
    pub kinds: BTreeMap<Word, u64>,
    pub last_t: Option<u64>,
    pub resolution_ns: Option<u64>,
    /// The warnings about the capture.
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
    /// The usual interval before the gap.
    pub usual_ns: u64,
}

/// A place in a capture.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Place {
    /// The number of the line or packet.
    pub number: u64,
    /// The offset in bytes.
    pub offset: u64,
    pub t: u64,
}

impl Contract for QualityResult {
    const SCHEMA: &'static str = "canvass/quality/1";
    const COMMAND: &'static str = "canvass decode --quality json";
}
