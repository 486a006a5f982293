//! The thresholds of rules: defaults, and the user's settings.

use super::percent::Percent;
use super::registry;
use super::rule::Metadata;
use canvass_traces::Duration;
use std::collections::BTreeMap;
use std::fmt;

/// A limit with which a rule compares, and which the user can set.
#[derive(Debug)]
pub struct Threshold {
    /// The name, which follows the rule's id and a dot.
    pub name: &'static str,
    /// The default value.
    pub default: u64,
    /// The unit of the value.
    pub unit: Unit,
    /// The lowest allowed value.
    pub least: u64,
    /// The highest allowed value.
    pub most: u64,
    /// The meaning of the threshold.
    pub meaning: &'static str,
}

/// The unit of a threshold.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unit {
    /// A time in milliseconds.
    Milliseconds,
    /// A time in microseconds.
    Microseconds,
    /// A share.
    Percent,
    /// A number of the named items; a plain number has an empty name.
    Count(&'static str),
}

/// The thresholds of all rules: defaults and settings.
#[derive(Clone, Debug, Default)]
pub struct Thresholds {
    set: BTreeMap<(&'static str, &'static str), u64>,
}

/// Why a threshold can't be set.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ThresholdError {
    /// The text does not have the right form.
    #[error("expected RULE.NAME=VALUE such as bus/load.percent=70, found \"{0}\"")]
    Syntax(String),
    /// The rule does not exist.
    #[error("there is no rule \"{0}\": `canvass list rules` lists them")]
    Rule(String),
    /// The rule has no threshold with this name.
    #[error("rule {rule} has no threshold \"{name}\": it has {known}")]
    Name {
        /// The rule.
        rule: &'static str,
        /// The given name.
        name: String,
        /// The names of the rule's thresholds.
        known: String,
    },
    /// The value has another unit.
    #[error("{rule}.{name} is {expected}, found \"{found}\"")]
    Unit {
        /// The rule.
        rule: &'static str,
        /// The threshold.
        name: &'static str,
        /// The expected unit, in words.
        expected: String,
        /// The given value.
        found: String,
    },
    /// The value is too low or too high.
    #[error("expected {rule}.{name} from {least} to {most}, found {found}")]
    Range {
        /// The rule.
        rule: &'static str,
        /// The threshold.
        name: &'static str,
        /// The lowest allowed value.
        least: u64,
        /// The highest allowed value.
        most: u64,
        /// The given value.
        found: u64,
    },
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Milliseconds => "ms",
            Self::Microseconds => "µs",
            Self::Percent => "%",
            Self::Count(of) => of,
        })
    }
}

impl Unit {
    /// Whether `word` after a value means this unit; an empty word means any unit.
    fn is_written(self, word: &str) -> bool {
        word.is_empty() || word == self.to_string() || self == Self::Microseconds && word == "us"
    }

    /// The expected value, for a message.
    fn words(self) -> String {
        match self {
            Self::Milliseconds => "a time in ms".to_owned(),
            Self::Microseconds => "a time in µs".to_owned(),
            Self::Percent => "a share in %".to_owned(),
            Self::Count("") => "a number".to_owned(),
            Self::Count(of) => format!("a number of {of}"),
        }
    }
}

impl Thresholds {
    /// The value of a rule's n-th threshold.
    fn value(&self, rule: &'static Metadata, at: usize) -> u64 {
        let Some(threshold) = rule.thresholds.get(at) else {
            debug_assert!(false, "{} has no threshold {at}", rule.id);
            return 0;
        };
        self.set.get(&(rule.id, threshold.name)).copied().unwrap_or(threshold.default)
    }

    /// The value of a rule's n-th threshold, in milliseconds.
    pub fn milliseconds(&self, rule: &'static Metadata, at: usize) -> Duration {
        Duration::from_millis(self.value(rule, at))
    }

