//! The fuzzer must accept every liberty that the standard allows. This is tried with all properties on each liberty
//! alone and on random combinations.

use super::campaign::{Found, FuzzError};
use super::detection::fuzz;
use super::generate::Target;
use canvass_device::models::Model;
use canvass_device::{Liberties, Liberty};
use canvass_suite::dice::Dice;
use canvass_suite::selftest::{in_parallel, random_liberties};
use canvass_suite::touch::Touch;
use std::collections::BTreeSet;

/// The extent of the trial.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Chance {
    /// The seed of the combinations and of all random choices of the fuzzer.
    pub seed: u64,
    /// Number of combinations of liberties, in addition to each liberty alone.
    pub combinations: usize,
    /// Number of exchanges for each firmware.
    pub exchanges: u64,
}

impl Chance {
    /// The trial of `canvass selftest`.
    pub const WHOLE: Self = Self { seed: 1, combinations: 200, exchanges: 60_000 };
    /// No trial.
    pub const NONE: Self = Self { seed: 1, combinations: 0, exchanges: 0 };
}

/// The results of the fuzzer for liberties.
#[derive(Clone, Debug, Default)]
pub struct Sparing {
    /// One row for each liberty, in the order of their definition.
    pub alone: Vec<FuzzedLiberties>,
    /// One row for each random combination.
    pub combined: Vec<FuzzedLiberties>,
}

/// The result of the fuzzer for a firmware that takes liberties and has no fault.
#[derive(Clone, Debug)]
pub struct FuzzedLiberties {
    /// The liberties that the firmware takes.
    pub liberties: Liberties,
    /// The id of the model.
    pub model: &'static str,
    /// Number of frames after which the answer, or the silence, was judged.
    pub exchanges: u64,
    /// Violations that the fuzzer reported, though the standard allows this behaviour.
    pub violations: Vec<Found>,
}

impl Sparing {
    /// All rows.
    pub fn rows(&self) -> impl Iterator<Item = &FuzzedLiberties> {
        self.alone.iter().chain(&self.combined)
    }

    /// Whether no liberty was reported as a violation.
    pub fn is_good(&self) -> bool {
        self.rows().all(|row| row.violations.is_empty())
    }

    /// Number of rows without a violation.
    pub fn spared(&self) -> usize {
        self.rows().filter(|row| row.violations.is_empty()).count()
    }

    /// Number of exchanges with all firmwares.
    pub fn exchanges(&self) -> u64 {
        self.rows().map(|row| row.exchanges).sum()
    }
}

/// Fuzzes a device for each liberty and for each combination, on as many threads as the computer has cores.
///
/// # Errors
/// [`FuzzError`] if a device can't be reached.
pub fn run(chance: Chance) -> Result<Sparing, FuzzError> {
    let mut dice = Dice::new(chance.seed);
    let alone: Vec<Liberties> = match chance.exchanges {
        0 => Vec::new(),
        _ => Liberty::ALL.iter().copied().map(Liberties::from).collect(),
    };
    let combined: Vec<Liberties> = (0..chance.combinations).map(|_| random_liberties(&mut dice)).collect();
    let rows = |sets: &[Liberties]| -> Result<Vec<FuzzedLiberties>, FuzzError> {
        let numbered: Vec<(u64, Liberties)> = (chance.seed..).zip(sets.iter().copied()).collect();
        in_parallel(&numbered, |(seed, liberties)| row(*liberties, *seed, chance.exchanges))
            .into_iter()
            .filter_map(Result::transpose)
            .collect()
    };
    Ok(Sparing { alone: rows(&alone)?, combined: rows(&combined)? })
}

/// Fuzzes a model with the liberties. `None` if their model does not exist.
fn row(liberties: Liberties, seed: u64, exchanges: u64) -> Result<Option<FuzzedLiberties>, FuzzError> {
    let Some(model) = liberties.iter().next().and_then(|liberty| Model::by_id(liberty.model())) else {
        return Ok(None);
    };
    let mut row = FuzzedLiberties { liberties, model: model.id(), exchanges: 0, violations: Vec::new() };
    // Once without any touch, as on a device of somebody else, and once with all touches.
    for allow in [BTreeSet::new(), Touch::ALL.into_iter().collect()] {
        let outcome = fuzz(model, liberties, Target::All, &allow, seed, &mut |done| done < exchanges / 2)?;
        row.exchanges += outcome.executions;
        row.violations.extend(outcome.violations);
    }
    Ok(Some(row))
}
