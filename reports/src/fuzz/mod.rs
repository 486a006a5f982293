//! The report of a run of the fuzzer, made from one [`Run`]. On the simulated bus two runs of the same seed give the same bytes: nothing but the date of the
//! provenance is of the wall clock.

pub mod detection;
pub mod faults_page;
mod json;
pub mod properties;
mod report;

use crate::provenance::Provenance;
use canvass_analyzer::NodeId;
use canvass_fuzzer::Property;
use canvass_fuzzer::campaign::{Found, Outcome};
use canvass_fuzzer::coverage::{Answer, Coverage, LssReach, SdoReach};
use canvass_fuzzer::{FinalState, Kept, Targets, Then, reproducer};
use canvass_suite::bench::Annotate;
use canvass_suite::touch::Touch;
use canvass_suite::zero_point::Moved;
use canvass_traces::{ChannelId, Direction, Record, Timestamp};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// A whole run, as the reports need it.
#[derive(Clone, Debug)]
pub struct Run {
    /// Where the result comes from.
    pub provenance: Provenance,
    /// The bus's address.
    pub bus: String,
    /// In bit/s, where it is known.
    pub bit_rate: Option<u32>,
    /// The device's node-ID.
    pub node: NodeId,
    /// What the user calls the device; empty: not described.
    pub model: String,
    /// The services.
    pub targets: Targets,
    /// What the sequences were allowed to do.
    pub allow: BTreeSet<Touch>,
    pub seed: u64,
    /// The command that repeats the run.
    pub repeat: String,
    /// Whether the run was interrupted.
    pub cancelled: bool,
    /// What of the SDO server can be reached.
    pub sdo_reach: SdoReach,
    /// What of LSS can be reached.
    pub reach: LssReach,
    pub outcome: Outcome,
    /// The zero point of the device on a bus that goes on, if it is not where it was before the run.
    pub zero_point: Option<Moved>,
    /// The words for the frames of each violation.
    pub words: Vec<Words>,
}

/// What the frames of a violation mean.
#[derive(Clone, Debug)]
pub struct Words {
    /// Of the minimal sequence, one text for each frame.
    pub sequence: Vec<String>,
    /// Of the frames on the bus.
    pub evidence: Vec<String>,
}

impl Words {
    /// The words that decoders give; each begins without any context.
    pub fn of(found: &Found, decoder: &mut dyn FnMut() -> Box<dyn Annotate>) -> Self {
        let mut annotate = decoder();
        let evidence: Vec<String> = found.evidence.iter().map(|record| annotate.annotate(record)).collect();
        let mut alone = decoder();
        let record = |frame| Record::new(Timestamp::ZERO, ChannelId(0), frame).with_direction(Direction::Tx);
        // With the device's answers in between a frame means more than alone.
        let mut sent = found.evidence.iter().zip(&evidence).filter(|(record, _)| record.direction == Direction::Tx);
        let sequence = found.sequence.stimuli.iter().map(|stimulus| match sent.next() {
            Some((record, words)) if record.frame == stimulus.frame => words.clone(),
            _ => alone.annotate(&record(stimulus.frame)),
        });
        let sequence = sequence.collect();
        Self { sequence, evidence }
    }
}

/// The share of combinations of state and command that was exercised.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Share {
    /// Number of exercised combinations.
    pub reached: usize,
    /// Number of all combinations.
    pub reachable: usize,
}

impl Share {
    /// In percent, rounded down; of nothing all was reached.
    pub fn percent(self) -> usize {
        (self.reached * 100).checked_div(self.reachable).unwrap_or(100)
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of {} ({} %)", self.reached, self.reachable, self.percent())
    }
}

impl Run {
    fn coverage(&self) -> &Coverage {
        &self.outcome.coverage
    }

    /// What was exercised of the SDO server.
    pub fn sdo_share(&self) -> Share {
        let (reached, reachable) = self.coverage().sdo_share(self.sdo_reach);
        Share { reached, reachable }
    }

    /// What was exercised of the LSS slave.
    pub fn lss_share(&self) -> Share {
        let (reached, reachable) = self.coverage().lss_share(&self.reach);
        Share { reached, reachable }
    }

    /// What the sequences never did, because nobody allowed it.
    fn forbidden(&self) -> String {
        let names: Vec<&str> = Touch::ALL
            .into_iter()
            .filter(|touch| touch.is_by_the_tester() && !self.allow.contains(touch))
            .map(Touch::name)
            .collect();
        names.join(",")
    }

    /// The violations with their words.
    fn violations(&self) -> impl Iterator<Item = (&Found, &Words)> {
        self.outcome.violations.iter().zip(&self.words)
    }
}

