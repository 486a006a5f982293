//! `verdicts`: the verdict of each case of a conformance run, and each violation of a fuzzing run.

use super::column::{Column, Rows, write, write_str};
use super::runs::{RunRow, kind};
use canvass_tables::columns;
use serde_json::Value;

/// The rows of `verdicts`.
pub struct Verdicts;

/// A case or a violation.
pub struct VerdictRow<'a> {
    /// The result that holds the verdict.
    pub of: &'a RunRow<'a>,
    /// The case or the violation.
    pub case: &'a Value,
}

impl Rows for Verdicts {
    type Row<'a> = VerdictRow<'a>;
    const COLUMNS: &'static [Column<Self>] = columns![Self:
        "run" name "the file" = |row, out| write_str(out, Some(row.of.run));
        "t" time "when the run began" = |row| row.of.date;
        "kind" word "`test` or `fuzz`" = |row| Some(kind(row.of.document));
        "id" name "the case, or the property of a fuzzer's run" = |row, out| write_str(out, row.id());
        "clause" name "the clause of the standard" = |row, out| write_str(out, row.case["clause"].as_str());
        "level" name "`must`, `should`, ..." = |row, out| write_str(out, row.case["level"].as_str());
        "verdict" name "the verdict; of a broken property `fail`" = |row, out| write_str(out, row.verdict());
        "flaky" flag "whether its repetitions differed" = |row| row.case["flaky"].as_bool();
        "quarantined" flag "whether its failure does not count yet" = |row| row.is_test().then(|| !row.case["quarantine"].is_null());
        "duration_ns" i64 "how long it took" = |row| row.case["duration_ns"].as_i64();
        "duty" text "what was to be done" = |row, out| write_str(out, row.case["reason"]["duty"].as_str());
        "expected" text "what was expected" = |row, out| write_str(out, row.reason("expected"));
        "actual" text "what happened instead" = |row, out| write_str(out, row.reason("actual"));
        "documented" text "what the device's manual or a waiver says of it" = |row, out| write_str(out, row.case["documented"].as_str());
        "breaches" u32 "how many breaches there were" = |row| row.case["breaches"].as_array().map(|all| all.len() as u64);
        "measurements" text "what was measured: a JSON array" = |row, out| match row.case["measurements"].as_array() {
            Some(measured) if !measured.is_empty() => write(out, Some(&row.case["measurements"])),
            _ => false,
        };
    ];
}

impl VerdictRow<'_> {
    fn is_test(&self) -> bool {
        kind(self.of.document) == "test"
    }

    fn id(&self) -> Option<&str> {
        self.case["id"].as_str().or_else(|| self.case["property"].as_str())
    }

    fn verdict(&self) -> Option<&str> {
        if self.is_test() { self.case["verdict"].as_str() } else { Some("fail") }
    }

    fn reason(&self, part: &str) -> Option<&str> {
        self.case["reason"][part].as_str().or_else(|| self.case[part].as_str())
    }
}
