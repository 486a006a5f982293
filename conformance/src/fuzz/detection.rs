//! The fuzzer is tested: how fast it finds each fault of the simulated devices, and how short the sequences are that
//! show it; and that it finds nothing on a model without fault.

use super::campaign::{self, Found, FuzzError, Plan};
use super::generate::Target;
use super::ground::simulated;
use crate::models::Model;
use crate::{Fault, Faults};
use canvass_analyzer::NodeId;
use std::time::{Duration, Instant};

/// How long a fault is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Frames, those of making the sequence small not counted.
    pub exchanges: u64,
    /// Time of this computer.
    pub time: Duration,
}

/// One run on a device with a fault.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The fault.
    pub fault: Fault,
    /// The seed.
    pub seed: u64,
    /// What was found, in which time; `None`: nothing until the limit.
    pub found: Option<Detected>,
    /// Frames that were sent.
    pub exchanges: u64,
}

/// A fault was found.
#[derive(Clone, Debug)]
pub struct Detected {
    /// What showed it.
    pub found: Found,
    /// The time of this computer until the violation was seen, and until its sequence was as short as it gets.
    pub elapsed: Duration,
}

/// How many tries making a sequence shorter may take.
const SHRINK_BUDGET: u32 = 2_000;

/// Looks for a fault on the model that shows it.
///
/// # Errors
/// [`FuzzError`] if the device can't be reached.
pub fn detect(fault: Fault, seed: u64, limit: Limit) -> Result<Trial, FuzzError> {
    let Some(model) = Model::by_id(fault.model()) else {
        return Ok(Trial { fault, seed, found: None, exchanges: 0 });
    };
    let begun = Instant::now();
    let outcome = fuzz(model, fault.into(), Target::All, seed, &mut |exchanges| {
        exchanges < limit.exchanges && begun.elapsed() < limit.time
    })?;
    let elapsed = begun.elapsed();
    let found = outcome.violations.into_iter().next().map(|found| Detected { found, elapsed });
    Ok(Trial { fault, seed, found, exchanges: outcome.executions })
}

/// Fuzzes a model until its first violation. `go_on` is asked with the number of frames sent.
///
/// # Errors
/// [`FuzzError`] if the device can't be reached.
pub fn fuzz(
    model: &'static Model,
    faults: Faults,
    target: Target,
    seed: u64,
    go_on: &mut dyn FnMut(u64) -> bool,
) -> Result<campaign::Outcome, FuzzError> {
    let node = model.default_node().unwrap_or(NodeId::MIN);
    let (mut ground, knowledge) = simulated(model, node, faults, model.default_bit_rate(), seed);
    let plan = Plan {
        target,
        seed,
        allow: campaign::harmless(),
        shrink_budget: SHRINK_BUDGET,
        stop_at_first: true,
        regressions: Vec::new(),
        only_regressions: false,
    };
    campaign::run(&mut ground, knowledge, &plan, &mut |progress| go_on(progress.executions))
}

/// The trials of one fault.
#[derive(Clone, Debug)]
pub struct Row {
    /// The fault.
    pub fault: Fault,
    /// One for each seed.
    pub trials: Vec<Trial>,
}

/// The trials of many faults.
#[derive(Clone, Debug)]
pub struct Table {
    /// One row for each fault.
    pub rows: Vec<Row>,
    /// Within this time every seed has to find a fault.
    pub limit: Duration,
}

impl Row {
    /// What was found, by seed.
    pub fn found(&self) -> impl Iterator<Item = &Detected> {
        self.trials.iter().filter_map(|trial| trial.found.as_ref())
    }

    /// Whether every seed found it in time, with a sequence that comes back.
    pub fn is_good(&self, limit: Duration) -> bool {
        self.trials.iter().all(|trial| {
            trial.found.as_ref().is_some_and(|detected| detected.found.confirmed && detected.elapsed <= limit)
        })
    }

    /// The time to find it, with the usual seed.
    pub fn median_time(&self) -> Option<Duration> {
        median(self.found().map(|detected| detected.elapsed).collect())
    }

    /// The time to find it, with the least lucky seed.
    pub fn longest_time(&self) -> Option<Duration> {
        self.found().map(|detected| detected.elapsed).max()
    }

    /// The frames of the usual minimal sequence.
    pub fn median_frames(&self) -> Option<usize> {
        median(self.found().map(|detected| detected.found.sequence.stimuli.len()).collect())
    }

    /// The frames of the longest minimal sequence.
    pub fn most_frames(&self) -> Option<usize> {
        self.found().map(|detected| detected.found.sequence.stimuli.len()).max()
    }
}

impl Table {
    /// The time to find a fault: the median over faults and seeds.
    pub fn median_time(&self) -> Option<Duration> {
        median(self.rows.iter().flat_map(Row::found).map(|detected| detected.elapsed).collect())
    }

    /// The longest time of all.
    pub fn longest_time(&self) -> Option<Duration> {
        self.rows.iter().filter_map(Row::longest_time).max()
    }

    /// The frames of a minimal sequence: the median over faults and seeds.
    pub fn median_frames(&self) -> Option<usize> {
        median(self.rows.iter().flat_map(Row::found).map(|detected| detected.found.sequence.stimuli.len()).collect())
    }

    /// The frames of the longest minimal sequence of all.
    pub fn most_frames(&self) -> Option<usize> {
        self.rows.iter().filter_map(Row::most_frames).max()
    }
}

/// The lower one of the two in the middle.
fn median<T: Ord + Copy>(mut values: Vec<T>) -> Option<T> {
    values.sort_unstable();
    values.get(values.len().checked_sub(1)? / 2).copied()
}
