//! One JSON document: [`EdsCheckResult`].

use super::{CheckedFile, Counts, Located, LocatedEdit};
use crate::results::eds_check::{Edit, Finding, Fix, Summary};
use crate::results::{Contract, EdsCheckResult};

/// The findings in all files.
pub fn document(files: &[CheckedFile]) -> EdsCheckResult {
    let counts = Counts::of(files);
    let findings = files.iter().flat_map(|file| file.findings.iter().map(|located| finding(file, located)));
    EdsCheckResult {
        findings: findings.collect(),
        schema: EdsCheckResult::SCHEMA.into(),
        summary: Summary {
            errors: counts.errors,
            files: files.len(),
            hints: counts.hints,
            mendable: counts.fixable,
            waived: counts.waived,
            warnings: counts.warnings,
        },
    }
}

fn finding(file: &CheckedFile, located: &Located) -> Finding {
    let finding = &located.finding;
    let problem = &finding.problem;
    let place = |number: u32| (finding.line > 0).then_some(number);
    Finding {
        clause: problem.rule.clause.bare(),
        clause_confidence: problem.rule.clause.confidence.name().into(),
        column: place(finding.column),
        end_column: place(located.end_column),
        end_line: place(located.end_line),
        expected: problem.expected.to_string(),
        field: problem.field.to_string(),
        file: file.name.clone(),
        fix: finding
            .fix
            .as_ref()
            .map(|fix| Fix { edits: located.edits.iter().map(edit).collect(), title: fix.title.to_string() }),
        found: problem.found.to_string(),
        line: place(finding.line),
        message: located.message(),
        rule: problem.rule.id.into(),
        section: problem.section.to_string(),
        severity: finding.severity().name().into(),
        waived: finding.waived.clone(),
    }
}

fn edit(edit: &LocatedEdit) -> Edit {
    let ((line, column), (end_line, end_column)) = (edit.start, edit.end);
    Edit { column, end_column, end_line, line, text: edit.text.clone() }
}
