//! Runs one sequence and holds every frame against the reference models.

mod recovery;
#[cfg(test)]
mod tests;
mod waits;

use super::baseline::{self, Kept};
use super::coverage::Coverage;
use super::oracle::{Oracle, Violation};
use super::property::Property;
use super::spent::{Cause, Spent};
use super::stand::{Readiness, TestStand, wait_for_boot_up};
use super::stimulus::{Sequence, Start, Stimulus, Then};
use super::time_limit::TimeLimit;
use super::trust::Trusts;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss;
use canvass_analyzer::wire::sdo::{AbortCode, REQUEST_BASE, RESPONSE_BASE, Request};
use canvass_bus::{BusError, Health};
use canvass_traces::{Frame, Record, Timestamp};
use std::any::Any;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::Knowledge;

/// So many of the last frames are kept as evidence at least.
const LONGEST_EVIDENCE: usize = 1_000;

/// Runs sequences.
#[derive(Debug)]
pub(super) struct Executor {
    knowledge: Arc<Knowledge>,
    oracle: Oracle,
    /// What was exercised.
    pub coverage: Coverage,
    /// Frames that were on the bus, and after which the models knew what must or must not come.
    pub executions: u64,
    /// Frames that were sent, with those after which anything may come.
    pub frames: u64,
    /// The frames since the last start, if they are kept.
    pub evidence: Vec<Record>,
    /// What was sent since the last start, on a device that goes on.
    sent: Vec<Stimulus>,
    /// The same of the start before, with its frames: of these a device died that does not come back.
    before: (Sequence, Vec<Record>),
    /// The way to the bus was interrupted in the last sequence: whether what began it was done is not known.
    was_interrupted: bool,
    /// What the last start has not brought back.
    pub kept: Vec<Kept>,
    /// Sequences since the last start.
    in_a_row: u32,
    /// Where the last sequence has left the device.
    left: Left,
    /// At that number of the frames since the last start the last sequence began, or its tail.
    begun_at: usize,
    /// At that stimulus the tail of the last sequence began: at rest, after a violation that was reported before.
    tail: usize,
    /// What of the frames since the last start needs no putting right: at that number of them the device held the values of
    /// power-on.
    settled: usize,
    pace: Pace,
    /// How long silence has to last, and what can stand for it.
    trusts: Trusts,
    /// A violation that was seen and is being shown again: an answer that is known to be missing is not waited for long.
    presumed: Option<(Property, &'static str)>,
    /// That was seen again, without the whole of its time.
    has_hurried: bool,
    /// Violations that were reported: they end no sequence.
    known: BTreeSet<(Property, &'static str)>,
    /// Those of them that were silence: for an answer that is known not to come nobody waits long.
    known_silence: BTreeSet<(Property, &'static str)>,
    /// How often an answer of the SDO server took so long that others have to be left out: by what was awaited.
    slow: BTreeMap<&'static str, u32>,
    /// An answer to this frame that must not come shows also when the next frame follows at once.
    followed: bool,
    keep: bool,
    /// What the time went into.
    pub spent: Spent,
    /// What the wait that is under way, or was the last, was for.
    awaited: Cause,
    time: TimeLimit,
    /// The request to read that each sequence ends with is under way: its silence is a violation of its own.
    probing: bool,
    /// The last sequence has not begun: the device was not at rest before it, and has shown so.
    pub is_between: bool,
    /// What came last from others.
    heard: Option<Frame>,
    /// Own frames that were handed over and have not been on the bus.
    outstanding: usize,
    /// Sequences that say nothing, because the way to the device failed.
    pub unjudged: u64,
    probe: Frame,
    abort: Frame,
    /// The CAN-ID of SDO responses.
    response: u16,
}

/// How a sequence is run.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Pace {
    /// From a start, and after each frame there is time for an answer that must not come.
    Careful,
    /// On a device that goes on: from where the last sequence has left it, if that is known, and with the next frame at
    /// once where an answer too many would come before the next answer.
    Swift,
}

/// Where a sequence has left the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Left {
    /// Where the next one can begin.
    AtRest,
    /// Where the next one can begin once the device has said what it holds.
    Recoverable,
    /// Where only a reset helps.
    Unknown,
}

/// How a sequence ended.
#[derive(Debug)]
pub(super) enum Ended {
    /// All properties hold, or nothing can be said.
    Well,
    /// One does not hold.
    Violation(Violation),
    /// The device was lost before the sequence: the reset did not bring it back. `dead`: nor did further ones.
    Lost { violation: Violation, dead: bool },
}

/// What a server violates that can't be read any more.
const WEDGED: (Property, &str) = (Property::Responsive, "canonical read");

/// The rule that a device breaks that does nothing any more.
pub(super) const DEATH: &str = "device death";

/// The rule that a device breaks that one reset does not bring back.
const REVIVED: &str = "reset after a sequence";

/// So often a sequence is run that is interrupted each time: it may be what interrupts the way to the bus.
const MOST_INTERRUPTED: u32 = 3;

/// After so many sequences a device that goes on is reset, so that what shows is not the sum of too much.
const MOST_IN_A_ROW: u32 = 64;

/// An answer that takes so many times as long as silence has to last is slow.
const SLOW_ANSWER: u64 = 25;

/// So many slow answers of a kind are waited for, and judged; the others end in an abort of the client.
const MOST_SLOW: u32 = 2;

/// Silence is waited for so many times as long as it has to last, where others keep the bus busy.
const MOST_QUIET: u64 = 10;

/// On a device that goes on, an answer that may come or not is waited for so many times as long as silence has to last; and
/// so is every one where a violation is repeated.
const LATE_ANSWER: u64 = 3;

/// So many frames may have their answers under way.
const LATELY: usize = 8;

/// An answer that is missing, as it was before, is waited for so many times as long as silence has to last: twelve times the
/// usual time of an answer, and more.
const MISSING_ANSWER: u64 = 6;

/// Whether an answer to that frame that must not come is wrong whenever it comes: servers and slaves answer one request
/// after the other, and the models of SDO and LSS don't mix them up. What other frames do, the next one may meet half done.
fn shows_late(frame: &Frame) -> bool {
    let is_request = |id| matches!(id, 0x600..=0x67F | lss::MASTER_CAN_ID);
    frame.id().as_standard().is_none_or(|id| is_request(id) && !frame.is_remote())
}

/// What a panic says.
fn panicked(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("its program panicked: {}", text.unwrap_or("without a word"))
}

/// Whether a frame lets the devices change to another bit rate at once. A live bus would be lost, as nobody follows them
/// there; the command of LSS and of LMT is the same.
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
    /// The run is over.
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
        let node = u16::from(knowledge.node.raw());
        Self {
            oracle: Oracle::new(Arc::clone(&knowledge)),
            coverage: Coverage::default(),
            executions: 0,
            frames: 0,
            evidence: Vec::new(),
            sent: Vec::new(),
            before: (Sequence::default(), Vec::new()),
            was_interrupted: false,
            kept: Vec::new(),
            in_a_row: 0,
            left: Left::Unknown,
            begun_at: 0,
            tail: 0,
            settled: 0,
            pace: Pace::Careful,
            trusts: Trusts::new(knowledge.patience.quiet),
            presumed: None,
            has_hurried: false,
            known: BTreeSet::new(),
            known_silence: BTreeSet::new(),
            slow: BTreeMap::new(),
            followed: false,
            keep: false,
            spent: Spent::default(),
            awaited: Cause::Answer,
            time,
            probing: false,
            is_between: false,
            heard: None,
            outstanding: 0,
            unjudged: 0,
            response: RESPONSE_BASE + node,
            abort: Request::abort(Multiplexer::new(0, 0), AbortCode::GENERAL).to_frame(REQUEST_BASE + node),
            probe: Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0)).to_frame(REQUEST_BASE + node),
            knowledge,
        }
    }

    /// Runs a sequence; the first property that does not hold ends it. `keep`: with its frames. If the way to the bus was
    /// interrupted meanwhile, nothing is judged, and the sequence is run again.
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
            let (before, unjudged, spent) = (stand.bus().health(), self.unjudged, self.spent);
            let ended = self.run_once(stand, sequence, pace, keep);
            if ended.is_ok() && !is_interrupted(stand, &before) {
                return ended;
            }
            // How long an interruption was says nothing about the device.
            (self.unjudged, self.spent) = (unjudged + 1, spent);
            (self.left, self.was_interrupted) = (Left::Unknown, true);
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
        self.keep = keep;
        self.pace = pace;
        (self.probing, self.is_between) = (false, false);
        self.outstanding = 0;
        let goes_on = pace == Pace::Swift && self.in_a_row < MOST_IN_A_ROW && sequence.start == Start::Configured;
        if !goes_on {
            self.left = Left::Unknown;
        }
        let is_begun = Cell::new(self.left != Left::Unknown);
        // A device in this process can panic. What is left of it is not used any more: the next start makes it anew.
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
                self.unjudged += 1;
                Ok(Ended::Well)
            }
        }
    }

    /// On a live device the end of a run does not wait for that of a sequence.
    fn in_time(&self, stand: &dyn TestStand) -> Result<(), Stop> {
        if !stand.is_repeatable() && self.time.is_over() { Err(Stop::Time) } else { Ok(()) }
    }

    fn attempt(&mut self, stand: &mut dyn TestStand, sequence: &Sequence, is_begun: &Cell<bool>) -> Result<(), Stop> {
        if sequence.start == Start::Unconfigured && !stand.has_unconfigured() {
            self.unjudged += 1;
            return Ok(());
        }
        self.in_time(stand)?;
        let before = stand.bus().health();
        let goes_on = match std::mem::replace(&mut self.left, Left::Unknown) {
            // What is to be shown again must not come from where the try before has ended.
            Left::AtRest if self.presumed.is_none() => true,
            Left::AtRest | Left::Recoverable if !self.is_recovery_faster() => false,
            Left::AtRest | Left::Recoverable => {
                self.is_between = true;
                let recovered = self.recover(stand)?;
                self.is_between = false;
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
            // The device may not have got the reset.
            return Ok(());
        }
        (self.begun_at, self.tail) = (self.sent.len(), 0);
        self.in_a_row += 1;
        self.trusts.regain();
        let before = stand.bus().health();
        let ended = self.steps(stand, sequence);
        if let Err(Stop::Violation(_)) = &ended
            && is_troubled(stand, &before)
        {
            // Frames are missing that the device may have sent.
            self.unjudged += 1;
            return Ok(());
        }
        self.left = match &ended {
            Ok(()) if self.oracle.is_at_rest() => Left::AtRest,
            ended if self.may_recover(ended) => Left::Recoverable,
            _ => Left::Unknown,
        };
        ended
    }

    /// Brings the device to its start, with the values of power-on.
    fn start(&mut self, stand: &mut dyn TestStand, start: Start) -> Result<(), Stop> {
        let begun = stand.bus().now();
        let ended = self.bring_to_start(stand, start);
        // A simulated device begins at a new time.
        self.spent.add(Cause::Start, stand.bus().now().since(begun));
        ended
    }

    fn bring_to_start(&mut self, stand: &mut dyn TestStand, start: Start) -> Result<(), Stop> {
        let is_repeatable = stand.is_repeatable();
        let evidence = std::mem::take(&mut self.evidence);
        if !is_repeatable {
            let stimuli = std::mem::take(&mut self.sent);
            if !std::mem::take(&mut self.was_interrupted) {
                self.before = (Sequence::default(), Vec::new());
            }
            self.before.0.stimuli.extend(stimuli);
            self.before.1.extend(evidence);
        }
        (self.in_a_row, self.begun_at, self.settled) = (0, 0, 0);
        if !is_repeatable && self.knowledge.services.boot_up_message && self.oracle.is_booting() {
            // Its boot-up message would be taken for that of the next reset.
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
        let earlier = std::mem::take(&mut self.kept);
        if !is_repeatable {
            let sent = &self.before.0.stimuli;
            self.kept = baseline::restore(stand.bus(), sent, &earlier, &self.knowledge, &mut |_| ())?;
        }
        self.trusts.awaits_lss = false;
        self.oracle.start(stand.bus().now(), start);
        for kept in &self.kept {
            self.oracle.holds(kept.at, kept.value);
        }
        Ok(())
    }

    /// Resets the device after the last sequence, and says whether that has brought it back.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    pub fn restart(&mut self, stand: &mut dyn TestStand) -> Result<Ended, BusError> {
        // A run whose time is over leaves the device as it was found all the same.
        let time = std::mem::take(&mut self.time);
        let ended = self.run(stand, &Sequence::default(), Pace::Careful, true);
        self.time = time;
        ended
    }

    /// The next sequence begins with a reset, wherever the last one has left the device.
    pub const fn forget_rest(&mut self) {
        self.left = Left::Unknown;
    }

    /// A sequence has shown something that did not come back: an answer may have come later than was waited for, or the
    /// device may serve later frames before earlier ones. Silence has to last longer for a while, and where that goes on, it
    /// is waited for after each frame.
    pub fn distrust(&mut self, property: Property) {
        self.unjudged += 1;
        self.trusts.doubt(property, self.knowledge.patience.answer);
    }

    /// Whether the device serves what comes first first, as far as it has shown: then an answer to a later request says that
    /// earlier frames have done what they do.
    pub const fn is_in_order(&self, property: Property) -> bool {
        self.trusts.is_in_order(property)
    }

    /// From now on that violation is only to be shown again; `None`: whole times are waited for. Whether some of it was
    /// shown without the whole of its time.
    pub const fn presume(&mut self, violation: Option<(Property, &'static str)>) -> bool {
        self.presumed = violation;
        std::mem::replace(&mut self.has_hurried, false)
    }

    /// That violation was reported, and is not reported again.
    pub fn take_for_granted(&mut self, violation: &Violation) {
        let key = (violation.property, violation.rule);
        self.known.insert(key);
        if violation.is_silence {
            self.known_silence.insert(key);
        }
    }

    /// What was sent since the last start: all that has made the device what it is.
    pub fn since_start(&self) -> Sequence {
        Sequence { start: Start::Configured, stimuli: self.sent.clone() }
    }

    /// The stimulus of the last sequence from which on the device had violated nothing.
    pub const fn tail(&self) -> usize {
        self.tail
    }

    /// What was sent since the last start before the last sequence, or its tail.
    pub fn before_sequence(&self) -> &[Stimulus] {
        self.sent.get(..self.begun_at).unwrap_or_default()
    }

    /// What was sent since the last sequence began.
    pub fn since_sequence(&self) -> Sequence {
        let stimuli = self.sent.get(self.begun_at..).unwrap_or_default().to_vec();
        Sequence { start: Start::Configured, stimuli }
    }

    /// What is known of the device.
    pub fn knowledge(&self) -> &Knowledge {
        &self.knowledge
    }

    /// What was sent between the last start and the one before, and the frames.
    pub fn before_start(&mut self) -> (Sequence, Vec<Record>) {
        std::mem::take(&mut self.before)
    }

    /// The device does nothing any more.
    fn death(&self, rule: &'static str, expected: &str, actual: &str) -> Violation {
        Violation {
            property: Property::Alive,
            rule,
            expected: expected.to_owned(),
            actual: actual.to_owned(),
            is_silence: false,
            at: self.evidence.last().map_or(Timestamp::ZERO, |record| record.timestamp),
        }
    }

    fn steps(&mut self, stand: &mut dyn TestStand, sequence: &Sequence) -> Result<(), Stop> {
        let is_live = stand.bus().is_live();
        for (at, stimulus) in sequence.stimuli.iter().enumerate() {
            if is_live && activates(&stimulus.frame) {
                continue;
            }
            self.in_time(stand)?;
            let next = sequence.stimuli.get(at + 1);
            self.followed = shows_late(&stimulus.frame)
                || next.is_some_and(|next| next.frame.id() == stimulus.frame.id() && !stimulus.frame.is_remote());
            match self.step(stand, stimulus) {
                Err(Stop::Violation(violation)) if self.is_tolerated(stand, &violation) => {
                    if !self.recover(stand)? {
                        return Err(violation.into());
                    }
                    (self.begun_at, self.tail) = (self.sent.len(), at + 1);
                    continue;
                }
                done => done?,
            }
            if is_live && stimulus.then == Then::AtOnce && next.is_some_and(|next| !self.are_told_apart(stimulus, next))
            {
                self.settle(stand)?;
            }
        }
        if sequence.stimuli.last().is_some_and(|last| last.then == Then::AtOnce) {
            self.settle(stand)?;
        }
        self.oracle.finish(stand.bus().now())?;
        if self.pace == Pace::Swift {
            for frame in self.oracle.brings_to_rest() {
                self.followed = shows_late(&frame);
                self.step(stand, &Stimulus::settle(frame))?;
            }
        }
        self.probe(stand)
    }

    /// Whether answers to two frames that follow each other at once can be distinguished on a bus where they take their
    /// time: those to SDO requests name what they answer. An answer to the first that comes after the second would be
    /// taken for an answer to that elsewhere.
    fn are_told_apart(&self, first: &Stimulus, second: &Stimulus) -> bool {
        let is_request =
            |stimulus: &Stimulus| !stimulus.frame.is_remote() && stimulus.frame.cob_id() == self.probe.cob_id();
        is_request(first) && is_request(second)
    }

    /// PROP-01: whatever came before, 1000h can be read.
    fn probe(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        self.followed = true;
        if !self.oracle.serves_sdo() {
            return Ok(());
        }
        if self.oracle.is_in_blocks() {
            // There a request to read can't be distinguished from a segment.
            self.step(stand, &Stimulus::settle(self.abort))?;
        }
        self.probing = true;
        let answered = self.step(stand, &Stimulus::settle(self.probe));
        self.probing = false;
        match answered {
            Err(Stop::Violation(violation)) if violation.is_silence => {
                Err(Stop::Violation(Violation { property: WEDGED.0, rule: WEDGED.1, ..violation }))
            }
            done => done,
        }
    }

    fn step(&mut self, stand: &mut dyn TestStand, stimulus: &Stimulus) -> Result<(), Stop> {
        stand.bus().send(&stimulus.frame)?;
        if !stand.is_repeatable() {
            self.sent.push(*stimulus);
        }
        self.outstanding += 1;
        self.frames += 1;
        self.trusts.awaits_lss |= stimulus.frame.cob_id() == Some(lss::MASTER_CAN_ID);
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

/// Whether frames were lost on this machine, or the bus was interrupted, since then.
fn is_troubled(stand: &mut dyn TestStand, before: &Health) -> bool {
    stand.bus().health().since(before).lost > 0 || is_interrupted(stand, before)
}

/// Whether the way to the bus was interrupted since then, or is so all the while.
pub(super) fn is_interrupted(stand: &mut dyn TestStand, before: &Health) -> bool {
    let since = stand.bus().health().since(before);
    since.interruptions > 0 || since.interrupted_since.is_some()
}
