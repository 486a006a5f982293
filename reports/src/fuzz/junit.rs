//! The result as JUnit XML: each property is a case, or, where it is violated, each of its rules that is.

use super::{Run, annotated, outcome, reliability, trouble};
use crate::junit::{Case, Outcome, Problem, Suite, write};
use crate::provenance;
use canvass_fuzzer::{Property, reproducer};
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let mut suite = Suite::new(format!("fuzz/{}", run.targets));
    suite.add_properties([
        ("node", run.node.to_string()),
        ("bus", run.bus.clone()),
        ("model", run.model.clone()),
        ("seed", run.seed.to_string()),
        ("repeat", run.repeat.clone()),
        ("outcome", outcome(run)),
        ("executions", run.outcome.executions.to_string()),
        ("frames", run.outcome.frames.to_string()),
        ("coverage_sdo", run.sdo_share().to_string()),
        ("coverage_lss", run.lss_share().to_string()),
    ]);
    suite.add_properties(
        Some(trouble(run)).filter(|trouble| !trouble.is_empty()).map(|trouble| ("bus_trouble", trouble)),
    );
    suite.add_properties(provenance::junit_properties(&run.provenance));
    for property in Property::all() {
        suite.add_cases(cases(run, property));
    }
    // What was not tried would look as if it had passed.
    suite.add_cases(run.outcome.ended_by.iter().map(|why| {
        let problem = Problem { kind: "bus", message: why.clone(), details: vec![trouble(run)] };
        Case::passed(format!("fuzz.{}", run.targets), "the bus works to the end of the run")
            .ended(Outcome::Error(problem))
    }));
    write("fuzz", &[suite], out)
}

fn cases(run: &Run, property: Property) -> Vec<Case> {
    let family = format!("fuzz.{}", run.targets);
    let mut cases: Vec<Case> = Vec::new();
    for (found, words) in run.violations().filter(|(found, _)| found.violation.property == property) {
        let violation = &found.violation;
        let text = format!(
            "{}\n{}\n{}",
            reliability(found, run.outcome.dead),
            annotated(found, words),
            reproducer::candump(&found.sequence)
        );
        cases.push(Case::passed(&*family, format!("{property} {}", violation.rule)).ended(Outcome::Failed(Problem {
            kind: if found.confirmed { "violation" } else { "violation seen once" },
            message: format!("expected {}, found {}", violation.expected, violation.actual),
            details: text.lines().map(str::to_owned).collect(),
        })));
    }
    if cases.is_empty() {
        cases.push(Case::passed(family, format!("{property} {}", property.title())));
    }
    cases
}
