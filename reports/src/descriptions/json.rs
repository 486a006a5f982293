//! One JSON object (`docs/json.md`).

use super::{CheckedFile, Counts, Located};
use serde_json::{Value, json};

/// The name and version of the contract.
pub const SCHEMA: &str = "canvass/eds-check/1";

/// What was found in all files.
pub fn document(files: &[CheckedFile]) -> Value {
    let counts = Counts::of(files);
    let findings: Vec<Value> =
        files.iter().flat_map(|file| file.findings.iter().map(|located| finding(file, located))).collect();
    json!({
        "schema": SCHEMA,
        "summary": {
            "files": files.len(),
            "errors": counts.errors,
            "warnings": counts.warnings,
            "hints": counts.hints,
            "waived": counts.waived,
            "mendable": counts.fixable,
        },
        "findings": findings,
    })
}

fn finding(file: &CheckedFile, located: &Located) -> Value {
    let finding = &located.finding;
    let problem = &finding.problem;
    let place = |number: u32| (finding.line > 0).then_some(number);
    let fix = finding.fix.as_ref().map(|fix| {
        let edits = located.edits.iter().map(|edit| {
            json!({
                "line": edit.start.0,
                "column": edit.start.1,
                "end_line": edit.end.0,
                "end_column": edit.end.1,
                "text": edit.text,
            })
        });
        json!({ "title": fix.title, "edits": edits.collect::<Vec<_>>() })
    });
    json!({
        "rule": problem.rule.id,
        "severity": finding.severity().name(),
        "file": file.name,
        "line": place(finding.line),
        "column": place(finding.column),
        "end_line": place(located.end_line),
        "end_column": place(located.end_column),
        "section": problem.section,
        "field": problem.field,
        "message": located.message(),
        "expected": problem.expected,
        "found": problem.found,
        "clause": problem.rule.clause.bare(),
        "clause_confidence": problem.rule.clause.confidence.name(),
        "fix": fix,
        "waived": finding.waived,
    })
}
