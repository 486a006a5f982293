//! Liberties that the standard allows must not fail a case: every case runs on every liberty, alone and in random
//! combinations. And a fault must be found together with any liberties of the firmware.

use super::{in_parallel, judge, judge_hearing, judge_knowing, node_of};
use crate::bench::{Knowledge, Target};
use crate::case::Case;
use crate::dice::Dice;
use crate::verdict::{Kind, Reason, Verdict};
use canvass_device::models::Model;
use canvass_device::{Fault, Faults, Firmware, Liberties, Liberty};
use canvass_traces::Record;
use std::hash::{DefaultHasher, Hash, Hasher};

/// The amount of random tests.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Chance {
    /// The seed of the random combinations: equal seeds give equal combinations.
    pub seed: u64,
    /// Number of combinations of [`Chance::TOGETHER`] liberties on which every case runs.
    pub combinations: usize,
    /// Number of combinations with which each fault is tested.
    pub beside_faults: usize,
    /// Number of positions, at most 3, from which every model moves in every way.
    pub starts: usize,
    /// Number of random motions from random positions for each model.
    pub motions: usize,
}

/// The results of the cases on firmware with liberties.
#[derive(Clone, Debug, Default)]
pub struct Sparing {
    /// One row for each liberty, in the order of their definition.
    pub alone: Vec<LibertyRow>,
    /// One row for each random combination.
    pub combined: Vec<LibertyRow>,
    /// Number of pairs of a fault and a combination of liberties.
    pub tried: usize,
    /// Number of these pairs in which the fault showed: a case that names the fault saw another frame, time or
    /// description than without the fault.
    pub looked_for: usize,
    /// Faults that showed together with these liberties but were not found.
    pub missed: Vec<(Fault, Liberties)>,
}

/// The result of the cases on a firmware with liberties and without a fault.
#[derive(Clone, Debug)]
pub struct LibertyRow {
    /// The liberties of the firmware.
    pub liberties: Liberties,
    /// The model.
    pub model: &'static str,
    /// Number of cases that ran to an end.
    pub executed: usize,
    /// The cases that failed, or in which the tester failed.
    pub alarms: Vec<(&'static Case, Kind, Reason)>,
}

impl Chance {
    /// Number of liberties in a combination.
    pub const TOGETHER: usize = 5;
    /// The amount in `canvass selftest`.
    pub const WHOLE: Self = Self { seed: 1, combinations: 500, beside_faults: 50, starts: 1, motions: 12 };
    /// No random tests.
    pub const NONE: Self = Self { seed: 1, combinations: 0, beside_faults: 0, starts: 0, motions: 0 };
}

impl LibertyRow {
    /// Whether no case failed.
    pub const fn is_spared(&self) -> bool {
        self.alarms.is_empty()
    }
}

impl Sparing {
    /// Number of liberties on which no case failed.
    pub fn spared(&self) -> usize {
        self.alone.iter().filter(|row| row.is_spared()).count()
    }

