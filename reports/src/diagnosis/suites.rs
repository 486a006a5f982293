//! The rules for JUnit files. Each rule is a case, which fails if the rule has a finding that counts.

use super::{Diagnosed, frame, times};
use crate::document::junit::{Case, Outcome, Problem, Suite};
use canvass_analyzer::findings::{Finding, Metadata, Severity, all};

/// A suite for each family of rules. A finding less severe than `fail_on` passes, and the output contains its text.
pub fn of(diagnosed: &Diagnosed<'_>, fail_on: Option<Severity>) -> Vec<Suite> {
    let rules: Vec<&Metadata> = all().map(|definition| definition.metadata).collect();
    let suite = |rules: &[&Metadata]| {
        let mut suite = Suite::new(rules.first().map_or("", |rule| family(rule)));
        suite.add_properties(diagnosed.provenance.properties());
        suite.add_cases(rules.iter().map(|rule| case(diagnosed, rule, fail_on)));
        suite
    };
    rules.chunk_by(|a, b| family(a) == family(b)).map(suite).collect()
}

fn family(rule: &Metadata) -> &str {
    rule.id.split_once('/').map_or(rule.id, |parts| parts.0)
}

fn case(diagnosed: &Diagnosed<'_>, rule: &Metadata, fail_on: Option<Severity>) -> Case {
    let own: Vec<&Finding> = diagnosed.results.findings.iter().filter(|finding| finding.rule.id == rule.id).collect();
    let fails = |finding: &&&Finding| fail_on.is_some_and(|least| finding.severity >= least);
    let name = rule.id.split_once('/').map_or(rule.id, |parts| parts.1);
    let mut case = Case::passed(format!("canvass.{}", family(rule)), name);
    match own.iter().find(fails) {
        Some(worst) => case.ended(Outcome::Failed(Problem {
            kind: worst.severity.name(),
            message: line(diagnosed, worst),
            details: details(diagnosed, rule, &own),
        })),
        None => {
            case.remarks.extend(own.iter().map(|finding| format!("{}: {}", rule.id, line(diagnosed, finding))));
            case
        }
    }
}

fn line(diagnosed: &Diagnosed<'_>, finding: &Finding) -> String {
    let whom = diagnosed.whom(finding);
    let whom = if whom.is_empty() { whom } else { format!("{whom}: ") };
    let at = diagnosed.since_start(finding.first);
    format!("{at} s: {whom}{}{}", finding.message, times(diagnosed, finding))
}

fn details(diagnosed: &Diagnosed<'_>, rule: &Metadata, findings: &[&Finding]) -> Vec<String> {
    let mut lines = vec![rule.title.to_owned()];
    for finding in findings {
        lines.push(line(diagnosed, finding));
        let frames = finding.evidence.iter();
        lines.extend(
            frames.map(|exhibit| format!("  {} {} {}", diagnosed.place(exhibit), frame(exhibit), exhibit.text)),
        );
    }
    lines.push(rule.advice.to_owned());
    lines
}
