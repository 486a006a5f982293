//! Runs one sequence and holds every frame against the reference models.

use super::coverage::Coverage;
use super::ground::{Ground, Readiness};
use super::oracle::{Oracle, Violation};
use super::property::Property;
use super::stimulus::{Sequence, Start, Stimulus, Then};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss;
use canvass_analyzer::wire::sdo::{AbortCode, REQUEST_BASE, RESPONSE_BASE, Request};
use canvass_bus::BusError;
use canvass_traces::{Direction, Frame, Record, Timestamp};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::{Knowledge, Patience};

/// The most frames of a sequence that are kept as evidence.
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
    /// The frames of the last sequence, if they are kept.
    pub evidence: Vec<Record>,
    keep: bool,
    /// Own frames that were handed over and have not been on the bus.
    outstanding: usize,
    /// Sequences that say nothing, because the way to the device failed.
    pub unjudged: u64,
    probe: Frame,
    abort: Frame,
    /// The CAN-ID of SDO responses.
    response: u16,
}

/// The rule that a device breaks that does nothing any more.
pub(super) const DEATH: &str = "device death";

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
    Bus(BusError),
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
    pub fn new(knowledge: Arc<Knowledge>) -> Self {
        let node = u16::from(knowledge.node.raw());
        Self {
            oracle: Oracle::new(Arc::clone(&knowledge)),
            coverage: Coverage::default(),
            executions: 0,
            frames: 0,
            evidence: Vec::new(),
            keep: false,
            outstanding: 0,
            unjudged: 0,
            response: RESPONSE_BASE + node,
            abort: Request::abort(Multiplexer::new(0, 0), AbortCode::GENERAL).to_frame(REQUEST_BASE + node),
            probe: Request::upload(Multiplexer::new(0x1000, 0)).to_frame(REQUEST_BASE + node),
            knowledge,
        }
    }

    /// Runs a sequence from its start; the first property that does not hold ends it. `keep`: with its frames.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    pub fn run(
        &mut self,
        ground: &mut dyn Ground,
        sequence: &Sequence,
        keep: bool,
    ) -> Result<Option<Violation>, BusError> {
        self.keep = keep;
        self.evidence.clear();
        self.outstanding = 0;
        // A device in this process can panic. What is left of it is not used any more: the next start makes it anew.
        let ended = catch_unwind(AssertUnwindSafe(|| self.attempt(ground, sequence)));
        match ended.unwrap_or_else(|panic| Err(Stop::Violation(self.death(&panicked(&*panic))))) {
            Ok(()) => Ok(None),
            Err(Stop::Violation(violation)) => Ok(Some(violation)),
            Err(Stop::Bus(error)) => Err(error),
        }
    }

    fn attempt(&mut self, ground: &mut dyn Ground, sequence: &Sequence) -> Result<(), Stop> {
        if sequence.start == Start::Unconfigured && !ground.has_unconfigured() {
            self.unjudged += 1;
            return Ok(());
        }
        if ground.begin(sequence.start)? == Readiness::Dead {
            return Err(Stop::Violation(self.death("neither a boot-up message nor an answer after repeated resets")));
        }
        let before = ground.bus().health();
        self.oracle.start(ground.bus().now(), sequence.start);
        let ended = self.steps(ground, sequence);
        if let Err(Stop::Violation(_)) = &ended {
            let trouble = ground.bus().health().since(&before);
            if trouble.lost > 0 || trouble.interruptions > 0 {
                // Frames are missing that the device may have sent.
                self.unjudged += 1;
                return Ok(());
            }
        }
        ended
    }

    /// The device does nothing any more.
    fn death(&self, actual: &str) -> Violation {
        Violation {
            property: Property::Responsive,
            rule: DEATH,
            expected: "a device that lives".to_owned(),
            actual: actual.to_owned(),
            is_silence: false,
            at: self.evidence.last().map_or(Timestamp::ZERO, |record| record.timestamp),
        }
    }

    fn steps(&mut self, ground: &mut dyn Ground, sequence: &Sequence) -> Result<(), Stop> {
        let is_live = ground.bus().is_live();
        for (at, stimulus) in sequence.stimuli.iter().enumerate() {
            if is_live && activates(&stimulus.frame) {
                continue;
            }
            self.step(ground, stimulus)?;
            let next = sequence.stimuli.get(at + 1);
            if is_live && stimulus.then == Then::AtOnce && next.is_some_and(|next| !self.are_told_apart(stimulus, next))
            {
                self.settle(ground)?;
            }
        }
        if sequence.stimuli.last().is_some_and(|last| last.then == Then::AtOnce) {
            self.settle(ground)?;
        }
        self.oracle.finish(ground.bus().now())?;
        self.probe(ground)
    }

    /// Whether answers to two frames that follow each other at once can be told apart on a bus where they take their
    /// time: those to SDO requests name what they answer. An answer to the first that comes behind the second would be
    /// taken for an answer to that elsewhere.
    fn are_told_apart(&self, first: &Stimulus, second: &Stimulus) -> bool {
        let is_request =
            |stimulus: &Stimulus| !stimulus.frame.is_remote() && stimulus.frame.cob_id() == self.probe.cob_id();
        is_request(first) && is_request(second)
    }

    /// PROP-01: whatever came before, 1000h can be read.
    fn probe(&mut self, ground: &mut dyn Ground) -> Result<(), Stop> {
        if !self.oracle.serves_sdo() {
            return Ok(());
        }
        if self.oracle.is_in_blocks() {
            // There a request to read can't be told from a segment.
            self.step(ground, &Stimulus::settle(self.abort))?;
        }
        match self.step(ground, &Stimulus::settle(self.probe)) {
            Err(Stop::Violation(violation)) if violation.is_silence => {
                Err(Stop::Violation(Violation { property: Property::Responsive, rule: "canonical read", ..violation }))
            }
            done => done,
        }
    }

    fn step(&mut self, ground: &mut dyn Ground, stimulus: &Stimulus) -> Result<(), Stop> {
        ground.bus().send(&stimulus.frame)?;
        self.outstanding += 1;
        self.frames += 1;
        match stimulus.then {
            Then::AtOnce => Ok(()),
            Then::Settle => self.settle(ground),
            Then::Pause(time) => {
                let until = ground.bus().now() + time;
                self.pass(ground, until)
            }
        }
    }

    /// Until what is due has come, or no answer has come for a while where none is due.
    fn settle(&mut self, ground: &mut dyn Ground) -> Result<(), Stop> {
        let Patience { quiet, answer, .. } = self.knowledge.patience;
        let mut was_due = false;
        let mut until = Timestamp::MAX;
        loop {
            let due = self.oracle.due();
            let deadline = match due {
                _ if self.outstanding > 0 => ground.bus().now() + answer,
                Some(due) => due,
                None if was_due && !self.oracle.is_open() => return Ok(()),
                None => {
                    if until == Timestamp::MAX {
                        until = ground.bus().now() + quiet;
                    }
                    until
                }
            };
            was_due |= due.is_some();
            match self.receive(ground, deadline)? {
                // Several answers may be under way; heartbeats and PDOs come all the time.
                Received::Answer => until = Timestamp::MAX,
                Received::Other => {}
                Received::Nothing => {
                    self.oracle.expire(ground.bus().now())?;
                    if self.outstanding > 0 {
                        // The bus does not take the frame: nothing can be said about the device.
                        self.outstanding = 0;
                    } else if due.is_none() {
                        self.oracle.quiet();
                        return Ok(());
                    }
                }
            }
        }
    }

    /// Lets time pass.
    fn pass(&mut self, ground: &mut dyn Ground, until: Timestamp) -> Result<(), Stop> {
        loop {
            let deadline = self.oracle.due().unwrap_or(until).min(until);
            if self.receive(ground, deadline)? == Received::Nothing {
                self.oracle.expire(ground.bus().now())?;
                if ground.bus().now() >= until {
                    self.oracle.quiet();
                    return Ok(());
                }
            }
        }
    }

    /// The next frame, if there is one until the deadline.
    fn receive(&mut self, ground: &mut dyn Ground, deadline: Timestamp) -> Result<Received, Stop> {
        let Some(record) = ground.bus().receive(deadline)? else { return Ok(Received::Nothing) };
        if record.frame.is_error() {
            return Ok(Received::Other);
        }
        let (now, frame, own) = (record.timestamp, record.frame, record.direction == Direction::Tx);
        if self.keep && self.evidence.len() < LONGEST_EVIDENCE {
            self.evidence.push(record);
        }
        if own {
            self.outstanding = self.outstanding.saturating_sub(1);
            self.oracle.sent(now, &frame, &mut self.coverage)?;
            self.executions += u64::from(self.oracle.judges(&frame));
            return Ok(Received::Answer);
        }
        self.oracle.received(now, &frame, &mut self.coverage)?;
        let id = frame.cob_id();
        let is_answer = id == Some(self.response) || id == Some(lss::SLAVE_CAN_ID);
        Ok(if is_answer { Received::Answer } else { Received::Other })
    }
}

/// What was received.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Received {
    Nothing,
    /// An own frame, or one with which servers and slaves answer.
    Answer,
    /// What comes by itself.
    Other,
}
