//! What a manual documents must hide no fault: every fault on every model, judged by the cases that name it.
//!
//! On a model that deviates, a case finds its documented breaches with and without a fault. A fault that adds a breach must
//! fail the case, whatever else the manual announces about it.

use super::{judge, judge_knowing, node_of};
use crate::bench::{Knowledge, Target};
use crate::case::Case;
use crate::verdict::{Breach, Kind, Ruled, Verdict};
use canvass_device::models::Model;
use canvass_device::{Fault, Faults};
use std::collections::BTreeMap;

/// What the faults made of a model.
#[derive(Clone, Debug, Default)]
pub struct Masking {
    /// How many pairs of a fault and a case that names it were run.
    pub tried: usize,
    /// In how many of them the fault added a breach.
    pub shown: usize,
    /// In how many of these the model deviates in the same case without the fault.
    pub beside_deviations: usize,
    /// Faults that added a breach and failed nothing.
    pub masked: Vec<Masked>,
}

/// A fault that a documented deviation hides.
#[derive(Clone, Debug)]
pub struct Masked {
    /// The model whose manual hides it.
    pub model: &'static str,
    /// The fault.
    pub fault: Fault,
    /// The case that names it.
    pub case: &'static Case,
    /// How the case ended.
    pub kind: Kind,
}

impl Masking {
    /// Adds what was found on another model.
    pub(super) fn add(&mut self, other: Self) {
        self.tried += other.tried;
        self.shown += other.shown;
        self.beside_deviations += other.beside_deviations;
        self.masked.extend(other.masked);
    }
}

/// Runs every fault on a model, with the cases that name it.
pub(super) fn of_model(model: &'static Model, cases: &[&'static Case], faults: &[Fault]) -> Masking {
    let mut masking = Masking::default();
    let mut without = BTreeMap::new();
    for &fault in faults {
        let target = Target::with_faults(model, node_of(model), fault.into());
        let mut knowledge = Knowledge::default();
        for &case in cases.iter().filter(|case| case.catches.contains(&fault)) {
            let healthy = without.entry(case.id).or_insert_with(|| judge(case, model, Faults::NONE).verdict);
            // A case that does not apply to the model has nothing to hide.
            if !healthy.kind().is_executed() {
                continue;
            }
            let verdict = judge_knowing(case, model, fault.into(), &target, &mut knowledge).verdict;
            masking.tried += 1;
            if !adds_a_breach(&verdict, healthy) {
                continue;
            }
            masking.shown += 1;
            masking.beside_deviations += usize::from(healthy.kind() == Kind::Deviation);
            let kind = verdict.kind();
            if !matches!(kind, Kind::Fail | Kind::Error) {
                masking.masked.push(Masked { model: model.id(), fault, case, kind });
            }
        }
    }
    masking
}

/// Whether a case found something with the fault that it does not find without.
fn adds_a_breach(with: &Verdict, without: &Verdict) -> bool {
    let same = |a: &Breach, b: &Breach| a.subject == b.subject && a.actual == b.actual && a.duty() == b.duty();
    let is_known = |ruled: &Ruled| without.breaches().iter().any(|known| same(&known.breach, &ruled.breach));
    with.breaches().iter().any(|ruled| !is_known(ruled) && ruled.kind() != Kind::Pass)
}
