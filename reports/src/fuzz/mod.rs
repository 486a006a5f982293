//! The report of a run of the fuzzer, made from one [`Run`]. On the simulated bus two runs with the same seed give the
//! same bytes, except for the date of the provenance.

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
use canvass_fuzzer::{FinalState, Kept, Start, Targets, Then, reproducer};
use canvass_suite::bench::Annotate;
use canvass_suite::touch::Touch;
use canvass_suite::zero_point::Moved;
use canvass_traces::{ChannelId, Direction, Record, Timestamp};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// A whole run with the data of the reports.
#[derive(Clone, Debug)]
pub struct Run {
    /// The provenance of the result.
    pub provenance: Provenance,
    /// The address of the bus.
    pub bus: String,
    /// The bit rate in bit/s, if it is known.
    pub bit_rate: Option<u32>,
    /// The node-ID of the device.
    pub node: NodeId,
    /// The user's name of the device. Empty if the device is not described.
    pub model: String,
    /// The services that were fuzzed.
    pub targets: Targets,
    /// The touches that the user allowed.
    pub allow: BTreeSet<Touch>,
    pub seed: u64,
    /// The command that repeats the run.
    pub repeat: String,
    /// Whether the run was interrupted.
    pub cancelled: bool,
    /// The reachable states of the SDO server.
    pub sdo_reach: SdoReach,
    /// The reachable states and commands of LSS.
    pub reach: LssReach,
    pub outcome: Outcome,
    /// The zero point of a live device, if it has moved during the run.
    pub zero_point: Option<Moved>,
    /// The words for the frames of each violation, in the order of the violations.
    pub words: Vec<Words>,
}

/// The meanings of the frames of a violation.
#[derive(Clone, Debug)]
pub struct Words {
    /// The meaning of each frame of the shortened sequence.
    pub sequence: Vec<String>,
    /// The meaning of each frame on the bus.
    pub evidence: Vec<String>,
}

impl Words {
    /// The meanings of the frames of a violation, by decoders that begin without context.
    pub fn of(found: &Found, decoder: &mut dyn FnMut() -> Box<dyn Annotate>) -> Self {
        let mut annotate = decoder();
        let evidence: Vec<String> = found.evidence.iter().map(|record| annotate.annotate(record)).collect();
        let mut alone = decoder();
        let record = |frame| Record::new(Timestamp::ZERO, ChannelId(0), frame).with_direction(Direction::Tx);
        // The device's answers give a frame more meaning than it has alone.
        let mut sent = found.evidence.iter().zip(&evidence).filter(|(record, _)| record.direction == Direction::Tx);
        let sequence = found.sequence.stimuli.iter().map(|stimulus| match sent.next() {
            Some((record, words)) if record.frame == stimulus.frame => words.clone(),
            _ => alone.annotate(&record(stimulus.frame)),
        });
        let sequence = sequence.collect();
        Self { sequence, evidence }
    }
}

/// The share of combinations of state and command that was seen.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Share {
    /// Number of combinations that were seen.
    pub reached: usize,
    /// Number of reachable combinations.
    pub reachable: usize,
}

impl Share {
    /// The share in percent, rounded down. It is 100 if there are no combinations.
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

    /// The share of the SDO server's combinations.
    pub fn sdo_share(&self) -> Share {
        let (reached, reachable) = self.coverage().sdo_share(self.sdo_reach);
        Share { reached, reachable }
    }

    /// The share of the LSS slave's combinations.
    pub fn lss_share(&self) -> Share {
        let (reached, reachable) = self.coverage().lss_share(&self.reach);
        Share { reached, reachable }
    }

    /// The touches that the user did not allow.
    fn forbidden(&self) -> String {
        let names: Vec<&str> = Touch::ALL
            .into_iter()
            .filter(|touch| touch.is_by_the_tester() && !self.allow.contains(touch))
            .map(Touch::name)
            .collect();
        names.join(",")
    }

    /// The violations, each with its words.
    fn violations(&self) -> impl Iterator<Item = (&Found, &Words)> {
        self.outcome.violations.iter().zip(&self.words)
    }
}

