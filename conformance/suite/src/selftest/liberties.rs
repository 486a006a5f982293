//! What the standard leaves free must be spared: every case on every liberty, alone and in random combinations; and a fault
//! must be found whatever liberties the firmware takes beside it.

use super::{in_parallel, judge, judge_knowing, node_of};
use crate::bench::{Knowledge, Target};
use crate::case::Case;
use crate::verdict::{Kind, Reason};
use canvass_device::models::Model;
use canvass_device::{Fault, Faults, Firmware, Liberties, Liberty};

/// How much is tried at random.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Chance {
    /// From which the combinations are drawn: the same seed draws the same.
    pub seed: u64,
    /// How many combinations of [`Chance::TOGETHER`] liberties every case runs on.
    pub combinations: usize,
    /// With how many combinations each fault is looked for.
    pub beside_faults: usize,
}

/// What the cases made of liberties.
#[derive(Clone, Debug, Default)]
pub struct Sparing {
    /// One row for each liberty, in the order of their definition.
    pub alone: Vec<LibertyRow>,
    /// One row for each random combination.
    pub combined: Vec<LibertyRow>,
    /// How often a fault was looked for beside liberties that leave a case that names it applicable.
    pub looked_for: usize,
    /// Faults that were not found beside liberties.
    pub missed: Vec<(Fault, Liberties)>,
}

/// What the cases made of a firmware that takes liberties and has no fault.
#[derive(Clone, Debug)]
pub struct LibertyRow {
    /// What it takes.
    pub liberties: Liberties,
    /// The model.
    pub model: &'static str,
    /// How many cases ran to an end.
    pub executed: usize,
    /// The cases that failed, or in which the tester failed.
    pub alarms: Vec<(&'static Case, Kind, Reason)>,
}

impl Chance {
    /// As many liberties are combined.
    pub const TOGETHER: usize = 5;
    /// What `canvass selftest` tries.
    pub const WHOLE: Self = Self { seed: 1, combinations: 500, beside_faults: 50 };
    /// Nothing at random.
    pub const NONE: Self = Self { seed: 1, combinations: 0, beside_faults: 0 };
}

impl LibertyRow {
    /// Whether no case failed.
    pub const fn is_spared(&self) -> bool {
        self.alarms.is_empty()
    }
}

impl Sparing {
    /// How many liberties no case failed.
    pub fn spared(&self) -> usize {
        self.alone.iter().filter(|row| row.is_spared()).count()
    }

    /// Whether nothing right was failed and nothing wrong was missed.
    pub fn is_good(&self) -> bool {
        self.missed.is_empty() && self.alone.iter().chain(&self.combined).all(LibertyRow::is_spared)
    }
}

/// Runs the cases on the liberties, and the faults beside them.
pub(super) fn run(cases: &[&'static Case], faults: &[Fault], chance: Chance) -> Sparing {
    let mut dice = Dice(chance.seed);
    let combinations: Vec<Liberties> = (0..chance.combinations).map(|_| dice.liberties()).collect();
    let alone: Vec<Liberties> = Liberty::ALL.iter().copied().map(Liberties::from).collect();
    let rows = |sets: &[Liberties]| {
        in_parallel(sets, |set| row(*set, cases)).into_iter().flatten().collect::<Vec<LibertyRow>>()
    };
    let beside: Vec<(Fault, Vec<Liberties>)> =
        faults.iter().map(|fault| (*fault, (0..chance.beside_faults).map(|_| dice.liberties()).collect())).collect();
    let found = in_parallel(&beside, |(fault, sets)| beside_liberties(*fault, sets, cases));
    Sparing {
        alone: rows(&alone),
        combined: rows(&combinations),
        looked_for: found.iter().map(|(looked_for, _)| looked_for).sum(),
        missed: found.into_iter().flat_map(|(_, missed)| missed).collect(),
    }
}

/// `None` if the liberty's model does not exist.
fn row(liberties: Liberties, cases: &[&'static Case]) -> Option<LibertyRow> {
    let model = Model::by_id(liberties.iter().next()?.model())?;
    let firmware = Firmware::from(liberties);
    let target = Target::with_firmware(model, node_of(model), firmware);
    let mut knowledge = Knowledge::default();
    let mut row = LibertyRow { liberties, model: model.id(), executed: 0, alarms: Vec::new() };
    for &case in cases {
        let verdict = judge_knowing(case, model, firmware, &target, &mut knowledge).verdict;
        let kind = verdict.kind();
        row.executed += usize::from(kind.is_executed());
        if matches!(kind, Kind::Fail | Kind::Error) {
            row.alarms.push((case, kind, verdict.reason().unwrap_or_default()));
        }
    }
    Some(row)
}

/// How often a fault was looked for, and beside which liberties it was not found.
fn beside_liberties(fault: Fault, sets: &[Liberties], cases: &[&'static Case]) -> (usize, Vec<(Fault, Liberties)>) {
    let Some(model) = Model::by_id(fault.model()) else { return (0, Vec::new()) };
    let (mut looked_for, mut missed) = (0, Vec::new());
    for &liberties in sets {
        let healthy = Firmware { faults: Faults::NONE, liberties };
        let faulty = Firmware { faults: fault.into(), liberties };
        let naming = cases.iter().filter(|case| case.catches.contains(&fault));
        // A liberty may take away what the fault is about.
        let mut visible = naming.filter(|case| judge(case, model, healthy).verdict.kind().is_executed()).peekable();
        if visible.peek().is_none() {
            continue;
        }
        looked_for += 1;
        let finds = |case: &&&'static Case| {
            let verdict = judge(case, model, faulty).verdict;
            matches!(verdict.kind(), Kind::Fail | Kind::Error) || super::records(case, &verdict)
        };
        if !visible.any(|case| finds(&case)) {
            missed.push((fault, liberties));
        }
    }
    (looked_for, missed)
}

/// Numbers that only look random (SplitMix64).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    fn liberties(&mut self) -> Liberties {
        let count = Liberty::ALL.len() as u64;
        let drawn = (0..Chance::TOGETHER).filter_map(|_| Liberty::ALL.get((self.next() % count) as usize).copied());
        drawn.collect()
    }
}
