//! Defects: cases in which the device did the same in the same situation.
//!
//! An engineer who repairs a firmware needs the number of its defects, not the number of cases that see them.

use super::{Run, is_bad};
use canvass_analyzer::Service;
use canvass_bus::client::Violation;
use canvass_bus::observation::{Observation, Subject};
use canvass_suite::runner::CaseReport;
use canvass_suite::situation::Situation;
use canvass_suite::verdict::{Breach, Kind, Reason, When};
use std::mem::{Discriminant, discriminant};

/// A defect.
pub struct Defect<'a> {
    /// The first case that shows it; it stands for all.
    pub first: &'a CaseReport,
    /// The other cases, in the order in which they ran.
    pub others: Vec<&'a CaseReport>,
}

/// The property that all cases of a defect share.
#[derive(PartialEq)]
enum Cause<'a> {
    /// The broken rule of the SDO protocol: an answer that breaks it is wrong in every situation.
    Violation(Discriminant<Violation>),
    /// The situation, and the answer that the standard does not allow in it.
    Listed(Situation, &'a Observation),
    /// The part of the device, and the wrong observation that it shows whatever is requested from it.
    Shown(Subject, &'a Observation),
    /// The duty and the wrong observation, for observations that may have another cause if another duty is broken.
    Duty(&'a str, &'a Observation),
    /// The verdict and its reason, for a case that could not be judged.
    Undecided(Kind, Reason),
}

/// The defects that the bad cases of the run show, in the order in which they were found. Cases that could not be judged
/// are joined by their reasons.
pub fn defects(run: &Run) -> Vec<Defect<'_>> {
    let mut causes: Vec<Cause<'_>> = Vec::new();
    let mut defects: Vec<Defect<'_>> = Vec::new();
    for report in run.cases.iter().filter(|report| is_bad(report.verdict.kind())) {
        let cause = cause(report);
        match causes.iter().position(|known| *known == cause).and_then(|at| defects.get_mut(at)) {
            Some(defect) => defect.others.push(report),
            None => {
                causes.push(cause);
                defects.push(Defect { first: report, others: Vec::new() });
            }
        }
    }
    defects
}

impl Defect<'_> {
    /// Whether cases failed, and not only could not be judged.
    pub fn is_failure(&self) -> bool {
        self.first.verdict.kind() == Kind::Fail
    }
}

fn cause(report: &CaseReport) -> Cause<'_> {
    let kind = report.verdict.kind();
    match report.verdict.worst().filter(|_| kind == Kind::Fail) {
        Some(ruled) => of_breach(&ruled.breach),
        None => Cause::Undecided(kind, report.verdict.reason().unwrap_or_default()),
    }
}

fn of_breach(breach: &Breach) -> Cause<'_> {
    match (&breach.situation, &breach.actual) {
        (_, Observation::Violation(violation)) => Cause::Violation(discriminant(violation)),
        (When::Listed { situation, .. }, actual) => Cause::Listed(*situation, actual),
        // A wrong answer of an SDO server, or silence, may have many causes: cases with such an observation show one
        // defect only if they break the same duty.
        (When::Own(duty), actual) if breach.subject == Subject::Service(Service::Sdo) => Cause::Duty(duty, actual),
        (When::Own(duty), actual @ Observation::Silence) => Cause::Duty(duty, actual),
        (_, actual) => Cause::Shown(breach.subject, actual),
    }
}
