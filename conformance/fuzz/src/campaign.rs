//! A run of the fuzzer: sequences until its time is over. Each violation is reported once, with a short sequence.

mod corpus;
mod found;
mod proof;
mod shortening;
mod violations;

use super::baseline::{self, FinalState};
use super::coverage::{Command, Coverage, LssReach, SdoReach, SdoState};
use super::execute::{Ended, Executor, Pace};
use super::generate::{Dialogues, Target, Targets};
use super::learn::learn;
use super::live::Live;
use super::oracle::Violation;
use super::shrink::SequenceTree;
use super::spent::{Cause, Spent};
use super::stand::TestStand;
use super::stimulus::{Sequence, Then};
use super::time_limit::TimeLimit;
use super::{Defect, Knowledge};
use canvass_analyzer::wire::lss;
use canvass_bus::{Bus, BusError, Interruptions};
use canvass_suite::touch::Touch;
use canvass_traces::{Duration, Record, Timestamp};
pub use found::{Found, Repetition, Replay};
use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use shortening::Shortening;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use violations::Unrepeated;

/// The options of a run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The services to fuzz.
    pub targets: Targets,
    /// The seed of all random choices.
    pub seed: u64,
    /// The touches that the user allows: effects on the device that are otherwise avoided.
    pub allow: BTreeSet<Touch>,
    /// Maximum number of tries to make the sequence of one violation shorter.
    pub shrink_budget: u32,
    /// Time limit of the run. It also ends a sequence that is being run or shortened.
    pub time: TimeLimit,
    /// End with the first violation.
    pub stop_at_first: bool,
    /// Sequences of earlier runs, tried first.
    pub regressions: Vec<Sequence>,
    /// Run only the regressions.
    pub only_regressions: bool,
    /// Sequences of earlier runs that reached much, tried after the regressions.
    pub corpus: Vec<Sequence>,
}

/// The state of a run, reported after each sequence.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Number of frames after which the answer, or the silence, was judged.
    pub executions: u64,
    /// Number of frames sent, including frames after which the standard leaves everything open.
    pub frames: u64,
    /// Number of sequences that were run.
    pub sequences: u64,
    /// The combinations of state, command and answer seen so far.
    pub coverage: &'a Coverage,
    /// Number of violations so far.
    pub violations: usize,
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Number of frames after which the answer, or the silence, was judged. Frames sent to shorten sequences count,
    /// too.
    pub executions: u64,
    /// Number of frames sent, including frames after which the standard leaves everything open.
    pub frames: u64,
    /// Number of sequences that were run.
    pub sequences: u64,
    /// The combinations of state, command and answer that were seen.
    pub coverage: Coverage,
    /// How the time on the bus was used.
    pub spent: Spent,
    /// The part of [`spent`](Self::spent) for repeating and shortening violations.
    pub spent_on_violations: Spent,
    /// Number of sequences without a result, because this machine lost frames or the bus was interrupted.
    pub unjudged: u64,
    /// Whether the run ended because the device did not come back after a reset.
    pub dead: bool,
    /// Whether each sequence got a new simulated device, so that the run leaves no device changed.
    pub is_simulated: bool,
    /// The settings that the run leaves on a live device. `None`: the device does not answer any more, or is simulated.
    pub left: Option<FinalState>,
    /// All violations, one for each rule.
    pub violations: Vec<Found>,
    /// The sequences that reached a combination of state and command before all others, in the order of the run.
    pub corpus: Vec<Sequence>,
    /// Number and duration of interruptions of the connection to the bus.
    pub interruptions: Option<Interruptions>,
    /// Why the run ended early: the bus did not come back, or failed otherwise.
    pub ended_by: Option<String>,
}

