//! A run of the fuzzer: sequences until its time is over, each violation once, made small.

use super::coverage::{Command, Coverage, LssReach, SdoState};
use super::execute::{DEATH, Executor};
use super::generate::{Dialogues, Target};
use super::ground::{Ground, Live, learn};
use super::oracle::Violation;
use super::shrink::SequenceTree;
use super::stimulus::Sequence;
use super::{Knowledge, Property};
use canvass_bus::{Bus, BusError};
use canvass_suite::case::Touch;
use canvass_traces::Record;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::collections::BTreeSet;
use std::sync::Arc;

/// What a run does.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The services.
    pub target: Target,
    /// The seed of everything random.
    pub seed: u64,
    /// What the sequences may do beyond what leaves no trace.
    pub allow: BTreeSet<Touch>,
    /// How many tries making one violation smaller may take.
    pub shrink_budget: u32,
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
    /// Whether it came again when the sequence was repeated. If not, sequence and evidence are those of the one time.
    pub confirmed: bool,
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

/// Fuzzes a device. `go_on` is asked after each sequence.
///
/// # Errors
/// [`FuzzError`] if the device can't be reached or the bus fails.
pub fn run(
    ground: &mut dyn Ground,
    mut knowledge: Knowledge,
    plan: &Plan,
    go_on: &mut dyn FnMut(Progress<'_>) -> bool,
) -> Result<Outcome, FuzzError> {
    if !learn(ground, &mut knowledge)? {
        return Err(FuzzError::Unreachable(knowledge.node));
    }
    let knowledge = Arc::new(knowledge);
    let mut campaign = Campaign {
        executor: Executor::new(Arc::clone(&knowledge)),
        seen: BTreeSet::new(),
        violations: Vec::new(),
        sequences: 0,
        last: None,
        dead: false,
        plan,
    };
    for sequence in &plan.regressions {
        campaign.attempt(ground, SequenceTree::new(sequence.clone()))?;
        if campaign.is_over(go_on) {
            return Ok(campaign.outcome());
        }
    }
    if plan.only_regressions {
        return Ok(campaign.outcome());
    }
    let mut dialogues = Dialogues {
        target: plan.target,
        allow: plan.allow.clone(),
        unconfigured: ground.has_unconfigured() && knowledge.services.lss == Some(true),
        patient: ground.is_repeatable(),
        focus: None,
        lss_focus: None,
        knowledge: Arc::clone(&knowledge),
    };
    let reach = LssReach::of(&knowledge.services, dialogues.unconfigured, &plan.allow);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng(plan.seed));
    loop {
        if campaign.sequences.is_multiple_of(REFOCUS) {
            let coverage = &campaign.executor.coverage;
            dialogues.focus = least_exercised(coverage, &knowledge);
            dialogues.lss_focus =
                Coverage::lss_pairs(&reach).min_by_key(|&(state, command)| coverage.lss_count(state, command));
        }
        // The strategy always makes a sequence.
        let Ok(tree) = dialogues.new_tree(&mut runner) else { return Ok(campaign.outcome()) };
        campaign.attempt(ground, tree)?;
        if campaign.is_over(go_on) {
            return Ok(campaign.outcome());
        }
    }
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
    let mut ground = Live::new(bus, &knowledge);
    run(&mut ground, knowledge, plan, go_on)
}

/// Runs one sequence, as it is, and says what it shows.
///
/// # Errors
/// As [`run`].
pub fn replay(
    ground: &mut dyn Ground,
    mut knowledge: Knowledge,
    sequence: &Sequence,
) -> Result<(Option<Violation>, Vec<Record>), FuzzError> {
    if !learn(ground, &mut knowledge)? {
        return Err(FuzzError::Unreachable(knowledge.node));
    }
    let mut executor = Executor::new(Arc::new(knowledge));
    let violation = executor.run(ground, sequence, true)?;
    Ok((violation, executor.evidence))
}

struct Campaign<'a> {
    executor: Executor,
    /// Violations that were reported: the same one again is no news.
    seen: BTreeSet<(Property, &'static str)>,
    violations: Vec<Found>,
    sequences: u64,
    /// On a device that is reset: the last sequence and its frames. A device that does not come back died of them.
    last: Option<(Sequence, Vec<Record>)>,
    dead: bool,
    plan: &'a Plan,
}

impl Campaign<'_> {
    fn attempt(&mut self, ground: &mut dyn Ground, mut tree: SequenceTree) -> Result<(), BusError> {
        self.sequences += 1;
        let keep = !ground.is_repeatable();
        let shown = self.executor.run(ground, tree.tried(), keep)?;
        let evidence = std::mem::take(&mut self.executor.evidence);
        let Some(violation) = shown else {
            self.last = keep.then(|| (tree.current(), evidence));
            return Ok(());
        };
        let sequence = tree.current();
        if violation.rule == DEATH && evidence.is_empty() && keep {
            self.bury(violation);
            return Ok(());
        }
        if !self.seen.insert((violation.property, violation.rule)) {
            self.last = keep.then_some((sequence, evidence));
            return Ok(());
        }
        let found = match self.confirm(ground, &sequence, &violation)? {
            Confirmed::Again => self.shrink(ground, &mut tree, violation)?,
            Confirmed::No => Found { violation, sequence, evidence, confirmed: false },
            Confirmed::Dead => {
                self.dead = true;
                Found { violation, sequence, evidence, confirmed: false }
            }
        };
        self.violations.push(found);
        Ok(())
    }

    /// The device did not come back after the last sequence: that one and its frames are what is known of its end.
    fn bury(&mut self, violation: Violation) {
        self.dead = true;
        let (sequence, evidence) = self.last.take().unwrap_or_default();
        self.violations.push(Found { violation, sequence, evidence, confirmed: false });
    }

    /// Whether the sequence shows the same violation again.
    fn confirm(
        &mut self,
        ground: &mut dyn Ground,
        sequence: &Sequence,
        as_in: &Violation,
    ) -> Result<Confirmed, BusError> {
        let is_repeatable = ground.is_repeatable();
        let again = self.executor.run(ground, sequence, !is_repeatable)?;
        let is_dead = |violation: &Violation| violation.rule == DEATH && self.executor.evidence.is_empty();
        Ok(match again {
            Some(violation) if is_same(&violation, as_in) => Confirmed::Again,
            Some(violation) if !is_repeatable && is_dead(&violation) => Confirmed::Dead,
            _ => Confirmed::No,
        })
    }

    fn shrink(
        &mut self,
        ground: &mut dyn Ground,
        tree: &mut SequenceTree,
        violation: Violation,
    ) -> Result<Found, BusError> {
        let mut more = tree.simplify();
        let mut tries = 0;
        while more && tries < self.plan.shrink_budget {
            tries += 1;
            more = match self.confirm(ground, tree.tried(), &violation)? {
                Confirmed::Again => tree.simplify(),
                Confirmed::No => tree.complicate(),
                Confirmed::Dead => {
                    self.dead = true;
                    break;
                }
            };
        }
        let sequence = tree.best().clone();
        // Once more with its frames, and with the words for this sequence.
        let last = self.executor.run(ground, &sequence, true)?;
        let evidence = std::mem::take(&mut self.executor.evidence);
        let confirmed = last.as_ref().is_some_and(|last| is_same(last, &violation));
        let violation = last.filter(|_| confirmed).unwrap_or(violation);
        Ok(Found { violation, sequence, evidence, confirmed })
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
        !go_on(progress) || enough || self.dead || self.violations.len() >= MOST_VIOLATIONS
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
    /// The device does not come back any more.
    Dead,
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
