//! Runs sequences and checks every frame against the reference models.

mod history;
mod known;
mod recovery;
mod requests;
mod tally;
#[cfg(test)]
mod tests;
mod waits;

use super::baseline::{self, Kept};
use super::oracle::{Oracle, Symptom, Violation};
use super::property::Property;
use super::spent::Cause;
use super::stand::{Readiness, TestStand, wait_for_boot_up};
use super::stimulus::{Sequence, Start, Stimulus, Then};
use super::time_limit::TimeLimit;
use canvass_analyzer::wire::lss;
use canvass_bus::{BusError, Health};
use canvass_traces::Frame;
use history::History;
use known::KnownViolations;
use requests::Requests;
use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use tally::Tally;
use waits::Waits;

use super::Knowledge;

/// Runs sequences.
#[derive(Debug)]
pub(super) struct Executor {
    knowledge: Arc<Knowledge>,
    oracle: Oracle,
    pub tally: Tally,
    pub history: History,
    pub known: KnownViolations,
    condition: Condition,
    course: Course,
    waits: Waits,
    requests: Requests,
    time: TimeLimit,
}

/// The frames of the last sequence that were sent.
#[derive(Debug, Default)]
struct Course {
    /// Number of stimuli of the sequence.
    stimuli: usize,
    /// The frames after the sequence, which find its effects.
    added: Vec<Stimulus>,
}

/// The condition of the device between two sequences.
#[derive(Debug)]
struct Condition {
    /// The state in which the last sequence has left the device.
    left: Left,
    /// Number of sequences since the last start.
    in_a_row: u32,
    /// Objects that the last start has not brought back to their power-on values.
    kept: Vec<Kept>,
    /// Whether the device is still being brought to rest, so that the next sequence has not begun. A violation then has
    /// another cause than the sequence.
    is_between: bool,
}

/// How a sequence begins, and how long the fuzzer waits after each frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Pace {
    /// The sequence begins with a start. After each frame there is enough time for a forbidden answer to be seen.
    Careful,
    /// On a live device the sequence begins in the state that the last sequence has left, if this state is known. If the
    /// device answers in the order of the frames, the fuzzer does not wait for silence but sends the next frame at once:
    /// a forbidden answer shows, because it comes before the answer to the next frame.
    Swift,
}

/// The state in which a sequence has left the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Left {
    /// At rest: the next sequence can begin.
    AtRest,
    /// The next sequence can begin after the fuzzer has read the device's state and values.
    Recoverable,
    /// Unknown: only a reset helps.
    Unknown,
}

/// The result of a sequence.
#[derive(Debug)]
pub(super) enum Ended {
    /// All properties hold, or nothing can be judged.
    Well,
    /// A property does not hold.
    Violation(Violation),
    /// The device was lost before the sequence: it did not start after the reset. If `dead` is set, it did not start after
    /// further resets either.
    Lost { violation: Violation, dead: bool },
}

/// The violation of a server that can't be read any more.
const WEDGED: (Property, &str) = (Property::Responsive, "canonical read");

/// The rule that a device violates if it has stopped working.
pub(super) const DEATH: &str = "device death";

/// The rule that a device violates if it comes back only after a further reset.
const REVIVED: &str = "reset after a sequence";

/// Maximum number of runs of a sequence that is interrupted each time: the sequence itself may interrupt the way to the
/// bus.
const MOST_INTERRUPTED: u32 = 3;

/// Number of sequences after which a device that is not reset between them is reset, so that a violation does not
/// depend on too many frames.
const MOST_IN_A_ROW: u32 = 64;

/// An answer is slow if it takes this multiple of the time after which the device counts as silent.
const SLOW_ANSWER: u64 = 25;

/// Maximum number of slow answers of one kind for which the client waits. Then it aborts the transfer instead.
const MOST_SLOW: u32 = 2;

/// Maximum wait for silence while other nodes keep the bus busy, as a multiple of the time after which the device
/// counts as silent.
const MOST_QUIET: u64 = 10;