/// Why a run has no result.
#[derive(Debug, thiserror::Error)]
pub enum FuzzError {
    /// The device does not answer.
    #[error("node {0} does not answer: expected a response to the request to read 1000h")]
    Unreachable(canvass_analyzer::NodeId),
    /// The bus failed.
    #[error("{0}")]
    Bus(#[from] BusError),
}

/// Number of violations after which a run ends: the device is broken in general.
const MOST_VIOLATIONS: usize = 25;

/// Number of sequences after which the fuzzer again looks for the least exercised combination of state and command.
const REFOCUS: u64 = 64;
/// [`REFOCUS`] for a live device, where a sequence takes much longer.
const REFOCUS_LIVE: u64 = 4;

/// On a live device, at most one part in [`PAUSES`] of the time is spent in pauses.
const PAUSES: u64 = 10;

/// Fuzzes a device. `go_on` is called after each sequence; `false` ends the run. If the bus fails, the run ends and
/// keeps its results.
///
/// # Errors
/// [`FuzzError::Unreachable`] if the device can't be reached.
pub fn run(
    stand: &mut dyn TestStand,
    mut knowledge: Knowledge,
    plan: &Plan,
    go_on: &mut dyn FnMut(Progress<'_>) -> bool,
) -> Result<Outcome, FuzzError> {
    let learned = learn(stand, &mut knowledge, plan.targets.contains(Target::Lss), &plan.time);
    if let Ok(false) = learned {
        return Err(FuzzError::Unreachable(knowledge.node));
    }
    let knowledge = Arc::new(knowledge);
    let mut campaign = Campaign {
        executor: Executor::new(Arc::clone(&knowledge), plan.time.clone()),
        seen: BTreeMap::new(),
        times: BTreeMap::new(),
        violations: Vec::new(),
        corpus: Vec::new(),
        sequences: 0,
        dead: false,
        is_simulated: stand.is_repeatable(),
        left: None,
        spent_on_violations: Spent::default(),
        begun: stand.bus().now(),
        unshortened: VecDeque::new(),
        shortened_for: Duration::ZERO,
        is_prelude_clean: true,
        unrepeated: None,
        interruptions: None,
        ended_by: None,
        plan,
    };
    let fuzzed = learned.and_then(|_| campaign.fuzz(stand, &knowledge, go_on));
    if let Err(error) = fuzzed.and_then(|()| campaign.shorten_rest(stand)) {
        campaign.end_early(&error);
    }
    if let Err(error) = campaign.leave(stand) {
        campaign.end_early(&error);
    }
    let bus = stand.bus();
    campaign.interruptions = bus.health().interruptions(bus.now());
    Ok(campaign.outcome())
}

/// Fuzzes the device on any bus, live or in this process, with a reset before each sequence. See [`run`].
///
/// A device in this process that panics is reported as dead. The bus must then provide a new device after the next
/// reset; otherwise the run ends.
///
/// # Errors
/// The errors of [`run`].
pub fn campaign(
    bus: &mut dyn Bus,
    knowledge: Knowledge,
    plan: &Plan,
    go_on: &mut dyn FnMut(Progress<'_>) -> bool,
) -> Result<Outcome, FuzzError> {
    let mut stand = Live::new(bus, &knowledge);
    run(&mut stand, knowledge, plan, go_on)
}

/// Runs one sequence unchanged and reports the violations that it shows.
///
/// # Errors
/// The errors of [`run`].
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
    Ok((violation, executor.history.take_evidence()))
}

struct Campaign<'a> {
    executor: Executor,
    /// The violations seen so far. Each defect is reported only once.
    seen: BTreeMap<Defect, Standing>,
    /// Number of sequences that have shown each defect, without repetitions.
    times: BTreeMap<Defect, u64>,
    violations: Vec<Found>,
    /// The sequences that reached something new.
    corpus: Vec<Sequence>,
    sequences: u64,
    dead: bool,
    is_simulated: bool,
    left: Option<FinalState>,
    /// The time for repeating and shortening violations.
    spent_on_violations: Spent,
    /// When the first sequence began.
    begun: Timestamp,
    /// Confirmed violations whose sequences may be made shorter.
    unshortened: VecDeque<Shortening>,
    /// Time spent on shortening so far.
    shortened_for: Duration,
    /// Whether the frames before each repetition showed no violation when the run began.
    is_prelude_clean: bool,
    /// The violation that is being repeated.
    unrepeated: Option<Unrepeated>,
    interruptions: Option<Interruptions>,
    ended_by: Option<String>,
    plan: &'a Plan,
}

/// The result of repeating a violation that was seen.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Standing {
    Confirmed,
    /// The violation did not come back in this number of repetitions.
    Doubtful(u32),
    /// The violation comes back at the swift pace when all frames since the start are sent again; this long sequence is
    /// being made shorter. Before that, the violation did not come back in this number of repetitions.
    InHistory(u32),
}

