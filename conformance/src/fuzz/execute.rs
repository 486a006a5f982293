//! Runs one sequence and holds every frame against the reference models.

use super::coverage::Coverage;
use super::ground::Ground;
use super::oracle::{Oracle, Violation};
use super::property::Property;
use super::stimulus::{Sequence, Stimulus, Then};
use crate::bus::BusError;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{REQUEST_BASE, Request};
use canvass_traces::{Direction, Frame, Record, Timestamp};
use std::sync::Arc;

use super::Knowledge;

/// The most frames of a sequence that are kept as evidence.
const LONGEST_EVIDENCE: usize = 1_000;

/// Runs sequences.
#[derive(Debug)]
pub(super) struct Executor {
    knowledge: Arc<Knowledge>,
    oracle: Oracle,
    /// What was exercised.
    pub coverage: Coverage,
    /// Frames that were sent.
    pub executions: u64,
    /// The frames of the last sequence, if they are kept.
    pub evidence: Vec<Record>,
    keep: bool,
    /// Own frames that were handed over and have not been on the bus.
    outstanding: usize,
    probe: Frame,
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
            evidence: Vec::new(),
            keep: false,
            outstanding: 0,
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
        ground.begin(sequence.start)?;
        self.oracle.start(ground.bus().now(), sequence.start);
        match self.steps(ground, sequence) {
            Ok(()) => Ok(None),
            Err(Stop::Violation(violation)) => Ok(Some(violation)),
            Err(Stop::Bus(error)) => Err(error),
        }
    }

    fn steps(&mut self, ground: &mut dyn Ground, sequence: &Sequence) -> Result<(), Stop> {
        for stimulus in &sequence.stimuli {
            self.step(ground, stimulus)?;
        }
        if sequence.stimuli.last().is_some_and(|last| last.then == Then::AtOnce) {
            self.settle(ground)?;
        }
        self.oracle.finish(ground.bus().now())?;
        self.probe(ground)
    }

    /// PROP-01: whatever came before, 1000h can be read.
    fn probe(&mut self, ground: &mut dyn Ground) -> Result<(), Stop> {
        if !self.oracle.serves_sdo() {
            return Ok(());
        }
        match self.step(ground, &Stimulus::settle(self.probe)) {
            Err(Stop::Violation(violation)) if violation.actual == "no answer" => {
                Err(Stop::Violation(Violation { property: Property::Responsive, rule: "canonical read", ..violation }))
            }
            done => done,
        }
    }

    fn step(&mut self, ground: &mut dyn Ground, stimulus: &Stimulus) -> Result<(), Stop> {
        ground.bus().send(&stimulus.frame)?;
        self.outstanding += 1;
        self.executions += 1;
        match stimulus.then {
            Then::AtOnce => Ok(()),
            Then::Settle => self.settle(ground),
            Then::Pause(time) => {
                let until = ground.bus().now() + time;
                self.pass(ground, until)
            }
        }
    }

    /// Until what is due has come, or nothing has come for a while where nothing is due.
    fn settle(&mut self, ground: &mut dyn Ground) -> Result<(), Stop> {
        let quiet = self.knowledge.patience.quiet;
        let mut was_due = false;
        let mut until = Timestamp::MAX;
        loop {
            let due = self.oracle.due();
            let deadline = match due {
                _ if self.outstanding > 0 => ground.bus().now() + self.knowledge.patience.answer,
                Some(due) => due,
                None if was_due => return Ok(()),
                None => {
                    if until == Timestamp::MAX {
                        until = ground.bus().now() + quiet;
                    }
                    until
                }
            };
            was_due |= due.is_some();
            if self.receive(ground, deadline)? {
                // Several answers may be under way.
                until = Timestamp::MAX;
                continue;
            }
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

    /// Lets time pass.
    fn pass(&mut self, ground: &mut dyn Ground, until: Timestamp) -> Result<(), Stop> {
        loop {
            let deadline = self.oracle.due().unwrap_or(until).min(until);
            if !self.receive(ground, deadline)? {
                self.oracle.expire(ground.bus().now())?;
                if ground.bus().now() >= until {
                    self.oracle.quiet();
                    return Ok(());
                }
            }
        }
    }

    /// The next frame, if there is one until the deadline.
    fn receive(&mut self, ground: &mut dyn Ground, deadline: Timestamp) -> Result<bool, Stop> {
        let Some(record) = ground.bus().receive(deadline)? else { return Ok(false) };
        if record.frame.is_error() {
            return Ok(true);
        }
        let (now, frame, own) = (record.timestamp, record.frame, record.direction == Direction::Tx);
        if self.keep && self.evidence.len() < LONGEST_EVIDENCE {
            self.evidence.push(record);
        }
        if own {
            self.outstanding = self.outstanding.saturating_sub(1);
            self.oracle.sent(now, &frame, &mut self.coverage)?;
        } else {
            self.oracle.received(now, &frame, &mut self.coverage)?;
        }
        Ok(true)
    }
}
