//! The tables: their names and columns, and how rows of captures are made.
//!
//! This is the only definition of the schema: Arrow, the lake, `\d` and the documentation all use it.

pub mod captures;
pub mod findings;
pub mod nodes;
pub mod runs;
pub mod statistics;
pub mod verdicts;

pub use canvass_tables::{builder, column, events, frames, messages, signals};
use column::{Column, Rows};
use datafusion::arrow::datatypes::{DataType, Field, Schema, SchemaRef};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The version of the schema: it is raised when a column changes its type or meaning, or is removed.
pub const SCHEMA_VERSION: u32 = 1;

/// The tables.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Table {
    /// Captures as a whole.
    Captures,
    /// Frames as they were recorded.
    Frames,
    /// Frames with their decoded meaning.
    Messages,
    /// Events caused by frames.
    Events,
    /// The values of process data.
    Signals,
    /// Problems found by the diagnosis.
    Findings,
    /// Nodes on the bus.
    Nodes,
    /// Frames, rates and load.
    Statistics,
    /// Results of tests.
    Runs,
    /// Verdicts of cases, and violations.
    Verdicts,
}

/// A column as the documentation shows it.
pub struct Described {
    /// The name and type of the column.
    pub field: Field,
    /// The meaning of the column.
    pub doc: &'static str,
}

impl Table {
    /// All tables.
    pub const ALL: [Self; 10] = [
        Self::Captures,
        Self::Frames,
        Self::Messages,
        Self::Events,
        Self::Signals,
        Self::Findings,
        Self::Nodes,
        Self::Statistics,
        Self::Runs,
        Self::Verdicts,
    ];

    /// The name of the table in SQL.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Captures => "captures",
            Self::Frames => "frames",
            Self::Messages => "messages",
            Self::Events => "events",
            Self::Signals => "signals",
            Self::Findings => "findings",
            Self::Nodes => "nodes",
            Self::Statistics => "statistics",
            Self::Runs => "runs",
            Self::Verdicts => "verdicts",
        }
    }

    /// The contents of the table, in a sentence.
    pub const fn doc(self) -> &'static str {
        match self {
            Self::Captures => "Captures as a whole: how far each can be trusted, and why one could not be read.",
            Self::Frames => "Frames as they were recorded. Nothing is decoded: the quickest table.",
            Self::Messages => "Every frame, understood: as `canvass decode` shows it.",
            Self::Events => {
                "Whole SDO transfers, states, errors, layer setting: as `canvass decode --events` shows them."
            }
            Self::Signals => "The values of process data, a row each.",
            Self::Findings => "What was wrong: as `canvass diagnose` shows it, of each capture alone.",
            Self::Nodes => "Who was there, with the identity that was read, and how each kept.",
            Self::Statistics => "Frames, rates and load of each channel, whole and by service.",
            Self::Runs => "Results of `canvass test` and `canvass fuzz`, from their JSON.",
            Self::Verdicts => "What came of each case of a run, and each property that a fuzzer's run has broken.",
        }
    }

    /// The table with this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|table| table.name() == name)
    }

    /// Whether the rows come from results of tests instead of captures.
    pub const fn is_of_results(self) -> bool {
        matches!(self, Self::Runs | Self::Verdicts)
    }

    /// The columns of the table.
    pub fn columns(self) -> Vec<Described> {
        match self {
            Self::Captures => described::<captures::Captures>(),
            Self::Frames => described::<frames::Frames>(),
            Self::Messages => described::<messages::Messages>(),
            Self::Events => described::<events::Events>(),
            Self::Signals => described::<signals::Signals>(),
            Self::Findings => described::<findings::Findings>(),
            Self::Nodes => described::<nodes::Nodes>(),
            Self::Statistics => described::<statistics::Statistics>(),
            Self::Runs => described::<runs::Runs>(),
            Self::Verdicts => described::<verdicts::Verdicts>(),
        }
    }

    /// The Arrow schema of the table.
    pub fn schema(self) -> SchemaRef {
        let fields: Vec<Field> = self.columns().into_iter().map(|column| column.field).collect();
        Arc::new(Schema::new(fields))
    }
}

fn described<R: Rows>() -> Vec<Described> {
    R::COLUMNS.iter().map(|column: &Column<R>| Described { field: column.field(), doc: column.doc }).collect()
}

/// The name of a type in the documentation.
pub const fn type_name(data_type: &DataType) -> &'static str {
    match data_type {
        DataType::Timestamp(..) => "time",
        DataType::UInt8 => "u8",
        DataType::UInt16 => "u16",
        DataType::UInt32 => "u32",
        DataType::UInt64 => "u64",
        DataType::Int64 => "i64",
        DataType::Float64 => "f64",
        DataType::Boolean => "boolean",
        DataType::Dictionary(..) => "name",
        DataType::Binary => "bytes",
        _ => "text",
    }
}

/// All tables as Markdown: a part of `docs/fleet.md`, which a test compares.
pub fn markdown() -> String {
    let mut text = String::new();
    for table in Table::ALL {
        text.push_str(&format!(
            "### `{}`\n\n{}\n\n| column | type | meaning |\n|---|---|---|\n",
            table.name(),
            table.doc()
        ));
        for column in table.columns() {
            let (name, kind) = (column.field.name(), type_name(column.field.data_type()));
            text.push_str(&format!("| `{name}` | {kind} | {} |\n", column.doc));
        }
        text.push('\n');
    }
    text
}
