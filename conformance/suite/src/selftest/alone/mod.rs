//! A case alone and the same case in a whole run give the same verdict.
//!
//! Each firmware is tested three ways: by each case in a run of its own on a new device, by all cases in one run in
//! their usual order, and by all cases in one run in a random order. A verdict that differs shows that an earlier case
//! has left something behind: in the tester, which is wrong, or in the device. `explained.toml` lists the defects that
//! outlive the reset between two cases, each with its reason, and is reviewed.

mod explained;
mod firmware;

pub use explained::BadList;
pub use firmware::Subject;

use super::{REST, TURNING, in_parallel, node_of};
use crate::bench::{Bench, Options, Target};
use crate::case::Case;
use crate::catalogue;
use crate::runner::{self, CaseReport, Plan, RunEvent};
use crate::touch::Touch;
use crate::verdict::Kind;
use canvass_bus::SimulatedBus;
use canvass_device::{Device, Motion};
use canvass_traces::Record;
use explained::Explained;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

/// The firmwares that run.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Sample {
    /// The seed of the draw and of the random order: equal seeds give equal runs.
    pub seed: u64,
    /// Number of firmwares with one fault, and of firmwares with two faults; `None` means every fault, and as many
    /// pairs of faults.
    pub count: Option<usize>,
}

impl Sample {
    /// Number of faults in `canvass selftest --alone`.
    pub const USUAL: usize = 40;
}

/// The results of the cases on a firmware.
#[derive(Clone, Debug)]
pub struct AloneRow {
    /// The firmware with its model.
    pub subject: Subject,
    /// Number of cases.
    pub cases: usize,
    /// The verdicts that differ, each with the defect of the device that explains it.
    pub explained: Vec<(Difference, String)>,
    /// The verdicts that differ and are not in the list.
    pub unexplained: Vec<Difference>,
}

/// A case whose verdict in a whole run differs from its verdict in a run of its own.
#[derive(Clone, Debug)]
pub struct Difference {
    /// The case.
    pub case: &'static Case,
    /// The verdict of the case in a run of its own.
    pub alone: Kind,
    /// The verdict of the case in the whole run; `None` if the run ended before it.
    pub together: Option<Kind>,
    /// The order of the whole run.
    pub order: Order,
    /// The reasons of both verdicts.
    pub reasons: [String; 2],
}

/// The order of the cases in a whole run.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Order {
    /// The order of `canvass test`.
    Usual,
    /// The order of `canvass test --shuffle`.
    Shuffled,
}

/// The verdict of a case and its reason.
type Outcomes = BTreeMap<&'static str, (Kind, String)>;

