//! Results of `canvass test` and `canvass fuzz`.

use super::ScanError;
use super::emit::{Emitter, Outlet, Wanted};
use crate::capture::{Access, CaptureFile};
use crate::table::Table;
use crate::table::runs::{RunRow, Runs};
use crate::table::verdicts::{VerdictRow, Verdicts};
use canvass_traces::Timestamp;
use serde_json::Value;

/// Maximum number of bytes of a result: far more than any result has.
pub const LONGEST: u64 = 256 << 20;

/// Outputs the rows of a result; `false` if the file is no result.
///
/// # Errors
/// [`ScanError`] if the file can't be read.
pub fn produce(
    access: &Access,
    table: Table,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<bool, ScanError> {
    let (content, sha256) = access.read(file, LONGEST)?;
    let Some(document) = read(&content) else { return Ok(false) };
    give(&document, &sha256, table, file, wanted, outlet)?;
    Ok(true)
}

/// The document of a result, if it is one.
pub fn read(content: &[u8]) -> Option<Value> {
    let document: Value = serde_json::from_slice(content).ok()?;
    let schema = document["schema"].as_str()?;
    matches!(schema, "canvass/test/1" | "canvass/fuzz/1").then_some(document)
}

/// Outputs the rows of a parsed result.
///
/// # Errors
/// As [`Emitter::row`].
pub fn give(
    document: &Value,
    sha256: &str,
    table: Table,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<(), ScanError> {
    let row = RunRow { run: &file.name, sha256, document, date: date(document) };
    if table == Table::Runs {
        let mut emitter = Emitter::<Runs>::new(wanted, outlet);
        let _ = emitter.row(&row)?;
        return emitter.finish();
    }
    let mut emitter = Emitter::<Verdicts>::new(wanted, outlet);
    let parts = ["cases", "violations"].into_iter().filter_map(|part| document[part].as_array());
    for case in parts.flatten() {
        if emitter.row(&VerdictRow { of: &row, case })?.is_break() {
            break;
        }
    }
    emitter.finish()
}

/// The date at which a run began; `None` if the result has no date.
pub fn date(document: &Value) -> Option<Timestamp> {
    let date: jiff::Timestamp = document["provenance"]["date"].as_str()?.parse().ok()?;
    u64::try_from(date.as_nanosecond()).ok().map(Timestamp)
}
