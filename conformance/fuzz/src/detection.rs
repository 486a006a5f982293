//! A test of the fuzzer: how fast it finds each fault of the simulated devices, how short the resulting sequences are,
//! and that it finds nothing on a model without faults.

use super::campaign::{self, Found, FuzzError, Plan};
use super::generate::{Target, Targets};
use super::stand::simulated;
use canvass_analyzer::NodeId;
use canvass_device::models::Model;
use canvass_device::{Fault, Faults, Firmware};
use canvass_suite::touch::Touch;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// The limits of the search for a fault.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Number of frames, without the frames sent to shorten the sequence.
    pub exchanges: u64,
    /// Time on this computer.
    pub time: Duration,
}

impl Limit {
    /// A limit that does not depend on the speed of this computer.
    pub const fn of_exchanges(exchanges: u64) -> Self {
        Self { exchanges, time: Duration::MAX }
    }
}

/// One run on a device with a fault.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The fault.
    pub fault: Fault,
    /// The seed.
    pub seed: u64,
    /// The violation that shows the fault. `None`: none was found within the limit.
    pub found: Option<Detected>,
    /// Number of frames sent.
    pub exchanges: u64,
}

/// A fault that was found.
#[derive(Clone, Debug)]
pub struct Detected {
    /// The violation that shows the fault.
    pub found: Found,
    /// Time on this computer until the violation was seen and its sequence shortened.
    pub elapsed: Duration,
    /// Whether the same sequence shows nothing on the model without the fault, so that the fault has caused the
    /// violation.
    pub caused: bool,
}

/// Maximum number of tries to shorten a sequence.
const SHRINK_BUDGET: u32 = 2_000;

/// Searches for a fault on the model that shows it. Touches that the fault needs are allowed.
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

/// The node-ID of the model as delivered, or the lowest if it is delivered without one.
fn node_of(model: &Model) -> NodeId {
    model.default_node().unwrap_or(NodeId::MIN)
}

/// Fuzzes a model until its first violation. `go_on` gets the number of frames sent.
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
        corpus: Vec::new(),
    };
    campaign::run(&mut stand, knowledge, &plan, &mut |progress| go_on(progress.executions))
}

/// The trials of one fault.
#[derive(Clone, Debug)]
pub struct FuzzedFault {
    /// The fault.
    pub fault: Fault,
    /// One trial for each seed.
    pub trials: Vec<Trial>,
}

/// The trials of many faults.
#[derive(Clone, Debug)]
pub struct Table {
    /// One row for each fault.
    pub rows: Vec<FuzzedFault>,
    /// Time within which every seed has to find each fault.
    pub limit: Duration,
}

impl FuzzedFault {
    /// The violations found, by seed.
    pub fn found(&self) -> impl Iterator<Item = &Detected> {
        self.trials.iter().filter_map(|trial| trial.found.as_ref())
    }

    /// Whether every seed found the fault in time, with a sequence that is confirmed and shows nothing without the
    /// fault.
    pub fn is_good(&self, limit: Duration) -> bool {
        let is_good = |detected: &Detected| detected.found.confirmed && detected.caused && detected.elapsed <= limit;
        self.trials.iter().all(|trial| trial.found.as_ref().is_some_and(is_good))
    }

    /// The median time to find the fault over the seeds.
    pub fn median_time(&self) -> Option<Duration> {
        median(self.found().map(|detected| detected.elapsed).collect())
    }

    /// The longest time to find the fault over the seeds.
    pub fn longest_time(&self) -> Option<Duration> {
        self.found().map(|detected| detected.elapsed).max()
    }

    /// The median number of frames of the shortened sequences.
    pub fn median_frames(&self) -> Option<usize> {
        median(self.found().map(|detected| detected.found.sequence.stimuli.len()).collect())
    }

    /// The largest number of frames of the shortened sequences.
    pub fn most_frames(&self) -> Option<usize> {
        self.found().map(|detected| detected.found.sequence.stimuli.len()).max()
    }
}

impl Table {
    /// The median time to find a fault over faults and seeds.
    pub fn median_time(&self) -> Option<Duration> {
        median(self.rows.iter().flat_map(FuzzedFault::found).map(|detected| detected.elapsed).collect())
    }

    /// The longest time to find a fault over faults and seeds.
    pub fn longest_time(&self) -> Option<Duration> {
        self.rows.iter().filter_map(FuzzedFault::longest_time).max()
    }

    /// The median number of frames of a shortened sequence over faults and seeds.
    pub fn median_frames(&self) -> Option<usize> {
        median(
            self.rows
                .iter()
                .flat_map(FuzzedFault::found)
                .map(|detected| detected.found.sequence.stimuli.len())
                .collect(),
        )
    }

    /// The largest number of frames of a shortened sequence over faults and seeds.
    pub fn most_frames(&self) -> Option<usize> {
        self.rows.iter().filter_map(FuzzedFault::most_frames).max()
    }
}

/// The median; the lower of the two middle values if their number is even.
fn median<T: Ord + Copy>(mut values: Vec<T>) -> Option<T> {
    values.sort_unstable();
    values.get(values.len().checked_sub(1)? / 2).copied()
}