/// Wait for an optional answer of a device that is not reset between sequences, as a multiple of the time after which
/// the device counts as silent. While a violation is repeated, the fuzzer waits this long for every answer.
const LATE_ANSWER: u64 = 3;

/// Maximum number of frames that wait for their answers.
const LATELY: usize = 8;

/// Wait for an answer that was missing before, as a multiple of the time after which the device counts as silent. It is
/// at least twelve times the usual time of an answer.
const MISSING_ANSWER: u64 = 6;

/// Whether a forbidden answer to the frame is recognised however late it comes. Servers and slaves answer one request
/// after the other, so that the models of SDO and LSS know the request of each answer. Other frames may still take
/// effect when the next frame comes.
fn shows_late(frame: &Frame) -> bool {
    let is_request = |id| matches!(id, 0x600..=0x67F | lss::MASTER_CAN_ID);
    frame.id().as_standard().is_none_or(|id| is_request(id) && !frame.is_remote())
}

/// The text of a panic.
fn panicked(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("its program panicked: {}", text.unwrap_or("without a word"))
}

/// Whether a frame makes the devices change to another bit rate at once. The connection to a live bus would be lost,
/// because the other nodes don't follow. LSS and LMT have the same command.
fn activates(frame: &Frame) -> bool {
    frame.cob_id() == Some(lss::MASTER_CAN_ID) && frame.data().first() == Some(&0x15)
}

/// Why a sequence ended early.
enum Stop {
    Violation(Violation),
    Lost {
        violation: Violation,
        dead: bool,
    },
    Bus(BusError),
    /// The time of the run is over.
    Time,
}

impl From<Violation> for Stop {
    fn from(violation: Violation) -> Self {
        Self::Violation(violation)
    }
}

impl From<BusError> for Stop {
    fn from(error: BusError) -> Self {
        Self::Bus(error)
    }
}

impl Executor {
    pub fn new(knowledge: Arc<Knowledge>, time: TimeLimit) -> Self {
        Self {
            oracle: Oracle::new(Arc::clone(&knowledge)),
            tally: Tally::default(),
            history: History::default(),
            known: KnownViolations::default(),
            condition: Condition { left: Left::Unknown, in_a_row: 0, kept: Vec::new(), is_between: false },
            course: Course::default(),
            waits: Waits::new(knowledge.patience.quiet),
            requests: Requests::new(knowledge.node),
            time,
            knowledge,
        }
    }

