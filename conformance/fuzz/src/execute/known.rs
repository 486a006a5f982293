//! Violations that were seen before. The fuzzer does not again wait the full time for their missing answers, and they
//! end no sequence.

use super::{MOST_SLOW, Pace, WEDGED};
use crate::oracle::{Defect, Violation};
use crate::property::Property;
use std::collections::{BTreeMap, BTreeSet};

/// A property and the violated rule.
pub(crate) type Key = (Property, &'static str);

/// The known violations of this device.
#[derive(Debug, Default)]
pub(crate) struct KnownViolations {
    /// The violation that is being shown again. The fuzzer does not wait the full time for its missing answer.
    presumed: Option<Defect>,
    /// Violations that were reported: they end no sequence.
    reported: BTreeSet<Defect>,
    /// Number of times that each reported violation came again without ending its sequence.
    times: BTreeMap<Defect, u64>,
    /// Reported violations that were missing answers. The fuzzer does not wait the full time for these answers.
    silence: BTreeSet<Key>,
    /// Number of slow answers of the SDO server, by the rule that requires the answer. The fuzzer avoids an answer that
    /// was slow too often.
    slow: BTreeMap<&'static str, u32>,
}

impl KnownViolations {
    /// Sets the violation that is to be shown again; `None`: the fuzzer waits the full times.
    pub(crate) const fn presume(&mut self, violation: Option<Defect>) {
        self.presumed = violation;
    }

    /// Whether a violation is being shown again.
    pub(crate) const fn presumes(&self) -> bool {
        self.presumed.is_some()
    }

    /// Marks a violation as reported, so that it is not reported again.
    pub(crate) fn take_for_granted(&mut self, violation: &Violation) {
        self.reported.insert(violation.defect());
        if violation.is_silence {
            self.silence.insert((violation.property, violation.rule));
        }
    }

    /// Counts a reported violation that ends no sequence.
    pub(crate) fn count(&mut self, violation: &Violation) {
        *self.times.entry(violation.defect()).or_default() += 1;
    }

    /// Number of times that a reported violation came again without ending its sequence.
    pub(crate) fn times(&self, defect: &Defect) -> u64 {
        self.times.get(defect).copied().unwrap_or_default()
    }

    /// Whether the violation was reported before and is not the one that is being shown again.
    pub(crate) fn is_reported(&self, violation: &Violation) -> bool {
        let defect = violation.defect();
        self.presumed != Some(defect) && self.reported.contains(&defect)
    }

    /// Whether the fuzzer has waited the full time for this missing answer before.
    pub(crate) fn is_known_silence(&self, key: Key, pace: Pace) -> bool {
        let is_presumed = self.presumed.is_some_and(|defect| (defect.property, defect.rule) == key);
        is_presumed || pace == Pace::Swift && self.silence.contains(&key)
    }

    /// Whether a server that can't be read any more would be a new violation.
    pub(crate) fn is_wedged_news(&self) -> bool {
        let is_reported = self.reported.iter().any(|defect| (defect.property, defect.rule) == WEDGED);
        self.presumed.is_none() && !self.silence.contains(&WEDGED) && !is_reported
    }

    /// Whether the device is known to send excess answers, which would be taken for answers to the next frame.
    pub(crate) fn answers_too_much(&self) -> bool {
        self.reported.iter().any(|defect| matches!(defect.property, Property::OneAnswer | Property::Silent))
    }

    /// Whether some answers are known to be missing or slow.
    pub(crate) fn shortens_waits(&self) -> bool {
        self.presumed.is_some() || !self.silence.is_empty() || !self.slow.is_empty()
    }

    /// Counts a slow answer.
    pub(crate) fn add_slow(&mut self, awaited: &'static str) {
        *self.slow.entry(awaited).or_default() += 1;
    }

    /// Whether an answer that this rule requires was slow too often to wait for it again.
    pub(crate) fn is_too_slow(&self, awaited: &'static str) -> bool {
        self.slow.get(awaited).is_some_and(|&times| times >= MOST_SLOW)
    }
}
