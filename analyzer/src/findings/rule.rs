//! What a rule is: what is said of it, and how it watches a bus.

use super::context::{Context, Scene};
use super::finding::Severity;
use super::sink::Sink;
use crate::NodeId;
use crate::message::Service;
use std::collections::BTreeMap;

/// What is said of a rule. `canvass explain` and `docs/rules.md` have no other source.
#[derive(Debug)]
pub struct Metadata {
    /// Its id, which never changes, such as `nodes/heartbeat-missing`.
    pub id: &'static str,
    /// The severity of its findings; single findings may be less severe.
    pub severity: Severity,
    /// What it finds, in one line.
    pub title: &'static str,
    /// What exactly is found, and what is not.
    pub what: &'static str,
    /// Why it matters.
    pub why: &'static str,
    /// What to look at next.
    pub advice: &'static str,
    /// What can be set.
    pub thresholds: &'static [Threshold],
}

/// A number that a rule compares with.
#[derive(Debug)]
pub struct Threshold {
    /// Its name, behind the rule's id and a dot.
    pub name: &'static str,
    /// What it is unless it is set.
    pub default: u64,
    /// `ms`, `%`, or empty for a mere number.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

/// A rule: what is said of it, and how its state for one bus is made.
#[derive(Debug)]
pub struct Definition {
    /// What is said of it.
    pub metadata: &'static Metadata,
    /// The services whose frames it is shown.
    pub services: &'static [Service],
    /// Frames that it is shown beside these.
    pub also: Also,
    /// Its state for one bus; `None` for a rule about whole captures.
    pub make: Option<Make>,
}

/// Frames of which only some are worth a rule's while: so that the others cost it nothing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Also {
    /// No others.
    Nothing,
    /// Those with values of an encoder's objects, be it in a TPDO or an SDO transfer.
    EncoderValues,
    /// TPDOs of whose communication parameters the capture has shown something.
    KnownTpdos,
    /// Those that are about a node which was told to reset itself, and whose boot-up has not come yet.
    Resetting,
}

/// Makes a rule's state for one bus.
pub type Make = fn(&Thresholds) -> Box<dyn Rule>;

/// A rule's state on one bus. It does no I/O and reads no clock; time is that of the capture.
pub trait Rule {
    /// A frame of one of its services.
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>);

    /// Time has gone on: called at most every [`super::Diagnosis::TICK`], before the frame that shows it.
    fn tick(&mut self, _scene: &Scene<'_>, _sink: &mut Sink<'_>) {}

    /// The parameters of a node's TPDOs may have changed with the frame that comes next, or are known with it.
    fn reconfigured(&mut self, _node: NodeId, _scene: &Scene<'_>) {}

    /// Frames may be missing here, or the clock has stepped: what was waited for may have come unseen.
    fn interrupted(&mut self) {}

    /// The capture has ended.
    fn finish(&mut self, _scene: &Scene<'_>, _sink: &mut Sink<'_>) {}
}

/// The thresholds of all rules: their defaults, and what was set.
#[derive(Clone, Debug, Default)]
pub struct Thresholds {
    set: BTreeMap<(&'static str, &'static str), u64>,
}

/// Why a threshold can't be set.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ThresholdError {
    /// It is not written as it should be.
    #[error("expected RULE.NAME=VALUE such as bus/load.percent=70, found \"{0}\"")]
    Syntax(String),
    /// There is no such rule.
    #[error("there is no rule \"{0}\": `canvass list rules` shows them")]
    Rule(String),
    /// The rule has no threshold of that name.
    #[error("rule {rule} has no threshold \"{name}\": it has {known}")]
    Name {
        /// The rule.
        rule: &'static str,
        /// As given.
        name: String,
        /// The names that there are.
        known: String,
    },
}

impl Thresholds {
    /// The value of one of a rule's thresholds.
    pub fn get(&self, rule: &'static Metadata, name: &str) -> u64 {
        let Some(threshold) = rule.thresholds.iter().find(|threshold| threshold.name == name) else {
            debug_assert!(false, "{} has no threshold {name}", rule.id);
            return 0;
        };
        self.set.get(&(rule.id, threshold.name)).copied().unwrap_or(threshold.default)
    }

    /// Sets one, given as `RULE.NAME=VALUE`.
    ///
    /// # Errors
    /// [`ThresholdError`] if that is not how it is written, or there is no such rule or threshold.
    pub fn set(&mut self, text: &str) -> Result<(), ThresholdError> {
        let syntax = || ThresholdError::Syntax(text.to_owned());
        let (key, value) = text.split_once('=').ok_or_else(syntax)?;
        let (id, name) = key.trim().rsplit_once('.').ok_or_else(syntax)?;
        let value = value.trim().parse().map_err(|_| syntax())?;
        let rule = super::find(id).ok_or_else(|| ThresholdError::Rule(id.to_owned()))?.metadata;
        let threshold = rule.thresholds.iter().find(|threshold| threshold.name == name).ok_or_else(|| {
            let known: Vec<&str> = rule.thresholds.iter().map(|threshold| threshold.name).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            ThresholdError::Name { rule: rule.id, name: name.to_owned(), known }
        })?;
        self.set.insert((rule.id, threshold.name), value);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_as_typed() {
        let mut thresholds = Thresholds::default();
        thresholds.set("bus/load.percent=70").unwrap();
        let load = super::super::find("bus/load").unwrap().metadata;
        assert_eq!(thresholds.get(load, "percent"), 70);
        assert!(matches!(thresholds.set("bus/load=70"), Err(ThresholdError::Syntax(_))));
        assert!(matches!(thresholds.set("bus/load.percent=x"), Err(ThresholdError::Syntax(_))));
        assert!(matches!(thresholds.set("bus/lode.percent=1"), Err(ThresholdError::Rule(_))));
        let unknown = thresholds.set("bus/load.per=1").unwrap_err();
        assert_eq!(unknown.to_string(), "rule bus/load has no threshold \"per\": it has percent, window");
    }
}
