//! `runs`: results of `canvass test` and `canvass fuzz`, with the values of their JSON.

use super::column::{Column, Rows, write_str};
use canvass_tables::columns;
use canvass_traces::Timestamp;
use serde_json::Value;

/// The rows of `runs`.
pub struct Runs;

/// A result.
pub struct RunRow<'a> {
    /// The name of the file.
    pub run: &'a str,
    /// The SHA-256 of the file in hexadecimal.
    pub sha256: &'a str,
    /// The document.
    pub document: &'a Value,
    /// The date at which the run began; `None` if the result has no date.
    pub date: Option<Timestamp>,
}

impl Rows for Runs {
    type Row<'a> = RunRow<'a>;
    const COLUMNS: &'static [Column<Self>] = columns![Self:
        "run" name "the file" = |row, out| write_str(out, Some(row.run));
        "sha256" text "its SHA-256 in hexadecimal" = |row, out| write_str(out, Some(row.sha256));
        "kind" word "`test` or `fuzz`" = |row| Some(kind(row.document));
        "t" time "when it began; null of a simulated run without a date" = |row| row.date;
        "version" name "of canvass" = |row, out| write_str(out, row.document["provenance"]["version"].as_str());
        "host" name "the computer" = |row, out| write_str(out, row.document["provenance"]["host"]["name"].as_str());
        "bus" name "the bus's address" = |row, out| write_str(out, row.document["bus"].as_str());
        "bit_rate" u32 "in bit/s" = |row| row.document["bit_rate"].as_u64();
        "node" u8 "the node-ID" = |row| row.document["node"].as_u64();
        "model" name "the model or description that was said" = |row, out| write_str(out, row.document["model"].as_str());
        "vendor_id" u32 "1018h:01, as the device says" = |row| row.device()["vendor_id"].as_u64();
        "product_code" u32 "1018h:02" = |row| row.device()["product_code"].as_u64();
        "revision_number" u32 "1018h:03" = |row| row.device()["revision_number"].as_u64();
        "serial_number" u32 "1018h:04" = |row| row.device()["serial_number"].as_u64();
        "name" name "1008h" = |row, out| write_str(out, row.device()["name"].as_str());
        "hardware_version" name "1009h" = |row, out| write_str(out, row.device()["hardware_version"].as_str());
        "software_version" name "100Ah" = |row, out| write_str(out, row.device()["software_version"].as_str());
        "seed" u64 "the seed of what was left to chance" = |row| row.document["seed"].as_u64();
        "cancelled" flag "whether it was interrupted" = |row| row.document["cancelled"].as_bool();
        "duration_ns" i64 "how long it took" = |row| row.document["duration_ns"].as_i64();
        "stores" u64 "how often the device was told to write its non-volatile memory" = |row| row.document["stores"].as_u64();
        "executions" u64 "of `fuzz`: how many sequences were sent" = |row| row.document["executions"].as_u64();
        "violations" u64 "of `fuzz`: how many properties were broken" = |row| row.document["violations"].as_array().map(|all| all.len() as u64);
        "pass" u64 "of `test`: cases with that verdict" = |row| row.count("pass");
        "tolerated" u64 "the same" = |row| row.count("tolerated");
        "deviation" u64 "the same" = |row| row.count("deviation");
        "fail" u64 "the same" = |row| row.count("fail");
        "inconclusive" u64 "the same" = |row| row.count("inconclusive");
        "not_applicable" u64 "the same" = |row| row.count("not_applicable");
        "error" u64 "the same" = |row| row.count("error");
    ];
}

/// The name of the contract of a result, without its version.
pub fn kind(document: &Value) -> &'static str {
    if document["schema"].as_str().is_some_and(|schema| schema.starts_with("canvass/fuzz/")) { "fuzz" } else { "test" }
}

impl RunRow<'_> {
    /// The device's own identity data.
    fn device(&self) -> &Value {
        match &self.document["device"] {
            Value::Null => &self.document["provenance"]["devices"][0],
            device => device,
        }
    }

    fn count(&self, verdict: &str) -> Option<u64> {
        self.document["summary"][verdict].as_u64()
    }
}
