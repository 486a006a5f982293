//! A run of the fuzzer: sequences until its time is over, each violation once, made small.

use super::coverage::{Command, Coverage, LssReach, SdoState};
use super::execute::{Ended, Executor, Pace};
use super::generate::{Dialogues, Target, Targets};
use super::learn::learn;
use super::live::Live;
use super::oracle::Violation;
use super::shrink::SequenceTree;
use super::stand::TestStand;
use super::stimulus::Sequence;
use super::time_limit::TimeLimit;
use super::{Kept, Knowledge, Property};
use canvass_analyzer::wire::lss;
use canvass_bus::{Bus, BusError};
use canvass_suite::touch::Touch;
use canvass_traces::{Duration, Record, Timestamp};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What a run does.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The services.
    pub targets: Targets,
    /// The seed of everything random.
    pub seed: u64,
    /// What the sequences may do beyond what leaves no trace.
    pub allow: BTreeSet<Touch>,
    /// How many tries making one violation smaller may take.
    pub shrink_budget: u32,
    /// When the run ends, also in the middle of a sequence or of making one shorter.
    pub time: TimeLimit,
    /// End with the first violation.
    pub stop_at_first: bool,
    /// Sequences of earlier runs, tried first.
    pub regressions: Vec<Sequence>,
    /// Try only those.
    pub only_regressions: bool,
}

/// A violation with the shortest sequence that shows it.
#[derive(Clone, Debug)]
pub struct Found {
    /// What does not hold.
    pub violation: Violation,
    /// The shortest sequence that was found to show it.
    pub sequence: Sequence,
    /// All frames of that sequence, with the device's, as they were on the bus.
    pub evidence: Vec<Record>,
    /// Whether it came again when the sequence was repeated from power-on. If not, sequence and evidence are those of the
    /// one time.
    pub confirmed: bool,
    /// The objects that had not their values of power-on when it was seen: neither a reset nor a write had brought them
    /// back. What is confirmed is confirmed with these.
    pub state: Vec<Kept>,
}

/// The state of a run, told after each sequence.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Exchanges: frames that were sent, and after which the answer, or the silence, was judged.
    pub executions: u64,
    /// Frames that were sent, with those after which anything may come.
    pub frames: u64,
    /// Sequences that were run.
    pub sequences: u64,
    /// What was exercised.
    pub coverage: &'a Coverage,
    /// Violations so far.
    pub violations: usize,
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Exchanges: frames that were sent, and after which the answer, or the silence, was judged. Those of shrinking
    /// included.
    pub executions: u64,
    /// Frames that were sent, with those after which anything may come.
    pub frames: u64,
    /// Sequences that were run.
    pub sequences: u64,
    /// What was exercised.
    pub coverage: Coverage,
    /// Sequences that say nothing, because frames were lost on this machine or the bus was interrupted.
    pub unjudged: u64,
    /// Whether the device did not come back after a reset: the run ended with that.
    pub dead: bool,
    /// Each violation once.
    pub violations: Vec<Found>,
}

