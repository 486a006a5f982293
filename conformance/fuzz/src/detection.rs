//! The fuzzer is tested: how fast it finds each fault of the simulated devices, and how short the sequences are that
//! show it; and that it finds nothing on a model without fault.

use super::campaign::{self, Found, FuzzError, Plan};
use super::generate::{Target, Targets};
use super::stand::simulated;
use canvass_analyzer::NodeId;
use canvass_device::models::Model;
use canvass_device::{Fault, Faults, Firmware};
use canvass_suite::touch::Touch;
use std::collections::BTreeSet;
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
    /// The same sequence shows nothing on the model without the fault: it is the fault that was found.
    pub caused: bool,
}

/// How many tries making a sequence shorter may take.
const SHRINK_BUDGET: u32 = 2_000;

/// Looks for a fault on the model that shows it; what has to be allowed is done where the fault needs it.
///
/// # Errors
/// [`FuzzError`] if the device can't be reached.
pub fn detect(fault: Fault, seed: u64, limit: Limit) -> Result<Trial, FuzzError> {
    let Some(model) = Model::by_id(fault.model()) else {
        return Ok(Trial { fault, seed, found: None, exchanges: 0 });
    };
    let begun = Instant::now();
    let allow: BTreeSet<Touch> = fault.fuzz_needs().and_then(|name| name.parse().ok()).into_iter().collect();
    let outcome = fuzz(model, fault, Target::All, &allow, seed, &mut |exchanges| {
        exchanges < limit.exchanges && begun.elapsed() < limit.time
    })?;
    let elapsed = begun.elapsed();
    let exchanges = outcome.executions;
    let Some(found) = outcome.violations.into_iter().next() else {
        return Ok(Trial { fault, seed, found: None, exchanges });
    };
    let (mut healthy, knowledge) = simulated(model, node_of(model), Faults::NONE, model.default_bit_rate(), seed);
    let (violation, _) = campaign::replay(&mut healthy, knowledge, &found.sequence)?;
    Ok(Trial { fault, seed, found: Some(Detected { found, elapsed, caused: violation.is_none() }), exchanges })
}

/// The node-ID of the model as delivered, or that which one without gets.
fn node_of(model: &Model) -> NodeId {
    model.default_node().unwrap_or(NodeId::MIN)
}

/// Fuzzes a model until its first violation. `go_on` is asked with the number of frames sent.
///
/// # Errors
/// [`FuzzError`] if the device can't be reached.
pub fn fuzz(
    model: &'static Model,
    firmware: impl Into<Firmware>,
    targets: impl Into<Targets>,
    allow: &BTreeSet<Touch>,
    seed: u64,
    go_on: &mut dyn FnMut(u64) -> bool,
) -> Result<campaign::Outcome, FuzzError> {
    let (mut stand, knowledge) = simulated(model, node_of(model), firmware, model.default_bit_rate(), seed);
    let plan = Plan {
        targets: targets.into(),
        seed,
        allow: allow.clone(),
        shrink_budget: SHRINK_BUDGET,
        time: crate::time_limit::TimeLimit::default(),
        stop_at_first: true,
        regressions: Vec::new(),
        only_regressions: false,
    };
    campaign::run(&mut stand, knowledge, &plan, &mut |progress| go_on(progress.executions))
}

/// The trials of one fault.
#[derive(Clone, Debug)]
pub struct FuzzedFault {
    /// The fault.
    pub fault: Fault,
    /// One for each seed.
    pub trials: Vec<Trial>,
}

/// The trials of many faults.
#[derive(Clone, Debug)]
pub struct Table {
    /// One row for each fault.
    pub rows: Vec<FuzzedFault>,
    /// Within this time every seed has to find a fault.
    pub limit: Duration,
}

impl FuzzedFault {
    /// What was found, by seed.
    pub fn found(&self) -> impl Iterator<Item = &Detected> {
        self.trials.iter().filter_map(|trial| trial.found.as_ref())
    }

    /// Whether every seed found it in time, with a sequence that comes back, and not without the fault.
    pub fn is_good(&self, limit: Duration) -> bool {
        let is_good = |detected: &Detected| detected.found.confirmed && detected.caused && detected.elapsed <= limit;
        self.trials.iter().all(|trial| trial.found.as_ref().is_some_and(is_good))
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
        median(self.rows.iter().flat_map(FuzzedFault::found).map(|detected| detected.elapsed).collect())
    }

    /// The longest time of all.
    pub fn longest_time(&self) -> Option<Duration> {
        self.rows.iter().filter_map(FuzzedFault::longest_time).max()
    }

    /// The frames of a minimal sequence: the median over faults and seeds.
    pub fn median_frames(&self) -> Option<usize> {
        median(
            self.rows
                .iter()
                .flat_map(FuzzedFault::found)
                .map(|detected| detected.found.sequence.stimuli.len())
                .collect(),
        )
    }

    /// The frames of the longest minimal sequence of all.
    pub fn most_frames(&self) -> Option<usize> {
        self.rows.iter().filter_map(FuzzedFault::most_frames).max()
    }
}

/// The lower one of the two in the middle.
fn median<T: Ord + Copy>(mut values: Vec<T>) -> Option<T> {
    values.sort_unstable();
    values.get(values.len().checked_sub(1)? / 2).copied()
}
