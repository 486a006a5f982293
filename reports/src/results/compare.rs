//! `canvass compare`.

use super::{Contract, Provenance, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The result of `canvass compare`.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct CompareResult {
    /// The changes, the worst first.
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
    /// Cases that failed before and that a waiver excuses now.
    #[serde(default)]
    pub waived: usize,
    pub worse: usize,
}

/// A change. Its texts come from the device or a file and may contain any characters.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Change {
    pub direction: Direction,
    /// The kind of the change: `verdict`, `timing`, `identity`, `dictionary` or `run`.
    pub kind: Word,
    /// The new value; `null` if the subject no longer exists.
    pub new: Option<String>,
    /// The old value; `null` if the subject did not exist before.
    pub old: Option<String>,
    /// Why a case no longer passes.
    pub reason: Option<String>,
    /// For a case that got worse and had been fixed: the latest earlier release in which the case was bad.
    pub returned: Option<String>,
    /// The case, measurement or object.
    pub subject: String,
}

/// The direction of a change.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// The new value is worse.
    Worse,
    /// The case failed before, and a waiver excuses it now.
    Waived,
    /// The new value is better.
    Better,
    /// The new value is neither worse nor better.
    Other,
}

impl Contract for CompareResult {
    const SCHEMA: &'static str = "canvass/compare/1";
    const COMMAND: &'static str = "canvass compare";
}
