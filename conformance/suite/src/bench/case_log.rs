//! The findings and measurements of a case so far, from which its verdict and report are made.

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

/// An object that a case chose among several that could serve it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Use {
    /// The object.
    pub multiplexer: Multiplexer,
    /// The purpose of the object in the case.
    pub purpose: &'static str,
}

/// A position in the log of a case: breaches after it can be forgotten.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    breaches: usize,
    untidy: usize,
}

impl CaseLog {
    /// Adds a breach. A breach without a time gets the time of the `last` frame.
    pub fn record(&mut self, breach: Breach, last: Option<Timestamp>) {
        let seen = breach.seen.or(last);
        self.breaches.push(Breach { seen, ..breach });
    }

    /// The breaches so far.
    pub fn breaches(&self) -> &[Breach] {
        &self.breaches
    }

    /// The breaches, for the verdict.
    pub(crate) fn take_breaches(&mut self) -> Vec<Breach> {
        std::mem::take(&mut self.breaches)
    }

    /// Keeps an answer with a wrong form, unless an equal one is already kept.
    pub(crate) fn keep_untidy(&mut self, breach: Breach) {
        if !self.untidy.iter().any(|known| known.actual == breach.actual) {
            self.untidy.push(breach);
        }
    }

    /// Takes the answers with a wrong form.
    pub(crate) fn take_untidy(&mut self) -> Vec<Breach> {
        std::mem::take(&mut self.untidy)
    }

    /// The current position.
    pub(super) const fn mark(&self) -> Mark {
        Mark { breaches: self.breaches.len(), untidy: self.untidy.len() }
    }

    /// Forgets all breaches after the mark.
    pub(super) fn forget_since(&mut self, mark: Mark) {
        self.breaches.truncate(mark.breaches);
        self.untidy.truncate(mark.untidy);
    }

    /// Adds a measurement.
    pub fn measure(&mut self, name: String, value: u64, unit: Unit) {
        self.measurements.push(Measurement { name, value, unit });
    }

    /// Records once that an object served the case.
    pub fn uses(&mut self, using: Use) {
        if !self.uses.contains(&using) {
            self.uses.push(using);
        }
    }

    /// Takes the further contents of the report: notes, measurements, and the objects that served.
    pub(super) fn take(&mut self) -> (Vec<String>, Vec<Measurement>, Vec<Use>) {
        let Self { notes, measurements, uses, .. } = std::mem::take(self);
        (notes, measurements, uses)
    }
}