    /// Runs a sequence until its end or its first violation. `keep`: keep its frames. If the connection to the bus was
    /// interrupted meanwhile, nothing is judged and the sequence is run again.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    pub fn run(
        &mut self,
        stand: &mut dyn TestStand,
        sequence: &Sequence,
        pace: Pace,
        keep: bool,
    ) -> Result<Ended, BusError> {
        for _ in 0..MOST_INTERRUPTED {
            let (before, unjudged, spent) = (stand.bus().health(), self.tally.unjudged, self.tally.spent);
            let ended = self.run_once(stand, sequence, pace, keep);
            if ended.is_ok() && !is_interrupted(stand, &before) {
                return ended;
            }
            // The duration of an interruption says nothing about the device.
            (self.tally.unjudged, self.tally.spent) = (unjudged + 1, spent);
            (self.condition.left, self.history.was_interrupted) = (Left::Unknown, true);
            ended?;
            if self.in_time(stand).is_err() {
                break;
            }
            stand.bus().wait_until_back()?;
        }
        Ok(Ended::Well)
    }

    fn run_once(
        &mut self,
        stand: &mut dyn TestStand,
        sequence: &Sequence,
        pace: Pace,
        keep: bool,
    ) -> Result<Ended, BusError> {
        self.history.keep = keep;
        self.course = Course::default();
        self.waits.begin(pace);
        self.condition.is_between = false;
        let goes_on =
            pace == Pace::Swift && self.condition.in_a_row < MOST_IN_A_ROW && sequence.start == Start::Configured;
        if !goes_on {
            self.condition.left = Left::Unknown;
        }
        let is_begun = Cell::new(self.condition.left != Left::Unknown);
        // A device in this process can panic. The panicked device is not used any more; the next start makes a new
        // device.
        let ended = catch_unwind(AssertUnwindSafe(|| self.attempt(stand, sequence, &is_begun)));
        let ended = ended.unwrap_or_else(|panic| {
            let violation = self.death(DEATH, "a device that lives", &panicked(&*panic));
            if is_begun.get() { Err(Stop::Violation(violation)) } else { Err(Stop::Lost { violation, dead: true }) }
        });
        match ended {
            Ok(()) => Ok(Ended::Well),
            Err(Stop::Violation(violation)) => Ok(Ended::Violation(violation)),
            Err(Stop::Lost { violation, dead }) => Ok(Ended::Lost { violation, dead }),
            Err(Stop::Bus(error)) => Err(error),
            Err(Stop::Time) => {
                self.tally.unjudged += 1;
                Ok(Ended::Well)
            }
        }
    }

    /// On a live device the end of a run does not wait for the end of a sequence.
    fn in_time(&self, stand: &dyn TestStand) -> Result<(), Stop> {
        if !stand.is_repeatable() && self.time.is_over() { Err(Stop::Time) } else { Ok(()) }
    }

    fn attempt(&mut self, stand: &mut dyn TestStand, sequence: &Sequence, is_begun: &Cell<bool>) -> Result<(), Stop> {
        if sequence.start == Start::Unconfigured && !stand.has_unconfigured() {
            self.tally.unjudged += 1;
            return Ok(());
        }
        self.in_time(stand)?;
        let before = stand.bus().health();
        let goes_on = match std::mem::replace(&mut self.condition.left, Left::Unknown) {
            // A sequence that shows a known violation again must not begin in the state that the previous try has left.
            Left::AtRest if !self.known.presumes() => true,
            Left::AtRest | Left::Recoverable if !self.is_recovery_faster() => false,
            Left::AtRest | Left::Recoverable => {
                self.condition.is_between = true;
                let recovered = self.recover(stand)?;
                self.condition.is_between = false;
                recovered
            }
            Left::Unknown => false,
        };
        is_begun.set(goes_on);
        if !goes_on {
            self.start(stand, sequence.start)?;
            is_begun.set(true);
        }
        if is_interrupted(stand, &before) {
            // The device may not have received the reset.
            return Ok(());
        }
        self.history.begin(0);
        self.condition.in_a_row += 1;
        self.waits.trusts.regain();
        let before = stand.bus().health();
        let ended = self.steps(stand, sequence);
        if let Err(Stop::Violation(_)) = &ended
            && is_troubled(stand, &before)
        {
            // The device may have sent frames that were lost here.
            self.tally.unjudged += 1;
            return Ok(());
        }
        self.condition.left = match &ended {
            Ok(()) if self.oracle.is_at_rest() => Left::AtRest,
            ended if self.may_recover(ended) => Left::Recoverable,
            _ => Left::Unknown,
        };
        ended
    }

    /// Starts the device with its power-on values.
    fn start(&mut self, stand: &mut dyn TestStand, start: Start) -> Result<(), Stop> {
        let begun = stand.bus().now();
        let ended = self.bring_to_start(stand, start);
        // The clock of a simulated device begins anew with each start.
        self.tally.spent.add(Cause::Start, stand.bus().now().since(begun));
        ended
    }

    fn bring_to_start(&mut self, stand: &mut dyn TestStand, start: Start) -> Result<(), Stop> {
        let is_repeatable = stand.is_repeatable();
        self.history.start(is_repeatable);
        self.condition.in_a_row = 0;
        if !is_repeatable && self.knowledge.services.boot_up_message && self.oracle.is_booting() {
            // The pending boot-up message would be taken for the boot-up message of the next reset.
            wait_for_boot_up(stand.bus(), self.knowledge.node, self.knowledge.patience.boot)?;
        }
        let health = stand.bus().health();
        let readiness = stand.begin(start)?;
        if readiness != Readiness::Ready && !is_troubled(stand, &health) {
            let within = self.knowledge.patience.boot;
            let expected =
                format!("a boot-up message, or an answer, within {within} of the reset between two sequences");
            let dead = readiness == Readiness::Dead;
            let violation = match dead {
                true => self.death(DEATH, &expected, "neither of them, and no reset brought it back"),
                false => self.death(REVIVED, &expected, "neither of them; a further reset brought it back"),
            };
            return Err(Stop::Lost { violation, dead });
        }
        let earlier = std::mem::take(&mut self.condition.kept);
        if !is_repeatable {
            let sent = self.history.sent_before();
            self.condition.kept = baseline::restore(stand.bus(), sent, &earlier, &self.knowledge, &mut |_| ())?;
        }
        self.waits.trusts.awaits_lss = false;
        self.oracle.start(stand.bus().now(), start);
        for kept in &self.condition.kept {
            self.oracle.holds(kept.at, kept.value);
        }
        Ok(())
    }

    /// Resets the device after the last sequence. The result says whether the reset has brought the device back.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    pub fn restart(&mut self, stand: &mut dyn TestStand) -> Result<Ended, BusError> {
        // The reset also happens after the end of the run's time, so that the device is left as it was found.
        let time = std::mem::take(&mut self.time);
        let ended = self.run(stand, &Sequence::default(), Pace::Careful, true);
        self.time = time;
        ended
    }

    /// Makes the next sequence begin with a reset, whatever state the last sequence has left.
    pub(crate) const fn forget_rest(&mut self) {
        self.condition.left = Left::Unknown;
    }

    /// Handles a violation that did not come back: an answer may have come too late, or the device may serve later
    /// frames before earlier frames. Silence has to last longer for a while. If this happens again and again, the
    /// fuzzer waits for silence after each frame.
    pub(crate) fn distrust(&mut self, property: Property) {
        self.tally.unjudged += 1;
        self.waits.trusts.doubt(property, self.knowledge.patience.answer);
    }

    /// Whether the device has so far served frames in their order. Then the answer to a later request proves that
    /// earlier frames have taken effect.
    pub(crate) const fn is_in_order(&self, property: Property) -> bool {
        self.waits.trusts.is_in_order(property)
    }

    /// Number of stimuli of the last sequence that were sent, and the frames that were sent after the sequence to find
    /// its effects.
    pub fn sent(&self) -> (usize, &[Stimulus]) {
        (self.course.stimuli, &self.course.added)
    }

    /// The part of the last sequence that was sent until its violation came.
    pub fn sent_of(&self, sequence: &Sequence) -> Sequence {
        let stimuli = sequence.stimuli.iter().take(self.course.stimuli).copied().collect();
        Sequence { stimuli, ..sequence.clone() }
    }

    /// Objects that the last start has not brought back to their power-on values.
    pub fn kept(&self) -> &[Kept] {
        &self.condition.kept
    }

    /// Whether the last sequence has not begun because the device was still being brought to rest.
    pub const fn is_between(&self) -> bool {
        self.condition.is_between
    }

    /// The knowledge of the device.
    pub fn knowledge(&self) -> &Knowledge {
        &self.knowledge
    }

    /// The violation of a device that has stopped working.
    fn death(&self, rule: &'static str, expected: &str, actual: &str) -> Violation {
        Violation {
            property: Property::Alive,
            rule,
            expected: expected.into(),
            actual: actual.into(),
            abort: None,
            interval: None,
            is_silence: false,
            symptom: Symptom::Dead,
            state: self.oracle.state(),
            at: self.history.last(),
        }
    }

    fn steps(&mut self, stand: &mut dyn TestStand, sequence: &Sequence) -> Result<(), Stop> {
        let is_live = stand.bus().is_live();
        for (at, stimulus) in sequence.stimuli.iter().enumerate() {
            self.course.stimuli = at + 1;
            if is_live && activates(&stimulus.frame) {
                continue;
            }
            self.in_time(stand)?;
            let next = sequence.stimuli.get(at + 1);
            self.waits.followed = shows_late(&stimulus.frame)
                || next.is_some_and(|next| next.frame.id() == stimulus.frame.id() && !stimulus.frame.is_remote());
            let is_probe = next.is_none() && stimulus.frame == self.requests.probe && self.may_probe();
            let judged = if is_probe { self.probe_by(stand, stimulus) } else { self.step(stand, stimulus) };
            match judged {
                Err(Stop::Violation(violation)) if self.is_tolerated(stand, &violation) => {
                    self.known.count(&violation);
                    if !self.recover(stand)? {
                        return Err(violation.into());
                    }
                    self.history.begin(at + 1);
                    continue;
                }
                done => done?,
            }
            if is_live
                && stimulus.then == Then::AtOnce
                && next.is_some_and(|next| !self.requests.are_told_apart(stimulus, next))
            {
                self.settle(stand)?;
            }
        }
        if sequence.stimuli.last().is_some_and(|last| last.then == Then::AtOnce) {
            self.settle(stand)?;
        }
        self.oracle.finish(stand.bus().now())?;
        if self.waits.pace == Pace::Swift {
            for frame in self.oracle.brings_to_rest() {
                self.waits.followed = shows_late(&frame);
                self.add(stand, frame)?;
            }
        }
        self.probe(stand)
    }

    /// Sends a frame that is not part of the sequence, and judges the answer.
    fn add(&mut self, stand: &mut dyn TestStand, frame: Frame) -> Result<(), Stop> {
        let stimulus = Stimulus::settle(frame);
        self.course.added.push(stimulus);
        self.step(stand, &stimulus)
    }

    /// PROP-01: 1000h can be read after any sequence.
    fn probe(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        self.waits.followed = true;
        if !self.oracle.serves_sdo() {
            return Ok(());
        }
        if self.oracle.is_in_blocks() {
            // In a block download a request to read can't be distinguished from a segment.
            self.add(stand, self.requests.abort)?;
        }
        let probe = Stimulus::settle(self.requests.probe);
        self.course.added.push(probe);
        self.probe_by(stand, &probe)
    }

    /// Whether a request to read must be answered, and can't be taken for the segment of a block.
    fn may_probe(&self) -> bool {
        self.oracle.serves_sdo() && !self.oracle.is_in_blocks()
    }

    /// Reads 1000h by this stimulus. Silence means that the server can't be read any more.
    fn probe_by(&mut self, stand: &mut dyn TestStand, stimulus: &Stimulus) -> Result<(), Stop> {
        self.waits.probing = true;
        let answered = self.step(stand, stimulus);
        self.waits.probing = false;
        match answered {
            Err(Stop::Violation(violation)) if violation.is_silence => {
                Err(Stop::Violation(Violation { property: WEDGED.0, rule: WEDGED.1, ..violation }))
            }
            done => done,
        }
    }

    fn step(&mut self, stand: &mut dyn TestStand, stimulus: &Stimulus) -> Result<(), Stop> {
        match stand.bus().send(&stimulus.frame) {
            // A bus over a network may carry no remote frames: the sequence goes on without it.
            Err(BusError::Unsendable { .. }) => return Ok(()),
            sent => sent?,
        }
        if !stand.is_repeatable() {
            self.history.send(*stimulus);
        }
        self.waits.outstanding += 1;
        self.tally.frames += 1;
        self.waits.trusts.awaits_lss |= stimulus.frame.cob_id() == Some(lss::MASTER_CAN_ID);
        match stimulus.then {
            Then::AtOnce => Ok(()),
            Then::Settle => self.settle(stand),
            Then::Pause(time) => {
                let until = stand.bus().now() + time;
                self.pass(stand, until)
            }
        }
    }
}

/// Whether frames were lost on this machine, or the bus was interrupted, since `before`.
fn is_troubled(stand: &mut dyn TestStand, before: &Health) -> bool {
    stand.bus().health().since(before).lost > 0 || is_interrupted(stand, before)
}

/// Whether the connection to the bus was interrupted since `before`, or still is.
pub(super) fn is_interrupted(stand: &mut dyn TestStand, before: &Health) -> bool {
    let since = stand.bus().health().since(before);
    since.interruptions > 0 || since.interrupted_since.is_some()
}