/// One line about the outcome.
pub fn outcome(run: &Run) -> String {
    let outcome = &run.outcome;
    let count = match outcome.violations.len() {
        0 => "no property is violated".to_owned(),
        1 => "1 violation".to_owned(),
        count => format!("{count} violations"),
    };
    let flaky = match outcome.violations.iter().filter(|found| !found.confirmed).count() {
        0 => String::new(),
        1 => ", 1 of them was seen once only".to_owned(),
        count => format!(", {count} of them were seen once only"),
    };
    let dead = if outcome.dead { "; the device is dead" } else { "" };
    let unjudged = match outcome.unjudged {
        0 => String::new(),
        1 => "; 1 sequence could not be judged".to_owned(),
        count => format!("; {count} sequences could not be judged"),
    };
    let ended = if outcome.ended_by.is_some() { "; the bus was lost before the end" } else { "" };
    let cancelled = if run.cancelled { " (cancelled before the end)" } else { "" };
    format!("{count}{flaky}{dead}{unjudged}{ended}{cancelled}")
}

/// How the way to the bus was interrupted, and why the run ended with that, if it did; empty if nothing was wrong.
fn trouble(run: &Run) -> String {
    let interruptions = run.outcome.interruptions.as_ref().map(ToString::to_string);
    let ended_by = run.outcome.ended_by.as_ref().map(|why| format!("the run ended early: {why}"));
    interruptions.into_iter().chain(ended_by).collect::<Vec<_>>().join("; ")
}

/// How the run left the device's settings; empty where nothing was to be left.
fn left(run: &Run) -> String {
    let zero_point = run.zero_point.as_ref().map(ToString::to_string);
    let settings = Some(settings_left(run)).filter(|text| !text.is_empty());
    settings.into_iter().chain(zero_point).collect::<Vec<_>>().join("; ")
}

fn settings_left(run: &Run) -> String {
    let outcome = &run.outcome;
    let Some(FinalState { settings, compared, different }) = &outcome.left else {
        let is_live = outcome.dead || !outcome.is_simulated;
        let why = if outcome.ended_by.is_some() { "the bus was lost" } else { "it does not answer any more" };
        let unknown = format!("whether the device's settings are as before the run is not known: {why}");
        return if is_live { unknown } else { String::new() };
    };
    match (different.len(), compared) {
        (0, 0) => "no setting of the device could be read".to_owned(),
        (0, _) if compared == settings => format!("the device's settings are as before the run ({compared} were read)"),
        (0, _) => format!("{compared} of the device's {settings} settings were read again, and are as before the run"),
        (1, _) => format!("1 of {compared} settings is not as before the run: {}", values(different, "holds")),
        (count, _) => {
            format!("{count} of {compared} settings are not as before the run: {}", values(different, "holds"))
        }
    }
}

/// Objects with the value that they have and the one of power-on.
fn values(kept: &[Kept], holds: &str) -> String {
    let value = |kept: &Kept| format!("{} {holds} {:X}h instead of {:X}h", kept.at, kept.value, kept.power_on);
    kept.iter().map(value).collect::<Vec<_>>().join(", ")
}

/// What is to be known of a violation that did not come back.
fn reliability(found: &Found, dead: bool) -> String {
    let text = match (found.confirmed, dead && found.violation.property == Property::Alive) {
        (false, _) if found.is_cut_off => {
            "was seen once, and the bus was lost before it could be repeated: its whole trace is shown"
        }
        (true, _) => "comes back whenever the sequence is repeated from power-on",
        (false, true) => "the device did not come back after it: these are its last frames",
        (false, false) => {
            "was seen once and did not come back when the sequence was repeated from power-on: its whole trace is shown"
        }
    };
    if found.state.is_empty() {
        return text.to_owned();
    }
    let kept = values(&found.state, "held");
    format!("{text}; neither a reset nor a write had restored the state of power-on: {kept}")
}

/// What follows a frame of a sequence, where that is not the usual.
fn then(then: Then) -> String {
    match then {
        Then::Settle => String::new(),
        Then::AtOnce => "next frame at once".to_owned(),
        Then::Pause(time) => format!("then {time}"),
    }
}

/// The minimal sequence, a line for each frame with its meaning.
fn annotated(found: &Found, words: &Words) -> String {
    let stimuli = found.sequence.stimuli.iter().zip(&words.sequence);
    stimuli.fold(String::new(), |mut text, (stimulus, words)| {
        let frame = stimulus.frame.to_string();
        let then = match then(stimulus.then) {
            then if then.is_empty() => then,
            then => format!(" [{then}]"),
        };
        // Writing to a string can't fail.
        let _ = writeln!(text, "{frame:24} {words}{then}");
        text
    })
}

/// The Rust test that shows the violation.
fn rust_test(run: &Run, found: &Found) -> String {
    reproducer::rust_test(found, &run.bus, run.node, run.seed)
}

/// State, command, and how often which answer came.
type SdoRow = (&'static str, &'static str, Vec<(Answer, u64)>);

/// The SDO coverage.
fn sdo_rows(run: &Run) -> Vec<SdoRow> {
    let mut rows: Vec<SdoRow> = Vec::new();
    for (state, command, answer, count) in run.coverage().sdo_rows() {
        match rows.last_mut().filter(|row| (row.0, row.1) == (state.name(), command.name())) {
            Some(row) => row.2.push((answer, count)),
            None => rows.push((state.name(), command.name(), vec![(answer, count)])),
        }
    }
    rows
}

#[cfg(test)]
mod tests;
