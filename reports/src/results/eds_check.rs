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

/// A finding. Lines and columns (in characters) count from 1; they are `null` if no single line is concerned.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    pub clause: String,
    pub clause_confidence: Word,
    pub column: Option<u32>,
    /// The column of the first character after the place of the finding.
    pub end_column: Option<u32>,
    pub end_line: Option<u32>,
    pub expected: String,
    /// The field, or the attribute of an XDD; empty if the finding has none.
    pub field: String,
    pub file: String,
    /// The change that fixes the finding without guessing; `null` if there is none.
    pub fix: Option<Fix>,
    pub found: String,
    pub line: Option<u32>,
    pub message: String,
    /// The rule that is broken (`canvass list eds-rules`).
    pub rule: Word,
    /// The section, or the element of an XDD; empty if the finding has none.
    pub section: String,
    /// `error`, `warning` or `hint`.
    pub severity: Word,
    /// The reason with which the file waives the finding.
    pub waived: Option<String>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Fix {
    /// The changes of the text; empty for a change of the character set.
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
