//! SARIF 2.1.0, which code hosts and editors show beside the lines.

use super::fingerprint::{NAME, fingerprints};
use super::{CheckedFile, Located, LocatedEdit};
use crate::document::sarif::{log, uri};
use canvass_analyzer::dictionary::{Rule, Severity, rules};
use serde_json::{Value, json};

/// The findings in all files.
pub fn document(files: &[CheckedFile]) -> Value {
    let of_file = |file: &CheckedFile| -> Vec<Value> {
        let fingerprints = fingerprints(file).into_iter();
        file.findings.iter().zip(fingerprints).map(|(located, print)| result(file, located, &print)).collect()
    };
    let results: Vec<Value> = files.iter().flat_map(of_file).collect();
    let mut log = log(&rules::all().map(rule).collect::<Vec<_>>(), &results);
    log["runs"][0]["columnKind"] = json!("unicodeCodePoints");
    log
}

const fn level(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Hint => "note",
    }
}

fn rule(rule: &Rule) -> Value {
    json!({
        "id": rule.id,
        "shortDescription": { "text": rule.title() },
        "fullDescription": { "text": rule.what() },
        "help": { "text": rule.advice() },
        "defaultConfiguration": { "level": level(rule.severity) },
        "properties": { "clause": rule.clause.bare(), "clause_confidence": rule.clause.confidence.name() },
    })
}

fn result(file: &CheckedFile, located: &Located, fingerprint: &str) -> Value {
    let finding = &located.finding;
    let artifact = json!({ "uri": uri(&file.name) });
    let mut physical = json!({ "artifactLocation": artifact });
    if finding.line > 0 {
        physical["region"] = json!({
            "startLine": finding.line,
            "startColumn": finding.column,
            "endLine": located.end_line,
            "endColumn": located.end_column,
        });
    }
    let mut result = json!({
        "ruleId": finding.problem.rule.id,
        "ruleIndex": rules::all().position(|rule| rule == finding.problem.rule),
        "level": level(finding.severity()),
        "message": { "text": located.message() },
        "locations": [{ "physicalLocation": physical }],
        "partialFingerprints": { NAME: fingerprint },
    });
    if let Some(reason) = &finding.waived {
        let kind = if located.is_known { "external" } else { "inSource" };
        result["suppressions"] = json!([{ "kind": kind, "justification": reason }]);
    }
    if let (Some(fix), false) = (&finding.fix, located.edits.is_empty()) {
        let replacements: Vec<Value> = located.edits.iter().map(replacement).collect();
        let change = json!({ "artifactLocation": artifact, "replacements": replacements });
        result["fixes"] = json!([{ "description": { "text": fix.title }, "artifactChanges": [change] }]);
    }
    result
}

fn replacement(edit: &LocatedEdit) -> Value {
    json!({
        "deletedRegion": {
            "startLine": edit.start.0,
            "startColumn": edit.start.1,
            "endLine": edit.end.0,
            "endColumn": edit.end.1,
        },
        "insertedContent": { "text": edit.text },
    })
}
