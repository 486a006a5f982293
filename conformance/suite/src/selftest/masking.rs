//! Documented deviations must hide no fault: every fault on every model, judged by the cases that name it.
//!
//! On a model that deviates, a case finds the documented breaches with and without a fault. If the fault adds a breach,
//! the case must fail, whatever the manual announces.

use super::{judge, judge_knowing, node_of};
use crate::bench::{Knowledge, Target};
use crate::case::Case;
use crate::verdict::{Breach, Kind, Ruled, Verdict};
use canvass_device::models::Model;
use canvass_device::{Fault, Faults};
use std::collections::BTreeMap;

/// The results of the faults on a model.
#[derive(Clone, Debug, Default)]
pub struct Masking {
    /// Number of pairs of a fault and a case that names it.
    pub tried: usize,
    /// Number of these pairs in which the fault added a breach.
    pub shown: usize,
    /// Number of these pairs in which the model deviates in the same case without the fault.
    pub beside_deviations: usize,
    /// Faults that added a breach without failing the case.
    pub masked: Vec<Masked>,
}

/// A fault that a documented deviation hides.
#[derive(Clone, Debug)]
pub struct Masked {
    /// The model whose manual hides the fault.
    pub model: &'static str,
    /// The fault.
    pub fault: Fault,
    /// The case that names the fault.
    pub case: &'static Case,
    /// The verdict of the case.
    pub kind: Kind,
}

impl Masking {
    /// Adds the results of another model.
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
            // A case that does not apply to the model can't hide a fault.
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

/// Whether a case has a breach with the fault that it does not have without it.
fn adds_a_breach(with: &Verdict, without: &Verdict) -> bool {
    let same = |a: &Breach, b: &Breach| a.subject == b.subject && a.actual == b.actual && a.duty() == b.duty();
    let is_known = |ruled: &Ruled| without.breaches().iter().any(|known| same(&known.breach, &ruled.breach));
    with.breaches().iter().any(|ruled| !is_known(ruled) && ruled.kind() != Kind::Pass)
}