impl Campaign<'_> {
    /// Runs sequences until the run is over.
    fn fuzz(
        &mut self,
        stand: &mut dyn TestStand,
        knowledge: &Arc<Knowledge>,
        go_on: &mut dyn FnMut(Progress<'_>) -> bool,
    ) -> Result<(), BusError> {
        self.try_prelude(stand)?;
        for sequence in &self.plan.regressions {
            // Each of these few sequences has shown a violation before: the careful pace excludes late answers to other
            // frames.
            self.attempt(stand, &SequenceTree::new(sequence.clone()), Pace::Careful)?;
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
        if self.run_corpus(stand, pace, go_on)? {
            return Ok(());
        }
        let mut runner = TestRunner::new_with_rng(Config::default(), rng(self.plan.seed));
        let refocus = if stand.is_repeatable() { REFOCUS } else { REFOCUS_LIVE };
        // A combination that was tried but not reached waits for its next turn: the device may never reach it.
        let mut tried = BTreeMap::new();
        loop {
            if self.sequences.is_multiple_of(refocus) {
                let coverage = &self.executor.tally.coverage;
                dialogues.focus = least_exercised(coverage, knowledge, &tried);
                if let Some(focus) = dialogues.focus.filter(|_| !stand.is_repeatable()) {
                    *tried.entry(focus).or_default() += 1;
                }
                dialogues.lss_focus =
                    Coverage::lss_pairs(&reach).min_by_key(|&(state, command)| coverage.lss_count(state, command));
            }
            // The strategy always makes a sequence.
            let Ok(mut tree) = dialogues.new_tree(&mut runner) else { return Ok(()) };
            if !stand.is_repeatable() {
                let mut sequence = tree.best().clone();
                keep_to_share(&mut sequence, &self.executor.tally.spent);
                tree = SequenceTree::new(sequence);
            }
            self.attempt_new(stand, &tree, pace)?;
            if self.is_over(go_on) {
                return Ok(());
            }
            self.shorten_in_turn(stand)?;
        }
    }

    /// Keeps the results of the run when the bus has failed.
    fn end_early(&mut self, error: &BusError) {
        self.ended_by.get_or_insert_with(|| error.to_string());
        if let Some(Unrepeated { seen, doubts, is_swift }) = self.unrepeated.take() {
            self.tell(Found { is_cut_off: true, ..seen }, doubts, is_swift);
        }
        self.keep_unshortened();
    }

    /// Resets a live device and compares its settings with those before the run. The device may also have died in the
    /// last sequence.
    fn leave(&mut self, stand: &mut dyn TestStand) -> Result<(), BusError> {
        if stand.is_repeatable() || self.dead {
            return Ok(());
        }
        match self.executor.restart(stand)? {
            Ended::Lost { violation, dead } => self.lose(stand, violation, dead)?,
            Ended::Well | Ended::Violation(_) => {}
        }
        if !self.dead {
            // An error while the settings are read must not lose the results of the run.
            let compared = catch_unwind(AssertUnwindSafe(|| baseline::compare(stand.bus(), self.executor.knowledge())));
            self.left = compared.ok().and_then(Result::ok).flatten();
        }
        Ok(())
    }

    fn attempt(&mut self, stand: &mut dyn TestStand, tree: &SequenceTree, pace: Pace) -> Result<(), BusError> {
        self.sequences += 1;
        let keep = !stand.is_repeatable();
        match self.executor.run(stand, tree.tried(), pace, keep)? {
            Ended::Well => Ok(()),
            Ended::Violation(violation) => {
                let before = self.executor.tally.spent;
                *self.times.entry(violation.defect()).or_default() += 1;
                let tree = match self.executor.is_between() {
                    true => SequenceTree::new(self.executor.history.since_sequence()),
                    false => SequenceTree::new(self.executor.sent_of(tree.tried())),
                };
                let judged = self.judge(stand, tree, violation, pace);
                self.spent_on_violations += self.executor.tally.spent.since(&before);
                judged
            }
            Ended::Lost { violation, dead } => self.lose(stand, violation, dead),
        }
    }

    fn is_over(&self, go_on: &mut dyn FnMut(Progress<'_>) -> bool) -> bool {
        let progress = Progress {
            executions: self.executor.tally.executions,
            frames: self.executor.tally.frames,
            sequences: self.sequences,
            coverage: &self.executor.tally.coverage,
            violations: self.violations.len(),
        };
        let enough = self.plan.stop_at_first && !self.violations.is_empty();
        // A sequence is not judged after the end of its time.
        !go_on(progress) || self.plan.time.is_over() || enough || self.dead || self.violations.len() >= MOST_VIOLATIONS
    }

    fn outcome(mut self) -> Outcome {
        for found in &mut self.violations {
            let defect = found.violation.defect();
            let tolerated = self.executor.known.times(&defect);
            found.times = self.times.get(&defect).copied().unwrap_or_default().max(1) + tolerated;
        }
        Outcome {
            executions: self.executor.tally.executions,
            frames: self.executor.tally.frames,
            sequences: self.sequences,
            unjudged: self.executor.tally.unjudged,
            dead: self.dead,
            is_simulated: self.is_simulated,
            left: self.left,
            spent: self.executor.tally.spent,
            spent_on_violations: self.spent_on_violations,
            coverage: self.executor.tally.coverage,
            violations: self.violations,
            corpus: self.corpus,
            interruptions: self.interruptions,
            ended_by: self.ended_by,
        }
    }
}

fn rng(seed: u64) -> TestRng {
    let mut bytes = [0; 16];
    // The generator does not accept a state of zeros only.
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    bytes[8..].copy_from_slice(&(!seed ^ 0x9E37_79B9_7F4A_7C15).to_le_bytes());
    TestRng::from_seed(RngAlgorithm::XorShift, &bytes)
}

/// Leaves out each pause if the earlier pauses have taken more than their share of the time, or if the pause is longer
/// than this share.
fn keep_to_share(sequence: &mut Sequence, spent: &Spent) {
    let share = Duration(spent.total().nanos() / PAUSES);
    let (_, mut paused) = spent.of(Cause::Pause);
    for stimulus in &mut sequence.stimuli {
        let Then::Pause(pause) = stimulus.then else { continue };
        if paused <= share && pause <= share {
            paused = paused + pause;
        } else {
            stimulus.then = Then::Settle;
        }
    }
}

/// The SDO state and command that came least often. A combination that the fuzzer has already tried counts each try as
/// an occurrence.
fn least_exercised(
    coverage: &Coverage,
    knowledge: &Knowledge,
    tried: &BTreeMap<(SdoState, Command), u64>,
) -> Option<(SdoState, Command)> {
    let times = |pair: &(SdoState, Command)| tried.get(pair).copied().unwrap_or_default();
    Coverage::sdo_pairs(SdoReach::of(knowledge)).min_by_key(|pair| coverage.sdo_count(pair.0, pair.1) + times(pair))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stimulus::Stimulus;
    use canvass_traces::{CanId, Frame};

    #[test]
    fn pauses_take_their_share_and_long_ones_have_their_turn() {
        let pause = |milliseconds| Then::Pause(Duration::from_millis(milliseconds));
        let spent = |paused, other| {
            let mut spent = Spent::default();
            spent.add(Cause::Pause, Duration::from_millis(paused));
            spent.add(Cause::Answer, Duration::from_millis(other));
            spent
        };
        let left = |spent: &Spent| {
            let frame = Frame::new(CanId::standard_masked(0x80), &[]).unwrap();
            let stimuli = [pause(60), Then::AtOnce, pause(2_000), pause(60)].map(|then| Stimulus { frame, then });
            let mut sequence = Sequence { stimuli: stimuli.to_vec(), ..Sequence::default() };
            keep_to_share(&mut sequence, spent);
            sequence.stimuli.iter().map(|stimulus| stimulus.then).collect::<Vec<_>>()
        };
        assert_eq!(left(&spent(0, 500)), [Then::Settle, Then::AtOnce, Then::Settle, Then::Settle]);
        assert_eq!(left(&spent(100, 9_900)), [pause(60), Then::AtOnce, Then::Settle, pause(60)]);
        assert_eq!(left(&spent(1_500, 18_500)), [pause(60), Then::AtOnce, pause(2_000), Then::Settle]);
        assert_eq!(left(&spent(1_500, 10_000)), [Then::Settle, Then::AtOnce, Then::Settle, Then::Settle]);
    }
}
