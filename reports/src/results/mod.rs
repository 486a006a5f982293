//! The types of the commands' JSON results. Each type serves to write and to read a result, and its JSON Schema in
//! `docs/schemas` is made from it.
//!
//! Contract: all numbers are JSON numbers, and times are integer nanoseconds. Within a version of the schema members
//! may be added, and no member changes its meaning. An older result, which lacks an added member, is read with a
//! default.

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

/// A name that canvass itself gives, which needs no allocation when a result is written.
pub type Word = Cow<'static, str>;

/// A document that names its contract in the member `schema`.
pub trait Contract: Serialize {
    /// The name and version of the contract: `canvass/test/1`.
    const SCHEMA: &'static str;
    /// The command that prints the document.
    const COMMAND: &'static str;
}

/// Why a text is no such result.
#[derive(Debug, thiserror::Error)]
pub enum NotAResult {
    /// The text is no JSON, or lacks members of the result.
    #[error("expected a result of `{command} --format json`: {error}")]
    Unreadable {
        command: &'static str,
        #[source]
        error: serde_json::Error,
    },
    /// The document has another contract, or a later version, whose members may have other meanings.
    #[error("expected a document of schema {expected}, found {found}")]
    Schema { expected: &'static str, found: String },
}

/// Reads a result. The schema is checked first, so that the error for another document names its schema and not a
/// missing member.
///
/// # Errors
/// [`NotAResult`] if the text is no such result.
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
/// The errors of `out`.
pub fn write(result: &impl Contract, out: &mut dyn Write) -> io::Result<()> {
    serde_json::to_writer_pretty(JsonText(&mut *out), result)?;
    out.write_all(b"\n")
}
