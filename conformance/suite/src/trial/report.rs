//! The report of a case.

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
    /// The verdict of the case.
    pub verdict: Verdict,
    /// The frames that were on the bus.
    pub evidence: Evidence,
    /// Other observations.
    pub notes: Vec<String>,
    /// The measurements, for any verdict.
    pub measurements: Vec<Measurement>,
    /// The objects that the case chose among several.
    pub uses: Vec<Use>,
    /// The messages that others sent to the device or for it meanwhile.
    pub foreign: Vec<ForeignMessages>,
    /// The verdict of each repetition; a single one if the case ran once.
    pub outcomes: Vec<Kind>,
    /// The quarantine that keeps a failure from counting.
    pub quarantine: Option<Quarantine>,
    /// The duration of the case on the clock of the bus, including precondition and restoration.
    pub duration: Duration,
}

impl CaseReport {
    /// Whether repetitions ended differently.
    pub fn is_flaky(&self) -> bool {
        self.outcomes.windows(2).any(|pair| pair.first() != pair.last())
    }
}