/// The outcome in one line.
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

/// The interruptions of the connection to the bus, and why the run ended early, if it did. Empty if there was no
/// trouble.
fn trouble(run: &Run) -> String {
    let interruptions = run.outcome.interruptions.as_ref().map(ToString::to_string);
    let ended_by = run.outcome.ended_by.as_ref().map(|why| format!("the run ended early: {why}"));
    interruptions.into_iter().chain(ended_by).collect::<Vec<_>>().join("; ")
}

/// The device's settings after the run, compared with the settings before. Empty for a simulated device.
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

/// Objects with the current and the power-on value.
fn values(kept: &[Kept], holds: &str) -> String {
    let value = |kept: &Kept| format!("{} {holds} {:X}h instead of {:X}h", kept.at, kept.value, kept.power_on);
    kept.iter().map(value).collect::<Vec<_>>().join(", ")
}

/// How reliable a violation is: whether it came back, and from which start.
fn reliability(found: &Found, dead: bool) -> String {
    let text = match (found.confirmed, dead && found.violation.property == Property::Alive) {
        (false, _) if found.is_cut_off => {
            "was seen once, and the bus was lost before it could be repeated: its whole trace is shown".to_owned()
        }
        (true, _) => comes_back(found),
        (false, true) => "the device did not come back after it: these are its last frames".to_owned(),
        (false, false) if found.needs_earlier => format!(
            "needs what came before: it came back only when all {} frames since a reset were sent again{}",
            found.sequence.stimuli.len(),
            instead(found)
        ),
        (false, false) => match found.late {
            Some(late) => format!(
                "was seen once, when the device or this machine was late: the answer came after {late}{}",
                instead(found)
            ),
            None => format!("was seen once and did not come back: its whole trace is shown{}", instead(found)),
        },
    };
    if found.state.is_empty() {
        return text;
    }
    let kept = values(&found.state, "held");
    format!("{text}; neither a reset nor a write had restored the state of power-on: {kept}")
}

/// The start of the repetitions, and their number.
fn comes_back(found: &Found) -> String {
    let start = match (found.prelude.is_empty(), found.sequence.start) {
        (_, Start::Unconfigured) => "power-on without node-ID",
        (true, Start::Configured) if found.is_live => "a reset",
        (true, Start::Configured) => "power-on",
        (false, Start::Configured) => "a reset after other SDO transfers, which are in the log",
    };
    let times = found.repetitions.iter().filter(|one| one.shows).count();
    let waits = match found.shows_by_times() {
        true => "",
        false => "; the player has to wait for the answers, as --replay does",
    };
    format!("came back in each of {times} repetitions from {start}{waits}")
}

/// What came in the repetitions that did not show the violation.
fn instead(found: &Found) -> String {
    let others: BTreeSet<&str> = found.repetitions.iter().filter(|one| !one.shows).map(|one| &*one.came).collect();
    let others: Vec<&str> = others.into_iter().collect();
    let shown = found.repetitions.iter().filter(|one| one.shows).count();
    match (shown, others.is_empty()) {
        (_, true) => String::new(),
        (0, false) => format!(" (in {} repetitions: {})", found.repetitions.len(), others.join(", ")),
        (_, false) => {
            format!(" (in {shown} of {} repetitions it came, else: {})", found.repetitions.len(), others.join(", "))
        }
    }
}

/// How often the violation was seen. Empty if it was once.
fn seen(found: &Found) -> String {
    if found.times > 1 { format!("in {} sequences", found.times) } else { String::new() }
}

/// The wait after a frame of a sequence, if it is not the usual wait.
fn then(then: Then) -> String {
    match then {
        Then::Settle => String::new(),
        Then::AtOnce => "next frame at once".to_owned(),
        Then::Pause(time) => format!("then {time}"),
    }
}

/// The shortened sequence, with a line for each frame and its meaning.
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

/// The state, the command, and the number of each answer.
type SdoRow = (&'static str, &'static str, Vec<(Answer, u64)>);

/// The rows of the SDO coverage.
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