/// Runs the cases alone and together on a sample of firmwares.
///
/// # Errors
/// [`BadList`] if the list of explained differences can't be read.
pub fn run(cases: &[&'static Case], sample: Sample) -> Result<Vec<AloneRow>, BadList> {
    let explained = Explained::read()?;
    let asking: Vec<&'static Case> = cases.iter().copied().filter(|case| case.asks_the_device()).collect();
    let shuffled = catalogue::shuffled(&asking, sample.seed);
    let subjects = Subject::draw(sample);
    Ok(in_parallel(&subjects, |subject| row(*subject, &asking, &shuffled, &explained)))
}

fn row(subject: Subject, cases: &[&'static Case], shuffled: &[&'static Case], explained: &Explained) -> AloneRow {
    let target = subject.target();
    let mut alone = Outcomes::new();
    for &case in cases {
        run_on(subject, &target, &[case], &mut alone);
    }
    let mut row = AloneRow { subject, cases: cases.len(), explained: Vec::new(), unexplained: Vec::new() };
    for (order, cases) in [(Order::Usual, cases), (Order::Shuffled, shuffled)] {
        let mut together = Outcomes::new();
        // A device either rests or moves during a run, so the cases form two groups.
        for moving in [false, true] {
            let some: Vec<_> = cases.iter().copied().filter(|case| case.needs_motion() == moving).collect();
            run_on(subject, &target, &some, &mut together);
        }
        for difference in differences(cases, &alone, &together, order) {
            let listed = explained.reason(subject.firmware, difference.case.id).map(str::to_owned);
            match judged_elsewhere(&difference, &together).or(listed) {
                Some(reason) => row.explained.push((difference, reason)),
                None => row.unexplained.push(difference),
            }
        }
    }
    row
}

fn differences(cases: &[&'static Case], alone: &Outcomes, together: &Outcomes, order: Order) -> Vec<Difference> {
    let difference = |case: &&'static Case| {
        let (alone, together) = (alone.get(case.id)?, together.get(case.id));
        let kind = together.map(|(kind, _)| *kind);
        let reasons = [alone.1.clone(), together.map(|(_, reason)| reason.clone()).unwrap_or_default()];
        (kind != Some(alone.0)).then_some(Difference { case, alone: alone.0, together: kind, order, reasons })
    };
    cases.iter().filter_map(difference).collect()
}

/// A precondition that the device breaks is judged once: a case that then can't be judged names the case that failed
/// for it.
fn judged_elsewhere(difference: &Difference, together: &Outcomes) -> Option<String> {
    let [_, reason] = difference.reasons.each_ref();
    let named = |(id, (kind, _)): &(&&'static str, &(Kind, String))| {
        *kind == Kind::Fail && **id != difference.case.id && reason.contains(**id)
    };
    let failed = || together.iter().find(named).map(|(id, _)| format!("{id} failed for it"));
    (difference.together == Some(Kind::Inconclusive)).then(failed).flatten()
}

/// Runs the cases on a new device, as `canvass test` does with everything allowed.
fn run_on(subject: Subject, target: &Target, cases: &[&'static Case], outcomes: &mut Outcomes) {
    let Some(first) = cases.first() else { return };
    let motion = Motion::constant(REST, if first.needs_motion() { TURNING } else { 0 });
    let bit_rate = subject.model.default_bit_rate();
    let mut bus = SimulatedBus::new(bit_rate);
    let node = node_of(subject.model);
    bus.attach(Box::new(Device::with_motion(subject.model, Some(node), subject.firmware, 0, &motion)));
    let allow = Touch::ALL.into_iter().collect();
    let options = Options { allow, zero_point_is_stored: true, ..Options::default() };
    let cancel = AtomicBool::new(false);
    let mut annotate = |_: &Record| String::new();
    let mut bench = Bench::new(&mut bus, target, &options, &mut annotate, &cancel);
    let plan = Plan { cases, bus: "sim", bit_rate: Some(bit_rate), seed: 0, shuffle: None };
    // If no case could be judged, the run ends with an error, but it has reported each case.
    let _ = runner::run(&mut bench, &plan, &mut |event| {
        if let RunEvent::CaseFinished(report) = event {
            outcomes.insert(report.case.id, (report.verdict.kind(), reason_of(report)));
        }
    });
}

fn reason_of(report: &CaseReport) -> String {
    report.verdict.reason().map(|reason| reason.to_string()).unwrap_or_default()
}

impl AloneRow {
    /// Whether every difference is explained.
    pub const fn is_good(&self) -> bool {
        self.unexplained.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_that_differs_or_is_missing_is_a_difference() {
        let cases: Vec<&'static Case> = catalogue::cases().into_iter().take(3).collect();
        let outcomes = |kinds: &[Kind]| -> Outcomes {
            cases.iter().zip(kinds).map(|(case, kind)| (case.id, (*kind, String::new()))).collect()
        };
        let alone = outcomes(&[Kind::Pass, Kind::Fail, Kind::Pass]);
        let together = outcomes(&[Kind::Pass, Kind::Inconclusive]);
        let found: Vec<_> = differences(&cases, &alone, &together, Order::Usual)
            .into_iter()
            .map(|difference| (difference.case.id, difference.alone, difference.together))
            .collect();
        assert_eq!(found, [(cases[1].id, Kind::Fail, Some(Kind::Inconclusive)), (cases[2].id, Kind::Pass, None)]);
    }
}