    /// Whether no liberty failed a case, and no fault was missed.
    pub fn is_good(&self) -> bool {
        self.missed.is_empty() && self.alone.iter().chain(&self.combined).all(LibertyRow::is_spared)
    }
}

/// Runs the cases on the liberties, and on the faults combined with liberties.
pub(super) fn run(cases: &[&'static Case], faults: &[Fault], chance: Chance) -> Sparing {
    let mut dice = Dice::new(chance.seed);
    let combinations: Vec<Liberties> = (0..chance.combinations).map(|_| random_liberties(&mut dice)).collect();
    let alone: Vec<Liberties> = Liberty::ALL.iter().copied().map(Liberties::from).collect();
    let rows = |sets: &[Liberties]| {
        in_parallel(sets, |set| row(*set, cases)).into_iter().flatten().collect::<Vec<LibertyRow>>()
    };
    let beside: Vec<(Fault, Vec<Liberties>)> = faults
        .iter()
        .map(|fault| (*fault, (0..chance.beside_faults).map(|_| random_liberties(&mut dice)).collect()))
        .collect();
    let found = in_parallel(&beside, |(fault, sets)| beside_liberties(*fault, sets, cases));
    Sparing {
        alone: rows(&alone),
        combined: rows(&combinations),
        tried: beside.iter().map(|(_, sets)| sets.len()).sum(),
        looked_for: found.iter().map(|(looked_for, _)| looked_for).sum(),
        missed: found.into_iter().flat_map(|(_, missed)| missed).collect(),
    }
}

/// The row of these liberties; `None` if their model does not exist.
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

/// Number of combinations in which a fault showed, and the combinations in which it showed but was not found.
fn beside_liberties(fault: Fault, sets: &[Liberties], cases: &[&'static Case]) -> (usize, Vec<(Fault, Liberties)>) {
    let Some(model) = Model::by_id(fault.model()) else { return (0, Vec::new()) };
    let (mut shown, mut missed) = (0, Vec::new());
    for &liberties in sets {
        let faulty = Firmware { faults: fault.into(), liberties };
        let mut naming = cases.iter().filter(|case| case.catches.contains(&fault));
        let outcome = if naming.any(|case| finds(case, &judge(case, model, faulty).verdict)) {
            Outcome::Found
        } else if is_harmless(fault, liberties) {
            Outcome::Hidden
        } else {
            Beside::new(model, fault, liberties).outcome(cases)
        };
        shown += usize::from(outcome != Outcome::Hidden);
        if outcome == Outcome::Missed {
            missed.push((fault, liberties));
        }
    }
    (shown, missed)
}

/// The outcome of a fault combined with liberties.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    /// A case fails because of the fault.
    Found,
    /// No case fails, although a case about the fault applies in which the device behaves differently than without the
    /// fault.
    Missed,
    /// In all cases about the fault the device behaves as without it: a liberty removes the feature with the fault.
    Hidden,
}

/// Combinations in which the behaviour differs from that of correct firmware, but is not wrong.
const HARMLESS: &[(Fault, &[Liberty], &str)] = &[
    (Fault::EdsCobIdTwice, &[Liberty::NoApplicationObjects, Liberty::PdosInvalid], "a PDO that is off has no CAN-ID"),
    (Fault::PdoIdNotPredefined, &[Liberty::NoApplicationObjects], "a PDO that is off has no CAN-ID"),
    (Fault::EdsDefaultBeyondLimit, &[Liberty::EdsWithoutLimits], "there is no limit"),
    (Fault::DummyRefused, &[Liberty::NoDummies], "the device may refuse dummies; the codes differ"),
    (Fault::SdoRangeUnchecked, &[Liberty::NoApplicationObjects], "there is no range"),
    (Fault::ErrorHistoryReversed, &[Liberty::GenericErrorCodes], "all errors have one code, whatever their order"),
    (Fault::ErrorHistoryMovesTwo, &[Liberty::GenericErrorCodes], "all errors have one code, whatever their order"),
    (
        Fault::SdoAnsweredBeforeBootUp,
        &[Liberty::AnswersIn900Ms, Liberty::AnswersVary],
        "the answer comes after the boot-up message, as that of a request that waited for it would",
    ),
    (Fault::LmtActivationNotSilent, &[Liberty::AnswersIn900Ms], "the answer comes when the silence is over"),
    (Fault::TpdoPositionLate, &[Liberty::AnswersIn900Ms], "the position is late by less than an answer takes"),
];

/// Whether a fault is harmless together with these liberties.
fn is_harmless(fault: Fault, liberties: Liberties) -> bool {
    let rows = HARMLESS.iter().filter(|row| row.0 == fault);
    rows.flat_map(|row| row.1).any(|harmless| liberties.has(*harmless))
}

/// A firmware with liberties, with a fault and without it.
struct Beside {
    model: &'static Model,
    fault: Fault,
    firmwares: [Firmware; 2],
    targets: [Target; 2],
}

impl Beside {
    fn new(model: &'static Model, fault: Fault, liberties: Liberties) -> Self {
        let firmwares = [fault.into(), Faults::NONE].map(|faults| Firmware { faults, liberties });
        let targets = firmwares.map(|firmware| Target::with_firmware(model, node_of(model), firmware));
        Self { model, fault, firmwares, targets }
    }

    /// The outcome of a fault that the cases that name it did not find.
    fn outcome(&self, cases: &[&'static Case]) -> Outcome {
        let mut naming = cases.iter().filter(|case| case.catches.contains(&self.fault));
        if !naming.any(|case| self.shows(case)) {
            return Outcome::Hidden;
        }
        let [faulty, _] = self.firmwares;
        let mut knowledge = Knowledge::default();
        let found = cases.iter().any(|case| {
            let verdict = judge_knowing(case, self.model, faulty, &self.targets[0], &mut knowledge).verdict;
            finds(case, &verdict)
        });
        if found { Outcome::Found } else { Outcome::Missed }
    }

    /// Whether a case applies without the fault, and sees a difference with it: a frame, a time, a description.
    fn shows(&self, case: &'static Case) -> bool {
        let [(_, faulty), (applies, healthy)] = [0, 1].map(|at| {
            let mut traffic = DefaultHasher::new();
            let mut hear = |record: &Record| (record.timestamp, record.frame).hash(&mut traffic);
            let (firmware, target) = (self.firmwares[at], &self.targets[at]);
            let report = judge_hearing(case, self.model, firmware, target, &mut Knowledge::default(), &mut hear);
            (report.verdict.kind().is_executed(), traffic.finish())
        });
        let described = || self.fault.is_in_description() && self.is_described_otherwise();
        applies && (faulty != healthy || described())
    }

    fn is_described_otherwise(&self) -> bool {
        let [faulty, healthy] = self.targets.each_ref().map(|target| format!("{:?}", target.description));
        faulty != healthy
    }
}

fn finds(case: &Case, verdict: &Verdict) -> bool {
    matches!(verdict.kind(), Kind::Fail | Kind::Error) || super::records(case, verdict)
}

/// A random combination of [`Chance::TOGETHER`] liberties.
pub fn random_liberties(dice: &mut Dice) -> Liberties {
    let count = Liberty::ALL.len() as u64;
    let drawn = (0..Chance::TOGETHER).filter_map(|_| Liberty::ALL.get((dice.next() % count) as usize).copied());
    drawn.collect()
}
