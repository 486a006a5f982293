//! `canvass history`.

use super::{Contract, Provenance, Verdict, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The result of `canvass history`. A case is bad if its verdict is *fail*, *error* or *inconclusive*.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct HistoryResult {
    /// The cases, by rising id.
    pub cases: Vec<Case>,
    pub provenance: Provenance,
    /// The releases, in the order in which they were given.
    pub releases: Vec<Release>,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
}

/// A release.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Release {
    /// Whether a run of the release did not reach its end.
    pub cancelled: bool,
    pub name: String,
    /// Number of results of the release.
    pub samples: usize,
    /// The software versions that the devices report, each once.
    pub software: Vec<String>,
}

/// The verdicts of a case over the releases, which are given by their names.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Case {
    /// The releases in which the case became bad: it is bad there, and was good or missing in the release before.
    pub became_bad: Vec<String>,
    pub became_good: Vec<String>,
    pub first_bad: Option<String>,
    /// Whether the case ended differently in samples of one release.
    pub flaky: bool,
    /// The release from which on the case did not run any more.
    pub gone_in: Option<String>,
    pub id: String,
    /// The release in which the case first ran, if that is not the first release.
    pub new_in: Option<String>,
    /// The case in each release.
    pub releases: Vec<Cell>,
    /// The releases among `became_bad` in which the case was bad again after it had been fixed.
    pub returned: Vec<String>,
}

/// A case in a release.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct Cell {
    /// The longest duration of the case in the samples.
    pub duration_ns: Option<u64>,
    /// Whether the case ended differently in the samples.
    pub flaky: bool,
    /// The longest of each measured time of the case, by name.
    pub times_ns: BTreeMap<String, u64>,
    /// The worst verdict of the samples; `null` if the case did not run.
    pub verdict: Option<Verdict>,
}

impl Contract for HistoryResult {
    const SCHEMA: &'static str = "canvass/history/1";
    const COMMAND: &'static str = "canvass history";
}
