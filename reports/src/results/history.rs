//! `canvass history`.

use super::{Contract, Provenance, Verdict, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The result of `canvass history`. Bad is *fail*, *error* or *inconclusive*.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct HistoryResult {
    /// By rising id.
    pub cases: Vec<Case>,
    pub provenance: Provenance,
    /// In the order in which they were given.
    pub releases: Vec<Release>,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
}

/// A release.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Release {
    /// Whether a run of it did not come to its end.
    pub cancelled: bool,
    pub name: String,
    /// The number of its results.
    pub samples: usize,
    /// What its devices call their software, each once.
    pub software: Vec<String>,
}

/// A case over the releases, which stand here by their names.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Case {
    /// Those in which it became bad: bad, and good or not there in the one before.
    pub became_bad: Vec<String>,
    pub became_good: Vec<String>,
    pub first_bad: Option<String>,
    /// Whether it did not always end the same way in a release.
    pub flaky: bool,
    /// The release from which on it did not run any more.
    pub gone_in: Option<String>,
    pub id: String,
    /// The release in which it first ran, if that is not the first one.
    pub new_in: Option<String>,
    /// One for each release.
    pub releases: Vec<Cell>,
    /// Of `became_bad` those in which it had been bad before, and fixed.
    pub returned: Vec<String>,
}

/// A case in a release.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct Cell {
    /// The longest of its durations.
    pub duration_ns: Option<u64>,
    /// Whether it did not always end the same way.
    pub flaky: bool,
    /// The longest of each of its measured times, by name.
    pub times_ns: BTreeMap<String, u64>,
    /// The worst of its samples; `null` where it did not run.
    pub verdict: Option<Verdict>,
}

impl Contract for HistoryResult {
    const SCHEMA: &'static str = "canvass/history/1";
    const COMMAND: &'static str = "canvass history";
}
