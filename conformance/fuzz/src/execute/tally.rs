//! What a run has exercised, and what its time went into.

use crate::coverage::Coverage;
use crate::spent::Spent;

/// Counts over all sequences.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    /// What was exercised.
    pub coverage: Coverage,
    /// Frames that were on the bus, and after which the models knew what must or must not come.
    pub executions: u64,
    /// Frames that were sent, with those after which anything may come.
    pub frames: u64,
    /// Sequences that say nothing, because the way to the device failed.
    pub unjudged: u64,
    /// What the time went into.
    pub spent: Spent,
}