/// Why a run says nothing about the device.
#[derive(Debug, thiserror::Error)]
pub enum FuzzError {
    /// The device does not answer.
    #[error("node {0} does not answer: expected a response to the request to read 1000h")]
    Unreachable(canvass_analyzer::NodeId),
    /// The bus failed.
    #[error("{0}")]
    Bus(#[from] BusError),
}

/// More violations of different kinds than this are not told apart any more: the device is simply broken.
const MOST_VIOLATIONS: usize = 25;

/// After so many sequences the least exercised combination is looked for anew.
const REFOCUS: u64 = 64;
/// The same on a device that goes on, where a sequence takes much longer.
const REFOCUS_LIVE: u64 = 4;

/// Fuzzes a device. `go_on` is asked after each sequence.
///
/// # Errors
/// [`FuzzError`] if the device can't be reached or the bus fails.
pub fn run(
    stand: &mut dyn TestStand,
    mut knowledge: Knowledge,
    plan: &Plan,
    go_on: &mut dyn FnMut(Progress<'_>) -> bool,
) -> Result<Outcome, FuzzError> {
    if !learn(stand, &mut knowledge, plan.targets.contains(Target::Lss), &plan.time)? {
        return Err(FuzzError::Unreachable(knowledge.node));
    }
    let knowledge = Arc::new(knowledge);
    let mut campaign = Campaign {
        executor: Executor::new(Arc::clone(&knowledge), plan.time.clone()),
        seen: BTreeMap::new(),
        violations: Vec::new(),
        sequences: 0,
        dead: false,
        plan,
    };
    campaign.fuzz(stand, &knowledge, go_on)?;
    campaign.leave(stand)?;
    Ok(campaign.outcome())
}

/// Fuzzes the device on any bus, live or in this process; it is reset before each sequence. See [`run`].
///
/// A device in this process that panics is reported as dead; the bus must then give a new one after the next reset, or
/// the run ends.
///
/// # Errors
/// As [`run`].
pub fn campaign(
    bus: &mut dyn Bus,
    knowledge: Knowledge,
    plan: &Plan,
    go_on: &mut dyn FnMut(Progress<'_>) -> bool,
) -> Result<Outcome, FuzzError> {
    let mut stand = Live::new(bus, &knowledge);
    run(&mut stand, knowledge, plan, go_on)
}

/// Runs one sequence, as it is, and says what it shows.
///
/// # Errors
/// As [`run`].
pub fn replay(
    stand: &mut dyn TestStand,
    mut knowledge: Knowledge,
    sequence: &Sequence,
) -> Result<(Option<Violation>, Vec<Record>), FuzzError> {
    let has_lss = sequence.stimuli.iter().any(|stimulus| stimulus.frame.cob_id() == Some(lss::MASTER_CAN_ID));
    let time = TimeLimit::default();
    if !learn(stand, &mut knowledge, has_lss, &time)? {
        return Err(FuzzError::Unreachable(knowledge.node));
    }
    let mut executor = Executor::new(Arc::new(knowledge), time);
    let violation = match executor.run(stand, sequence, Pace::Careful, true)? {
        Ended::Well => None,
        Ended::Violation(violation) | Ended::Lost { violation, .. } => Some(violation),
    };
    Ok((violation, executor.evidence))
}

struct Campaign<'a> {
    executor: Executor,
    /// Violations that were reported, and how often those were tried that did not come back: the same one again is no news.
    seen: BTreeMap<(Property, &'static str), Standing>,
    violations: Vec<Found>,
    sequences: u64,
    dead: bool,
    plan: &'a Plan,
}

/// What is known of a violation that was seen.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Standing {
    Confirmed,
    /// It did not come back so often.
    Doubtful(u32),
}

/// A violation that did not come back so often is not tried again.
const MOST_DOUBTS: u32 = 3;

/// On a device that goes on, shrinking one violation ends after that time of the bus.
const LONGEST_SHRINKING: Duration = Duration::from_secs(10);

impl Campaign<'_> {
    /// Sequences until the run is over.
    fn fuzz(
        &mut self,
        stand: &mut dyn TestStand,
        knowledge: &Arc<Knowledge>,
        go_on: &mut dyn FnMut(Progress<'_>) -> bool,
    ) -> Result<(), FuzzError> {
        for sequence in &self.plan.regressions {
            // There are few of them, and each has shown something before: what is seen now is to be the device's doing.
            self.attempt(stand, SequenceTree::new(sequence.clone()), Pace::Careful)?;
            if self.is_over(go_on) {
                return Ok(());
            }
        }
        if self.plan.only_regressions {
            return Ok(());
        }
        let mut dialogues = Dialogues {
            targets: self.plan.targets,
            allow: self.plan.allow.clone(),
            unconfigured: stand.has_unconfigured() && knowledge.services.lss == Some(true),
            patient: stand.is_repeatable(),
            focus: None,
            lss_focus: None,
            knowledge: Arc::clone(knowledge),
        };
        let reach = LssReach::of(&knowledge.services, dialogues.unconfigured, &self.plan.allow);
        let pace = if stand.is_repeatable() { Pace::Careful } else { Pace::Swift };
        let mut runner = TestRunner::new_with_rng(Config::default(), rng(self.plan.seed));
        let refocus = if stand.is_repeatable() { REFOCUS } else { REFOCUS_LIVE };
        loop {
            if self.sequences.is_multiple_of(refocus) {
                let coverage = &self.executor.coverage;
                dialogues.focus = least_exercised(coverage, knowledge);
                dialogues.lss_focus =
                    Coverage::lss_pairs(&reach).min_by_key(|&(state, command)| coverage.lss_count(state, command));
            }
            // The strategy always makes a sequence.
            let Ok(tree) = dialogues.new_tree(&mut runner) else { return Ok(()) };
            self.attempt(stand, tree, pace)?;
            if self.is_over(go_on) {
                return Ok(());
            }
        }
    }

    /// A device that goes on is left as it was found: nothing was stored. The last sequence may have been its end.
    fn leave(&mut self, stand: &mut dyn TestStand) -> Result<(), BusError> {
        if stand.is_repeatable() || self.dead {
            return Ok(());
        }
        match self.executor.restart(stand)? {
            Ended::Lost { violation, dead } => self.lose(stand, violation, dead),
            Ended::Well | Ended::Violation(_) => Ok(()),
        }
    }

    fn attempt(&mut self, stand: &mut dyn TestStand, tree: SequenceTree, pace: Pace) -> Result<(), BusError> {
        self.sequences += 1;
        let keep = !stand.is_repeatable();
        match self.executor.run(stand, tree.tried(), pace, keep)? {
            Ended::Well => Ok(()),
            Ended::Violation(violation) => self.judge(stand, tree, violation, pace),
            Ended::Lost { violation, dead } => self.lose(stand, violation, dead),
        }
    }

    /// A violation was seen: it is repeated from power-on, with its sequence alone or, on a device that goes on, with all
    /// that came before it. What was seen at the swift pace and does not come back may have been a late answer to another
    /// frame: it is told of when it was seen several times.
    fn judge(
        &mut self,
        stand: &mut dyn TestStand,
        mut tree: SequenceTree,
        violation: Violation,
        pace: Pace,
    ) -> Result<(), BusError> {
        let key = (violation.property, violation.rule);
        let doubts = match self.seen.get(&key) {
            Some(Standing::Confirmed | Standing::Doubtful(MOST_DOUBTS..)) => return Ok(()),
            Some(Standing::Doubtful(doubts)) => *doubts,
            None => 0,
        };
        let (sequence, whole) = (tree.current(), self.executor.since_start());
        let seen = Found {
            violation,
            sequence,
            evidence: self.executor.evidence.clone(),
            confirmed: false,
            state: self.executor.kept.clone(),
        };
        let mut confirmed = self.confirm(stand, &seen.sequence, &seen.violation)?;
        if matches!(confirmed, Confirmed::No) && whole.stimuli.len() > seen.sequence.stimuli.len() {
            confirmed = self.confirm(stand, &whole, &seen.violation)?;
            tree = SequenceTree::new(whole);
        }
        let (found, lost) = match confirmed {
            Confirmed::Again => (self.shrink(stand, &mut tree, seen.violation)?, None),
            Confirmed::No => (seen, None),
            Confirmed::Lost(lost, dead) => (seen, Some((lost, dead))),
        };
        if !found.confirmed
            && lost.is_none()
            && doubts + 1 < MOST_DOUBTS
            && pace == Pace::Swift
            && self.may_be_mixed_up(&found.violation)
        {
            self.executor.distrust(key.0);
            self.seen.insert(key, Standing::Doubtful(doubts + 1));
            return Ok(());
        }
        let standing = if found.confirmed { Standing::Confirmed } else { Standing::Doubtful(doubts + 1) };
        self.seen.insert(key, standing);
        if found.confirmed {
            self.executor.take_for_granted(key.0, key.1);
        }
        let is_known = |other: &&mut Found| (other.violation.property, other.violation.rule) == key;
        match self.violations.iter_mut().find(is_known) {
            Some(before) if found.confirmed => *before = found,
            Some(_) => {}
            None => self.violations.push(found),
        }
        match lost {
            Some((violation, dead)) => self.lose(stand, violation, dead),
            None => Ok(()),
        }
    }

    /// Whether what was seen at the swift pace may come from an answer to another frame, or from an order of service that
    /// nobody has promised.
    fn may_be_mixed_up(&self, violation: &Violation) -> bool {
        // A device that has died is no matter of order.
        violation.property != Property::Alive
            && !violation.is_silence
            && (self.executor.is_in_order(violation.property) || is_mixable(violation))
    }

    /// The device did not come back from a reset: what was sent since the start before, and the frames, are what is known of
    /// its end. `dead`: nor did further resets bring it back.
    fn lose(&mut self, stand: &mut dyn TestStand, violation: Violation, dead: bool) -> Result<(), BusError> {
        self.dead |= dead;
        let (sequence, evidence) = self.executor.before_start();
        let key = (violation.property, violation.rule);
        if self.seen.insert(key, Standing::Confirmed).is_some() {
            return Ok(());
        }
        let mut confirmed = false;
        if !dead {
            self.executor.run(stand, &sequence, Pace::Careful, true)?;
            if let Ended::Lost { dead, .. } = self.executor.restart(stand)? {
                confirmed = true;
                self.dead |= dead;
            }
        }
        self.violations.push(Found { violation, sequence, evidence, confirmed, state: Vec::new() });
        Ok(())
    }

    /// Whether the sequence shows the same violation again, from power-on.
    fn confirm(
        &mut self,
        stand: &mut dyn TestStand,
        sequence: &Sequence,
        as_in: &Violation,
    ) -> Result<Confirmed, BusError> {
        let keep = !stand.is_repeatable();
        Ok(match self.executor.run(stand, sequence, Pace::Careful, keep)? {
            Ended::Violation(violation) if is_same(&violation, as_in) => Confirmed::Again,
            Ended::Lost { violation, dead } if keep => Confirmed::Lost(violation, dead),
            _ => Confirmed::No,
        })
    }

    /// Makes the sequence shorter. It has shown the violation from power-on.
    fn shrink(
        &mut self,
        stand: &mut dyn TestStand,
        tree: &mut SequenceTree,
        violation: Violation,
    ) -> Result<Found, BusError> {
        let whole = Found {
            sequence: tree.best().clone(),
            evidence: self.executor.evidence.clone(),
            state: self.executor.kept.clone(),
            violation: violation.clone(),
            confirmed: true,
        };
        // For what was found missing nobody waits as long again with each try.
        self.executor.presume(Some((violation.property, violation.rule)));
        let shortest = self.shorten(stand, tree, violation);
        let has_hurried = self.executor.presume(None);
        let found = self.show(stand, shortest?)?;
        Ok(if has_hurried && !found.confirmed { whole } else { found })
    }

    fn shorten(
        &mut self,
        stand: &mut dyn TestStand,
        tree: &mut SequenceTree,
        violation: Violation,
    ) -> Result<Found, BusError> {
        // The frames of the shortest sequence so far, where they are kept.
        let mut shown = std::mem::take(&mut self.executor.evidence);
        let until = match stand.is_repeatable() {
            true => Timestamp::MAX,
            false => stand.bus().now() + LONGEST_SHRINKING,
        };
        let mut more = tree.simplify();
        let mut tries = 0;
        while more && tries < self.plan.shrink_budget && stand.bus().now() < until && !self.plan.time.is_over() {
            tries += 1;
            more = match self.confirm(stand, tree.tried(), &violation)? {
                Confirmed::Again => {
                    shown = std::mem::take(&mut self.executor.evidence);
                    tree.simplify()
                }
                Confirmed::No => tree.complicate(),
                Confirmed::Lost(lost, dead) => {
                    self.lose(stand, lost, dead)?;
                    !self.dead && tree.complicate()
                }
            };
        }
        let (sequence, state) = (tree.best().clone(), self.executor.kept.clone());
        Ok(Found { violation, sequence, evidence: shown, confirmed: true, state })
    }

    /// Once more with its frames, and with the words for this sequence, if there is time for it.
    fn show(&mut self, stand: &mut dyn TestStand, shortest: Found) -> Result<Found, BusError> {
        if self.plan.time.is_over() && !shortest.evidence.is_empty() {
            return Ok(shortest);
        }
        let last = match self.dead {
            true => Ended::Well,
            false => self.executor.run(stand, &shortest.sequence, Pace::Careful, true)?,
        };
        let evidence = std::mem::take(&mut self.executor.evidence);
        let shown = Found { evidence, state: self.executor.kept.clone(), ..shortest };
        Ok(match last {
            Ended::Violation(last) if is_same(&last, &shown.violation) => Found { violation: last, ..shown },
            Ended::Lost { violation: lost, dead } => {
                self.lose(stand, lost, dead)?;
                Found { confirmed: false, ..shown }
            }
            _ => Found { confirmed: false, ..shown },
        })
    }

    fn is_over(&self, go_on: &mut dyn FnMut(Progress<'_>) -> bool) -> bool {
        let progress = Progress {
            executions: self.executor.executions,
            frames: self.executor.frames,
            sequences: self.sequences,
            coverage: &self.executor.coverage,
            violations: self.violations.len(),
        };
        let enough = self.plan.stop_at_first && !self.violations.is_empty();
        // After its time no sequence is judged any more.
        !go_on(progress) || self.plan.time.is_over() || enough || self.dead || self.violations.len() >= MOST_VIOLATIONS
    }

    fn outcome(self) -> Outcome {
        Outcome {
            executions: self.executor.executions,
            frames: self.executor.frames,
            sequences: self.sequences,
            unjudged: self.executor.unjudged,
            dead: self.dead,
            coverage: self.executor.coverage,
            violations: self.violations,
        }
    }
}

/// What became of a repetition.
enum Confirmed {
    /// The same violation.
    Again,
    /// Another one, or none.
    No,
    /// The device did not come back from the reset before it, which is a violation of its own; whether further resets
    /// did not bring it back either.
    Lost(Violation, bool),
}

/// Whether the answer to another frame, come late, can look like that.
fn is_mixable(violation: &Violation) -> bool {
    let is_answer = matches!(
        violation.property,
        Property::LegalSdo
            | Property::OneAnswer
            | Property::Silent
            | Property::Consistent
            | Property::ReadBack
            | Property::AbortedUnchanged
            | Property::Restored
            | Property::LegalLss
            | Property::Fastscan
    );
    is_answer && !violation.is_silence
}

fn is_same(one: &Violation, other: &Violation) -> bool {
    (one.property, one.rule) == (other.property, other.rule)
}

fn rng(seed: u64) -> TestRng {
    let mut bytes = [0; 16];
    // An all-zero state is no state for this generator.
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    bytes[8..].copy_from_slice(&(!seed ^ 0x9E37_79B9_7F4A_7C15).to_le_bytes());
    TestRng::from_seed(RngAlgorithm::XorShift, &bytes)
}

/// The combination of SDO state and command that came least.
fn least_exercised(coverage: &Coverage, knowledge: &Knowledge) -> Option<(SdoState, Command)> {
    Coverage::sdo_pairs(knowledge.services.block_transfer != Some(false))
        .min_by_key(|&(state, command)| coverage.sdo_count(state, command))
}
