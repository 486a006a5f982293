//! `canvass eds check`.

use super::{Contract, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The result of `canvass eds check`.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct EdsCheckResult {
    pub findings: Vec<Finding>,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    pub summary: Summary,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Summary {
    pub errors: usize,
    pub files: usize,
    pub hints: usize,
    pub mendable: usize,
    pub waived: usize,
    pub warnings: usize,
}

/// Places count from 1, columns in characters; they are `null` for what concerns no single line.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    pub clause: String,
    pub clause_confidence: Word,
    pub column: Option<u32>,
    /// The first character after it.
    pub end_column: Option<u32>,
    pub end_line: Option<u32>,
    pub expected: String,
    /// Field, or attribute of an XDD; empty where there is none.
    pub field: String,
    pub file: String,
    /// What fixes it without guessing; `null` if it can't be fixed so.
    pub fix: Option<Fix>,
    pub found: String,
    pub line: Option<u32>,
    pub message: String,
    /// The rule that is broken (`canvass list eds-rules`).
    pub rule: Word,
    /// Section, or element of an XDD; empty where there is none.
    pub section: String,
    /// `error`, `warning` or `hint`.
    pub severity: Word,
    /// The reason that the file gives for leaving it so.
    pub waived: Option<String>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Fix {
    /// None for a change of the character set.
    pub edits: Vec<Edit>,
    pub title: String,
}

/// A change of the text; the end is the first character that stays.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Edit {
    pub column: u32,
    pub end_column: u32,
    pub end_line: u32,
    pub line: u32,
    pub text: String,
}

impl Contract for EdsCheckResult {
    const SCHEMA: &'static str = "canvass/eds-check/1";
    const COMMAND: &'static str = "canvass eds check";
}
