//! SARIF 2.1.0, which code hosts show as alerts: one result for each case that did not pass.
//!
//! The device is tested and not its source, but code hosts refuse a result without a file: the tested object stands in its
//! place. The fingerprint is the id of the case, so that an alert stays the same alert in later runs.

use super::Document;
use super::junit::{Case, Outcome, Problem};
use crate::escape::printable;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{self, Write};

/// A log with one run of canvass: its rules, and a result for each problem.
pub(crate) fn log(rules: &[Value], results: &[Value]) -> Value {
    json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": { "name": "canvass", "version": env!("CARGO_PKG_VERSION"), "rules": rules } },
            "results": results,
        }],
    })
}

/// Writes the cases that did not pass.
///
/// # Errors
/// The errors of `out`.
pub(super) fn render(document: &Document, out: &mut dyn Write) -> io::Result<()> {
    let failed: Vec<(&Case, &Problem, &str)> =
        document.suites.iter().flat_map(super::junit::Suite::cases).filter_map(failed).collect();
    let ids: BTreeSet<String> = failed.iter().map(|(case, ..)| rule_id(case)).collect();
    let rules: Vec<Value> = ids.iter().map(|id| json!({ "id": id })).collect();
    let results: Vec<Value> =
        failed.iter().map(|(case, problem, level)| result(document, case, problem, level)).collect();
    let mut sarif = log(&rules, &results);
    sarif["runs"][0]["automationDetails"] = json!({ "id": format!("canvass/{}", document.command) });
    serde_json::to_writer_pretty(&mut *out, &sarif)?;
    writeln!(out)
}

/// The problem of a case that did not pass, and its level. A case that was left out has no problem.
fn failed(case: &Case) -> Option<(&Case, &Problem, &'static str)> {
    match &case.outcome {
        Outcome::Failed(problem) if problem.is_certain() => Some((case, problem, "error")),
        Outcome::Failed(problem) | Outcome::Error(problem) => Some((case, problem, "warning")),
        Outcome::Passed | Outcome::Skipped { .. } => None,
    }
}

fn rule_id(case: &Case) -> String {
    printable(&format!("{}/{}", case.family, case.name)).into_owned()
}

fn result(document: &Document, case: &Case, problem: &Problem, level: &str) -> Value {
    let id = rule_id(case);
    let text: Vec<_> = std::iter::once(&problem.message).chain(&problem.details).map(|line| printable(line)).collect();
    json!({
        "ruleId": id,
        "level": level,
        "message": { "text": text.join("\n") },
        "locations": [{
            "physicalLocation": {
                "artifactLocation": { "uri": uri(&document.title) },
                "region": { "startLine": 1 },
            },
            "logicalLocations": [{ "fullyQualifiedName": printable(&document.title), "kind": "module" }],
        }],
        "partialFingerprints": { "canvass/1": id },
    })
}

/// A path as a relative or absolute URI reference. Bytes with a meaning in a URI are percent-encoded.
pub(crate) fn uri(path: &str) -> String {
    let mut uri = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' | b'/' => uri.push(char::from(byte)),
            b'\\' if cfg!(windows) => uri.push('/'),
            // Writing to a string can't fail.
            _ => _ = write!(uri, "%{byte:02X}"),
        }
    }
    uri
}
