//! Violations that were seen before: nobody waits for them as long again, and they end no sequence.

use super::{MOST_SLOW, Pace, WEDGED};
use crate::oracle::Violation;
use crate::property::Property;
use std::collections::{BTreeMap, BTreeSet};

/// A property, and the rule of it that does not hold.
pub(crate) type Key = (Property, &'static str);

/// What is known of the violations of this device.
#[derive(Debug, Default)]
pub(crate) struct KnownViolations {
    /// A violation that was seen and is being shown again: an answer that is known to be missing is not waited for long.
    presumed: Option<Key>,
    /// That was seen again, without the whole of its time.
    has_hurried: bool,
    /// Violations that were reported: they end no sequence.
    reported: BTreeSet<Key>,
    /// Those of them that were silence: for an answer that is known not to come nobody waits long.
    silence: BTreeSet<Key>,
    /// How often an answer of the SDO server took so long that others have to be left out: by what was awaited.
    slow: BTreeMap<&'static str, u32>,
}

impl KnownViolations {
    /// From now on that violation is only to be shown again; `None`: whole times are waited for. Whether some of it was
    /// shown without the whole of its time.
    pub const fn presume(&mut self, violation: Option<Key>) -> bool {
        self.presumed = violation;
        std::mem::replace(&mut self.has_hurried, false)
    }

    /// Whether a violation is only to be shown again.
    pub const fn presumes(&self) -> bool {
        self.presumed.is_some()
    }

    /// That violation was reported, and is not reported again.
    pub fn take_for_granted(&mut self, violation: &Violation) {
        let key = (violation.property, violation.rule);
        self.reported.insert(key);
        if violation.is_silence {
            self.silence.insert(key);
        }
    }

    /// Whether that violation was reported before, and is not the one that is to be shown again.
    pub fn is_reported(&self, violation: &Violation) -> bool {
        let key = (violation.property, violation.rule);
        self.presumed != Some(key) && self.reported.contains(&key)
    }

    /// Whether that silence is one that was waited for in full before.
    pub fn is_known_silence(&self, key: Key, pace: Pace) -> bool {
        self.presumed == Some(key) || pace == Pace::Swift && self.silence.contains(&key)
    }

    /// Ends the time of a try early: what is to be shown again has been shown without the whole of its time.
    pub const fn hurry(&mut self) {
        self.has_hurried = true;
    }

    /// Whether a server that can't be read any more would be something new.
    pub fn is_wedged_news(&self) -> bool {
        self.presumed.is_none() && !self.silence.contains(&WEDGED) && !self.reported.contains(&WEDGED)
    }

    /// Whether the device is known to answer where nothing is due: that would be taken for the answer to the next frame.
    pub fn answers_too_much(&self) -> bool {
        self.reported.iter().any(|(property, _)| matches!(property, Property::OneAnswer | Property::Silent))
    }

    /// Whether some answers are known not to come, or to be slow.
    pub fn shortens_waits(&self) -> bool {
        self.presumed.is_some() || !self.silence.is_empty() || !self.slow.is_empty()
    }

    /// What was awaited took long.
    pub fn add_slow(&mut self, awaited: &'static str) {
        *self.slow.entry(awaited).or_default() += 1;
    }

    /// Whether the answer to what is awaited was slow so often that it is not waited for any more.
    pub fn is_too_slow(&self, awaited: &'static str) -> bool {
        self.slow.get(awaited).is_some_and(|&times| times >= MOST_SLOW)
    }
}
