//! The cases of a run for JUnit files.
//!
//! A *fail* is a failure. *Error* and *inconclusive* are errors, because the case gave no result although it should
//! have. *Not applicable* is skipped, and so is a case in quarantine, with its verdict. *Tolerated* and *deviation*
//! pass, with their reason in the suite's output.

use super::told::Told;
use super::{Run, cct_forecast, is_bad, name_in_family, quarantined, repetitions};
use crate::document::junit::{Case, Outcome, Problem, Suite};
use canvass_suite::foreign;
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;
use canvass_traces::Timestamp;

/// A suite for each family.
pub fn of(run: &Run) -> Vec<Suite> {
    run.families().into_iter().map(|(family, cases)| suite(run, family, &cases)).collect()
}

fn suite(run: &Run, family: &str, cases: &[&CaseReport]) -> Suite {
    let [name, _, software] = &run.info.device.names;
    let mut suite = Suite::new(family);
    suite.set_began(began(cases));
    suite.add_properties([
        ("node", run.info.node.to_string()),
        ("bus", run.info.bus.clone()),
        ("model", run.info.model.clone()),
        ("device", name.clone().unwrap_or_default()),
        ("software", software.clone().unwrap_or_default()),
        ("seed", run.info.seed.to_string()),
        ("host", run.summary.host.as_ref().map(super::host::sentence).unwrap_or_default()),
    ]);
    if let Some(seed) = run.info.shuffle {
        suite.add_properties([("shuffle", seed.to_string())]);
    }
    if !run.other_clients.is_empty() {
        suite.add_properties([("other_clients", foreign::told(&run.other_clients))]);
    }
    suite.add_properties(run.provenance.properties());
    suite.add_cases(cases.iter().map(|report| case(report)));
    suite
}

fn case(report: &CaseReport) -> Case {
    Case {
        family: report.case.family().replace('/', "."),
        name: name_in_family(report.case.id).to_owned(),
        duration: report.duration,
        outcome: outcome(report),
        remarks: remarks(report),
    }
}

fn outcome(report: &CaseReport) -> Outcome {
    let kind = report.verdict.kind();
    let reason = report.verdict.reason().map(|reason| reason.to_string()).unwrap_or_default();
    let problem = || Problem { kind: kind.name(), message: reason.clone(), details: details(report) };
    match (kind, quarantined(report)) {
        (Kind::Pass | Kind::Tolerated | Kind::Deviation, _) => Outcome::Passed,
        (_, Some(quarantined)) => Outcome::Skipped { message: format!("{quarantined}; {kind}: {reason}") },
        (Kind::Fail, None) => Outcome::Failed(problem()),
        (Kind::Error | Kind::Inconclusive, None) => Outcome::Error(problem()),
        (Kind::NotApplicable, None) => Outcome::Skipped { message: reason },
    }
}

/// The details of a failed case for a person.
fn details(report: &CaseReport) -> Vec<String> {
    let mut lines = vec![
        report.case.id.to_owned(),
        format!("{} ({})", report.case.clause, report.case.level.name()),
        report.case.requirement.to_owned(),
    ];
    let told = Told::all(report);
    lines.extend(told.iter().map(|told| format!("{}: expected {}, found {}", told.duty, told.expected, told.found)));
    lines.extend(told.iter().filter_map(Told::waiver).map(|waiver| format!("as data: {waiver}")));
    lines.extend(cct_forecast(report).map(|forecast| format!("forecast for CiA's test tool: {forecast}")));
    lines.extend(repetitions(report));
    lines.extend(report.notes.iter().map(|note| format!("note: {note}")));
    for exhibit in report.evidence.frames() {
        let record = &exhibit.record;
        lines.push(format!("({}) {} {}", record.timestamp, record.frame, exhibit.text));
    }
    lines
}

/// The remarks on a case that neither simply passed nor failed.
fn remarks(report: &CaseReport) -> Vec<String> {
    if is_bad(report.verdict.kind()) {
        return Vec::new();
    }
    let mut remarks = Vec::new();
    for told in Told::all(report).iter().filter(|told| matches!(told.kind, Kind::Tolerated | Kind::Deviation)) {
        remarks.push(format!("{}: {}: expected {}, found {}", told.kind, told.duty, told.expected, told.found));
        let documented = told.excuse.iter().map(|excuse| &excuse.documented);
        remarks.extend(documented.map(|text| format!("{}: {text}", told.authority().to_lowercase())));
    }
    remarks.extend(repetitions(report));
    remarks.extend(report.notes.iter().map(|note| format!("note: {note}")));
    remarks.iter().map(|remark| format!("{}: {remark}", report.case.id)).collect()
}

/// The time of the first frame. On a simulated bus it counts from power-on, so that the same run gives the same bytes.
fn began(cases: &[&CaseReport]) -> Timestamp {
    let first = cases.iter().find_map(|report| report.evidence.frames().next());
    first.map_or(Timestamp::ZERO, |exhibit| exhibit.record.timestamp)
}
