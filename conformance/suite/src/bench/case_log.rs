//! What a case has found and measured so far: its verdict and its report are made of it.

use super::measurement::{Measurement, Unit};
use crate::verdict::Breach;
use canvass_analyzer::Multiplexer;
use canvass_traces::Timestamp;

/// The findings of one case.
#[derive(Debug, Default)]
pub(crate) struct CaseLog {
    breaches: Vec<Breach>,
    /// Answers of the SDO server whose form is wrong, one of each sort.
    untidy: Vec<Breach>,
    pub(super) notes: Vec<String>,
    measurements: Vec<Measurement>,
    uses: Vec<Use>,
}

/// An object that served a case, where another could have.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Use {
    /// The object.
    pub multiplexer: Multiplexer,
    /// What for.
    pub purpose: &'static str,
}

/// A moment in a case: breaches after it can be forgotten.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    breaches: usize,
    untidy: usize,
}

impl CaseLog {
    /// Adds a breach; one without a time of its own was seen with the `last` frame.
    pub fn record(&mut self, breach: Breach, last: Option<Timestamp>) {
        let seen = breach.seen.or(last);
        self.breaches.push(Breach { seen, ..breach });
    }

    /// The breaches so far.
    pub fn breaches(&self) -> &[Breach] {
        &self.breaches
    }

    /// The breaches, for the verdict.
    pub fn take_breaches(&mut self) -> Vec<Breach> {
        std::mem::take(&mut self.breaches)
    }

    /// Keeps an answer whose form is wrong, unless one of its sort is known.
    pub fn keep_untidy(&mut self, breach: Breach) {
        if !self.untidy.iter().any(|known| known.actual == breach.actual) {
            self.untidy.push(breach);
        }
    }

    /// The answers whose form is wrong.
    pub fn take_untidy(&mut self) -> Vec<Breach> {
        std::mem::take(&mut self.untidy)
    }

    /// This moment.
    pub(super) const fn mark(&self) -> Mark {
        Mark { breaches: self.breaches.len(), untidy: self.untidy.len() }
    }

    /// Forgets the breaches since then.
    pub(super) fn forget_since(&mut self, mark: Mark) {
        self.breaches.truncate(mark.breaches);
        self.untidy.truncate(mark.untidy);
    }

    /// Adds a measurement.
    pub fn measure(&mut self, name: String, value: u64, unit: Unit) {
        self.measurements.push(Measurement { name, value, unit });
    }

    /// Says which object served the case; once.
    pub fn uses(&mut self, using: Use) {
        if !self.uses.contains(&using) {
            self.uses.push(using);
        }
    }

    /// What goes into the report beside the breaches: notes, measurements, and which objects served.
    pub(super) fn take(&mut self) -> (Vec<String>, Vec<Measurement>, Vec<Use>) {
        let Self { notes, measurements, uses, .. } = std::mem::take(self);
        (notes, measurements, uses)
    }
}
