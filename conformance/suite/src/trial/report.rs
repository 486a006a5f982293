//! What a case leaves for the reports.

use crate::bench::{Evidence, Measurement, Use};
use crate::case::Case;
use crate::foreign::ForeignMessages;
use crate::quarantine::Quarantine;
use crate::verdict::{Kind, Verdict};
use canvass_traces::Duration;

/// The outcome of one case.
#[derive(Clone, Debug)]
pub struct CaseReport {
    /// The case.
    pub case: &'static Case,
    /// How it ended.
    pub verdict: Verdict,
    /// The frames that were on the bus.
    pub evidence: Evidence,
    /// What else was noticed.
    pub notes: Vec<String>,
    /// What was measured, whatever the verdict.
    pub measurements: Vec<Measurement>,
    /// Which objects served it, where others could have.
    pub uses: Vec<Use>,
    /// What others sent to the device or for it meanwhile.
    pub foreign: Vec<ForeignMessages>,
    /// How each repetition ended; one where the case ran once.
    pub outcomes: Vec<Kind>,
    /// What keeps its failure from counting.
    pub quarantine: Option<Quarantine>,
    /// How long it took on the clock of the bus, with the way to the precondition and back.
    pub duration: Duration,
}

impl CaseReport {
    /// Whether repetitions ended differently.
    pub fn is_flaky(&self) -> bool {
        self.outcomes.windows(2).any(|pair| pair.first() != pair.last())
    }
}