    /// The value of a rule's n-th threshold, in microseconds.
    pub fn microseconds(&self, rule: &'static Metadata, at: usize) -> Duration {
        Duration::from_micros(self.value(rule, at))
    }

    /// The value of a rule's n-th threshold, as a share.
    pub fn percent(&self, rule: &'static Metadata, at: usize) -> Percent {
        Percent(self.value(rule, at))
    }

    /// The value of a rule's n-th threshold, as a number.
    pub fn count(&self, rule: &'static Metadata, at: usize) -> u64 {
        self.value(rule, at)
    }

    /// Sets a threshold by `RULE.NAME=VALUE`, with or without the unit.
    ///
    /// # Errors
    /// [`ThresholdError`] for a wrong form, an unknown rule or threshold, or an invalid value.
    pub fn set(&mut self, text: &str) -> Result<(), ThresholdError> {
        let syntax = || ThresholdError::Syntax(text.to_owned());
        let (key, given) = text.split_once('=').ok_or_else(syntax)?;
        let (id, name) = key.trim().rsplit_once('.').ok_or_else(syntax)?;
        let given = given.trim();
        let digits = given.bytes().take_while(u8::is_ascii_digit).count();
        let (value, unit) = given.split_at(digits);
        let found = value.parse().map_err(|_| syntax())?;
        let rule = registry::find(id).ok_or_else(|| ThresholdError::Rule(id.to_owned()))?.metadata;
        let threshold = rule.thresholds.iter().find(|threshold| threshold.name == name).ok_or_else(|| {
            let known: Vec<&str> = rule.thresholds.iter().map(|threshold| threshold.name).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            ThresholdError::Name { rule: rule.id, name: name.to_owned(), known }
        })?;
        let (rule, name) = (rule.id, threshold.name);
        if !threshold.unit.is_written(unit.trim()) {
            return Err(ThresholdError::Unit { rule, name, expected: threshold.unit.words(), found: given.to_owned() });
        }
        let Threshold { least, most, .. } = *threshold;
        if !(least..=most).contains(&found) {
            return Err(ThresholdError::Range { rule, name, least, most, found });
        }
        self.set.insert((rule, name), found);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_as_typed() {
        let mut thresholds = Thresholds::default();
        let load = registry::find("bus/load").unwrap().metadata;
        assert_eq!(thresholds.percent(load, 0), Percent(85));
        for given in ["bus/load.percent=70", "bus/load.percent=70%", "bus/load.percent = 70 %"] {
            thresholds.set(given).unwrap();
            assert_eq!(thresholds.percent(load, 0), Percent(70));
        }
        thresholds.set("bus/load.window=500ms").unwrap();
        assert_eq!(thresholds.milliseconds(load, 1), Duration::from_millis(500));
        assert!(matches!(thresholds.set("bus/load=70"), Err(ThresholdError::Syntax(_))));
        assert!(matches!(thresholds.set("bus/load.percent=x"), Err(ThresholdError::Syntax(_))));
        assert!(matches!(thresholds.set("bus/lode.percent=1"), Err(ThresholdError::Rule(_))));
        let says = |text: &str| Thresholds::default().set(text).unwrap_err().to_string();
        assert_eq!(says("bus/load.per=1"), "rule bus/load has no threshold \"per\": it has percent, window");
        assert_eq!(says("bus/load.percent=1ms"), "bus/load.percent is a share in %, found \"1ms\"");
        assert_eq!(
            says("bus/load.window=0").split(',').next(),
            Some("expected bus/load.window from 1 to 18446744073709551615")
        );
    }

    #[test]
    fn every_default_can_be_set() {
        for rule in registry::all().map(|definition| definition.metadata) {
            for Threshold { name, default, unit, .. } in rule.thresholds {
                let given = format!("{}.{name}={default}{unit}", rule.id);
                assert_eq!(Thresholds::default().set(&given), Ok(()), "{given}");
            }
        }
    }
}
