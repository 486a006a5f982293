//! `canvass compare`.

use super::{Contract, Provenance, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The result of `canvass compare`.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct CompareResult {
    /// The worst first.
    pub changes: Vec<Change>,
    pub provenance: Provenance,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    pub summary: Summary,
}

/// The number of changes by direction.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Summary {
    pub better: usize,
    pub other: usize,
    pub worse: usize,
}

/// One difference. Texts come from the device or a file: they may hold anything.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Change {
    pub direction: Direction,
    /// `verdict`, `timing`, `identity`, `dictionary`, `run`.
    pub kind: Word,
    /// What it is; `null`: it is gone.
    pub new: Option<String>,
    /// What it was; `null`: it was not there.
    pub old: Option<String>,
    /// Why a case no longer passes.
    pub reason: Option<String>,
    /// Of a case that got worse: the earlier release in which it was bad last. It had been fixed since.
    pub returned: Option<String>,
    /// The case, measurement or object.
    pub subject: String,
}

/// Which way something changed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// It was better before.
    Worse,
    /// It is better now.
    Better,
    /// Neither.
    Other,
}

impl Contract for CompareResult {
    const SCHEMA: &'static str = "canvass/compare/1";
    const COMMAND: &'static str = "canvass compare";
}
