//! What the commands print as JSON: one type for each result, from which it is written and read, and from which its JSON
//! Schema in `docs/schemas` is made.
//!
//! Contract: numbers are numbers, times are integer nanoseconds. Members may be added, with a default where results are
//! read; none changes its meaning within a version of the schema.

pub mod compare;
pub mod decode;
mod device;
pub mod diagnose;
pub mod eds_check;
pub mod fuzz;
pub mod history;
pub mod provenance;
pub mod quality;
pub mod schemas;
pub mod selftest;
pub mod test;
mod verdict;

pub use compare::CompareResult;
pub use decode::DecodeLine;
pub use device::Device;
pub use diagnose::DiagnoseResult;
pub use eds_check::EdsCheckResult;
pub use fuzz::FuzzResult;
pub use history::HistoryResult;
pub use provenance::Provenance;
pub use quality::QualityResult;
pub use selftest::{AloneSelftestResult, FuzzSelftestResult, NullSelftestResult, SelftestResult, WireSelftestResult};
pub use test::TestResult;
pub use verdict::Verdict;

use crate::escape::{JsonText, printable};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::io::{self, Write};

/// A name that canvass gives: not allocated where it is written.
pub type Word = Cow<'static, str>;

/// A document whose first member says what it is.
pub trait Contract: Serialize {
    /// Name and version: `canvass/test/1`.
    const SCHEMA: &'static str;
    /// The command that prints it.
    const COMMAND: &'static str;
}

/// What is no such result.
#[derive(Debug, thiserror::Error)]
pub enum NotAResult {
    /// No JSON, or not with the members of the result.
    #[error("expected a result of `{command} --format json`: {error}")]
    Unreadable {
        command: &'static str,
        #[source]
        error: serde_json::Error,
    },
    /// Another document, or a later version, which may mean something else.
    #[error("expected a document of schema {expected}, found {found}")]
    Schema { expected: &'static str, found: String },
}

/// Reads a result. Its schema is looked at first: the members of others would only be said to be wrong.
///
/// # Errors
/// [`NotAResult`].
pub fn read<T: Contract + DeserializeOwned>(text: &str) -> Result<T, NotAResult> {
    #[derive(Deserialize)]
    struct Named {
        schema: String,
    }
    let unreadable = |error| NotAResult::Unreadable { command: T::COMMAND, error };
    let Named { schema } = serde_json::from_str(text).map_err(unreadable)?;
    if schema != T::SCHEMA {
        return Err(NotAResult::Schema { expected: T::SCHEMA, found: printable(&schema).into_owned() });
    }
    serde_json::from_str(text).map_err(unreadable)
}

/// Writes a result, indented, with a line end.
///
/// # Errors
/// What `out` gives.
pub fn write(result: &impl Contract, out: &mut dyn Write) -> io::Result<()> {
    serde_json::to_writer_pretty(JsonText(&mut *out), result)?;
    out.write_all(b"\n")
}
