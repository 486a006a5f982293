//! The coverage of a run and the use of its time.

use crate::coverage::Coverage;
use crate::spent::Spent;

/// Sums over all sequences.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    /// The combinations of state, command and answer that were seen.
    pub coverage: Coverage,
    /// Number of frames on the bus for which the models knew the required or forbidden answers.
    pub executions: u64,
    /// Number of frames sent, including frames after which the standard leaves everything open.
    pub frames: u64,
    /// Number of sequences without a result, because the connection to the device failed.
    pub unjudged: u64,
    /// The use of the time on the bus.
    pub spent: Spent,
}
