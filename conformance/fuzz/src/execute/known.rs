//! Violations that were seen before. The fuzzer does not again wait the full time for their missing answers, and they
//! end no sequence.

use super::{MOST_SLOW, Pace, WEDGED};
use crate::oracle::Violation;
use crate::property::Property;
use std::collections::{BTreeMap, BTreeSet};

/// A property and the violated rule.
pub(crate) type Key = (Property, &'static str);

/// The known violations of this device.
#[derive(Debug, Default)]
pub(crate) struct KnownViolations {
    /// The violation that is being shown again. The fuzzer does not wait the full time for its missing answer.
    presumed: Option<Key>,
    /// Whether the violation was shown again before the full time had passed.
    has_hurried: bool,
    /// Violations that were reported: they end no sequence.
    reported: BTreeSet<Key>,
    /// Reported violations that were missing answers. The fuzzer does not wait the full time for these answers.
    silence: BTreeSet<Key>,
    /// Number of slow answers of the SDO server, by the rule that requires the answer. The fuzzer avoids an answer that
    /// was slow too often.
    slow: BTreeMap<&'static str, u32>,
}

impl KnownViolations {
    /// Sets the violation that is to be shown again; `None`: the fuzzer waits the full times. Returns whether the
    /// previous violation was shown before its full time had passed.
    pub(crate) const fn presume(&mut self, violation: Option<Key>) -> bool {
        self.presumed = violation;
        std::mem::replace(&mut self.has_hurried, false)
    }

    /// Whether a violation is being shown again.
    pub(crate) const fn presumes(&self) -> bool {
        self.presumed.is_some()
    }

    /// Marks a violation as reported, so that it is not reported again.
    pub(crate) fn take_for_granted(&mut self, violation: &Violation) {
        let key = (violation.property, violation.rule);
        self.reported.insert(key);
        if violation.is_silence {
            self.silence.insert(key);
        }
    }

    /// Whether the violation was reported before and is not the one that is being shown again.
    pub(crate) fn is_reported(&self, violation: &Violation) -> bool {
        let key = (violation.property, violation.rule);
        self.presumed != Some(key) && self.reported.contains(&key)
    }

    /// Whether the fuzzer has waited the full time for this missing answer before.
    pub(crate) fn is_known_silence(&self, key: Key, pace: Pace) -> bool {
        self.presumed == Some(key) || pace == Pace::Swift && self.silence.contains(&key)
    }

    /// Records that a violation was shown again before its full time had passed.
    pub(crate) const fn hurry(&mut self) {
        self.has_hurried = true;
    }

    /// Whether a server that can't be read any more would be a new violation.
    pub(crate) fn is_wedged_news(&self) -> bool {
        self.presumed.is_none() && !self.silence.contains(&WEDGED) && !self.reported.contains(&WEDGED)
    }

    /// Whether the device is known to send excess answers, which would be taken for answers to the next frame.
    pub(crate) fn answers_too_much(&self) -> bool {
        self.reported.iter().any(|(property, _)| matches!(property, Property::OneAnswer | Property::Silent))
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
